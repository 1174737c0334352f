"""The report: one page that needs nothing else."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from habilis.files import write_whole
from habilis.studies.outcome import Reproduction
from habilis.studies.page import inlined, render
from habilis.studies.published import EXPERIMENTS, Experiment
from habilis.studies.settings import frozen_settings
from habilis.studies.tables import Result, comparisons, table
from habilis.studies.verdicts import in_words, tally


def write_report(reproduction: Reproduction, folder: Path) -> None:
    """Writes `report.html` into the folder that holds the figures, which go into the page."""
    page = render(
        "report.html",
        reproduction=reproduction,
        summary=reproduction.summary(),
        verdicts=in_words(reproduction.verdicts),
        tables=[_section(e, reproduction.results[e.name]) for e in EXPERIMENTS],
        settings=frozen_settings(),
        figure=lambda name: inlined(folder / f"{name}.svg"),
    )
    write_whole(folder / "report.html", lambda file: file.write(page.encode()))


def _section(experiment: Experiment, results: Sequence[Result]) -> dict[str, Any]:
    """One of the tables, and its pairs of rows."""
    compared = comparisons(experiment, results)
    return {
        "experiment": experiment,
        "rows": table(experiment, results).to_dicts(),
        "comparisons": compared,
        "verdicts": in_words(tally(c.outcome for c in compared)),
    }
