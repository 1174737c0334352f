"""The lines of training on a terminal."""

import pytest

from habilis.cli import main
from habilis.learning.display import _text, progress_bars
from habilis.learning.runs import Progress

LATE = Progress(
    config=0,
    episodes=98_765.4,
    share=0.9,
    episode_return=-499.9,
    steps_per_second=1_234_567.0,
    seconds_left=4_000.0,
    converged=10,
    ended=9,
    runs=30,
)


def test_what_a_line_has_no_room_for_is_left_out_least_important_first():
    wide = "98,765 episodes, return -499.9, 10/30 converged, 1,235k steps/s, at most 66:40 left"
    assert _text(LATE, 200) == wide
    assert _text(LATE, 70) == "98,765 episodes, return -499.9, 10/30 converged, at most 66:40 left"
    assert _text(LATE, 50) == "return -499.9, 10/30 converged, at most 66:40 left"
    assert _text(LATE, 40) == "10/30 converged, at most 66:40 left"
    assert _text(LATE, 20) == "at most 66:40 left"


@pytest.mark.parametrize("label", ["yard", "/home/somebody/worlds/of/mine/kitchen.txt"])
def test_a_line_keeps_its_bar_at_80_columns(label, monkeypatch, capsys):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.setenv("COLUMNS", "80")
    with progress_bars([label]) as show:
        show(LATE)
    line = next(part for part in capsys.readouterr().err.split("\n") if "left" in part)
    assert "━" * 15 in line
    assert label[-10:] in line
    assert "at most 66:40 left" in line
    assert "…" not in line


def test_a_training_in_which_no_run_converged_says_what_to_try(tmp_path, capsys):
    out = tmp_path / "a run"
    command = ["train", "yard", "--runs", "1", "--episodes", "2", "--out", str(out)]
    assert main(command) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0] == "0 of 1 runs converged"
    assert said[-1].endswith(
        f"raise --episodes, or look at what they do with: habilis watch '{out}'"
    )
    assert "best return, -10:" in said[-1]
