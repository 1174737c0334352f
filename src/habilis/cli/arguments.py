"""Arguments that several verbs share."""

import argparse
from dataclasses import fields
from typing import Any

from habilis.cli.output import shows_progress
from habilis.empowerment.kinds import EFFECTIVE, KINDS, OPEN_LOOP
from habilis.empowerment.methods import Exact, Sampled
from habilis.worlds.reach import MAX_STATES
from habilis.worlds.things import Where
from habilis.worlds.world import ENVIRONMENT, Cell, World

Args = argparse.Namespace

TOOLS = "picker, broom, rake, stick, magnet, none or your own as FILE.py:CLASS"


def add_world(parser: argparse.ArgumentParser, or_environment: bool = False) -> None:
    text = "a built-in world, a map file, or a puzzle file (.pwp, .xsb, LEVELS.xsb#3)"
    if or_environment:
        text += ", a table (.npz, or .drn of Storm)"
        text += f", or a Gymnasium environment as {ENVIRONMENT}FrozenLake-v1?map_name=8x8"
    parser.add_argument("world", metavar="WORLD", help=text)
    add_tool(parser)


def add_tool(parser: argparse.ArgumentParser) -> None:
    text = f"{TOOLS}; replaces the tool of the map"
    parser.add_argument("--tool", metavar="TOOL", help=text)


def add_measure(parser: argparse.ArgumentParser, needs_horizon: bool = True) -> None:
    """The sensor, horizon and actions; where there are kinds, `horizon_of` checks the horizon."""
    sensor = "state, agent, tool, object, one of several as object:can, rest for all but the "
    sensor += "agent, or a sum or product of values as 'object:can + object:ball', "
    sensor += "'object:can * object:ball' (default state)"
    parser.add_argument("--sensor", default="state", help=sensor)
    text = "number of actions"
    parser.add_argument("--horizon", type=int, required=needs_horizon, metavar="H", help=text)
    parser.add_argument("--actions", default="all", help="all, moves, tool, or indices as 0,1,2")
    add_slip(parser)


def add_kind(parser: argparse.ArgumentParser) -> None:
    text = f"kind of empowerment: {', '.join(KINDS)} (default {OPEN_LOOP})"
    parser.add_argument("--kind", choices=KINDS, default=OPEN_LOOP, help=text, metavar="KIND")
    text = "discount of effective empowerment, which has no horizon"
    parser.add_argument("--discount", type=float, metavar="G", help=text)
    text = "steps that goal-directed empowerment may add to a shortest way (default 0)"
    parser.add_argument("--slack", type=int, metavar="N", help=text)


def horizon_of(args: Args) -> int:
    """The horizon; any for a kind without one.

    Raises:
        ValueError: it is missing.
    """
    if args.horizon is None and args.kind != EFFECTIVE:
        raise ValueError("--horizon is missing; give a number of actions, as --horizon 3")
    return 1 if args.horizon is None else args.horizon


def add_player(parser: argparse.ArgumentParser) -> None:
    """Whose empowerment it is, where there are several agents."""
    text = "agent whose empowerment is computed, of a map with two or a table of several players"
    parser.add_argument("--player", metavar="NAME", help=text)
    text = "what the other players do: uniform (the default), or their best or worst for the player"
    parser.add_argument("--others", choices=("uniform", "best", "worst"), help=text)


def add_places(parser: argparse.ArgumentParser) -> None:
    cell: dict[str, Any] = {"type": parse_placed_cell, "metavar": "[NAME=]ROW,COLUMN"}
    text = "cell of the tool (default: that of the map); one of several as picker=2,6; repeatable"
    parser.add_argument("--tool-at", action="append", help=text, **cell)
    text = "cell of the can (default: that of the map); one of several as can=2,6; repeatable"
    parser.add_argument("--object-at", action="append", help=text, **cell)


def add_slip(parser: argparse.ArgumentParser) -> None:
    slip = "probability that a random action replaces the chosen one (default 0)"
    parser.add_argument("--slip", type=float, default=0.0, metavar="P", help=slip)


def add_unit(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--unit", choices=("bits", "nats"), default="bits", help="unit of all values"
    )


def add_options(parser: argparse.ArgumentParser) -> None:
    """Adds the unit, and the method with its settings under their names."""
    add_unit(parser)
    add_tolerance(parser)
    parser.add_argument(
        "--method", choices=("exact", "sampled"), default="exact", help="sampled: a lower bound"
    )
    text = f"number of sampled action sequences (default {Sampled.samples})"
    parser.add_argument("--samples", type=int, default=Sampled.samples, help=text)
    text = f"seed of the samples (default {Sampled.seed})"
    parser.add_argument("--seed", type=int, default=Sampled.seed, help=text)
    parser.add_argument("--threads", type=int, help="number of threads (default: all processors)")
    add_limits(parser)


def add_tolerance(parser: argparse.ArgumentParser) -> None:
    text = f"gap to reach (default {Exact.tolerance:g})"
    parser.add_argument("--tolerance", type=float, default=Exact.tolerance, help=text)


def add_limits(parser: argparse.ArgumentParser) -> None:
    text = f"memory limit in GiB (default {Exact.max_gib:g})"
    parser.add_argument("--max-gib", type=float, default=Exact.max_gib, help=text)
    text = f"time limit in seconds (default {Exact.max_seconds:g})"
    parser.add_argument("--max-seconds", type=float, default=Exact.max_seconds, help=text)


def add_most(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--max-states", type=int, metavar="N", help="largest number of states accepted"
    )


def parse_cell(text: str) -> Cell:
    try:
        row, column = (int(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a cell; write row,column, as in 2,6"
        ) from None
    return row, column


def parse_placed_cell(text: str) -> tuple[str, Cell]:
    """A name, "" if none is given, and its cell."""
    name, _, cell = text.rpartition("=")
    return name, parse_cell(cell)


def parse_words(text: str) -> list[str]:
    return [word for word in text.split(",") if word]


def parse_positive(text: str) -> float:
    value = float(text)
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is not positive")
    return value


def max_states(args: Args) -> int:
    return MAX_STATES if args.max_states is None else args.max_states


def measure_options(args: Args) -> Any:
    """The arguments of `habilis.empowerment` that options of the verb give."""
    kind = Sampled if getattr(args, "method", "exact") == "sampled" else Exact
    method = kind(**{f.name: getattr(args, f.name) for f in fields(kind) if f.name in args})
    options = {"method": method, "unit": args.unit, "show_progress": shows_progress(args)}
    executor = getattr(args, "executor", None)
    return options if executor is None else options | {"executor": executor}


def cells_of(world: World, kind: str, places: list[tuple[str, Cell]] | None) -> Where | None:
    """Cells by name, or the cell of the only tool or object."""
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
        raise ValueError(f"--{kind}-at has {where['']} without a name; specify which, as NAME=1,2")
    return where[""]


def action_indices(text: str) -> list[int] | None:
    named = {"all": None, "moves": [0, 1, 2, 3], "tool": [4, 5, 6, 7]}
    if text in named:
        return named[text]
    try:
        return [int(part) for part in text.split(",")]
    except ValueError:
        raise ValueError(
            f"--actions {text!r} is unknown; use all, moves, tool, or indices as 0,1,2"
        ) from None
