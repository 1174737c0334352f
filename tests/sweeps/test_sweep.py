"""Grids: what is finished stays finished, whatever happens to the process that drives them."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import polars as pl
import pytest

from habilis.cli import main
from habilis.learning.runner import train
from habilis.sweeps import sweep
from habilis.sweeps.store import LAYOUT, results
from habilis.sweeps.training import tasks_of, train_tasks
from habilis.tasks.local import available_memory, peak_memory, processes

SPEC = """
[config]
world = "{room}"
runs = 7
episodes = 300
episode_limit = 50
hidden = [8]
[grid]
learning_rate = [2e-3, 4e-3, 8e-3]
entropy = [0.0, 0.02]
"""
TASK_COUNT = 12


@pytest.fixture(scope="module")
def spec(room, tmp_path_factory):
    path = tmp_path_factory.mktemp("spec") / "grid.toml"
    path.write_text(SPEC.format(room=room))
    return path


def without_seconds(folder: Path) -> pl.DataFrame:
    frame = pl.read_parquet(folder / "results.parquet")
    assert frame.equals(results(folder))
    return frame.drop("seconds")


@pytest.fixture(scope="module")
def whole(spec, tmp_path_factory):
    """The result of an undisturbed grid."""
    folder = tmp_path_factory.mktemp("sweeps") / "whole"
    assert main(["sweep", str(spec), "--out", str(folder)]) == 0
    return without_seconds(folder)


def start(spec: Path, folder: Path, *options: str) -> subprocess.Popen:
    command = [sys.executable, "-m", "habilis", "sweep", str(spec), "--out", str(folder)]
    with open(f"{folder}.err", "w") as said:
        return subprocess.Popen([*command, *options], stdout=said, stderr=said)


def finished(folder: Path) -> list[Path]:
    return sorted((folder / LAYOUT.results).glob("[!.]*.npz"))


def wait_for(process: subprocess.Popen, folder: Path, count: int) -> None:
    """Until so many tasks are finished."""
    while len(finished(folder)) < count:
        assert process.poll() is None, Path(f"{folder}.err").read_text()
        time.sleep(0.005)


def test_every_run_of_every_point_is_there_once(whole):
    assert whole.height == 6 * 7
    assert whole.select("point", "run").n_unique() == 6 * 7
    pairs = whole.group_by("point", maintain_order=True).first()
    pairs = pairs.select("learning_rate", "entropy").rows()
    assert pairs == [(r, e) for r in (2e-3, 4e-3, 8e-3) for e in (0.0, 0.02)]
    assert whole["final_return"].n_unique() > 20


def test_a_killed_sweep_goes_on_and_trains_nothing_twice(spec, tmp_path, whole):
    folder = tmp_path / "killed"
    process = start(spec, folder)
    wait_for(process, folder, 2)
    process.kill()
    assert process.wait() == -signal.SIGKILL
    kept = {path: path.stat().st_mtime_ns for path in finished(folder)}
    assert 2 <= len(kept) < TASK_COUNT
    assert main(["sweep", str(spec), "--out", str(folder), "--resume"]) == 0
    assert {path: path.stat().st_mtime_ns for path in kept} == kept
    assert len(finished(folder)) == TASK_COUNT
    assert without_seconds(folder).equals(whole)


def test_ctrl_c_keeps_what_is_finished_and_says_how_to_go_on(spec, tmp_path, whole):
    folder = tmp_path / "stopped"
    process = start(spec, folder)
    wait_for(process, folder, 1)
    process.send_signal(signal.SIGINT)
    assert process.wait() == 130
    said = Path(f"{folder}.err").read_text()
    assert f"of {TASK_COUNT} tasks are kept in {folder}: continue with --resume" in said
    assert "Traceback" not in said
    assert main(["sweep", str(spec), "--out", str(folder), "--resume"]) == 0
    assert without_seconds(folder).equals(whole)


def test_a_damaged_file_is_reported_and_its_runs_trained_again(config, tmp_path, capsys):
    folder = tmp_path / "sweep"
    before = sweep([config], folder)
    path = finished(folder)[0]
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)
    assert results(folder).height < before.height
    after = sweep([config], folder, resume=True)
    reported = capsys.readouterr().err
    assert reported.startswith(f"habilis: {path}: is damaged (")
    assert reported.endswith("; it is computed again\n")
    assert reported.count("\n") == 1
    assert after.drop("seconds").equals(before.drop("seconds"))
    assert results(folder).equals(after)


def test_another_tasks_file_is_damage_too(config, tmp_path, capsys):
    folder = tmp_path / "sweep"
    before = sweep([config], folder)
    one, other = tasks_of(config)
    files = [folder / LAYOUT.results / f"{task.name}.npz" for task in (one, other)]
    files[0].write_bytes(files[1].read_bytes())
    assert sweep([config], folder, resume=True).drop("seconds").equals(before.drop("seconds"))
    assert "holds runs [5, 6]" in capsys.readouterr().err


def test_a_second_driver_is_refused(spec, tmp_path, capsys):
    folder = tmp_path / "busy"
    process = start(spec, folder)
    try:
        wait_for(process, folder, 1)
        process.send_signal(signal.SIGSTOP)  # or it may be done before we ask
        assert main(["sweep", str(spec), "--out", str(folder), "--resume"]) == 2
        assert "another process" in capsys.readouterr().err
    finally:
        process.kill()
        process.wait()


def test_more_points_and_runs_are_added_to_what_is_there(config, tmp_path):
    folder = tmp_path / "sweep"
    few = sweep([config.changed(runs=5)], folder)
    trained = []

    def counting(tasks, done, stopped):
        trained.extend(tasks)
        train_tasks(tasks, done, stopped)

    more = [config, config.changed(learning_rate=3e-3)]
    frame = sweep(more, folder, resume=True, executor=counting)
    assert len(trained) == 3
    assert frame.height == 14
    assert frame[:5].equals(few)


def steps_taken(run, index):
    """A measure: all steps of a run's episodes."""
    return {"steps_taken": int(run.episodes.filter(run=index)["steps"].sum())}


