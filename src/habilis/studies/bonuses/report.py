"""The results of the studies, as a page, figures and data."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import polars as pl

from habilis.files import write_whole, writing
from habilis.studies.bonuses.analysis import (
    Contrast,
    contrasts,
    divergences,
    sentences,
    summary,
)
from habilis.studies.bonuses.study import HORIZON, QUICK, Budget, Study
from habilis.studies.page import inlined, render
from habilis.worlds.pictures.figures import save_figure

PAGE = "report.html"


@dataclass(frozen=True, eq=False)
class Answer:
    """The result of a study.

    Attributes:
        study: the study.
        runs: a row a run, as `training.trained` has them.
        table: `analysis.summary`.
        compared: `analysis.contrasts`.
    """

    study: Study
    runs: pl.DataFrame
    table: pl.DataFrame
    compared: list[Contrast]

    @classmethod
    def of(cls, study: Study, runs: pl.DataFrame) -> "Answer":
        return cls(study, runs, summary(study, runs), contrasts(study, runs))

    @property
    def outcome(self) -> list[str]:
        """In words."""
        return [*sentences(self.study, self.compared), *divergences(self.runs)]

    def as_dict(self) -> dict[str, Any]:
        """For machines."""
        compared = [one.as_dict() for one in self.compared]
        return {"table": self.table.to_dicts(), "compared": compared, "outcome": self.outcome}


def write_report(answers: Sequence[Answer], budget: Budget, folder: Path) -> None:
    """Writes `report.html`, a picture of each study as SVG, and its tables as CSV, into a folder.

    Raises:
        ValueError: the folder cannot be written.
    """
    with writing(folder):
        for answer in answers:
            name = answer.study.name
            write_whole(folder / f"{name}.csv", answer.table.write_csv)
            write_whole(folder / f"{name}-runs.csv", answer.runs.write_csv)
            save_figure(answer.study.figure(answer.table, answer.runs), folder / f"{name}.svg")
        write_page(answers, budget, folder)


def write_page(answers: Sequence[Answer], budget: Budget, folder: Path) -> None:
    """Writes `report.html` into the folder that holds the figures, which go into the page."""
    page = render(
        "studies.html",
        sections=[_section(answer, budget) for answer in answers],
        figure=lambda name: inlined(folder / f"{name}.svg"),
        betas=budget.betas,
        horizon=HORIZON,
        budget=budget,
        quick=budget is QUICK,
    )
    write_whole(folder / PAGE, lambda file: file.write(page.encode()))


def _section(answer: Answer, budget: Budget) -> dict[str, Any]:
    worlds = {case.world.name: case.world.text() for case in answer.study.cases}
    return {
        "study": answer.study,
        "outcome": answer.outcome,
        "rows": answer.table.to_dicts(),
        "worlds": worlds.items(),
        "steps": min(answer.study.steps, budget.most),
    }
