"""--ray, --processes, --work and --resume of verbs that compute values of many states."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from disks import content

import habilis as hb
from habilis.cli import executors, main

ROOM = "AP.\n.C.\n..G"


@pytest.fixture
def room(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "room.txt").write_text(ROOM)
    monkeypatch.chdir(tmp_path)
    return tmp_path


VERBS = {
    "empowerment": ["empowerment", "room.txt", "--slip", "0.1", "--horizon", "1"],
    "players": ["empowerment", "two.npz", "--horizon", "2", "--player", "we", "--others", "worst"],
    "landscape": ["landscape", "room.txt", "--slip", "0.1", "--horizon", "2"],
    "compare": ["compare", "room.txt", "--tools", "broom,none", "--horizon", "2"],
    "pairs": ["compare", "room.txt", "--tools", "broom,none", "--horizon", "2", "--pairs"],
}


def printed(capsys: pytest.CaptureFixture, *command: str) -> str:
    assert main([*command, "--json"]) == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("command", VERBS.values(), ids=VERBS.keys())
def test_a_folder_of_finished_tasks_changes_no_value_and_is_used_again(
    command, room: Path, capsys, monkeypatch: pytest.MonkeyPatch
):
    if "two.npz" in command:
        rng = np.random.default_rng(0)
        players = {"we": 2, "they": 2}
        hb.TabularMDP.deterministic(rng.integers(9, size=(9, 4)), players=players).save("two.npz")
    here = printed(capsys, *command)
    assert printed(capsys, *command, "--work", "work") == here
    kept = content(room / "work" / "tasks")
    assert kept

    def never(tasks, done, stopped):
        raise AssertionError(f"{len(tasks)} tasks ran again")

    monkeypatch.setattr(executors, "in_turn", never)
    assert printed(capsys, *command, "--work", "work", "--resume") == here
    assert content(room / "work" / "tasks") == kept


def test_no_task_of_a_comparison_runs_twice(room: Path, capsys, monkeypatch: pytest.MonkeyPatch):
    ran: list[str] = []

    def counting(tasks, done, stopped):
        ran.extend(task.name for task in tasks)
        for task in tasks:
            done(task.name, task.run())

    monkeypatch.setattr(executors, "in_turn", counting)
    printed(capsys, *VERBS["compare"], "--work", "work")
    assert len(ran) == len(set(ran)) > 0


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--ray", "auto", "--processes", "2"], "--ray and --processes exclude each other"),
        (["--resume"], "--resume is given without --work"),
        (["--work", "taken"], "taken: exists already"),
        (["--work", "taken", "--resume"], "taken: has no computation to resume"),
        (["--work", "new", "--horizon", "-1"], "horizon is -1"),
        (["--work", "new", "--sensor", "nothing"], "'nothing' is unknown"),
        (["--work", "new", "--kind", "closed-loop"], "all states at once; leave out --work"),
        (["--ray", "nonsense", "--work", "new"], "nonsense: no Ray cluster can be reached there"),
        (["--processes", "0", "--work", "new"], "processes is 0; give at least 1"),
    ],
)
def test_bad_options_are_one_line_and_touch_nothing(options, says, room: Path, capsys):
    (room / "taken").mkdir()
    (room / "taken" / "mine").write_text("mine")
    before = content(room)
    assert main([*VERBS["empowerment"], *options]) == 2
    output, error = capsys.readouterr()
    assert output == ""
    assert says in error
    assert error.count("\n") == 1
    assert content(room) == before


def test_a_puzzle_and_a_robot_have_no_tasks(room: Path, capsys):
    (room / "p.pwp").write_text("A  M1 M0 .  .")
    for world, horizon in (("p.pwp", ["--horizon", "2"]), ("reach.xml", [])):
        assert main(["compare", world, *horizon, "--processes", "2"]) == 2
        error = capsys.readouterr().err
        assert error.startswith("habilis: --processes is for worlds")
        assert error.count("\n") == 1


def test_what_ctrl_c_stops_goes_on_with_the_same_result(room: Path, capsys):
    (room / "large.txt").write_text("AP....\n......\n..C...\n.....G")
    command = ["empowerment", "large.txt", "--slip", "0.1", "--horizon", "2", "--work", "work"]
    first = subprocess.Popen(
        [sys.executable, "-m", "habilis", *command], stderr=subprocess.PIPE, text=True
    )
    tasks = room / "work" / "tasks"
    while not tasks.is_dir() or len(list(tasks.glob("[!.]*.npz"))) < 3:
        assert first.poll() is None
        time.sleep(0.01)
    os.kill(first.pid, signal.SIGINT)
    _, error = first.communicate()
    assert first.returncode == 130
    assert "tasks are kept in work: continue with --resume" in error
    assert error.count("\n") == 1
    done = len(list(tasks.glob("*.npz")))
    there = json.loads(printed(capsys, *command, "--resume"))
    assert len(list(tasks.glob("*.npz"))) > done >= 3
    assert there == json.loads(printed(capsys, *command[:-2]))
