"""What each verb of the command line takes."""

import argparse
import re
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Any, NoReturn

import habilis
from habilis.files import FILMS, FOLDER, PICTURES, TABLES
from habilis.worlds.world import ENVIRONMENT, NO_TOOL, Cell, World

Args = argparse.Namespace
Verb = Callable[[Args], int]

PREFIX = ENVIRONMENT
OPTIONS = (
    *("unit", "tolerance", "method", "samples", "seed", "threads", "max_gib", "max_seconds"),
)
COMPARED = ("picker", "broom", NO_TOOL)
"""The tools that are compared, after those of the map, where nobody says which."""
PAIRS_HORIZON = 6
_PYTHON_ONLY = ("max_states", "key", "state", "ignore", "factors", "starts", "states")
"""Arguments that errors of the library name, besides those that are options of the verbs."""

_QUOTES = "'[]"

_TOOLS = "picker, broom, rake, stick, magnet, none or one of your own as FILE.py:CLASS"
_ABOUT = "Exact empowerment of finite MDPs, tool-use worlds, and agents that learn with it."


def compared(world: World) -> list[str]:
    """The map's own tools, as it has them, and those that come with the package, each once.

    On a map without a place for a tool only the bare agent can be compared.
    """
    if world.tool_cell is None and not world.tools:
        return [NO_TOOL]
    return [*dict.fromkeys([*(tool.name for tool in world.tools), *COMPARED])]


class _Parser(argparse.ArgumentParser):
    """Refuses bad usage in one line, as every other bad input is."""

    def error(self, message: str) -> NoReturn:
        raise ValueError(f"{message}; see {self.prog} --help")


class _VerbParser(_Parser):
    """Refuses what a verb does not take itself, so that the line names the help of the verb."""

    def parse_known_args(  # pyright: ignore[reportIncompatibleMethodOverride]
        self, args: Any = None, namespace: Any = None
    ) -> Any:
        found, others = super().parse_known_args(args, namespace)
        if others:
            self.error(f"unrecognized arguments: {' '.join(others)}")
        return found, []


