"""Runs side by side: the same numbers, wherever each of them comes from."""

import jax
import numpy as np
import pytest

from habilis.learning import stacks
from habilis.learning.algorithms.a2c import A2C
from habilis.learning.batches import train_jobs
from habilis.learning.config import Config
from habilis.learning.jobs import Job
from habilis.learning.stacks import InStack, Seat, finite, merged, side_by_side, stacked

CPU = jax.devices()[0]


@pytest.fixture
def room(tmp_path):
    path = tmp_path / "room.txt"
    path.write_text("A.\nC.\n..\nG.\n")
    return Config(
        algorithm=A2C(hidden=(8,)), world=str(path), runs=5, episodes=10**6, episode_limit=50
    )


def advanced(index: int, config: Config) -> Job:
    """A job after a stretch of training."""
    job, over = Job.of(index, config), list[bool]()
    train_jobs([job], on_stretch=lambda: over.append(True), stopped=lambda: over)
    return job


def assert_same(found, expected):
    for one, other in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
        np.testing.assert_array_equal(np.asarray(one), np.asarray(other))
        assert one.dtype == other.dtype


def test_what_is_put_together_on_the_device_is_what_numpy_puts_together(room):
    first = advanced(0, room)
    second = advanced(1, room.changed(seed=3, learning_rate=1e-3))
    new = Job.of(2, room.changed(seed=2**32 - 1, runs=3))
    kept = Job.of(3, room.changed(seed=9, runs=2))
    kept.lanes.update({run: kept.start(run) for run in range(2)})
    left = [Seat(second, 4), Seat(new, 2), Seat(first, 3), Seat(kept, 1), Seat(first, 0)]
    for seats in (left, [*left, Seat(second, 0), Seat(new, 0)], [Seat(first, 2)], [Seat(new, 1)]):
        found, expected = merged(seats, 8, CPU), stacked(seats, 8, CPU)
        assert_same((found.settings, found.lanes), (expected.settings, expected.lanes))
        for place, (job, run) in enumerate(seats):
            assert_same(found.lane(place), job.lane(run))


def test_runs_that_are_side_by_side_stay_so(room):
    job = advanced(0, room)
    held = job.lanes[0]
    assert isinstance(held, InStack)
    stack, places = side_by_side([Seat(job, 4), Seat(job, 1)], 5, CPU)
    assert stack is held.stack
    for run, place in zip((4, 1), places, strict=True):
        assert_same(stack.lane(place), job.lane(run))
    wider, _ = side_by_side([Seat(job, 4), Seat(job, 1)], 8, CPU)
    assert wider is not stack
    assert wider.width == 8


@pytest.mark.parametrize("on_host", [True, False])
def test_a_lane_on_its_own_does_not_hold_the_others(room, on_host, monkeypatch):
    stack = stacked([Seat(Job.of(0, room), run) for run in range(5)], 5, CPU)
    monkeypatch.setattr(stacks, "_on_host", lambda device: on_host)
    alone = stack.alone(3)
    assert_same(alone, stack.lane(3))
    if on_host:
        assert all(leaf.base is None for leaf in jax.tree.leaves(alone))


@pytest.mark.parametrize("on_host", [True, False])
def test_the_lane_that_is_not_finite_is_found(room, on_host, monkeypatch):
    stack = stacked([Seat(Job.of(0, room), run) for run in range(5)], 5, CPU)
    leaves, structure = jax.tree.flatten(stack.lanes.train_state)
    monkeypatch.setattr(stacks, "_on_host", lambda device: on_host)
    assert finite(stack).tolist() == [True] * 5
    for number, leaf in enumerate(leaves):
        if not np.issubdtype(leaf.dtype, np.floating):
            continue
        broken = np.array(leaf)
        broken[(2, *[-1] * (leaf.ndim - 1))] = np.inf
        learner = structure.unflatten([*leaves[:number], broken, *leaves[number + 1 :]])
        other = stacks.Stack(CPU, stack.settings, stack.lanes._replace(train_state=learner))
        assert finite(other).tolist() == [True, True, False, True, True]
