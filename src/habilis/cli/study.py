"""`habilis study`: the small studies."""

import argparse
from pathlib import Path

from habilis.cli.arguments import Args
from habilis.cli.output import print_json, print_written, refuse, shows_progress
from habilis.extras import import_from
from habilis.files import FOLDER
from habilis.progress import progress_bar

HELP: str = "train agents in worlds with several tools, objects or placements, and compare rewards"
EXAMPLE: str = "habilis study choosing two-goals unseen --out studies"
COMMON: tuple[str, ...] = ("--out", "--resume", "--quick")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    text = "choosing, two-goals, unseen (default: all three)"
    parser.add_argument("names", nargs="*", metavar="NAME", help=text)
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="a new folder")
    parser.add_argument(
        "--resume", action="store_true", help="continue the interrupted studies in --out DIR"
    )
    parser.add_argument(
        "--quick", action="store_true", help="smoke test; the results are meaningless"
    )
    parser.set_defaults(writes={"out": FOLDER})


def run(args: Args) -> int:
    studies = import_from("habilis.studies.bonuses.run", "learn")
    try:
        with progress_bar("tasks", shows_progress(args)) as on_progress:
            answers = studies.run_studies(
                args.names, args.out, args.quick, args.resume, on_progress
            )
    except KeyboardInterrupt as stop:
        return refuse(str(stop) or "interrupted", status=128 + getattr(stop, "signal", 2))
    if args.json:
        described = {answer.study.name: answer.as_dict() for answer in answers}
        return print_json({"studies": described, "out": str(args.out)})
    for answer in answers:
        print(f"{answer.study.title} ({answer.study.name})")
        for line in answer.outcome:
            print(f"  {line}")
    print_written(args.out / studies.PAGE)
    return 0
