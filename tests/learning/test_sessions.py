"""Interrupted training, by real processes that are really killed."""

import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from disks import mounted

from habilis.cli import main
from habilis.learning import checkpoints
from habilis.learning.algorithms.a2c import A2C
from habilis.learning.algorithms.ppo import PPO
from habilis.learning.config import Config
from habilis.learning.folder import load_run, read_config
from habilis.learning.jobs import Job
from habilis.learning.runner import train

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
            [sys.executable, "-m", "habilis", *command], stdout=said, stderr=said
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
    assert sorted(path.name for path in folder.iterdir()) == sorted([*names, "tensorboard"])
    return {name: (folder / name).read_bytes() for name in names}


@pytest.fixture(scope="module")
def whole(room, tmp_path_factory):
    """The result of an undisturbed run."""
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


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_saves_and_says_how_to_go_on(room, tmp_path, whole, number, capsys):
    folder = tmp_path / "stopped here"
    process = start(room, folder)
    wait_for_checkpoints(process, folder, 1)
    process.send_signal(number)
    assert process.wait() == 128 + number
    (line,) = said_by(folder).splitlines()
    begun, command = line.split("; continue with: habilis ")
    assert begun == f"habilis: stopped; all is kept in {folder}"
    with np.load(checkpoints.checkpoints(folder)[0]) as saved:
        trained = len(saved["1/episodes"])
    assert main(["watch", str(folder), "--run", "1", "--json"]) in (0, 1)
    watched = json.loads(capsys.readouterr().out)
    assert watched["ended"] is False
    assert watched["episodes"] == trained > 0
    assert main(shlex.split(command)) == 0
    assert content(folder) == whole


def train_again(room: Path, folder: Path) -> int:
    return main(["train", str(room), *OPTIONS, "--out", str(folder), "--resume"])


