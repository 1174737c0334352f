"""The command line: one thin function a verb."""

import os
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

import habilis
from habilis.cli_arguments import OPTIONS, PREFIX, Args, Verb, compared, in_flags, parser
from habilis.cli_learning import plot, study, sweep, train, watch
from habilis.cli_output import (
    check_outputs,
    console,
    lower_bounds,
    print_json,
    refuse,
    save,
    shows_progress,
)
from habilis.extras import MissingExtraError, import_from
from habilis.progress import progress_bar
from habilis.worlds.map_writing import header_of
from habilis.worlds.moving import Where, elsewhere
from habilis.worlds.placements import start_of
from habilis.worlds.plans import check_certain
from habilis.worlds.reach import MAX_STATES, reachable
from habilis.worlds.world import NO_TOOL, Cell, World, load_world, world_names

if TYPE_CHECKING:
    from habilis.analysis.usefulness import Usefulness


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command.

    Returns:
        The exit status: 0 done, 1 the answer is "no" (a goal out of reach, a claim that does
        not hold), 2 bad input.
    """
    flags: dict[str, str] = {}
    lacks: tuple[str, ...] = ()
    try:
        args = parser(_VERBS).parse_args(arguments)
        flags, lacks = args.flags, getattr(args, "lacks", ())
        args.command = list(sys.argv[1:] if arguments is None else arguments)
        check_outputs(args)
        status = args.verb(args)
        sys.stdout.flush()
        return status
    except BrokenPipeError:
        # Whoever reads our output has gone; so that Python does not complain at exit either:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except (ValueError, MissingExtraError, FloatingPointError) as error:
        return refuse(in_flags(str(error), flags, lacks))
    except (OSError, OverflowError) as error:
        return refuse(f"{error}; check the place and the numbers given")
    except MemoryError:
        return refuse("not enough memory; make the world or the horizon smaller")
    except KeyboardInterrupt:
        return refuse("interrupted", status=130)


def worlds(args: Args) -> int:
    if args.name is None:
        if args.tool is not None or args.out is not None:
            raise ValueError("no world to draw; give its name besides --tool or --out")
        listed = [load_world(name) for name in world_names()]
        if args.json:
            return print_json({"worlds": [world.name for world in listed]})
        for world in listed:
            print(f"{world.name}: {world.height} x {world.width} cells, tool {world.tool}")
        return 0
    world = load_world(args.name, args.tool)
    if args.out is not None:
        from habilis.worlds.pictures.figures import save_picture

        with progress_bar("drawing", shows_progress(args)):
            save(args.out, lambda path: save_picture(world, path))
    header = header_of(world)
    if args.json:
        told = {"name": world.name, "height": world.height, "width": world.width}
        told |= {"tool": world.tool, "map": list(world.rows)}
        if header:
            told |= {"header": header}
        if world.several:
            told |= {"tools": [tool.name for tool in world.tools]}
            told |= {"objects": [thing.name for thing in world.objects]}
        return print_json(told)
    from habilis.worlds.pictures.figures import colored_text

    for line in header:
        print(line)
    console().print(colored_text(world))
    return 0


def solve(args: Args) -> int:
    world = check_certain(load_world(args.world, args.tool))
    mdp = habilis.tabulate(world, max_states=_most(args), show_progress=shows_progress(args))
    with progress_bar("solving", shows_progress(args)):
        plan = habilis.solve(mdp)
    if args.json:
        print_json(
            {"steps": None, "return": None, "actions": None}
            if plan is None
            else {"steps": plan.steps, "return": plan.best_return, "actions": list(plan.actions)}
        )
    elif plan is None:
        print("the goal is out of reach")
    else:
        print(f"{plan.steps} steps, return {plan.best_return:g}")
        print(", ".join(mdp.actions[action] for action in plan.actions))
    return 1 if plan is None else 0


def empowerment(args: Args) -> int:
    from habilis.analysis.data_frames import save_table, to_dataframe

    mdp = _table(args)
    values, gap = habilis.empowerment(
        mdp, args.horizon, args.sensor, _actions(args.actions), return_gap=True, **_options(args)
    )
    if args.out is not None:
        with_gap = gap.any() and args.out.suffix.lower() != ".npy"  # one column of values
        columns = {args.unit: values} | ({"gap": gap} if with_gap else {})
        save_table(to_dataframe(mdp, columns), args.out)
    summary = {
        "states": len(values),
        "mean": float(values.mean()),
        "min": float(values.min()),
        "max": float(values.max()),
        "gap": float(gap.max()),
    }
    if "equipped" in mdp.flags and mdp.flags["equipped"].any():
        summary["mean_equipped"] = float(values[mdp.flags["equipped"]].mean())
    if args.json:
        kind = {"unit": args.unit, "method": args.method}
        return print_json(summary | kind | {"out": args.out and str(args.out)})
    print(
        f"{lower_bounds(args)}{args.horizon}-step empowerment through the sensor {args.sensor!r}, "
        f"in {args.unit}"
    )
    for name, value in summary.items():
        style = {"states": ",", "gap": ".2g"}.get(name, ".4f")
        print(f"{name:>14}  {value:{style}}")
    if args.out is not None:
        print(f"values of all states: {args.out}")
    return 0


def _table(args: Args) -> habilis.TabularMDP:
    """The table of a world or, as `gym:ID`, of a Gymnasium environment."""
    if not args.world.startswith(PREFIX):
        if args.ignore:
            raise ValueError("--ignore is for environments, gym:ID; leave it out")
        world = load_world(args.world, args.tool)
        show = shows_progress(args)
        return habilis.tabulate(world, args.slip, max_states=_most(args), show_progress=show)
    if args.tool is not None:
        raise ValueError(f"{args.world} has no tool to choose; leave out --tool")
    from habilis.bridges.gymnasium import table_named

    name = args.world.removeprefix(PREFIX)
    mdp = table_named(name, args.max_states, args.ignore, shows_progress(args))
    return mdp.slippery(args.slip) if args.slip else mdp


def _most(args: Args) -> int:
    return MAX_STATES if args.max_states is None else args.max_states


def _options(args: Args) -> Any:
    """What the verb takes of the arguments of `habilis.empowerment`."""
    given = {name: getattr(args, name) for name in OPTIONS if name in args}
    return given | {"show_progress": shows_progress(args)}


def landscape(args: Args) -> int:
    from habilis.analysis.landscape import landscape as measure

    world = load_world(args.world, args.tool)
    found = measure(
        world,
        args.horizon,
        args.sensor,
        _actions(args.actions),
        slip=args.slip,
        tool=_where(world, "tool", args.tool_at),
        object=_where(world, "object", args.object_at),
        **_options(args),
    )
    if args.out is not None:
        with progress_bar("drawing", shows_progress(args)):
            save(args.out, found.save)
    if args.json:
        rows = [[None if np.isnan(v) else v for v in row] for row in found.values.tolist()]
        return print_json({"values": rows})
    for row in found.values:
        print(" ".join("    ." if np.isnan(value) else f"{value:5.2f}" for value in row))
    if args.out is not None:
        print(f"written: {args.out}")
    return 0


def _where(world: World, kind: str, places: list[tuple[str, Cell]] | None) -> Where | None:
    """Cells by names, or the cell of the only tool or object."""
    if places is None:
        return None
    if kind == "tool" and not world.tools:
        raise ValueError(f"{world.name} has no tool here; leave out --tool-at, or give --tool")
    where: dict[str, Cell] = {}
    for name, cell in places:
        if name in where:
            raise ValueError(f"--{kind}-at has {name or 'the ' + kind} twice; give it one cell")
        where[name] = cell
    if "" not in where:
        return where
    if len(where) > 1:
        raise ValueError(f"--{kind}-at has {where['']} without a name; say which, as NAME=1,2")
    return where[""]


def compare(args: Args) -> int:
    from habilis.analysis.averages import compare as measure
    from habilis.analysis.averages import ranking, with_each_tool
    from habilis.analysis.usefulness import usefulness

    if args.pairs:
        from habilis.cli_pairs import compare_pairs

        return compare_pairs(args)
    if args.out:
        raise ValueError("--out is for what --pairs finds; add --pairs, or leave out --out")
    if args.horizon is None:
        raise ValueError("no number of actions; give --horizon, as --horizon 3")
    world = load_world(args.world)
    if len(world.objects) > 1:
        named = ", ".join(thing.name for thing in world.objects)
        raise ValueError(f"{world.name} has several objects, {named}; add --pairs for each of them")
    tools = compared(world) if args.tools is None else args.tools
    averages = measure(world, tools, args.horizon, args.slip, **_options(args))
    verdicts = {
        tool: usefulness(armed, args.horizon, args.slip, **_options(args))
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


def futures(args: Args) -> int:
    from habilis.analysis.futures import futures as measure
    from habilis.analysis.futures import futures_figure, sequence_text

    world = load_world(args.world, args.tool)
    world = elsewhere(
        world,
        agent=args.agent_at,
        tool=_where(world, "tool", args.tool_at),
        object=_where(world, "object", args.object_at),
    )
    if world.several:
        steps = max(args.horizon, 0)
        most, show = _most(args), shows_progress(args)
        mdp = reachable(world, start_of(world), steps, most, show)[0].slippery(args.slip)
    else:
        show = shows_progress(args)
        mdp = habilis.tabulate(world, args.slip, max_states=_most(args), show_progress=show)
    cells = [name for name in mdp.factors if mdp.is_cell(name)]
    if args.out and (args.sensor == "state" or mdp.factor_named(args.sensor) not in cells):
        raise ValueError(
            f"a picture needs cells; use --sensor {', '.join(cells)}, or leave out --out"
        )
    found = measure(
        mdp, mdp.start, args.horizon, args.sensor, _actions(args.actions), **_options(args)
    )
    if args.out is not None:
        from habilis.worlds.pictures.figures import save_figure

        with progress_bar("drawing", shows_progress(args)):
            figure = futures_figure(world, mdp, found, args.sensor)
            save(args.out, lambda path: save_figure(figure, path))
    if args.json:
        return print_json(
            {
                "empowerment": found.empowerment,
                "gap": found.gap,
                "unit": found.unit,
                "sequences": found.sequences.tolist(),
                "probability": found.probability.tolist(),
                "observations": found.observations.tolist(),
                "seen": found.seen.tolist(),
            }
        )
    count = len(found.observations)
    possible = f"{count} possible observation{'s' if count > 1 else ''}"
    print(f"{found.empowerment:.4f} {found.unit}, {possible}")
    shown = list(zip(found.probability, found.sequences, strict=True))
    for probability, sequence in shown[:20]:
        print(f"{probability:8.2%}  {sequence_text(mdp, sequence)}")
    if len(shown) > 20:
        print(f"          and {len(shown) - 20} more sequences")
    if args.out is not None:
        print(f"picture: {args.out}")
    return 0


def reproduce(args: Args) -> int:
    study = import_from("habilis.studies.reproduce", "learn")
    result = study.reproduce(args.out, quick=args.quick, show_progress=True)
    if args.json:
        return print_json(result.summary())
    print(result.text())
    return 0


def reconstruct(args: Args) -> int:
    from habilis.studies.reconstruction.command import reconstruct as search

    return search(args)


def studio(args: Args) -> int:
    from habilis.cli_studio import studio as serve

    return serve(args)


def bench(args: Args) -> int:
    from habilis.benchmarks import run_benchmarks

    results = run_benchmarks(args.what)
    if args.json:
        return print_json({"results": [result.as_dict() for result in results]})
    for result in results:
        print(result)
    return 0


def _actions(text: str) -> list[int] | None:
    named = {"all": None, "moves": [0, 1, 2, 3], "tool": [4, 5, 6, 7]}
    if text in named:
        return named[text]
    try:
        return [int(part) for part in text.split(",")]
    except ValueError:
        raise ValueError(
            f"--actions {text!r} is unknown; use all, moves, tool, or indices as 0,1,2"
        ) from None


_VERBS: dict[str, Verb] = {
    verb.__name__: verb
    for verb in (
        worlds,
        solve,
        empowerment,
        landscape,
        futures,
        compare,
        train,
        watch,
        plot,
        sweep,
        reproduce,
        study,
        reconstruct,
        studio,
        bench,
    )
}


if __name__ == "__main__":
    sys.exit(main())
