"""Interrupted training, by real processes that are really killed."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from habilis.cli import main
from habilis.learning import checkpoints
from habilis.learning.algorithms import A2C, PPO
from habilis.learning.config import Config
from habilis.learning.folder import load_run
from habilis.learning.train import train

# Too much entropy to converge: the budget of steps is used up.
OPTIONS = (
    *("--runs", "3", "--steps", "240000", "--episodes", "1000000", "--entropy", "9"),
    *("--episode-limit", "60", "--hidden", "16", "--checkpoint-seconds", "0"),
)


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    path = tmp_path_factory.mktemp("world") / "room.txt"
    path.write_text("A..\nPC.\n..G\n")
    return path


def start(room: Path, folder: Path, *options: str) -> subprocess.Popen:
    """A process that trains; what it says goes to a file beside its folder."""
    command = ["train", str(room), *OPTIONS, "--out", str(folder), *options]
    with open(f"{folder}.err", "w") as said:
        return subprocess.Popen(
            [sys.executable, "-m", "habilis.cli", *command], stdout=said, stderr=said
        )


def said_by(folder: Path) -> str:
    return Path(f"{folder}.err").read_text()


def wait_for_checkpoints(process: subprocess.Popen, folder: Path, count: int) -> None:
    """Until the latest checkpoint has at least this number."""
    while process.poll() is None:
        found = checkpoints.checkpoints(folder)
        if found and int(found[0].stem.split("-")[1]) >= count:
            return
        time.sleep(0.005)
    raise AssertionError(said_by(folder))


def content(folder: Path) -> dict[str, bytes]:
    names = ("episodes.parquet", "parameters.npz", "summary.json", "config.json", "world.txt")
    assert sorted(path.name for path in folder.iterdir()) == sorted(names)
    return {name: (folder / name).read_bytes() for name in names}


@pytest.fixture(scope="module")
def whole(room, tmp_path_factory):
    """What comes of the run when nothing happens to it."""
    folder = tmp_path_factory.mktemp("runs") / "whole"
    assert start(room, folder).wait() == 0, said_by(folder)
    return content(folder)


def test_a_killed_run_goes_on_to_the_same_bytes(room, tmp_path, whole):
    folder = tmp_path / "killed"
    for count in (2, 5, 9):
        process = start(room, folder, "--resume")
        wait_for_checkpoints(process, folder, count)
        process.send_signal(signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL
        assert len(checkpoints.checkpoints(folder)) <= checkpoints.KEPT + 1
    process = start(room, folder, "--resume")
    assert process.wait() == 0, said_by(folder)
    assert content(folder) == whole


def test_ctrl_c_saves_and_says_how_to_go_on(room, tmp_path, whole):
    folder = tmp_path / "stopped"
    process = start(room, folder)
    wait_for_checkpoints(process, folder, 1)
    process.send_signal(signal.SIGINT)
    assert process.wait() == 130
    err = said_by(folder)
    assert err.endswith(f"stopped; all is kept in {folder}: go on with --resume\n")
    assert "Traceback" not in err
    assert main(["watch", str(folder)]) == 2
    assert train_again(room, folder) == 0
    assert content(folder) == whole


def train_again(room: Path, folder: Path) -> int:
    return main(["train", str(room), *OPTIONS, "--out", str(folder), "--resume"])


@pytest.fixture
def interrupted(room, tmp_path):
    """A folder with two checkpoints."""
    folder = tmp_path / "interrupted"
    process = start(room, folder)
    wait_for_checkpoints(process, folder, 3)
    process.kill()
    process.wait()
    for partial in folder.glob(".*.partial"):
        partial.unlink()
    while len(checkpoints.checkpoints(folder)) > checkpoints.KEPT:
        checkpoints.checkpoints(folder)[-1].unlink()
    return folder


def test_a_damaged_checkpoint_is_named_and_the_one_before_used(room, interrupted, whole, capsys):
    latest = checkpoints.checkpoints(interrupted)[0]
    latest.write_bytes(latest.read_bytes()[:-2000])
    assert train_again(room, interrupted) == 0
    assert f"{latest}: is damaged" in capsys.readouterr().err
    assert content(interrupted) == whole


def test_one_flipped_byte_is_damage(room, interrupted, whole, capsys):
    latest = checkpoints.checkpoints(interrupted)[0]
    data = bytearray(latest.read_bytes())
    data[len(data) // 2] ^= 1
    latest.write_bytes(data)
    assert train_again(room, interrupted) == 0
    assert f"{latest}: is damaged" in capsys.readouterr().err
    assert content(interrupted) == whole


def test_where_all_checkpoints_are_damaged_nothing_is_overwritten(room, interrupted, capsys):
    for path in checkpoints.checkpoints(interrupted):
        path.write_bytes(b"not this")
    assert train_again(room, interrupted) == 2
    assert "train the run again" in capsys.readouterr().err
    assert len(checkpoints.checkpoints(interrupted)) == checkpoints.KEPT


def test_a_second_process_is_refused(room, tmp_path, capsys):
    folder = tmp_path / "busy"
    process = start(room, folder)
    try:
        wait_for_checkpoints(process, folder, 1)
        assert train_again(room, folder) == 2
        assert "another process trains in it" in capsys.readouterr().err
    finally:
        process.kill()
        process.wait()


def test_other_settings_are_refused(room, interrupted, capsys):
    arguments = ["train", str(room), *OPTIONS, "--out", str(interrupted), "--resume"]
    assert main([*arguments, "--discount", "0.5"]) == 2
    assert "was begun with discount 0.99, not 0.5" in capsys.readouterr().err


def test_without_resume_an_interrupted_folder_is_refused(room, interrupted, capsys):
    assert main(["train", str(room), *OPTIONS, "--out", str(interrupted)]) == 2
    assert "exists already" in capsys.readouterr().err


def test_a_finished_run_is_resumed_by_reading_it(room, tmp_path, capsys):
    folder = tmp_path / "done"
    arguments = ["train", str(room), "--runs", "1", "--steps", "1", "--out", str(folder)]
    assert main(arguments) == 0
    before = {path: path.stat().st_mtime_ns for path in folder.iterdir()}
    assert main([*arguments, "--resume"]) == 0
    assert {path: path.stat().st_mtime_ns for path in folder.iterdir()} == before


def test_a_full_disk_is_one_line_and_earlier_checkpoints_stay(
    room, interrupted, capsys, monkeypatch
):
    before = {path: path.read_bytes() for path in checkpoints.checkpoints(interrupted)}

    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    assert train_again(room, interrupted) == 2
    err = capsys.readouterr().err
    assert "No space left on device" in err.splitlines()[-1]
    assert "Traceback" not in err
    assert {p: p.read_bytes() for p in checkpoints.checkpoints(interrupted)} == before


def test_what_is_not_finite_names_the_last_good_checkpoint(room, tmp_path):
    config = Config(
        algorithm=A2C(learning_rate=1e30, clip=1e30, hidden=(8,)), world=str(room), runs=1
    )
    with pytest.raises(FloatingPointError, match="no checkpoint was made"):
        train(config, out=tmp_path / "run")


@pytest.mark.parametrize("intrinsic", ["count", "rnd", "object"])
def test_what_an_intrinsic_reward_has_learned_is_kept_too(room, tmp_path, intrinsic):
    config = Config(
        algorithm=PPO(rollout=32, entropy=9.0, hidden=(8,)),
        world=str(room),
        intrinsic=intrinsic,
        horizon=1,
        beta=0.1,
        runs=2,
        steps=60_000,
    )
    train(config, out=tmp_path / "whole")

    class StopError(Exception):
        pass

    def stop(_):
        if checkpoints.checkpoints(tmp_path / "cut"):
            raise StopError

    with pytest.raises(StopError):
        train(config, stop, out=tmp_path / "cut", checkpoint_seconds=0)
    train(config, out=tmp_path / "cut", resume=True)
    assert content(tmp_path / "cut") == content(tmp_path / "whole")
    assert load_run(tmp_path / "cut").config == config
