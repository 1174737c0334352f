"""Whether the movable of largest loss of object empowerment is the one that a solution uses.

    python -m research.tools_in_pushworld --puzzles ../shared/pushworld     # goes on; see --help

Tables in `results/`: what each movable is to each target (`cases.csv`), the bits that are
lost without it (`losses.csv`), and how far horizons reach (`feasible.csv`). Of these come a fourth
(`precision.csv`), the numbers of the page, which are printed, and its picture.
"""

import argparse
import time
from pathlib import Path
from typing import Any

import polars as pl

from habilis.bridges.puzzles.pushworld import load_pushworld
from habilis.files import write_whole
from habilis.models.limits import TooManyStatesError
from research.tools_in_pushworld.cases import cases_of, measured_targets, puzzle_files, targets_of
from research.tools_in_pushworld.losses import HORIZONS, PATIENCE, chosen_states, feasible, losses
from research.tools_in_pushworld.page import pieces
from research.tools_in_pushworld.pictures import save_pictures
from research.tools_in_pushworld.precision import precision, verdicts
from research.tools_in_pushworld.solutions import load_plan, replayed

RESULTS = Path(__file__).parent / "results"
PICTURE = Path(__file__).parents[2] / "docs" / "explanation" / "tools-in-pushworld.png"


def losses_of(puzzle_file: Path, solution: Path, targets: list[str]) -> list[dict[str, Any]]:
    """The rows of a puzzle in `losses.csv`, for each horizon that is within the budget."""
    puzzle = load_pushworld(puzzle_file)
    states = chosen_states(replayed(puzzle, load_plan(solution)))
    rows = []
    for horizon in HORIZONS:
        try:
            found = losses(puzzle, targets, states, horizon)
        except TooManyStatesError:
            break
        for loss in found:
            rows.append(
                {"horizon": horizon, "target": loss.target, "object": loss.object}
                | {"bits": _short(loss.bits.mean())}
                | {"lost_fixed": _short(loss.fixed.mean())}
                | {"lost_removed": _short(loss.removed.mean())}
                | {"bits_first": _short(loss.bits[0])}
                | {"fixed_first": _short(loss.fixed[0])}
                | {"removed_first": _short(loss.removed[0])}
            )
    return rows


def _short(bits: float) -> float:
    return round(float(bits), 5) + 0.0  # no -0.0


def _order(row: dict[str, Any]) -> tuple[str, str]:
    return row["level"], row["puzzle"]


def _rows(path: Path) -> list[dict[str, Any]]:
    return pl.read_csv(path, infer_schema_length=None).to_dicts() if path.exists() else []


def _write(path: Path, rows: list[dict[str, Any]]) -> None:
    write_whole(path, pl.DataFrame(rows, infer_schema_length=None).write_csv)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--puzzles", type=Path, required=True, help="PushWorld's folder")
    parser.add_argument("--out", type=Path, default=RESULTS, help="the folder to go on with")
    parser.add_argument("--picture", type=Path, default=PICTURE, help="the six puzzles")
    parser.add_argument(
        "--patience",
        type=float,
        default=PATIENCE,
        help="seconds that a horizon above 20 may be expected to take",
    )
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    files = puzzle_files(args.puzzles)

    of_puzzle = {file: cases_of(level, file, solution) for level, file, solution in files}
    cases = [row for rows in of_puzzle.values() for row in rows]
    _write(args.out / "cases.csv", cases)

    rows = _rows(args.out / "losses.csv")
    done = {(row["level"], row["puzzle"]) for row in rows}
    for level, file, solution in files:
        asked = measured_targets(of_puzzle[file])
        if not asked or (level, file.stem) in done:
            continue
        start = time.perf_counter()
        found = losses_of(file, solution, asked)
        rows += [{"level": level, "puzzle": file.stem} | row for row in found]
        rows.sort(key=_order)
        _write(args.out / "losses.csv", rows)
        seconds = time.perf_counter() - start
        print(file.stem, asked, found[-1]["horizon"], f"{seconds:.1f} s", flush=True)

    rows = _rows(args.out / "feasible.csv")
    done = {(row["level"], row["puzzle"]) for row in rows}
    for level, file, solution in files:
        if (level, file.stem) in done:
            continue
        puzzle = load_pushworld(file)
        about = {
            "level": level,
            "puzzle": file.stem,
            "rows": puzzle.height,
            "columns": puzzle.width,
            "movables": len(puzzle.objects),
            "targets": len(targets_of(puzzle)),
            "plan": len(load_plan(solution)),
        }
        found = about | feasible(puzzle, args.patience)
        rows.append(found)
        rows.sort(key=_order)
        _write(args.out / "feasible.csv", rows)
        print(*found.values(), flush=True)

    tables = pl.DataFrame(cases), pl.read_csv(args.out / "losses.csv")
    found = precision(verdicts(*tables))
    _write(args.out / "precision.csv", found.to_dicts())
    for piece in pieces(*tables, found, pl.read_csv(args.out / "feasible.csv")):
        print(piece, end="\n\n")
    save_pictures(args.puzzles, *tables, args.picture)


if __name__ == "__main__":
    main()
