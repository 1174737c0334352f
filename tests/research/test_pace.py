"""The calibration at the paper's pace: its design, its ranks, and what it trains."""

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

from habilis.learning.config import Config
from habilis.learning.lanes import Program
from habilis.studies.pace.data import first_success, load_pace
from research.pace import design, ranking, runs

FIRST = {"envs": 4, "rollout": 5, "hidden": (4,), "episode_limit": 20}


def test_the_design_is_the_same_list_everywhere():
    listed = json.dumps([sorted(one.items()) for one in design.settings()])
    assert len(design.settings()) == 148
    assert hashlib.sha256(listed.encode()).hexdigest()[:16] == "db7109ac50dd3050"


def test_no_setting_has_a_bonus():
    assert not any(Config.from_dict(one).regularised for one in design.settings())


def test_the_settings_of_a_structure_share_a_compiled_program():
    *structures, presets = design.parts()
    assert sorted(n for part in design.parts() for n in part) == list(range(148))
    assert len(presets) == 4
    every = design.settings()
    for part in structures:
        if every[part[0]]["rollout"]:  # else an episode's limit is part of the program
            programs = {Program.of(Config.from_dict(every[n]), 10, 20_000) for n in part}
            assert len(programs) == 1


def line(setting, world, tool, *episodes, had=500_000):
    counts = ["-" if n is None else str(n) for n in episodes]
    return (setting, world, tool), {
        "setting": str(setting),
        "map": world,
        "tool": tool,
        "runs": str(len(episodes)),
        "converged": str(sum(n is not None for n in episodes)),
        "episodes": " ".join(counts),
        "had": " ".join(str(had) if n is None else str(n) for n in episodes),
    }


def rows(setting, corridor, picker, broom, *, first="corridor-b", second="yard-b"):
    return dict(
        [
            line(setting, first, "picker", *corridor),
            line(setting, second, "picker", *picker),
            line(setting, second, "broom", *broom),
        ]
    )


def test_the_published_rows_are_at_no_distance_and_lead():
    stated = ((37438, 3461.7), (15555.4, 418.8), (52872.2, 7742.2))
    published = [[mean - sd, mean, mean + sd] for mean, sd in stated]
    twice = [[2 * n for n in row] for row in published]
    first, second = ranking.ranked(rows(3, *twice) | rows(7, *published))
    assert (first.setting, first.worst, second.setting) == (7, 3, 3)
    assert first.distance == pytest.approx(0, abs=1e-9)
    assert second.distance == pytest.approx(3 * np.log(2) ** 2 * 1.25)


def test_converged_runs_in_the_worst_row_come_before_nearness():
    near = rows(1, (37000, 38000, 37500), (15500, 15600, 15400), (52000, 53000, None))
    far = rows(2, (900, 950, 1000), (900, 950, 1000), (900, 950, 1000))
    assert [one.setting for one in ranking.ranked(near | far)] == [2, 1]


def test_a_run_that_did_not_converge_counts_with_its_budget_however_few_episodes_it_had():
    _, row = line(1, "yard-b", "broom", 10, None, had=70)
    np.testing.assert_array_equal(ranking.budgeted(row), [10, 1_000_000])


def test_a_setting_that_lacks_a_row_has_no_rank():
    found = rows(1, (1, 2), (1, 2), (1, 2))
    del found[1, "yard-b", "broom"]
    assert ranking.ranked(found) == []


def test_the_best_pairs_have_different_settings_each_on_its_best_maps(tmp_path: Path):
    good, bad = ((30_000, 40_000), (15_000, 16_000), (50_000, 60_000)), ((1, 2), (1, 2), (1, 2))
    found = (
        rows(1, *bad)
        | rows(1, *good, first="corridor-02", second="yard-03")
        | rows(2, *good, second="yard-05")
        | rows(3, *bad)
    )
    pairs = ranking.best_pairs(ranking.ranked(found), 2)
    assert [(p.setting, p.corridor, p.yard) for p in pairs] == [
        (1, "corridor-02", "yard-03"),
        (2, "corridor-b", "yard-05"),
    ]
    (tmp_path / "pairs.toml").write_text(ranking.frozen(pairs))
    first, second = load_pace(tmp_path).pairs
    assert first.maps == {"table1": "corridor-02", "table2": "yard-03"}
    wanted = Config.from_dict(design.settings()[2])
    assert Config.from_dict(dict(second.learner)) == wanted


SMALL: design.Setting = {"runs": 2, "seed": 5, "episodes": 40, "steps": 20_000}


def test_what_is_trained_goes_into_the_file_once_and_is_read_by_the_report(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(runs, "settings", lambda: [FIRST, FIRST | {"learning_rate": 2e-3}])
    monkeypatch.setattr(runs, "GOES_ON", 0)
    file = tmp_path / "screen.csv"
    runs.in_turn([0], runs.ROWS, SMALL, file, lambda: False)
    before = file.read_text()
    runs.in_turn([0], runs.ROWS, SMALL, file, lambda: False)
    assert file.read_text() == before
    runs.in_turn([0, 1], runs.ROWS, SMALL, file, lambda: False)
    assert file.read_text().startswith(before.splitlines()[0])
    screened = load_pace(tmp_path).screened
    assert screened is not None
    keys = screened.select("setting", "map", "tool").rows()
    assert keys == [(n, *row) for n in (0, 1) for row in sorted(runs.ROWS)]
    assert screened["runs"].to_list() == [2] * 6
    assert all(len(one.split()) == 2 for one in screened["had"])


def test_a_row_in_which_too_few_runs_converge_ends_a_setting(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(runs, "settings", lambda: [FIRST])
    runs.in_turn([0], runs.ROWS, SMALL, tmp_path / "screen.csv", lambda: False)
    assert list(runs.read(tmp_path / "screen.csv")) == [(0, *runs.ROWS[0])]


def test_what_there_is_no_time_for_is_left(tmp_path: Path):
    runs.in_turn([0], runs.ROWS, SMALL, tmp_path / "screen.csv", lambda: True)
    assert not (tmp_path / "screen.csv").exists()


def test_the_first_success_is_when_a_hundred_episodes_cost_at_most_twice_the_best():
    returns = np.concatenate([np.full(150, -100.0), np.full(250, -20.0)])
    curve = runs.learning_curve(returns)
    assert first_success(curve, -10.0) == 300
    assert first_success(curve, -9.0) == np.inf
