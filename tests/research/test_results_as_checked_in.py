"""The tables of the multiverse, and the frozen pairs, are what today's code makes of their runs."""

from pathlib import Path

import polars as pl
import pytest
from polars.testing import assert_frame_equal

from habilis.studies.pace.data import FOLDER
from research.multiverse import claims, results
from research.pace import ranking, runs

DOCS = Path(__file__).parents[2] / "docs" / "multiverse"
RUNS = pl.read_csv(DOCS / "runs.csv", infer_schema_length=None)


def agrees(found: pl.DataFrame, wanted: pl.DataFrame) -> None:
    assert_frame_equal(found, wanted.cast(found.schema), rel_tol=1e-12)


@pytest.mark.parametrize(
    ("name", "part", "verdicts"),
    [("multiverse", "multiverse", claims.multiverse), ("maps", "maps", claims.on_maps)],
)
def test_verdicts_follow_from_the_runs(name, part, verdicts, monkeypatch):
    """Those of the first success need the learning curves, which are not checked in."""
    monkeypatch.setattr(claims, "MEASURES", ("episodes", "steps"))
    wanted = pl.read_csv(DOCS / f"{name}.csv", infer_schema_length=None)
    agrees(verdicts(RUNS.filter(part=part)), wanted.filter(pl.col("measure") != "first success"))


def test_rows_and_their_intervals_follow_from_the_runs():
    wanted = pl.read_csv(DOCS / "rows.csv", infer_schema_length=None)
    agrees(results.rows(RUNS.filter(part="shaping")), wanted)


def test_the_best_policies_are_what_they_were(monkeypatch):
    horizons = (1, 3)
    monkeypatch.setattr(results, "HORIZONS", horizons)
    wanted = pl.read_csv(DOCS / "optima.csv", infer_schema_length=None)
    agrees(results.optima(), wanted.filter(pl.col("horizon").is_in(horizons)))


def test_the_frozen_pairs_are_the_best_of_those_that_were_confirmed():
    done = runs.read(FOLDER / "confirm.csv")
    frozen = ranking.frozen(ranking.best_pairs(ranking.ranked(done)))
    assert frozen == (FOLDER / "pairs.toml").read_text()