def parser(functions: Mapping[str, Verb]) -> argparse.ArgumentParser:
    """The whole command line.

    Args:
        functions: what each verb does, by its name.
    """
    whole = _Parser(prog="habilis", description=_ABOUT)
    whole.add_argument("--version", action="version", version=habilis.__version__)
    verbs = whole.add_subparsers(required=True, metavar="VERB", parser_class=_VerbParser)

    def verb(name: str, text: str, example: str) -> argparse.ArgumentParser:
        added = verbs.add_parser(
            name,
            help=text,
            description=text[0].upper() + text[1:] + ".",
            epilog=f"example: {example}",
        )
        added.set_defaults(verb=functions[name])
        added.add_argument("--json", action="store_true", help="print JSON, for machines")
        return added

    v = verb("worlds", "list the built-in worlds, or draw one", "habilis worlds yard --tool broom")
    v.add_argument("name", nargs="?", metavar="NAME", help="a built-in world or a map file")
    _tool(v)
    v.add_argument("--out", type=Path, metavar="F.png", help="picture (.png, .svg, .pdf)")
    v.set_defaults(writes={"out": PICTURES})

    v = verb("solve", "find a shortest plan", "habilis solve corridor --tool none")
    _world(v)
    _most(v)

    v = verb(
        "empowerment",
        "compute the empowerment of every state",
        "habilis empowerment corridor --sensor object --horizon 6 --out bits.csv",
    )
    _world(v, or_environment=True)
    _measure(v)
    _options(v)
    _most(v)
    text = "an attribute of an environment that is no part of its state, as a counter of steps"
    v.add_argument("--ignore", action="append", default=[], metavar="NAME", help=text)
    v.add_argument(
        "--out", type=Path, metavar="F.csv", help="all values (.csv, .parquet, .npz, .npy)"
    )
    v.set_defaults(writes={"out": TABLES})

    v = verb(
        "landscape",
        "empowerment for every agent cell, everything else as on the map",
        "habilis landscape corridor --sensor object --horizon 6 --out landscape.png",
    )
    _world(v)
    _measure(v)
    _options(v)
    _places(v)
    kinds = "picture (.png, .svg, .pdf) or values (.csv, .parquet, .npz, .npy)"
    v.add_argument("--out", type=Path, metavar="F.png", help=kinds)
    v.set_defaults(writes={"out": (*PICTURES, *TABLES)})

    v = verb(
        "futures",
        "the action sequences worth choosing among, from the map's start",
        "habilis futures yard --sensor object --horizon 3 --agent-at 8,5 --tool-at 8,4",
    )
    _world(v)
    _measure(v)
    _unit(v)
    _tolerance(v)
    _limits(v)
    _most(v)
    v.set_defaults(lacks=("method", "samples", "seed", "threads"))
    v.add_argument("--agent-at", type=_cell, metavar="ROW,COLUMN", help="another for the agent")
    _places(v)
    v.add_argument("--out", type=Path, metavar="F.png", help="picture (.png, .svg, .pdf)")
    v.set_defaults(writes={"out": PICTURES})

    v = verb(
        "compare",
        "average object empowerment with each tool, and without",
        "habilis compare yard --tools picker,broom,none --horizon 3",
    )
    v.add_argument("world", metavar="WORLD", help="a built-in world or a map file")
    text = f"each {_TOOLS}, or one of the map's (default: those of the map, then"
    text += f" {','.join(COMPARED)} where the map has a place for a tool)"
    v.add_argument("--tools", type=_words, metavar="A,B,...", help=text)
    text = f"number of actions (with --pairs up to so many, by default {PAIRS_HORIZON})"
    v.add_argument("--horizon", type=int, metavar="H", help=text)
    text = (
        "every tool by every object of the map (default of --tools then all of the map, and none)"
    )
    v.add_argument("--pairs", action="store_true", help=text)
    kinds = "of --pairs: picture (.png, .svg, .pdf) or values (.csv, .parquet, .npz, .npy)"
    text = f"{kinds}; again for another"
    v.add_argument("--out", type=Path, action="append", default=[], metavar="F.png", help=text)
    v.set_defaults(writes={"out": (*PICTURES, *TABLES)})
    _slip(v)
    _options(v)

    v = verb(
        "train",
        "train agents, with empowerment in the reward or without",
        "habilis train corridor --intrinsic object --horizon 6 --beta 0.07 --out runs/toe",
    )
    _world(v)
    from habilis.learning.arguments import add_config_arguments

    add_config_arguments(v)
    v.add_argument("--out", type=Path, required=True, metavar="DIR", help="a new folder")
    v.add_argument("--resume", action="store_true", help="go on where --out DIR was interrupted")
    seconds = "time between checkpoints (default 10)"
    v.add_argument("--checkpoint-seconds", type=float, default=10.0, metavar="S", help=seconds)
    lanes = (
        "runs in one compiled batch; another number is another rounding, so another run (default 5 "
        "on a CPU; on a GPU as many as wait, 512 at most)"
    )
    v.add_argument("--lanes", type=int, metavar="N", help=lanes)
    v.set_defaults(writes={"out": FOLDER})

    v = verb(
        "watch", "replay what an agent learned", "habilis watch runs/toe --run 2 --gif toe.gif"
    )
    v.add_argument("folder", type=Path, metavar="DIR", help="folder of a run")
    v.add_argument("--run", type=int, default=0, help="which of its runs (default 0)")
    seed = "of what happens at random, in a stochastic world (default 0)"
    v.add_argument("--seed", type=int, default=0, help=seed)
    v.add_argument("--gif", type=Path, metavar="F.gif", help="write the episode as a GIF")
    v.add_argument("--mp4", type=Path, metavar="F.mp4", help="or as a video (extra [video])")
    v.set_defaults(writes={"gif": FILMS[:1], "mp4": FILMS[1:]})
    v.add_argument("--speed", type=_positive, default=4.0, help="steps a second (default 4)")

    v = verb(
        "plot",
        "draw learning curves with intervals, of one or several runs",
        "habilis plot runs/none runs/toe --out curves.svg",
    )
    v.add_argument("folders", type=Path, nargs="+", metavar="DIR", help="folders of runs")
    v.add_argument(
        "--out",
        type=Path,
        metavar="F.png",
        help="picture (.png, .svg, .pdf; default curves.png, or none with --json)",
    )
    v.set_defaults(writes={"out": PICTURES})
    v.add_argument("--x", choices=("episodes", "steps"), default="episodes", help="to the right")
    v.add_argument(
        "--value",
        choices=("return", "length", "equipped", "attached"),
        default="return",
        help="of an episode: its extrinsic return (default), its steps, the share of them with the "
        "tool in hand, or the share of these with the object attached",
    )
    v.add_argument(
        "--statistic",
        choices=("mean", "iqm"),
        default="mean",
        help="over the runs: their mean (default), or that of the middle half of them",
    )

    v = verb(
        "sweep",
        "train a grid of configurations, or search for the best",
        "habilis sweep SPEC.toml --out sweeps/beta",
    )
    v.add_argument("spec", type=Path, metavar="SPEC.toml", help="[config], and [grid] or [search]")
    v.add_argument("--out", type=Path, required=True, metavar="DIR", help="a new folder")
    v.add_argument("--resume", action="store_true", help="go on where --out DIR was interrupted")
    ray = "train on a Ray cluster: HOST:PORT, auto, or local to start one here"
    v.add_argument("--ray", metavar="ADDRESS", help=ray)
    text = "train in so many processes, or as many as there is memory for (default: in this one)"
    v.add_argument("--processes", type=int, metavar="N", help=text)
    v.set_defaults(writes={"out": FOLDER})

    v = verb(
        "reproduce",
        "recompute the paper: every table, figure and number",
        "habilis reproduce --out paper",
    )
    v.add_argument("--out", type=Path, required=True, metavar="DIR", help="a new folder")
    v.add_argument("--quick", action="store_true", help="few runs and episodes, in 3 minutes")
    v.set_defaults(writes={"out": FOLDER})

    v = verb(
        "study",
        "train agents where there are several tools, objects or placements, and compare rewards",
        "habilis study choosing two-goals unseen --out studies",
    )
    text = "choosing, two-goals, unseen (default: all three)"
    v.add_argument("names", nargs="*", metavar="NAME", help=text)
    v.add_argument("--out", type=Path, required=True, metavar="DIR", help="a new folder")
    v.add_argument("--resume", action="store_true", help="go on where --out DIR was interrupted")
    v.add_argument("--quick", action="store_true", help="so little that it says nothing: a trial")
    v.set_defaults(writes={"out": FOLDER})

    v = verb(
        "reconstruct",
        "search for maps that meet stated numbers, because the paper's own maps are not available",
        "habilis reconstruct corridor --count 6 --seed 0 --out maps",
    )
    stated = "corridor, yard, yard-apart, or a TOML file of stated numbers"
    v.add_argument("stated", metavar="LIST", help=stated)
    v.add_argument("--count", type=int, default=1, metavar="N", help="of maps (default 1)")
    v.add_argument("--seed", type=int, default=0, help="of the search (default 0)")
    v.add_argument("--out", type=Path, metavar="DIR", help="where to write the maps as text")
    v.add_argument("--attempts", type=int, default=200, metavar="N", help="at most (default 200)")
    first = "number of the first, to go on where a search was stopped (default 1)"
    v.add_argument("--attempt", type=int, default=1, metavar="N", help=first)
    changes = "at most in an attempt (default 2000)"
    v.add_argument("--changes", type=int, default=2000, metavar="N", help=changes)
    v.add_argument("--hot", type=float, default=1.0, metavar="T", help="temperature to begin at")
    begin = "begin each attempt with this map (default: at random)"
    v.add_argument("--from", dest="begin", metavar="WORLD", help=begin)
    after = "folder with earlier maps: others are found, and numbered on from them"
    v.add_argument("--after", type=Path, metavar="DIR", help=after)
    reading = "how rules 3 to 5 are read: some of 'pushes shoves sweeps sticky'"
    v.add_argument("--reading", default="", metavar="WORDS", help=reading)
    over = ("equipped", "all", "reachable")
    v.add_argument("--over", choices=over, default=over[0], help="states that averages go over")
    v.set_defaults(writes={"out": FOLDER})

    v = verb(
        "studio",
        "draw worlds in a browser and see their empowerment at once",
        "habilis studio --port 8000",
    )
    v.add_argument(
        "run", nargs="?", type=Path, metavar="RUN", help="a trained run's folder to show"
    )
    loopback = "address to listen on (default 127.0.0.1: only this machine can reach it)"
    v.add_argument("--host", default="127.0.0.1", help=loopback)
    v.add_argument("--port", type=int, default=0, help="default 0: any that is free")
    own = "one of your own as FILE.py:CLASS, beside picker and broom; again for another"
    v.add_argument("--tool", action="append", default=[], dest="tools", metavar="TOOL", help=own)
    kept = "keep what is trained from the page there (default: until the studio ends)"
    v.add_argument("--out", type=Path, metavar="DIR", help=kept)
    v.set_defaults(writes={"out": FOLDER})
    v.add_argument("--no-browser", action="store_true", help="only print the address")

    v = verb("bench", "measure our speed beside the alternatives", "habilis bench empowerment")
    v.add_argument("what", nargs="*", metavar="WHAT", help="which benchmarks (default all)")
    for added in verbs.choices.values():
        flags = {a.dest: a.option_strings[0] for a in added._actions if a.option_strings}
        added.set_defaults(flags=flags)
    return whole


