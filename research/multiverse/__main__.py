"""python -m research.multiverse --out docs/multiverse --work multiverse"""

import argparse
import sys
from pathlib import Path

from habilis.files import check_folder
from habilis.interruption import Interrupted
from habilis.progress import progress_bar
from habilis.sweeps import sweep
from research.multiverse.report import write_page, write_study
from research.multiverse.results import Multiverse, joined
from research.multiverse.settings import agents, all_maps


def main() -> int:
    parser = argparse.ArgumentParser(prog="research.multiverse", description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="where the page and data go")
    parser.add_argument(
        "--work", type=Path, default=Path("multiverse"), help="where finished runs are kept"
    )
    parser.add_argument(
        "--page", action="store_true", help="write the page alone, of what is in --out"
    )
    args = parser.parse_args()
    if args.page:
        write_page(Multiverse.read(args.out), args.out)
        print(args.out / "report.html")
        return 0
    everyone = agents(all_maps())
    try:
        check_folder(args.out)
        with progress_bar("tasks", sys.stderr.isatty()) as on_progress:
            results = sweep(
                [agent.config for agent in everyone],
                args.work,
                resume=True,
                on_progress=on_progress,
            )
    except Interrupted:
        print(
            f"habilis: stopped; what is finished is in {args.work}: call it again to go on",
            file=sys.stderr,
        )
        return 130
    except ValueError as error:
        print(f"habilis: {error}", file=sys.stderr)
        return 2
    study = Multiverse.of(joined(everyone, results))
    write_study(study, args.out)
    print(args.out / "report.html")
    return 0


if __name__ == "__main__":
    sys.exit(main())
