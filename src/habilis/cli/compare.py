"""`habilis compare`: average object empowerment with each tool, and without."""

import argparse
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from habilis.bridges.puzzles.pushworld import PushWorld
from habilis.cli.arguments import (
    TOOLS,
    Args,
    add_most,
    add_options,
    add_slip,
    max_states,
    measure_options,
    parse_words,
)
from habilis.cli.compare_robots import SUFFIX, check, run_robots
from habilis.cli.executors import OPTIONS, add_executor
from habilis.cli.output import lower_bounds, print_json, print_written, save, shows_progress
from habilis.cli.puzzles import puzzle_of
from habilis.files import PICTURES, TABLES
from habilis.progress import progress_bar
from habilis.worlds.world import NO_TOOL, World, load_world

if TYPE_CHECKING:
    from habilis.analysis.pairs import Pairs
    from habilis.analysis.usefulness import Usefulness

_COMPARED = ("picker", "broom", NO_TOOL)
"""The tools compared after those of the map, unless --tools names some."""
_PAIRS_HORIZON = 6

HELP: str = "average object empowerment with each tool, and without; or which movable is the tool"
EXAMPLE: str = "habilis compare yard --tools picker,broom,none --horizon 3"
COMMON: tuple[str, ...] = ("--horizon", "--tools", "--pairs")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    text = "a built-in world or a map file; a puzzle file (.pwp, .xsb), for its tool ranking; or a "
    text += "MuJoCo file (.xml) with bodies hand and puck, such as the built-in reach.xml"
    parser.add_argument("world", metavar="WORLD", help=text)
    text = "the movable of a puzzle that is acted on (default: the first)"
    parser.add_argument("--target", metavar="M0", help=text)
    add_most(parser)
    text = f"each {TOOLS}, or a tool of the map (default: those of the map, then"
    text += f" {','.join(_COMPARED)} where the map has a place for a tool)"
    parser.add_argument("--tools", type=parse_words, metavar="A,B,...", help=text)
    text = f"number of actions (with --pairs the largest one, by default {_PAIRS_HORIZON})"
    parser.add_argument("--horizon", type=int, metavar="H", help=text)
    text = "every tool with every object of the map (--tools: by default those of the map, none)"
    parser.add_argument("--pairs", action="store_true", help=text)
    text = "of a MuJoCo file: the puck is put into each of N by N squares (default 8)"
    parser.add_argument("--side", type=int, metavar="N", help=text)
    text = "of a MuJoCo file: searches of each placement (default 4)"
    parser.add_argument("--seeds", type=int, metavar="K", help=text)
    text = "of a MuJoCo file: states that a search goes on from (default 200)"
    parser.add_argument("--sequences", type=int, metavar="N", help=text)
    kinds = "with --pairs or of a MuJoCo file: picture (.png, .svg, .pdf) or values (.csv, "
    kinds += ".parquet, .npz, .npy)"
    text = f"{kinds}; repeatable"
    parser.add_argument("--out", type=Path, action="append", default=[], metavar="F.png", help=text)
    parser.set_defaults(writes={"out": (*PICTURES, *TABLES)})
    add_slip(parser)
    add_options(parser)
    add_executor(parser)


