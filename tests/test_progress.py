"""A bar appears for what takes long, on standard error, and for nothing else."""

import sys
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import habilis as hb
from habilis import progress
from habilis.analysis.averages import compare
from habilis.analysis.futures import futures
from habilis.analysis.pairs import pairs
from habilis.analysis.usefulness import usefulness
from habilis.cli import main
from habilis.empowerment import effective
from habilis.empowerment.closed_loop import closed_loop_empowerment
from habilis.empowerment.goal_directed import goal_directed_empowerment
from habilis.empowerment.horizons import empowerment_by_horizon
from habilis.empowerment.limits import Limits, watched
from habilis.empowerment.tabular.persistence import persistence
from habilis.progress import Pace, progress_bar
from habilis.worlds.reach import reachable
from habilis.worlds.rules import Grid


@pytest.fixture
def terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Standard error as a terminal, with an immediate progress bar."""
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(progress, "PATIENCE", 0.0)


def test_a_bar_says_what_is_counted_and_how_far_it_is(terminal, capsys):
    with progress_bar("beans", True) as report:
        report(3, 8)
        time.sleep(0.3)
    shown = capsys.readouterr()
    assert "beans" in shown.err
    assert "3/8" in shown.err
    assert shown.out == ""


def test_what_is_done_at_once_shows_no_bar(terminal, capsys, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(progress, "PATIENCE", 60.0)
    with progress_bar("beans", True) as report:
        report(3, 8)
    assert capsys.readouterr().err == ""


def test_a_bar_of_tasks_shows_the_time_that_is_left(
    terminal, capsys, monkeypatch: pytest.MonkeyPatch
):
    with progress_bar("beans", True, time_left=True) as report:
        time.sleep(0.2)
        with monkeypatch.context() as patch:
            patch.setattr(progress.Pace, "seconds_left", lambda self, now: 3723.4)
            report(3, 8)
            time.sleep(0.3)
    assert "1:02:03 left" in capsys.readouterr().err


def test_the_time_left_is_that_of_the_pace_and_what_was_found_finished_does_not_count():
    pace = Pace()
    pace.report(100, 0, 100)
    assert pace.seconds_left(100) is None
    for done in range(1, 51):  # which were on the disk
        pace.report(100.1, done, 100)
    for done in range(51, 61):
        pace.report(100 + 7 * (done - 50), done, 100)
    assert pace.seconds_left(170) == pytest.approx(40 * 7)
    assert pace.seconds_left(173) == pytest.approx(40 * 7 - 3)
    assert pace.seconds_left(1000) == 0
    for done in range(61, 81):  # twice as fast
        pace.report(170 + 3.5 * (done - 60), done, 100)
    assert pace.seconds_left(240) == pytest.approx(20 * 3.5)


def test_without_being_asked_for_there_is_no_bar(terminal, capsys):
    with progress_bar("beans", False) as report:
        report(3, 8)
        time.sleep(0.1)
    assert capsys.readouterr().err == ""


def test_a_bar_within_another_is_a_line_below_it(terminal, capsys):
    with progress_bar("pods", True) as outer:
        outer(1, 2)
        with progress_bar("beans", True) as inner:
            inner(3, 8)
            time.sleep(0.3)
        with progress_bar("peas", True) as inner:
            inner(5, 9)
            time.sleep(0.3)
    shown = capsys.readouterr().err
    for text in ("pods", "1/2", "beans", "3/8", "peas", "5/9"):
        assert text in shown


def test_an_error_within_a_bar_within_another_ends_the_inner_one(terminal, capsys):
    with progress_bar("pods", True) as outer:
        with pytest.raises(ValueError, match="rotten"), progress_bar("beans", True):
            raise ValueError("rotten")
        capsys.readouterr()
        outer(1, 2)
        time.sleep(0.3)
        shown = capsys.readouterr().err
    assert "1/2" in shown
    assert "beans" not in shown.partition("1/2")[2]


def test_an_error_within_a_bar_ends_it(terminal, capsys):
    with pytest.raises(ValueError, match="rotten"), progress_bar("beans", True):
        raise ValueError("rotten")
    with progress_bar("peas", True) as report:
        report(5, 9)
        time.sleep(0.3)
    assert "beans" not in capsys.readouterr().err.partition("peas")[2]


ROOM = hb.World.parse("A..\nP#.\n.C.\n..G\n", "room")


@pytest.mark.parametrize("slip", [0.0, 0.1])
def test_showing_progress_changes_no_value(terminal, slip):
    mdp = hb.tabulate(ROOM, slip)
    for sensor in ("state", "object"):
        plain = hb.empowerment(mdp, 2, sensor, states=range(9))
        shown = hb.empowerment(mdp, 2, sensor, states=range(9), show_progress=True)
        assert np.array_equal(plain, shown)
    plain, shown = hb.landscape(ROOM, 1), hb.landscape(ROOM, 1, show_progress=True)
    assert np.array_equal(plain.values, shown.values, equal_nan=True)
    tools = ["picker", "none"]
    assert compare(ROOM, tools, 2) == compare(ROOM, tools, 2, show_progress=True)
    judged = usefulness(ROOM, 2, show_progress=True)
    assert np.array_equal(judged.with_tool, usefulness(ROOM, 2).with_tool)
    start = mdp.start
    choice = futures(mdp, start, 2, "object", show_progress=True)
    assert choice.empowerment == futures(mdp, start, 2, "object").empowerment
    rows = empowerment_by_horizon(mdp, 2, "object", show_progress=True)
    assert np.array_equal(rows, empowerment_by_horizon(mdp, 2, "object"))
    lasting = persistence(hb.tabulate(ROOM), "object")
    assert np.array_equal(persistence(ROOM, "object", show_progress=True), lasting)
    assert pairs(ROOM, 1, show_progress=True).tools == ("picker", "none")


def test_pairs_show_all_that_they_compute_within_their_bar(monkeypatch: pytest.MonkeyPatch):
    shown: list[str] = []
    _spy_on_bars(monkeypatch, lambda what, show: shown.append(what) if show else None)
    pairs(ROOM, 1, slip=0.1, show_progress=True)
    assert {"pairs", "placements", "components"} <= set(shown)


@pytest.mark.parametrize("slip", [0.0, 0.1])
def test_every_kind_shows_its_progress_and_the_same_values(monkeypatch: pytest.MonkeyPatch, slip):
    shown: list[str] = []
    _spy_on_bars(monkeypatch, lambda what, show: shown.append(what) if show else None)
    ring = hb.TabularMDP.deterministic([[(s - 1) % 5, (s + 1) % 5] for s in range(5)]).slippery(
        slip
    )
    price = {"cost": np.ones((5, 2)), "budget": [2, 3]}
    asked: dict[str, Callable[[dict[str, Any]], Any]] = {
        "budget": lambda more: hb.empowerment(ring, 2, **price, **more),
        "each step": lambda more: hb.empowerment(ring, 2, sensor_at="each step", **more),
        "belief": lambda more: hb.empowerment(ring, 2, states=np.full((1, 5), 0.2), **more),
        "closed loop": lambda more: closed_loop_empowerment(ring, 2, **more),
        "effective": lambda more: hb.effective_empowerment(ring, "uniform", 0.5, **more),
        "best first": lambda more: hb.effective_empowerment(
            ring, "uniform", 0.5, maximise=True, **more
        ),
    }
    if not slip:
        asked["goal-directed"] = lambda more: goal_directed_empowerment(
            ring, 2, goal=[0], slack=2, **more
        )
    for kind, measure in asked.items():
        shown.clear()
        plain = measure({})
        assert not shown, kind
        assert np.array_equal(measure({"show_progress": True}), plain), kind
        assert shown, kind


@pytest.mark.parametrize("maximise", [False, True])
def test_shares_of_an_effective_empowerment_rise_from_nothing_to_all(
    monkeypatch: pytest.MonkeyPatch, maximise
):
    """In blocks of one observation each."""
    heard: list[float] = []
    monkeypatch.setattr(effective, "_BLOCK", 5)
    monkeypatch.setattr(
        effective, "in_percent", lambda bar: lambda share: heard.append(round(share, 9))
    )
    ring = hb.TabularMDP.deterministic([[(s - 1) % 5, (s + 1) % 5] for s in range(5)])
    hb.effective_empowerment(ring, "uniform", 0.9, maximise=maximise)
    assert heard[0] == 0
    assert heard == sorted(heard)
    assert heard[-1] == pytest.approx(0.5 if maximise else 1.0)


def test_a_bar_is_there_before_the_placements_of_a_large_map_are_read(
    monkeypatch: pytest.MonkeyPatch,
):
    order: list[str] = []
    _spy_on_bars(monkeypatch, lambda what, show: order.append(what) if show else None)

    def read(*size: Any) -> Grid:
        order.append("map")
        return grid(*size)

    grid = Grid.of
    monkeypatch.setattr(Grid, "of", staticmethod(read))
    room = replace(ROOM)  # not read yet
    reachable(room, [{"agent": (0, 0), "tool": (1, 0), "object": (2, 1)}], 1, show_progress=True)
    assert order[:2] == ["placements", "map"]


def test_counting_reports_every_share_up_to_the_whole():
    heard: list[float] = []
    watch = watched(9, 9, 0.0, Limits(1, 1e9), heard.append)
    for share in (0.0, 0.5, 1.0):
        watch(share)
    assert heard == [0.0, 0.5, 1.0]


def _spy_on_bars(monkeypatch: pytest.MonkeyPatch, hear: Callable[[str, bool], object]) -> None:
    enter = progress.progress_bar

    def spy(what: str, show: bool):
        hear(what, show)
        return enter(what, False)

    for name, module in list(sys.modules.items()):
        if name.startswith("habilis") and getattr(module, "progress_bar", None) is enter:
            monkeypatch.setattr(module, "progress_bar", spy)


@pytest.mark.parametrize(
    "verb",
    [
        ["worlds", "yard", "--out", "yard.png"],
        ["empowerment", "corridor", "--horizon", "2"],
        ["landscape", "corridor", "--horizon", "2", "--out", "corridor.svg"],
        ["landscape", "yard", "--horizon", "2", "--kind", "goal-directed"],
        [
            "landscape",
            "yard",
            "--horizon",
            "2",
            "--kind",
            "effective",
            "--discount",
            "0",
            "--sensor",
            "object",
        ],
        ["compare", "yard", "--horizon", "2"],
        ["compare", "yard", "--horizon", "1", "--pairs"],
        ["futures", "yard", "--horizon", "2", "--sensor", "object"],
        ["solve", "yard"],
    ],
)
def test_verbs_ask_for_a_bar_on_a_terminal_only(verb, tmp_path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    asked: list[bool] = []
    _spy_on_bars(monkeypatch, lambda what, show: asked.append(show))
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    assert main(verb) == 0
    assert any(asked)
    asked.clear()
    assert main([*verb, "--json"]) == 0
    assert not any(asked)
