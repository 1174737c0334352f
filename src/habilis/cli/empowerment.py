"""`habilis empowerment`: the empowerment of every state."""

import argparse
from pathlib import Path

import habilis
from habilis.cli.arguments import (
    Args,
    action_indices,
    add_measure,
    add_most,
    add_options,
    add_world,
    max_states,
    measure_options,
)
from habilis.cli.output import lower_bounds, print_json, shows_progress
from habilis.extras import import_from
from habilis.files import TABLES
from habilis.worlds.world import ENVIRONMENT, load_world

HELP: str = "compute the empowerment of every state"
EXAMPLE: str = "habilis empowerment corridor --sensor object --horizon 6 --out bits.csv"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_world(parser, or_environment=True)
    add_measure(parser)
    add_options(parser)
    add_most(parser)
    text = "attribute of an environment that is not part of its state, such as a step counter"
    parser.add_argument("--ignore", action="append", default=[], metavar="NAME", help=text)
    parser.add_argument(
        "--out", type=Path, metavar="F.csv", help="all values (.csv, .parquet, .npz, .npy)"
    )
    parser.set_defaults(writes={"out": TABLES})


def run(args: Args) -> int:
    from habilis.analysis.data_frames import save_table, to_dataframe

    mdp = _table(args)
    values, gap = habilis.empowerment(
        mdp,
        args.horizon,
        args.sensor,
        action_indices(args.actions),
        return_gap=True,
        **measure_options(args),
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