def run(args: Args) -> int:
    from habilis.analysis.averages import compare as measure
    from habilis.analysis.averages import ranking, with_each_tool
    from habilis.analysis.usefulness import usefulness

    check(args)
    if args.world.endswith(SUFFIX):
        return run_robots(args)
    puzzle = puzzle_of(args, args.world, ("tools", "pairs", "slip", "out", *OPTIONS))
    if puzzle is not None:
        return _run_ranking(args, puzzle)
    for given in ("target", "max_states"):
        if getattr(args, given) is not None:
            raise ValueError(f"{args.flags[given]} is for puzzles; leave it out")
    if args.pairs:
        return _run_pairs(args)
    if args.out:
        raise ValueError("--out is for the results of --pairs; add --pairs, or leave out --out")
    if args.horizon is None:
        raise ValueError("no horizon; give --horizon, such as --horizon 3")
    world = load_world(args.world)
    if len(world.objects) > 1:
        named = ", ".join(thing.name for thing in world.objects)
        raise ValueError(f"{world.name} has several objects, {named}; add --pairs for each of them")
    tools = _compared(world) if args.tools is None else args.tools
    averages = measure(world, tools, args.horizon, args.slip, **measure_options(args))
    verdicts = {
        tool: usefulness(armed, args.horizon, args.slip, **measure_options(args))
        for tool, armed in with_each_tool(world, tools).items()
        if tool != NO_TOOL
    }
    if args.json:
        judged = {
            tool: {
                "useful": verdict.useful_on_average,
                "better_than_none": verdict.better_than_none_on_average,
                "encumbers": verdict.encumbers_on_average,
                "equal": _equal(verdict, args.tolerance),
                "gap": _gap(verdict),
                "useful_share": float(verdict.useful.mean()),
                "better_than_none_share": float(verdict.better_than_none.mean()),
                "encumbers_share": float(verdict.encumbers.mean()),
            }
            for tool, verdict in verdicts.items()
        }
        return print_json(
            {"averages": averages, "horizon": args.horizon, "unit": args.unit, "tools": judged}
        )
    print(f"{lower_bounds(args)}average {args.horizon}-step object empowerment, in {args.unit}")
    width = max(10, *map(len, averages))
    for tool in ranking(averages):
        line = f"{tool:>{width}}  {averages[tool]:.4f}"
        if tool in verdicts:
            line += f"  {_verdict(verdicts[tool], args.tolerance)}"
        print(line)
    return 0


def _gap(tool: "Usefulness") -> float:
    """How much larger the averages that are compared can be, at most."""
    return max(tool.gap_with_tool, tool.gap_without)


def _equal(tool: "Usefulness", tolerance: float) -> bool:
    """Whether a tool is neither better nor worse than none, and the bounds are tight enough."""
    decided = tool.better_than_none_on_average or tool.encumbers_on_average
    return not decided and _gap(tool) <= tolerance


def _verdict(tool: "Usefulness", tolerance: float) -> str:
    useful = f"useful in {tool.useful.mean():.0%}"
    better, worse = tool.better_than_none.mean(), tool.encumbers.mean()
    if tool.better_than_none_on_average:
        return f"better than none (in {better:.0%} of placements; {useful})"
    if tool.encumbers_on_average:
        return f"encumbers the agent (in {worse:.0%} of placements; {useful})"
    what = "equal to none" if _equal(tool, tolerance) else "perhaps better or worse than none"
    return f"{what} (better in {better:.0%} of placements, worse in {worse:.0%}; {useful})"


def _run_ranking(args: Args, puzzle: PushWorld) -> int:
    """Prints the bits lost with each of a puzzle's movables but the target."""
    from habilis.analysis.tool_ranking import tool_ranking

    if args.horizon is None:
        raise ValueError("no horizon; give --horizon, such as --horizon 10")
    if not puzzle.objects:
        raise ValueError(f"{puzzle.name} has no movable to act on; draw one")
    options, target = measure_options(args), puzzle.objects[0]
    if options.pop("unit") != "bits" or args.method != "exact":
        raise ValueError("the tool ranking is exact and in bits; leave out --unit and --method")
    if args.target is not None:
        target = puzzle.objects[puzzle.place(args.target) - 1]
    frame = tool_ranking(
        puzzle, target, horizon=args.horizon, max_states=max_states(args), **options
    )
    if args.json:
        found = {"target": f"object:{target}", "horizon": args.horizon, "ranking": frame.to_dicts()}
        return print_json(found)
    if frame.is_empty():
        print(f"{puzzle.name} has no movable other than {target}")
        return 0
    bits = frame["bits"][0]
    print(f"{args.horizon}-step object empowerment over {target}: {bits:.4f} bits")
    print("bits lost when another movable is fixed, and when it is removed")
    rows = [["", "fixed", "removed"]]
    for name, _, fixed, removed in frame.iter_rows():
        rows.append([name, f"{fixed:z.4f}", f"{removed:z.4f}"])
    _print_table(rows)
    return 0


