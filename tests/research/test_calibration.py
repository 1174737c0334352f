"""The choice of the A2C settings."""

import polars as pl
import pytest

from habilis.learning.runner import train
from habilis.studies.paper.settings import frozen_settings
from research import calibration
from research.calibration import frozen, scores, settings_grid, vanilla_configs


def test_the_frozen_settings_are_those_that_came_first():
    assert frozen_settings() == frozen(scores("confirm")[0])


def test_no_vanilla_run_was_there_to_see_entropy_fall():
    assert frozen_settings()["entropy_hold"] > scores("confirm")[0].slowest


def test_the_frozen_settings_converged_in_every_vanilla_run():
    best = scores("confirm")[0]
    assert best.converged
    assert best.setting in settings_grid()


def test_only_settings_that_converged_in_every_screening_run_are_confirmed_while_there_are_any():
    screened = {str(s.setting): s.converged for s in scores("screen")}
    assert all(screened[str(s.setting)] for s in scores("confirm"))


def test_vanilla_agents_alone_are_trained():
    configs = vanilla_configs(settings_grid()[0], {"seed": 1})
    assert [(c.world, c.tool) for c in configs] == [
        ("corridor", "picker"),
        ("yard", "picker"),
        ("yard", "broom"),
    ]
    assert not any(config.regularised for config in configs)


@pytest.fixture
def results(tmp_path, monkeypatch):
    """Two settings: the first is the faster one, but a run of its last row is missing."""
    rows = [
        {"stage": "screen", "world": world, "tool": "picker"}
        | setting
        | {"runs": 2, "converged": 2 - (place == 0 and row == 2), "slowest": 100 * (place + 1)}
        for place, setting in enumerate(settings_grid()[:2])
        for row, world in enumerate(["corridor", "yard", "yard"])
    ]
    path = tmp_path / "results.csv"
    pl.DataFrame(rows).write_csv(path)
    monkeypatch.setattr(calibration, "RESULTS", path)


def test_convergence_comes_before_speed(results):
    first, second = scores("screen")
    assert first.setting == settings_grid()[1]
    assert first.converged
    assert not second.converged
    assert first.steps == pytest.approx(200)


def test_a_stage_is_trained_once_and_added_to_the_results(tmp_path, monkeypatch):
    monkeypatch.setattr(calibration, "RESULTS", tmp_path / "results.csv")
    monkeypatch.setattr(calibration, "WORK", tmp_path / "work")
    budget = {"runs": 2, "seed": 1, "episodes": 30, "steps": 40_000}
    setting = settings_grid()[0]
    calibration.run_stage("screen", budget, [setting])
    rows = pl.read_csv(tmp_path / "results.csv")
    runs = train(vanilla_configs(setting, budget))
    assert rows["world"].to_list() == [run.config.world for run in runs]
    steps = [run.episodes.group_by("run").agg(pl.col("steps").sum())["steps"] for run in runs]
    assert rows["slowest"].to_list() == [some.max() for some in steps]
    assert rows.select("runs", "converged", "episodes").rows() == [(2, 0, "- -")] * 3
    before = (tmp_path / "results.csv").read_bytes()
    calibration.run_stage("screen", budget, [setting])
    assert (tmp_path / "results.csv").read_bytes() == before
