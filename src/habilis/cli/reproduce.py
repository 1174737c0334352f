"""`habilis reproduce`: the paper, recomputed."""

import argparse
from pathlib import Path

from habilis.cli.arguments import Args
from habilis.cli.output import print_json
from habilis.extras import import_from
from habilis.files import FOLDER

HELP: str = "recompute the paper: every table, figure and number"
EXAMPLE: str = "habilis reproduce --out paper"
COMMON: tuple[str, ...] = ("--out", "--quick")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="a new folder")
    parser.add_argument("--quick", action="store_true", help="few runs and episodes, a minute")
    parser.set_defaults(writes={"out": FOLDER})


def run(args: Args) -> int:
    study = import_from("habilis.studies.reproduction.reproduce", "learn")
    result = study.reproduce(args.out, quick=args.quick, show_progress=True)
    if args.json:
        return print_json(result.summary())
    print(result.text())
    return 0
