"""Batches of lanes: who is in them, how wide they are, and what does not depend on it."""

from types import SimpleNamespace
from typing import Any

import jax
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from habilis.cli import main
from habilis.learning import batches, checkpoints, stacks
from habilis.learning.algorithms.a2c import A2C
from habilis.learning.batches import LANES, MOST_LANES, train_jobs
from habilis.learning.config import Config
from habilis.learning.jobs import Job
from habilis.learning.lanes import advance
from habilis.learning.runner import train
from habilis.learning.runs import Progress
from habilis.learning.stacks import Seat

CPU, GPU = SimpleNamespace(platform="cpu"), SimpleNamespace(platform="gpu")


@pytest.fixture
def room(tmp_path):
    path = tmp_path / "room.txt"
    path.write_text("A.\nC.\n..\nG.\n")
    return Config(
        algorithm=A2C(hidden=(8,)), world=str(path), runs=2, episodes=300, episode_limit=50
    )


def leaves_of(run) -> list[np.ndarray]:
    return [run.episodes.to_numpy(), *map(np.asarray, jax.tree.leaves(run.parameters))]


def assert_same(found, expected):
    for one, other in zip(leaves_of(found), leaves_of(expected), strict=True):
        np.testing.assert_array_equal(one, other)


# How wide


@pytest.mark.parametrize(
    ("wait", "wide"),
    [(1, 5), (5, 5), (6, 8), (8, 8), (9, 16), (200, 256), (512, 512), (513, 512), (9999, 512)],
)
def test_on_a_gpu_a_batch_is_the_least_power_of_two_that_holds_those_that_wait(wait, wide):
    assert batches._width(wait, GPU) == wide
    assert batches._width(wait, CPU) == LANES
    assert MOST_LANES == 512


def test_a_run_is_the_same_whatever_trains_beside_it_at_any_given_width(room):
    other = room.changed(learning_rate=1e-3, intrinsic="object", horizon=2, beta=0.1, runs=6)
    for lanes in (1, 3):
        alone = train(room, lanes=lanes)
        _, beside = train([other, room], lanes=lanes)
        assert_same(beside, alone)


def test_five_lanes_are_what_a_cpu_has_by_itself(room):
    assert_same(train(room, lanes=LANES), train(room))


def test_every_batch_is_as_wide_as_was_asked_for(room, monkeypatch):
    widths = set()

    def watching(dynamics, settings, lanes, program):
        widths.add(len(lanes.updates))
        return advance(dynamics, settings, lanes, program)

    monkeypatch.setattr(batches, "advance", watching)
    train(room.changed(runs=4), lanes=3)
    assert widths == {3}


@pytest.mark.ill_typed
@pytest.mark.parametrize("lanes", [0, -1, 2.0, True, "5", 10**6])
def test_what_is_no_width_is_refused(room, lanes):
    with pytest.raises(ValueError, match=r"lanes is .*; give a whole number from 1 to 65,536"):
        train(room, lanes=lanes)


def test_the_command_line_sets_the_width(room, tmp_path, monkeypatch, capsys):
    used = []
    monkeypatch.setattr(batches, "advance", lambda *parts: used.append(parts) or advance(*parts))
    command = ["train", room.world, "--runs", "2", "--steps", "1", "--hidden", "8"]
    command += ["--out", str(tmp_path / "run")]
    assert main([*command, "--lanes", "0"]) == 2
    assert "lanes is 0; give a whole number from 1 to 65,536" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()
    assert main([*command, "--lanes", "3"]) == 0
    assert [len(lanes.updates) for _, _, lanes, _ in used] == [3]


def test_a_training_that_was_interrupted_goes_on_to_the_same_at_its_width(room, tmp_path):
    whole = train(room.changed(runs=4), lanes=3)

    def stop(_):
        if checkpoints.checkpoints(tmp_path / "cut"):
            raise InterruptedError

    with pytest.raises(InterruptedError):
        train(room.changed(runs=4), stop, out=tmp_path / "cut", checkpoint_seconds=0, lanes=3)
    again = train(room.changed(runs=4), out=tmp_path / "cut", resume=True, lanes=3)
    assert_same(again, whole)


