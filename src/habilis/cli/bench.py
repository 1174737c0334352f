"""`habilis bench`: benchmarks."""

import argparse

from habilis.cli.arguments import Args
from habilis.cli.output import print_json

HELP: str = "measure speed next to the alternatives"
EXAMPLE: str = "habilis bench empowerment"
COMMON: tuple[str, ...] = ()


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("what", nargs="*", metavar="WHAT", help="which benchmarks (default all)")
    text = "of kinds also the largest sizes: five minutes and more"
    parser.add_argument("--large", action="store_true", help=text)


def run(args: Args) -> int:
    from habilis.benchmarks import run_benchmarks

    results = run_benchmarks(args.what, args.large)
    if args.json:
        return print_json({"results": [result.as_dict() for result in results]})
    for result in results:
        print(result)
    return 0