def test_measurements_are_columns_of_the_results(config, tmp_path):
    folder, measures = tmp_path / "sweep", (steps_taken,)
    frame = sweep([config.changed(runs=2)], folder, measures=measures)
    assert results(folder, measures).equals(frame)
    assert frame.columns[-2:] == ["steps_taken", "curve"]
    (run,) = train([config.changed(runs=2)])
    taken = run.episodes.group_by("run", maintain_order=True).agg(pl.col("steps").sum())["steps"]
    assert frame["steps_taken"].to_list() == taken.to_list()
    with processes(1) as executor:
        other = sweep([config], tmp_path / "other", executor=executor, measures=measures)
    assert other[:2].drop("seconds").equals(frame.drop("seconds"))


def test_a_result_that_comes_twice_is_kept_once(config, tmp_path):
    def twice(tasks, done, _stopped):
        for task in [*tasks, *tasks]:
            done(task.name, task.run())

    frame = sweep([config], tmp_path / "sweep", executor=twice)
    assert frame["run"].to_list() == list(range(7))


@pytest.mark.parametrize(
    ("change", "fix"),
    [
        ({"world": "nowhere"}, "point 1: nowhere: no such world"),
        (
            {"intrinsic": "objet", "horizon": 1, "beta": 0.1},
            "point 1: intrinsic 'objet' is",
        ),
        ({"tool": "broom"}, "point 1: .*no tool whose place"),
    ],
)
def test_what_cannot_be_trained_is_refused_before_anything_is_written(
    config, tmp_path, change, fix
):
    with pytest.raises(ValueError, match=fix):
        sweep([config, config.changed(**change)], tmp_path / "sweep")
    assert not (tmp_path / "sweep").exists()


def test_a_folder_of_something_else_is_refused(config, tmp_path, spec, capsys):
    (tmp_path / "sweep").mkdir()
    (tmp_path / "sweep" / "letters.txt").write_text("mine")
    with pytest.raises(ValueError, match="exists already"):
        sweep([config], tmp_path / "sweep")
    with pytest.raises(ValueError, match="has no sweep to resume"):
        sweep([config], tmp_path / "sweep", resume=True)
    with pytest.raises(ValueError, match="nothing to sweep over"):
        sweep([], tmp_path / "none")
    arguments = ["sweep", str(spec), "--out", str(tmp_path / "both")]
    assert main([*arguments, "--ray", "local", "--processes", "2"]) == 2
    assert "give one of them" in capsys.readouterr().err
    assert main([*arguments, "--processes", "0"]) == 2
    assert "processes is 0; give at least 1" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["sweep"]


def test_a_task_whose_process_is_killed_is_run_again(config, tmp_path):
    configs = [config, config.changed(learning_rate=3e-3)]
    killed = []

    def kill_one(done: int, _total: int) -> None:
        if done == 1 and not killed:
            children = Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()
            for child in map(int, children):
                if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes():
                    os.kill(child, signal.SIGKILL)
                    killed.append(child)

    with processes(1) as executor:
        frame = sweep(configs, tmp_path / "sweep", executor=executor, on_progress=kill_one)
    assert killed
    alone = sweep(configs, tmp_path / "alone")
    assert frame.drop("seconds").equals(alone.drop("seconds"))


def test_no_more_processes_are_started_than_fit_into_memory(config, tmp_path, monkeypatch):
    monkeypatch.setattr("habilis.tasks.local.available_memory", lambda: 100 * 2**20)
    reported = []
    with processes(3, reported.append) as executor:
        frame = sweep([config], tmp_path / "sweep", executor=executor)
    assert frame.height == 7
    assert len(reported) == 1
    assert reported[0].startswith("habilis: 1 of 3 processes fit into memory, at ")


def test_memory_is_counted():
    assert available_memory() > 2**20
    assert peak_memory() > 2**25
