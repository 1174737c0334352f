"""The results that are checked in are what today's code makes of the runs that are checked in."""

import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import polars as pl
import pytest
from polars.testing import assert_frame_equal

from habilis.studies.bonuses.analysis import summary
from habilis.studies.bonuses.report import Answer, write_page
from habilis.studies.bonuses.run import STUDIES
from habilis.studies.bonuses.study import FULL
from habilis.studies.pace.data import load_pace
from habilis.studies.pace.ratios import one_by_one
from habilis.studies.pace.slowness import association
from habilis.studies.paper.published import EXPERIMENTS
from habilis.studies.paper.tables import Result, table

DOCS = Path(__file__).parents[2] / "docs"
PACE = load_pace()


def read(name: str) -> pl.DataFrame:
    return pl.read_csv(DOCS / name, infer_schema_length=None)


@pytest.mark.parametrize("study", STUDIES.values(), ids=STUDIES)
def test_tables_of_the_small_studies_follow_from_their_runs(study):
    runs = read(f"studies/{study.name}-runs.csv")
    found = summary(study, runs)
    wanted = pl.read_csv(DOCS / f"studies/{study.name}.csv", schema_overrides=found.schema)
    assert_frame_equal(found, wanted, rel_tol=1e-12)


def test_the_page_of_the_small_studies_is_what_their_runs_and_the_template_give(tmp_path):
    """Or call `Answer.of` and `write_page` with these runs."""
    answers = [Answer.of(s, read(f"studies/{s.name}-runs.csv")) for s in STUDIES.values()]
    for study in STUDIES:
        shutil.copy(DOCS / f"studies/{study}.svg", tmp_path)
    write_page(answers, FULL, tmp_path)
    page = (tmp_path / "report.html").read_text()
    assert page == (DOCS / "studies/report.html").read_text()


@pytest.mark.ill_typed
@pytest.mark.parametrize("experiment", EXPERIMENTS, ids=lambda experiment: experiment.name)
def test_more_runs_and_the_ensemble_are_in_the_tables_as_their_runs_say(experiment):
    run: Any = SimpleNamespace(converged_at=[1, 2])
    results = [Result(row, run, np.array([1.0, 2.0])) for row in experiment.rows]
    found = table(experiment, results, PACE)
    names = [name for name in found.columns if name.startswith(("published", "thirty", "ensemble"))]
    wanted = pl.read_csv(DOCS / f"results/{experiment.name}.csv", schema_overrides=found.schema)
    assert_frame_equal(found.select(names), wanted.select(names), rel_tol=1e-12)


ASSOCIATIONS = {
    ("first success", "ratio"): (0.4117995424426409, 0.04672288695706329, 0.6600144924415349),
    ("first success", "order"): (0.3306196255235076, -0.16029770045378974, 0.7396510157748928),
    ("convergence", "ratio"): (-0.23978678362792863, -0.5926558265582655, 0.20118372680161092),
    ("convergence", "order"): (-0.10722142777812955, -0.47459344689290106, 0.29268176754727776),
}
"""Rank correlations and their intervals, by measure and by what is compared."""


@pytest.mark.parametrize(("measure", "by"), ASSOCIATIONS)
def test_the_association_with_slowness_is_what_it_was(measure, by):
    found = association(PACE.learners, measure, by)
    assert found is not None
    assert (found.middle, found.low, found.high) == pytest.approx(
        ASSOCIATIONS[measure, by], rel=1e-12
    )
    below = {"first success": 23, "convergence": 10}[measure]
    assert (found.learners, found.below, found.marks) == (11, below, 44)


def test_the_pairs_one_by_one_are_what_they_were():
    rows = one_by_one(PACE.ensemble)
    sums = rows.select("mean", "deviation", "converged", "runs", "ratio").sum().row(0)
    assert sums == pytest.approx(
        (3105685.1, 1035253.9084094947, 344, 350, 34.41742238038), rel=1e-12
    )
    outcomes = dict(rows["outcome"].drop_nulls().value_counts().iter_rows())
    assert outcomes == {"undecided": 5, "opposite": 10, "holds": 5}
