"""The small study of goal-directed bonuses."""

from dataclasses import replace
from pathlib import Path

import polars as pl

import habilis as hb
from research import goal_directed

PAGE = Path(__file__).parents[2] / "docs" / "explanation" / "kinds.md"


def test_the_page_shows_the_results_as_they_were_computed():
    assert goal_directed.as_table(pl.read_csv(goal_directed.RESULTS)) in PAGE.read_text("utf-8")


def test_every_bonus_has_a_row_for_each_of_its_runs():
    results = pl.read_csv(goal_directed.RESULTS)
    assert results["bonus"].value_counts()["count"].to_list() == [goal_directed.RUNS] * 5
    assert set(results["bonus"]) == goal_directed.BONUSES.keys()


def test_a_run_that_never_gets_there_has_no_number():
    config = replace(goal_directed.config("none"), runs=2, episodes=120)
    found = goal_directed.rows("none", hb.train(config))
    assert found["run"].to_list() == [0, 1]
    assert found["converged_at"].to_list() == [None, None]
