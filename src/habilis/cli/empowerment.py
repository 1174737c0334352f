"""`habilis empowerment`: the empowerment of every state."""

import argparse
from pathlib import Path

import numpy as np
from jaxtyping import Float64

import habilis
from habilis.bridges import table_files
from habilis.bridges.puzzles.pushworld import PushWorld
from habilis.cli.arguments import (
    Args,
    action_indices,
    add_kind,
    add_measure,
    add_most,
    add_options,
    add_player,
    add_world,
    horizon_of,
    max_states,
    measure_options,
)
from habilis.cli.executors import add_executor
from habilis.cli.output import lower_bounds, print_json, print_written, shows_progress
from habilis.cli.puzzles import puzzle_of
from habilis.empowerment.kinds import OPEN_LOOP, WHOLE, checked_kind, named, of_kind
from habilis.extras import import_from
from habilis.files import TABLES
from habilis.models.limits import TooManyStatesError
from habilis.worlds.world import ENVIRONMENT, load_world

HELP: str = "compute the empowerment of every state"
EXAMPLE: str = "habilis empowerment corridor --sensor object --horizon 6 --out bits.csv"
COMMON: tuple[str, ...] = ("--horizon", "--sensor", "--out")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_world(parser, or_environment=True)
    add_measure(parser, needs_horizon=False)
    add_kind(parser)
    add_options(parser)
    add_most(parser)
    text = "of the first state alone; of a puzzle, then only what the horizon reaches is explored"
    parser.add_argument("--start", action="store_true", help=text)
    add_player(parser)
    text = "attribute of an environment that is not part of its state, such as a step counter"
    parser.add_argument("--ignore", action="append", default=[], metavar="NAME", help=text)
    parser.add_argument(
        "--out", type=Path, metavar="F.csv", help="all values (.csv, .parquet, .npz, .npy)"
    )
    parser.set_defaults(writes={"out": TABLES})
    add_executor(parser)


def run(args: Args) -> int:
    from habilis.analysis.data_frames import save_table, to_dataframe

    horizon = horizon_of(args)
    mdp = _table(args, horizon)
    states = [mdp.start] if args.start else None
    values, gap = _values(args, mdp, horizon, states)
    if args.out is not None:
        with_gap = gap.any() and args.out.suffix.lower() != ".npy"  # one column of values
        columns = {args.unit: values} | ({"gap": gap} if with_gap else {})
        save_table(to_dataframe(mdp, columns, states=states), args.out)
    summary = {
        "states": len(values),
        "mean": float(values.mean()),
        "min": float(values.min()),
        "max": float(values.max()),
        "gap": float(gap.max()),
    }
    if states is None and "equipped" in mdp.flags and mdp.flags["equipped"].any():
        summary["mean_equipped"] = float(values[mdp.flags["equipped"]].mean())
    if args.json:
        kind = {"unit": args.unit, "method": args.method}
        if args.kind != OPEN_LOOP:
            kind |= {"kind": args.kind}
        if args.player is not None:
            kind |= {"player": args.player, "others": args.others or "uniform"}
        return print_json(summary | kind | {"out": args.out and str(args.out)})
    print(
        f"{lower_bounds(args)}{named(args.kind, horizon, args.discount)}{_of_whom(args)} "
        f"through the sensor {args.sensor!r}, in {args.unit}"
    )
    for name, value in summary.items():
        style = {"states": ",", "gap": ".2g"}.get(name, ".4f")
        print(f"{name:>14}  {value:{style}}")
    if args.out is not None:
        print_written(args.out)
    return 0


def _values(
    args: Args, mdp: habilis.TabularMDP, horizon: int, states: list[int] | None
) -> tuple[Float64[np.ndarray, "n"], Float64[np.ndarray, "n"]]:
    """Values and gaps."""
    asked = horizon, args.sensor, action_indices(args.actions), states
    options = measure_options(args)
    checked_kind(args.kind, args.discount, args.slack)
    if args.kind == OPEN_LOOP:
        players = {"player": args.player, "others": args.others}
        return habilis.empowerment(mdp, *asked, **players, return_gap=True, **options)
    if args.others in ("best", "worst"):
        raise ValueError(
            f"--others {args.others} goes with --kind {OPEN_LOOP}; leave one of them out"
        )
    if args.player is not None:
        mdp = mdp.of_player(args.player, args.others or "uniform")
    elif args.others is not None:
        raise ValueError("--others is given without --player; name the player")
    return of_kind(args.kind, mdp, *asked, args.discount, args.slack, options)


def _of_whom(args: Args) -> str:
    """The player and what the others do, as the first line says it."""
    if args.player is None:
        return ""
    others = {"best": "at their best for it", "worst": "at their worst for it"}
    return f" of {args.player!r}, the others {others.get(args.others, 'acting uniformly')},"


def _table(args: Args, horizon: int) -> habilis.TabularMDP:
    """The table of a world, a puzzle, a file or, as `gym:ID`, of a Gymnasium environment."""
    puzzle = puzzle_of(args, args.world, ("tool", "ignore"))
    if puzzle is not None:
        return _explored(args, puzzle, horizon).slippery(args.slip)
    if table_files.names_table(args.world):
        for flag, given in (("--tool", args.tool), ("--ignore", args.ignore)):
            if given:
                raise ValueError(f"{flag} is given for a table, {args.world}; leave it out")
        return table_files.table_named(args.world).slippery(args.slip)
    if not args.world.startswith(ENVIRONMENT):
        if args.ignore:
            raise ValueError("--ignore is for environments, gym:ID; leave it out")
        world = load_world(args.world, args.tool)
        show = shows_progress(args)
        return habilis.tabulate(world, args.slip, max_states=max_states(args), show_progress=show)
    if args.tool is not None:
        raise ValueError(f"{args.world} has no tool to choose; leave out --tool")
    named = import_from("habilis.bridges.gymnasium.named", "gymnasium")
    name = args.world.removeprefix(ENVIRONMENT)
    mdp = named.table_named(name, args.max_states, args.ignore, shows_progress(args))
    return mdp.slippery(args.slip) if args.slip else mdp


def _explored(args: Args, puzzle: PushWorld, horizon: int) -> habilis.TabularMDP:
    """What can be reached in a puzzle, or within the horizon."""
    steps = max(horizon, 0) if args.start and args.kind not in WHOLE else None
    most, show = max_states(args), shows_progress(args)
    try:
        return habilis.explore(puzzle, None, steps, most, show_progress=show)
    except TooManyStatesError:
        if args.start:
            raise
        raise ValueError(
            f"more than {most:,} states of {puzzle.name} can be reached; give --start for the "
            "first alone, or raise max_states if there is memory for it"
        ) from None
