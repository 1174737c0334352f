"""`habilis sweep`: a grid of configurations, or a search."""

import argparse
from pathlib import Path

from habilis.cli.arguments import Args
from habilis.cli.output import print_json, shows_progress
from habilis.extras import import_from
from habilis.files import FOLDER

HELP: str = "train a grid of configurations, or search for the best"
EXAMPLE: str = "habilis sweep SPEC.toml --out sweeps/beta"
COMMON: tuple[str, ...] = ("--out", "--resume", "--processes")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "spec", type=Path, metavar="SPEC.toml", help="with [config], and [grid] or [search]"
    )
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="a new folder")
    parser.add_argument(
        "--resume", action="store_true", help="continue the interrupted sweep in --out DIR"
    )
    ray = "train on a Ray cluster: HOST:PORT, auto, or local to start one here"
    parser.add_argument("--ray", metavar="ADDRESS", help=ray)
    text = "number of processes, at most as many as memory allows (default: this process)"
    parser.add_argument("--processes", type=int, metavar="N", help=text)
    parser.set_defaults(writes={"out": FOLDER})


def run(args: Args) -> int:
    command = import_from("habilis.sweeps.command", "learn")
    result = command.run(args, shows_progress(args))
    if args.json:
        return print_json(result)
    command.show(result)
    return 0
