"""`habilis reconstruct`: a search for maps."""

import argparse
from pathlib import Path

from habilis.cli.arguments import Args
from habilis.files import FOLDER

HELP: str = (
    "search for maps that meet stated numbers, because the paper's own maps are not available"
)
EXAMPLE: str = "habilis reconstruct corridor --count 6 --seed 0 --out maps"
COMMON: tuple[str, ...] = ("--count", "--seed", "--out")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    stated = "corridor, yard, yard-apart, or a TOML file of stated numbers"
    parser.add_argument("stated", metavar="LIST", help=stated)
    parser.add_argument(
        "--count", type=int, default=1, metavar="N", help="number of maps (default 1)"
    )
    parser.add_argument("--seed", type=int, default=0, help="seed of the search (default 0)")
    parser.add_argument("--out", type=Path, metavar="DIR", help="where to write the maps as text")
    parser.add_argument(
        "--attempts",
        type=int,
        default=200,
        metavar="N",
        help="largest number of attempts (default 200)",
    )
    first = "number of the first attempt, to continue a search (default 1)"
    parser.add_argument("--attempt", type=int, default=1, metavar="N", help=first)
    changes = "largest number of changes in an attempt (default 2000)"
    parser.add_argument("--changes", type=int, default=2000, metavar="N", help=changes)
    parser.add_argument("--hot", type=float, default=1.0, metavar="T", help="initial temperature")
    begin = "map that each attempt starts from (default: a random one)"
    parser.add_argument("--from", dest="begin", metavar="WORLD", help=begin)
    after = "folder of earlier maps: new ones differ from them, and are numbered from the last"
    parser.add_argument("--after", type=Path, metavar="DIR", help=after)
    reading = "reading of rules 3 to 5: some of 'pushes shoves sweeps sticky'"
    parser.add_argument("--reading", default="", metavar="WORDS", help=reading)
    over = ("equipped", "all", "reachable")
    parser.add_argument(
        "--over", choices=over, default=over[0], help="states that averages are taken over"
    )
    parser.set_defaults(writes={"out": FOLDER})


def run(args: Args) -> int:
    from habilis.studies.reconstruction.command import reconstruct as search

    return search(args)