@pytest.fixture(scope="module")
def interrupted_once(room, tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "interrupted"
    process = start(room, folder)
    wait_for_checkpoints(process, folder, 3)
    process.kill()
    process.wait()
    for partial in folder.glob(".*.partial"):
        partial.unlink()
    while len(checkpoints.checkpoints(folder)) > checkpoints.KEPT:
        checkpoints.checkpoints(folder)[-1].unlink()
    return folder


@pytest.fixture
def interrupted(interrupted_once, tmp_path):
    """A folder with two checkpoints."""
    return Path(shutil.copytree(interrupted_once, tmp_path / "interrupted"))


@pytest.mark.parametrize("damage", ["cut short", "empty", "gone on with"])
def test_a_damaged_checkpoint_is_named_and_the_one_before_used(
    room, interrupted, whole, capsys, damage
):
    latest, before = checkpoints.checkpoints(interrupted)
    written = latest.read_bytes()
    changed = {"cut short": written[:-2000], "empty": b"", "gone on with": written + b"x"}
    latest.write_bytes(changed[damage])
    assert train_again(room, interrupted) == 0
    (line,) = capsys.readouterr().err.splitlines()
    assert f"{latest}: is damaged" in line
    assert line.endswith(f"continuing from the previous one, {before}")
    assert content(interrupted) == whole


def test_any_flipped_bit_is_damage(room, interrupted):
    latest, before = checkpoints.checkpoints(interrupted)
    written = latest.read_bytes()
    random = np.random.default_rng(0)
    ends = [*range(40), *range(len(written) - 120, len(written))]  # a header, a directory, the hash
    for place in [*ends, *random.integers(len(written), size=60)]:
        changed = bytearray(written)
        changed[place] ^= 1 << int(random.integers(8))
        latest.write_bytes(changed)
        found = checkpoints.restore(Job.of(0, config_of(room)), interrupted)
        assert found == (before, {latest: "its checksum does not match"})


def test_a_damaged_checkpoint_is_none_of_the_two_that_are_kept(room, interrupted):
    latest, before = checkpoints.checkpoints(interrupted)
    latest.write_bytes(b"not this")

    class StopError(Exception):
        pass

    def stop(_):
        if len(checkpoints.checkpoints(interrupted)) == checkpoints.KEPT:
            raise StopError

    with pytest.raises(StopError):
        train(config_of(room), stop, out=interrupted, resume=True, checkpoint_seconds=0)
    assert checkpoints.checkpoints(interrupted)[1] == before
    for path in checkpoints.checkpoints(interrupted):
        assert checkpoints.restore(Job.of(0, config_of(room)), interrupted) == (path, {})
        path.unlink()


def config_of(room: Path) -> Config:
    """The settings of `OPTIONS`."""
    return Config(
        world=str(room),
        algorithm=A2C(entropy=9.0, hidden=(16,)),
        runs=3,
        steps=240_000,
        episodes=1_000_000,
        episode_limit=60,
    )


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
        assert "another process is using it" in capsys.readouterr().err
    finally:
        process.kill()
        process.wait()


def test_other_settings_are_refused(room, interrupted, capsys):
    arguments = ["train", str(room), *OPTIONS, "--out", str(interrupted), "--resume"]
    assert main([*arguments, "--discount", "0.5"]) == 2
    assert "was started with discount 0.99, not 0.5" in capsys.readouterr().err


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


def test_a_full_disk_is_one_line_and_with_room_it_goes_on(room, tmp_path, whole):
    disk = tmp_path / "disk"
    with mounted(disk, "size=192k"):
        folder = disk / "run"
        process = start(room, folder)
        assert process.wait() == 2
        said = said_by(folder)
        assert said.startswith(f"habilis: {folder}: cannot be written (")
        assert "No space left on device" in said
        assert said.endswith("make room there, and continue with resume\n")
        assert said.count("\n") == 1
        good = checkpoints.checkpoints(folder)
        assert good
        assert not list(folder.glob(".*.partial"))
        assert checkpoints.restore(Job.of(0, config_of(room)), folder) == (good[0], {})
        subprocess.run(["mount", "-o", "remount,size=10m", str(disk)], check=True)
        assert train_again(room, folder) == 0
        assert content(folder) == whole


def test_a_full_disk_at_the_start_is_one_line(room, tmp_path, capsys):
    disk = tmp_path / "disk"
    with mounted(disk, "size=4k"):
        (disk / "filled").write_bytes(b"x" * 4096)
        assert train_again(room, disk / "run") == 2
        err = capsys.readouterr().err
        assert "No space left on device" in err
        assert err.count("\n") == 1


def test_a_folder_that_is_read_only_is_one_line(room, tmp_path, capsys):
    disk = tmp_path / "disk"
    with mounted(disk, "ro"):
        assert train_again(room, disk) == 2
        assert train_again(room, disk / "run") == 2
        assert main(["train", str(room), *OPTIONS, "--out", str(disk / "run")]) == 2
        lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 3
    assert all(
        f"{disk} cannot be written to (Read-only file system); name another place" in line
        for line in lines
    )


def test_a_disk_that_turns_read_only_is_one_line(room, interrupted, capsys, monkeypatch):
    before = {path: path.read_bytes() for path in checkpoints.checkpoints(interrupted)}

    def read_only(*_, **__):
        raise OSError(30, "Read-only file system")

    monkeypatch.setattr(os, "fsync", read_only)
    assert train_again(room, interrupted) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "Read-only file system" in line
    assert {p: p.read_bytes() for p in checkpoints.checkpoints(interrupted)} == before


def test_what_is_not_finite_is_one_line_and_leaves_the_last_good_checkpoint(room, tmp_path):
    folder = tmp_path / "diverges"
    # Squares of values that grow, until their sum over a rollout is no float32 any more.
    settings = {"algorithm": "q-learning", "reward-scale": "1.9e18", "learning-rate": "0.001"}
    limits = {"episode-limit": "60", "steps": "9000000", "episodes": "1000000", "runs": "2"}
    options = [f"--{name}={value}" for name, value in (settings | limits).items()]
    command = ["train", str(room), *options, "--out", str(folder), "--checkpoint-seconds", "0"]
    done = subprocess.run(
        [sys.executable, "-m", "habilis", *command], capture_output=True, text=True
    )
    assert done.returncode == 2
    found = re.fullmatch(
        r"habilis: room.txt: the loss of run (\d) is not finite at step ([\d,]+); lower "
        r"--learning-rate or --reward-scale; the last good checkpoint is (.+)\n",
        done.stderr,
    )
    assert found, done.stderr
    latest = checkpoints.checkpoints(folder)[0]
    assert found[3] == str(latest)
    job = Job.of(0, read_config(folder))
    assert checkpoints.restore(job, folder) == (latest, {})
    run, step = int(found[1]), int(found[2].replace(",", ""))
    # The step is that of the update, no more than a stretch behind what was saved.
    per_update = job.config.algorithm.envs * job.config.algorithm.rollout
    assert step % per_update == 0
    assert job.records[run].steps < step <= job.records[run].steps + job.program.steps
    assert all(
        np.isfinite(job.lane(k).train_state.parameters).all() for k in range(len(job.records))
    )


def test_what_is_not_finite_names_the_last_good_checkpoint(room, tmp_path):
    config = Config(
        algorithm=A2C(learning_rate=1e30, clip=1e30, hidden=(8,)), world=str(room), runs=1
    )
    with pytest.raises(FloatingPointError, match="no checkpoint was made"):
        train(config, out=tmp_path / "run")


def check_that_it_goes_on_to_the_same_bytes(config: Config, folder: Path) -> None:
    """Trains a configuration in one go, and again with an interruption."""
    train(config, out=folder / "whole")

    class StopError(Exception):
        pass

    def stop(_):
        if checkpoints.checkpoints(folder / "cut"):
            raise StopError

    with pytest.raises(StopError):
        train(config, stop, out=folder / "cut", checkpoint_seconds=0)
    train(config, out=folder / "cut", resume=True)
    assert content(folder / "cut") == content(folder / "whole")
    assert load_run(folder / "cut").config == config


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
    check_that_it_goes_on_to_the_same_bytes(config, tmp_path)


def test_actions_are_counted_where_updates_do_not_report_them(room, tmp_path):
    """Whole episodes, and schedules by how many have ended: both are counted in the lanes."""
    learner = A2C(
        envs=4,
        rollout=0,
        schedule="episodes",
        entropy=9.0,
        entropy_end=5.0,
        entropy_steps=100_000,
        learning_rate_every=300,
        learning_rate_decay=0.9,
        networks="separate",
        hidden=(8,),
    )
    config = Config(
        algorithm=learner,
        world=str(room),
        observation="coordinates",
        episode_limit=60,
        runs=2,
        steps=60_000,
    )
    check_that_it_goes_on_to_the_same_bytes(config, tmp_path)
