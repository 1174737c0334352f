"""Processes killed at chosen moments: as a folder begins, as a checkpoint is written, at the end.

Between them they go through every touch of the disk; `test_sessions.py` kills from outside.
"""

import signal
import subprocess
import sys
from pathlib import Path

import pytest
from events import scalars

from habilis.cli import main

KILLER = Path(__file__).parents[1] / "support" / "killed.py"

# Nothing is learned: the budget of steps is used up, in four stretches.
SHORT = ("--runs", "2", "--steps", "80000", "--episodes", "1000000", "--episode-limit", "64")
UNDECIDED = ("--hidden", "8", "--entropy", "9")
AIMLESS = ("--algorithm", "q-learning", "--epsilon", "1", "--epsilon-steps", "0")
NOVEL = ("--beta", "0.1", "--intrinsic")
CASES = {
    # The folder's beginning, the first checkpoint and some later one, and the end.
    "q-learning": (AIMLESS, ":6 :12 :29 :38 parquet:2 summary:3 summary:7"),
    "a2c, count": ((*UNDECIDED, *NOVEL, "count"), ":34 :41"),
    "ppo": (("--algorithm", "ppo", *UNDECIDED), ":36 :33"),
    "ppo, rnd": (("--algorithm", "ppo", *UNDECIDED, *NOVEL, "rnd"), ":37 :44"),
}


@pytest.mark.parametrize("case", CASES)
def test_whenever_it_is_killed_it_ends_with_the_same_bytes(case, tmp_path, capsys):
    options, moments = CASES[case]
    room = tmp_path / "room.txt"
    room.write_text("A..\nPC.\n..G\n")
    killed, whole = tmp_path / "killed", tmp_path / "whole"

    def command(folder: Path) -> list[str]:
        return ["train", str(room), *SHORT, *options, "--out", str(folder)]

    again = [*command(killed), "--resume", "--checkpoint-seconds", "0"]
    plan = moments.replace(" ", ",")
    done = subprocess.run(
        [sys.executable, "-W", "ignore", str(KILLER), str(killed), plan, *again],
        capture_output=True,
        text=True,
    )
    ends = [line.split()[1] for line in done.stdout.splitlines()]
    assert ends == [str(-signal.SIGKILL)] * len(moments.split()), done.stdout + done.stderr
    assert main(again) == 0
    assert main(command(whole)) == 0
    assert "damaged" not in done.stderr + capsys.readouterr().err
    names = ["config.json", "episodes.parquet", "parameters.npz", "summary.json", "world.txt"]
    for folder in (killed, whole):
        assert sorted(path.name for path in folder.iterdir() if path.is_file()) == names
    for name in names:
        assert (killed / name).read_bytes() == (whole / name).read_bytes(), name
    for run in ("run-0", "run-1"):
        points, wanted = (
            scalars(folder / "tensorboard" / run, but=("speed/steps_per_second",))
            for folder in (killed, whole)
        )
        assert points == wanted
