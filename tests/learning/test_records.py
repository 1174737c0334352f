"""A record, stretch by stretch, against all of its episodes at once."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from habilis.learning.algorithms.a2c import A2C
from habilis.learning.config import Config
from habilis.learning.convergence import episodes_to_convergence
from habilis.learning.episodes import Ledger
from habilis.learning.runs import Record, Rows

BEST = -4.0
LEDGER = Ledger(np.array([[1.0, -1.0], [1.0, 0.0]]), np.array([False, True]))
"""A step that goes on, and one that ends the episode."""


def record(episodes: int) -> Record:
    return Record(Config(algorithm=A2C(envs=1), episodes=episodes), BEST, LEDGER)


def add(to: Record, lengths: np.ndarray) -> None:
    """A stretch with episodes of these lengths, the last of which goes on."""
    transition = np.zeros(int(lengths.sum()) + 2, np.int32)
    transition[np.cumsum(lengths) - 1] = 1
    truncated = np.zeros((len(transition), 1), bool)
    to.add(to.gain(transition[:, None], truncated, 0.0))


def lengths_of(rng: np.random.Generator) -> list[np.ndarray]:
    """Stretches of episodes that become shorter, most often to the point of convergence."""
    long = np.maximum(np.linspace(rng.integers(5, 40), -40, 3_500), rng.integers(3, 7))
    all_of_them = np.maximum(1, rng.normal(long, 1.0).astype(int))
    return np.split(all_of_them, np.sort(rng.integers(0, 3_500, 12)))


@settings(deadline=None, max_examples=60)
@given(seed=st.integers(0, 10**6), budget=st.integers(1, 4_000), restored=st.integers(0, 12))
def test_a_record_is_over_when_all_its_episodes_say_so(seed, budget, restored):
    stretches = lengths_of(np.random.default_rng(seed))
    mine, every = record(episodes=budget), np.empty(0)
    left = 0  # of the episode that goes on when a stretch ends
    for number, lengths in enumerate(stretches):
        if number == restored:  # from a checkpoint, by another process
            saved, mine = mine, record(episodes=budget)
            metrics = saved.metrics().copy()
            mine.restore(saved.steps, saved.running.copy(), saved.episodes().copy(), metrics)
            assert (mine.ended, mine.converged_at) == (saved.ended, saved.converged_at)
        add(mine, lengths)
        if len(lengths):
            every = np.append(every, -(lengths - 1.0))
            every[len(every) - len(lengths)] -= left
            left = 0
        left += 2
        at = episodes_to_convergence(every[:budget], BEST)
        assert mine.converged_at == at
        assert mine.ended == (at is not None or len(every) >= budget)
        kept = every[: at or budget]
        np.testing.assert_array_equal(mine.episodes()[:, 1], kept)
        if mine.ended:
            return


@pytest.mark.parametrize(("budget", "converged_at"), [(2098, None), (2099, 2099), (2100, 2099)])
def test_episodes_beyond_the_budget_do_not_count(budget, converged_at):
    mine = record(budget)
    add(mine, np.full(2_500, 5))
    assert (mine.ended, mine.converged_at) == (True, converged_at)
    assert mine.count == min(budget, 2099)


def test_what_a_stretch_will_add_is_worked_out_without_a_change():
    mine = record(episodes=100)
    add(mine, np.array([3, 4]))
    before = mine.steps, mine.count, mine.running.copy()
    gain = mine.gain(np.ones((5, 1), np.int32), np.zeros((5, 1), bool), 0.0)
    assert (mine.steps, mine.count) == before[:2]
    np.testing.assert_array_equal(mine.running, before[2])
    mine.add(gain)
    assert (mine.steps, mine.count) == (before[0] + 5, before[1] + 5)


def test_a_run_over_budget_keeps_its_episodes_and_has_not_converged():
    mine = record(episodes=100)
    add(mine, np.array([3, 4]))
    mine.stop()
    assert (mine.ended, mine.converged_at, mine.count) == (True, None, 2)


@pytest.mark.parametrize("first", [0, 3])
def test_rows_are_those_that_were_added(first):
    rows, expected = Rows(np.ones((first, 2))), np.ones((first, 2))
    for count in (1, 0, 7, 2, 30):
        more = np.full((count, 2), count)
        rows.add(more)
        expected = np.concatenate([expected, more])
        np.testing.assert_array_equal(rows.all(), expected)
    rows.keep(5)
    rows.keep(9)
    assert len(rows) == 5
    np.testing.assert_array_equal(rows.all(), expected[:5])