def in_flags(message: str, flags: Mapping[str, str], lacks: Collection[str] = ()) -> str:
    """An error of the library as the command line says it: arguments by their options.

    Args:
        message: names arguments as Python has them, as in `raise max_gib` and `unit='nats'`.
        flags: the options of the verb, by the names of their arguments.
        lacks: arguments that its function in Python does not have either.

    Example:
        >>> in_flags("slip is 2; give slip=0.1 or raise max_gib", {"slip": "--slip"})
        '--slip is 2; give --slip 0.1 or raise max_gib (in Python)'
    """
    names = sorted({*flags, *OPTIONS, *_PYTHON_ONLY}, key=len, reverse=True)
    every, long = "|".join(names), "|".join(name for name in names if "_" in name)
    named = re.compile(
        rf"(?<![\w./-])(?P<given>{every})=(?P<value>'[^']*'|\[[^]]*\]|[\w.]+)?"
        rf"|(?<![\w./'-])(?P<long>{long})(?![\w./'=])"
        rf"|(?:^|(?<=: )|(?<=, )|(?<=and )|(?<=but ))(?P<subject>{every})(?= (?:is|has|have) )"
    )

    def said(found: re.Match[str]) -> str:
        name = found["given"] or found["long"] or found["subject"]
        if name in flags:
            return f"{flags[name]} {(found['value'] or '').strip(_QUOTES)}".rstrip()
        return found[0] if found["subject"] or name in lacks else f"{found[0]} (in Python)"

    return named.sub(said, message)


