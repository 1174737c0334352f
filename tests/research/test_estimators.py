"""The page on estimators shows the results as they were computed."""

from pathlib import Path

import polars as pl

from habilis.estimators import case_names, contestants
from research import estimators

PAGE = Path(__file__).parents[2] / "docs" / "explanation" / "estimators.md"


def test_the_page_shows_the_results_as_they_were_computed():
    assert estimators.as_table(pl.read_csv(estimators.RESULTS)) in PAGE.read_text("utf-8")


def test_the_page_says_what_training_on_other_states_gave():
    table = pl.read_csv(estimators.RESULTS.parent / "variational_states.csv")
    bits = dict(table.select("trained on", "bits").iter_rows())
    page = " ".join(PAGE.read_text("utf-8").split())
    asked, most = bits["those asked about"], bits["random, most influence"]
    assert f"{asked:.2f} of {table['truth'][0]:.2f} bits" in page
    assert f"(mean {most:.1f})".replace("-", "−") in page
    assert abs(bits["random"]) < 0.005


def test_every_estimator_has_a_row_for_each_case():
    results = pl.read_csv(estimators.RESULTS)
    pairs = set(results.select("estimator", "case").iter_rows())
    assert pairs == {(name, case) for name in contestants() for case in case_names()}
    assert (results["seeds"] == 3).all()
    assert (results["reason"].is_null() == results["bias"].is_not_null()).all()


def test_what_is_called_exact_is_exact_and_lower_bounds_are_below():
    results = pl.read_csv(estimators.RESULTS)
    exact = results.filter(pl.col("kind") == "exact")
    assert len(exact) >= 5
    assert (exact["rmse"] < 1e-6).all()
    assert (results.filter(pl.col("kind") == "lower bound")["bias"] < 0.01).all()
