"""The whole paper, by one call."""

import json
import shutil
import tempfile
import time
from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from habilis.files import check_folder
from habilis.learning.display import progress_bars
from habilis.learning.runner import train
from habilis.studies.pace.data import load_pace
from habilis.studies.pace.slowness import marks
from habilis.studies.paper.agent_statements import agent_statements
from habilis.studies.paper.numbers import published_numbers, published_statements
from habilis.studies.paper.published import EXPERIMENTS
from habilis.studies.paper.settings import FULL, QUICK, row_config
from habilis.studies.paper.tables import Result, table
from habilis.studies.reproduction import figures
from habilis.studies.reproduction.figures import slowness_figure
from habilis.studies.reproduction.report import write_report
from habilis.studies.reproduction.result import Reproduction
from habilis.worlds.pictures.figures import save_figure, save_picture
from habilis.worlds.world import load_world

MARK = "numbers.json"
_SUFFIXES = (".csv", ".parquet", ".svg", ".html")  # of what else is written


def reproduce(
    out: str | Path,
    quick: bool = False,
    budget: dict[str, Any] | None = None,
    show_progress: bool = False,
) -> Reproduction:
    """Recomputes every number, statement, table and figure of the paper.

    Args:
        out: the folder to write: `report.html`, `numbers.json`, `table1.csv`, `table2.csv`,
            `slowness.csv`, the figures and the episodes of every row. Nothing is there before all
            is done; an earlier reproduction is replaced.
        quick: whether to train with the small budget.
        budget: fields of `Config` instead of either budget, such as `{"runs": 2}`.
        show_progress: whether to draw bars on standard error.

    Returns:
        What came out, beside what is published: numbers, statements, and both tables.

    Raises:
        ValueError: the folder holds something else, or cannot be written.
    """
    began = time.perf_counter()
    out = Path(out)
    _check_replaceable(out)
    budget = budget or (QUICK if quick else FULL)
    pace = load_pace()
    numbers, relations = published_numbers(), published_statements()
    rows = [(experiment, row) for experiment in EXPERIMENTS for row in experiment.rows]
    configs = [row_config(experiment, row, budget, pace.best) for experiment, row in rows]
    labels = [f"{experiment.title}: {row.label}" for experiment, row in rows]
    with progress_bars(labels) if show_progress else nullcontext() as show:
        runs = train(configs, show)
    results: dict[str, list[Result]] = {experiment.name: [] for experiment in EXPERIMENTS}
    for (experiment, row), run in zip(rows, runs, strict=True):
        results[experiment.name].append(Result.of(row, run))
    reproduction = Reproduction(
        folder=out,
        numbers=numbers,
        relations=relations,
        learned=agent_statements(results, pace.ensemble),
        results=results,
        pace=pace,
        budget=budget,
        quick=quick,
        seconds=time.perf_counter() - began,
    )
    _write(reproduction)
    return reproduction


def _check_replaceable(out: Path) -> None:
    """Refuses a folder that holds anything but an earlier reproduction."""
    check_folder(out)
    if out.is_symlink():
        raise ValueError(f"{out}: is a link; name the folder itself")
    if out.exists() and not _is_reproduction(out):
        raise ValueError(f"{out}: exists and is not an earlier reproduction; name a new folder")


def _is_reproduction(folder: Path) -> bool:
    """Whether a folder is empty, or has our numbers and no file that is not ours."""
    if not folder.is_dir():
        return False
    names = {path.name for path in folder.iterdir()}
    if not names:
        return True
    try:
        ours = "habilis" in json.loads((folder / MARK).read_text("utf-8"))
    except (OSError, ValueError, TypeError):
        return False
    return ours and all(name == MARK or Path(name).suffix in _SUFFIXES for name in names)


def _write(reproduction: Reproduction) -> None:
    """Writes everything beside the folder first, then puts it in its place."""
    out = reproduction.folder.absolute()
    out.parent.mkdir(parents=True, exist_ok=True)
    folder = Path(tempfile.mkdtemp(dir=out.parent, prefix=f".{out.name}-"))
    try:
        _write_data(reproduction, folder)
        _write_figures(reproduction, folder)
        write_report(reproduction, folder)
        folder.chmod(0o755)
        _put_in_place(folder, out)
    except (OSError, pl.exceptions.PolarsError) as error:
        reason = str(error).splitlines()[0]
        raise ValueError(
            f"{out}: cannot be written ({reason}); partial results: {folder}"
        ) from error


def _put_in_place(folder: Path, out: Path) -> None:
    """Has a whole folder take the place of an earlier one, which stays if that fails."""
    earlier = folder.with_name(f"{folder.name}-earlier")
    if out.exists():
        out.rename(earlier)
    try:
        folder.rename(out)
    except OSError:
        if earlier.exists():
            earlier.rename(out)
        raise
    shutil.rmtree(earlier, ignore_errors=True)


def _write_data(reproduction: Reproduction, folder: Path) -> None:
    for experiment in EXPERIMENTS:
        results = reproduction.results[experiment.name]
        table(experiment, results, reproduction.pace).write_csv(folder / f"{experiment.name}.csv")
        for i, result in enumerate(results):
            result.run.episodes.write_parquet(folder / f"{experiment.name}-row{i + 1}.parquet")
    marks(reproduction.pace.learners).write_csv(folder / "slowness.csv")
    (folder / MARK).write_text(
        json.dumps(reproduction.as_data(), indent=2, default=np.generic.item) + "\n"
    )


def _write_figures(reproduction: Reproduction, folder: Path) -> None:
    first, second = (reproduction.results[name] for name in ("table1", "table2"))
    for experiment in EXPERIMENTS:
        name = experiment.world
        save_picture(load_world(name), folder / f"{name}.svg")
    for world in reproduction.other_worlds:
        save_picture(world, folder / f"{world.name}.svg")
    drawn: Sequence[tuple[str, Any]] = (
        ("figure1", figures.figure_1()),
        ("figure2", figures.figure_2(first)),
        ("figure3", figures.figure_3()),
        ("figure4a", figures.figure_4a()),
        ("figure4b", figures.figure_4b()),
        ("returns1", figures.returns_figure(first)),
        ("returns2", figures.returns_figure(second)),
    )
    for name, figure in drawn:
        save_figure(figure, folder / f"{name}.svg")
    if reproduction.pace.learners:
        figure = slowness_figure(marks(reproduction.pace.learners))
        save_figure(figure, folder / "slowness.svg")
