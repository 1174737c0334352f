"""habilis compare --pairs: every tool by every object."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from habilis.analysis.pairs import MEASURES, Pairs, pairs
from habilis.cli_arguments import OPTIONS, PAIRS_HORIZON, Args, compared
from habilis.cli_output import lower_bounds, print_json, save, shows_progress
from habilis.progress import progress_bar
from habilis.worlds.world import World, load_world


def compare_pairs(args: Args) -> int:
    """Prints the matrix, a line for each pair, and writes pictures and tables."""
    world = load_world(args.world)
    found = pairs(
        world,
        PAIRS_HORIZON if args.horizon is None else args.horizon,
        _tools(world) if args.tools is None else args.tools,
        slip=args.slip,
        **{name: getattr(args, name) for name in OPTIONS},
        show_progress=shows_progress(args),
    )
    for path in args.out:
        with progress_bar("drawing", shows_progress(args)):
            save(path, found.save)
    if args.json:
        return print_json(_told(found))
    print(f"{lower_bounds(args)}average {found.horizon}-step object empowerment, in {found.unit}")
    _print_table([["", *found.objects], *_matrix(found)])
    print()
    print(f"of each pair, and its average for h = 1 to {found.horizon}")
    heads = ["tool", "object", "range", "latency", "median", "persistence", "reliability"]
    heads += [f"h = {h}" for h in range(1, found.horizon + 1)]
    _print_table([heads, *_lines(found)])
    for path in args.out:
        print(f"written: {path}")
    return 0


def _tools(world: World) -> Sequence[str] | None:
    """Of a map with one tool also those that are compared without --pairs."""
    if len(world.tools) != 1:
        return None
    return compared(world)


def _matrix(found: Pairs) -> Iterable[list[str]]:
    for tool, row in zip(found.tools, found.averages[-1], strict=True):
        yield [tool, *(f"{value:.4f}" for value in row)]


def _lines(found: Pairs) -> Iterable[list[str]]:
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


def _told(found: Pairs) -> dict[str, Any]:
    """By tool and object, so that nothing has to be counted."""

    def pair(row: int, column: int) -> dict[str, Any]:
        values = {name: getattr(found, name)[row, column].item() for name in MEASURES}
        told = {name: value if np.isfinite(value) else None for name, value in values.items()}
        return {"averages": found.averages[:, row, column].tolist()} | told

    return {
        "averages": _by_name(found, lambda row, column: found.averages[-1, row, column].item()),
        "horizon": found.horizon,
        "unit": found.unit,
        "pairs": _by_name(found, pair),
    }


def _by_name(found: Pairs, value: Any) -> dict[str, dict[str, Any]]:
    return {
        tool: {object: value(row, column) for column, object in enumerate(found.objects)}
        for row, tool in enumerate(found.tools)
    }