def _world(parser: argparse.ArgumentParser, or_environment: bool = False) -> None:
    text = "a built-in world or a map file"
    if or_environment:
        text += f", or a Gymnasium environment as {PREFIX}FrozenLake-v1?map_name=8x8"
    parser.add_argument("world", metavar="WORLD", help=text)
    _tool(parser)


def _tool(parser: argparse.ArgumentParser) -> None:
    text = f"{_TOOLS}, in the place of the map's own"
    parser.add_argument("--tool", metavar="TOOL", help=text)


def _measure(parser: argparse.ArgumentParser) -> None:
    sensor = "state, agent, tool, object, or one of several as object:can (default state)"
    parser.add_argument("--sensor", default="state", help=sensor)
    parser.add_argument("--horizon", type=int, required=True, help="number of actions")
    parser.add_argument("--actions", default="all", help="all, moves, tool, or indices as 0,1,2")
    _slip(parser)


def _places(parser: argparse.ArgumentParser) -> None:
    where: dict[str, Any] = {"type": _place, "action": "append", "metavar": "[NAME=]ROW,COLUMN"}
    text = "another cell for the tool; of several as picker=2,6, and again for another"
    parser.add_argument("--tool-at", help=text, **where)
    text = "another for the can; of several as can=2,6, and again for another"
    parser.add_argument("--object-at", help=text, **where)


def _slip(parser: argparse.ArgumentParser) -> None:
    slip = "probability that a random action replaces the chosen one (default 0)"
    parser.add_argument("--slip", type=float, default=0.0, metavar="P", help=slip)


def _unit(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--unit", choices=("bits", "nats"), default="bits", help="of all values")


def _options(parser: argparse.ArgumentParser) -> None:
    """What `OPTIONS` lists: arguments of `habilis.empowerment` by their names."""
    _unit(parser)
    _tolerance(parser)
    parser.add_argument(
        "--method", choices=("exact", "sampled"), default="exact", help="sampled: a lower bound"
    )
    parser.add_argument("--samples", type=int, default=1000, help="sequences (default 1000)")
    parser.add_argument("--seed", type=int, default=0, help="of the samples (default 0)")
    parser.add_argument("--threads", type=int, help="how many work side by side")
    _limits(parser)


def _tolerance(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--tolerance", type=float, default=1e-6, help="gap to reach (default 1e-6)")


def _limits(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--max-gib", type=float, default=8.0, help="memory limit (default 8)")
    parser.add_argument("--max-seconds", type=float, default=3600.0, help="limit (default 3600)")


def _most(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--max-states", type=int, metavar="N", help="how many states to accept")


def _cell(text: str) -> Cell:
    try:
        row, column = (int(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a cell; write row,column, as in 2,6"
        ) from None
    return row, column


def _place(text: str) -> tuple[str, Cell]:
    """A name, "" if it is not said, and the cell for it."""
    name, _, cell = text.rpartition("=")
    return name, _cell(cell)


def _words(text: str) -> list[str]:
    return [word for word in text.split(",") if word]


def _positive(text: str) -> float:
    value = float(text)
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is not above 0")
    return value