def test_what_a_device_puts_together_itself_trains_the_same(room, monkeypatch):
    """Batches that change as runs end, on the path that a GPU takes."""
    configs = [room.changed(seed=seed, episodes=40 + 300 * seed, runs=3) for seed in range(4)]
    expected = train(configs, lanes=3)
    monkeypatch.setattr(stacks, "_on_host", lambda device: False)
    monkeypatch.setattr(batches, "workers", lambda: 2)
    for found, wanted in zip(train(configs, lanes=3), expected, strict=True):
        assert_same(found, wanted)


def test_a_stretch_is_compiled_once_for_all_batches_of_a_width(room):
    stretches: Any = advance
    train(room.changed(runs=11), lanes=3)
    before = stretches._cache_size()
    train(room.changed(runs=13, seed=4), lanes=3)
    assert stretches._cache_size() == before


# Who


class Waits(Job):
    """As much of a job as one that waits needs."""

    __repr__ = object.__repr__  # that of a job names fields that are not there

    def __init__(self, index: int, kind: int, steps: list[int]):
        records = [SimpleNamespace(steps=step) for step in steps]
        vars(self).update(index=index, kind=(kind,), records=records)


@settings(deadline=None)
@given(st.data(), st.integers(1, 6))
def test_those_that_have_come_least_far_are_taken_and_of_one_kind(data, lanes):
    steps = st.lists(st.integers(0, 3), max_size=6)
    jobs = [
        Waits(index, data.draw(st.integers(0, 2)), data.draw(steps))
        for index in range(data.draw(st.integers(1, 5)))
    ]
    left = [Seat(job, run) for job in jobs for run in range(len(job.records))]
    waiting = batches._Waiting()
    for seat in data.draw(st.permutations(left)):
        waiting.add(seat)
    gone = data.draw(st.none() | st.sampled_from(jobs))
    if gone is not None:
        waiting.drop(gone)
        left = [seat for seat in left if seat.job is not gone]
    while left:
        assert len(waiting) == len(left)
        left.sort(key=lambda seat: (seat.job.records[seat.run].steps, seat.job.index, seat.run))
        expected = [seat for seat in left if seat.job.kind == left[0].job.kind][:lanes]
        assert waiting.take(lanes, CPU) == (expected, lanes)
        left = [seat for seat in left if seat not in expected]
    assert len(waiting) == 0


# Given up


def test_a_job_that_is_stopped_ends_unconverged_and_changes_no_other(room):
    bad, good = room.changed(runs=23, episodes=10**6), room.changed(seed=5)
    jobs, asked, reported = [Job.of(0, bad), Job.of(1, good)], set[int](), list[Progress]()

    def stop(job: Job) -> bool:
        asked.add(job.index)
        assert not all(record.ended for record in job.records)
        return job.index == 0

    train_jobs(jobs, reported.append, stop_job=stop)
    assert 0 in asked
    assert all(record.ended and record.converged_at is None for record in jobs[0].records)
    made = {record.steps for record in jobs[0].records}
    assert min(made) == 0
    assert len(made) == 2  # a stretch, or none
    ends = [progress for progress in reported if progress.config == 0]
    assert [progress.ended for progress in ends] == [23]  # reported once, and nothing later
    assert_same(jobs[1].result(), train(good))
    stopped = jobs[0].result()
    assert len(jax.tree.leaves(stopped.parameters)[0]) == 23
    assert stopped.converged_at == (None,) * 23


def test_a_job_that_is_not_stopped_trains_to_its_end(room):
    job = Job.of(0, room)
    train_jobs([job], stop_job=lambda job: False)
    assert_same(job.result(), train(room))


def test_there_is_room_for_the_jobs_that_come_after_one_that_is_stopped(room):
    begun = []

    def jobs():
        for index in range(5):
            begun.append(Job.of(index, room.changed(seed=index, episodes=10**6)))
            yield begun[-1]

    train_jobs(jobs(), at_once=2, stop_job=lambda job: True)
    assert len(begun) == 5
    assert all(record.ended for job in begun for record in job.records)
