"""The report: one page that needs nothing else."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from habilis.files import write_whole
from habilis.studies.outcome import Reproduction
from habilis.studies.pace.data import Pace
from habilis.studies.pace.method import method_of
from habilis.studies.pace.ratios import one_by_one
from habilis.studies.pace.slowness import sentence
from habilis.studies.page import inlined, render
from habilis.studies.published import EXPERIMENTS, Experiment
from habilis.studies.settings import learner_settings
from habilis.studies.tables import Result, comparisons, table
from habilis.studies.verdicts import in_words, tally


def write_report(reproduction: Reproduction, folder: Path) -> None:
    """Writes `report.html` into the folder that holds the figures, which go into the page."""
    page = render(
        "report.html",
        reproduction=reproduction,
        summary=reproduction.summary(),
        verdicts=in_words(reproduction.verdicts),
        tables=[_section(e, reproduction.results[e.name], reproduction.pace) for e in EXPERIMENTS],
        settings=learner_settings(reproduction.pace.best),
        method=method_of(reproduction.pace),
        pairs=one_by_one(reproduction.pace.ensemble).to_dicts(),
        ensemble_verdicts=in_words(reproduction.ensemble_verdicts),
        sources=_sources(reproduction.pace),
        sentences=[sentence(found) for found in reproduction.associations],
        figure=lambda name: inlined(folder / f"{name}.svg"),
    )
    write_whole(folder / "report.html", lambda file: file.write(page.encode()))


def _section(experiment: Experiment, results: Sequence[Result], pace: Pace) -> dict[str, Any]:
    """One of the tables, and its pairs of rows."""
    compared = comparisons(experiment, results)
    return {
        "experiment": experiment,
        "rows": table(experiment, results, pace).to_dicts(),
        "world": results[0].map,
        "comparisons": compared,
        "verdicts": in_words(tally(c.outcome for c in compared)),
    }


def _sources(pace: Pace) -> dict[str, list[str]]:
    """The learners of the picture, by where they come from."""
    found: dict[str, list[str]] = {}
    for learner in pace.learners:
        found.setdefault(learner.source, []).append(learner.name)
    return found