def _run_pairs(args: Args) -> int:
    """Prints the matrix, a line for each pair, and writes pictures and tables."""
    from habilis.analysis.pairs import pairs

    world = load_world(args.world)
    found = pairs(
        world,
        _PAIRS_HORIZON if args.horizon is None else args.horizon,
        _tools(world) if args.tools is None else args.tools,
        slip=args.slip,
        **measure_options(args),
    )
    for path in args.out:
        with progress_bar("drawing", shows_progress(args)):
            save(path, found.save)
    if args.json:
        return print_json(_as_dict(found))
    print(f"{lower_bounds(args)}average {found.horizon}-step object empowerment, in {found.unit}")
    _print_table([["", *found.objects], *_matrix(found)])
    print()
    print(f"of each pair, and its average for h = 1 to {found.horizon}")
    heads = ["tool", "object", "range", "latency", "median", "persistence", "reliability"]
    heads += [f"h = {h}" for h in range(1, found.horizon + 1)]
    _print_table([heads, *_lines(found)])
    print(
        f"range in cells; latency, least and median, in actions (-: over {found.horizon}); "
        f"persistence in {found.unit}; reliability: the share of the average that slips leave"
    )
    for path in args.out:
        print_written(path)
    return 0


def _tools(world: World) -> Sequence[str] | None:
    """Of a map with one tool also those that are compared without --pairs."""
    if len(world.tools) != 1:
        return None
    return _compared(world)


def _matrix(found: "Pairs") -> Iterable[list[str]]:
    for tool, row in zip(found.tools, found.averages[-1], strict=True):
        yield [tool, *(f"{value:.4f}" for value in row)]


def _lines(found: "Pairs") -> Iterable[list[str]]:
    from habilis.analysis.pairs import MEASURES

    for place in np.ndindex(len(found.tools), len(found.objects)):
        tool, object = found.tools[place[0]], found.objects[place[1]]
        counts = [_shown(getattr(found, name)[place], "g") for name in MEASURES[:3]]
        values = [_shown(getattr(found, name)[place], ".4f") for name in MEASURES[3:]]
        yield [
            tool,
            object,
            *counts,
            *values,
            *(f"{bits:.4f}" for bits in found.averages[:, *place]),
        ]


def _shown(value: float | np.integer, style: str) -> str:
    return f"{value:{style}}" if np.isfinite(value) else "-"


def _print_table(rows: Sequence[Sequence[str]]) -> None:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = (f"{cell:>{width}}" for cell, width in zip(row, widths, strict=True))
        print("  ".join(["", *cells]))


def _as_dict(found: "Pairs") -> dict[str, Any]:
    """Values by the names of tool and object."""
    from habilis.analysis.pairs import MEASURES

    def pair(row: int, column: int) -> dict[str, Any]:
        values = {name: getattr(found, name)[row, column].item() for name in MEASURES}
        shown = {name: value if np.isfinite(value) else None for name, value in values.items()}
        return {"averages": found.averages[:, row, column].tolist()} | shown

    return {
        "averages": _by_name(found, lambda row, column: found.averages[-1, row, column].item()),
        "horizon": found.horizon,
        "unit": found.unit,
        "pairs": _by_name(found, pair),
    }


def _by_name(found: "Pairs", value: Any) -> dict[str, dict[str, Any]]:
    return {
        tool: {object: value(row, column) for column, object in enumerate(found.objects)}
        for row, tool in enumerate(found.tools)
    }


def _compared(world: World) -> list[str]:
    """The map's own tools, as it has them, and those that come with the package, each once.

    On a map without a place for a tool only the bare agent can be compared.
    """
    if world.tool_cell is None:
        return [NO_TOOL]
    return [*dict.fromkeys([*(tool.name for tool in world.tools), *_COMPARED])]
