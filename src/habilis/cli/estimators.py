"""`habilis estimators`: estimators evaluated on cases with known empowerment."""

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from habilis.cli.arguments import Args, parse_words
from habilis.cli.executors import add_executor
from habilis.cli.output import print_json, print_written, save, shows_progress
from habilis.files import PICTURES
from habilis.progress import progress_bar

if TYPE_CHECKING:
    import polars as pl

    from habilis.estimators.evaluation.case import Case

HELP: str = "evaluate estimators of empowerment on cases with known values"
EXAMPLE: str = "habilis estimators --estimator counting --cases maze,yard"
COMMON: tuple[str, ...] = ("--estimator", "--cases", "--quick", "--out")

_TABLES = (".csv", ".parquet")  # the formats of words that may be missing
_QUICK = ("maze", "frozen-lake", "channels-16", "lake-effective", "gauss-2", "wall")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    text = "one of the package, or your own class with fit as FILE.py:CLASS; repeatable (default: "
    text += "all of the package)"
    parser.add_argument("--estimator", action="append", metavar="NAME", help=text)
    text = "cases of the suite (default all; with --quick a few)"
    parser.add_argument("--cases", type=parse_words, metavar="A,B,...", help=text)
    text = "few cases, one seed, less sampling and training"
    parser.add_argument("--quick", action="store_true", help=text)
    text = "number of seeds, each a fit (default 3, with --quick 1)"
    parser.add_argument("--seeds", type=int, metavar="N", help=text)
    text = "table (.csv, .parquet) or picture (.png, .svg, .pdf); repeatable"
    parser.add_argument("--out", type=Path, action="append", default=[], metavar="F.csv", help=text)
    parser.set_defaults(writes={"out": (*_TABLES, *PICTURES)})
    add_executor(parser)


def run(args: Args) -> int:
    from habilis.estimators.evaluation.case import suite
    from habilis.estimators.evaluation.evaluate import evaluate

    chosen = _chosen(args)
    seeds = args.seeds if args.seeds is not None else 1 if args.quick else 3
    names = args.cases if args.cases is not None else _QUICK if args.quick else None
    show = shows_progress(args)
    with progress_bar("cases", show):
        cases = suite(names)
    with _own_code(args):
        table = evaluate(chosen, cases, seeds, executor=args.executor, show_progress=show)
    for path in args.out:
        save(path, lambda path: _write(table, path))
    if args.json:
        return print_json({"results": table.to_dicts()})
    _print(table, cases)
    for path in args.out:
        print_written(path)
    return 0


@contextmanager
def _own_code(args: Args) -> Iterator[None]:
    """Turns an error in somebody's estimator into one line."""
    from habilis.own_code import BETWEEN, failure, is_own

    try:
        yield
    except Exception as error:
        own = [name for name in args.estimator or () if is_own(name)]
        if isinstance(error, ValueError) or not own:
            raise
        files = [sys.modules[name.rpartition(BETWEEN)[0]].__file__ for name in own]
        what = failure(error, files)
        raise ValueError(f"{', '.join(own)}: fails with {what}; fix it") from error


def _chosen(args: Args) -> dict[str, Any]:
    from habilis.estimators.evaluation.contestants import contestants
    from habilis.estimators.evaluation.own import own_estimator
    from habilis.own_code import is_own

    known: dict[str, Any] = dict(contestants(args.quick))
    if args.estimator is None:
        return known
    unknown = [name for name in args.estimator if not is_own(name) and name not in known]
    if unknown:
        raise ValueError(
            f"estimator {unknown[0]!r} is unknown; use {', '.join(known)}, or your own as "
            "FILE.py:CLASS"
        )
    return {name: own_estimator(name) if is_own(name) else known[name] for name in args.estimator}


def _write(table: "pl.DataFrame", path: Path) -> None:
    if path.suffix in _TABLES:
        from habilis.analysis.data_frames import save_table

        save_table(table, path)
        return
    from habilis.estimators.evaluation.picture import evaluation_figure
    from habilis.worlds.pictures.figures import save_figure

    save_figure(evaluation_figure(table), path)


def _print(table: "pl.DataFrame", cases: "list[Case]") -> None:
    """A block for each case, then why there are no numbers elsewhere."""
    names = table["estimator"].unique(maintain_order=True).to_list()
    width = max(map(len, names))
    silent: dict[tuple[str, str], list[str]] = {}
    for case in cases:
        mean = f"{case.bits.mean():.2f} bits in the mean of {len(case.states)} states"
        print(f"{case.name}: {case.about}; h = {case.horizon}, {mean}, {case.target}")
        rows = [row for row in table.iter_rows(named=True) if row["case"] == case.name]
        for row in rows:
            if row["reason"] is not None:
                silent.setdefault((row["estimator"], row["reason"]), []).append(case.name)
                continue
            print(f"  {row['estimator']:<{width}}  {_numbers(row)}")
    if silent:
        print("not compared")
    for (name, reason), where in silent.items():
        print(f"  {name:<{width}}  {', '.join(where)}: {reason}")


def _numbers(row: dict[str, Any]) -> str:
    ends = f"({row['bias_low']:+.3f} to {row['bias_high']:+.3f})" if row["seeds"] > 1 else ""
    rank = "   -" if row["rank"] is None else f"{row['rank']:+.2f}"
    return (
        (
            f"bias {row['bias']:+.3f} {ends}  rmse {row['rmse']:.3f}  rank {rank}  "
            f"{row['seconds']:7.2f} s  {row['steps']:>11,} steps  {row['kind']}"
        )
        .replace("+0.000", " 0.000")
        .replace("-0.000", " 0.000")
    )
