"""The ledger adds up what the environments did, to the last bit as NumPy does."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_ledger import plain_entries

from habilis.learning.episodes import Ledger


def ledger_of(rng: np.random.Generator, rewards: str, transitions: int = 60) -> Ledger:
    reward = {
        "whole": -rng.integers(0, 3, transitions).astype(float),
        "any": rng.normal(-1, 3, transitions) * 10.0 ** rng.integers(-9, 9, transitions),
    }[rewards]
    flags = rng.random((2, transitions)) < 0.3
    return Ledger(
        np.stack([np.ones(transitions), reward, *flags], axis=1), rng.random(transitions) < 0.1
    )


@pytest.mark.parametrize("rewards", ["whole", "any"])
@settings(deadline=None)  # it is compiled at first
@given(seed=st.integers(0, 10**6), steps=st.integers(1, 40), envs=st.integers(1, 5))
def test_episodes_are_to_the_last_bit_those_of_numpy(rewards, seed, steps, envs):
    rng = np.random.default_rng(seed)
    ledger = ledger_of(rng, rewards)
    running = ours = ledger.nothing(envs)
    for _ in range(3):
        transition = rng.integers(0, 60, (steps, envs), dtype=np.int32)
        truncated = rng.random((steps, envs)) < rng.choice([0, 0.05, 1])
        expected, running = plain_entries(ledger, running, transition, truncated)
        found, ours = ledger.entries(ours, transition, truncated)
        np.testing.assert_array_equal(found, expected)
        np.testing.assert_array_equal(ours, running)
        assert found.dtype == expected.dtype == np.float64


def test_episodes_come_in_the_order_of_time_and_then_of_the_environments():
    ledger = Ledger(np.array([[1.0, 10.0], [1.0, 100.0], [1.0, 1000.0]]), np.array([0, 0, 1], bool))
    transition = np.array([[0, 1], [0, 2], [2, 0]])
    truncated = np.array([[0, 0], [0, 0], [0, 1]], bool)
    rows, after = ledger.entries(np.array([[5.0, 50.0], [0.0, 0.0]]), transition, truncated)
    np.testing.assert_array_equal(rows, [[2, 1100], [8, 1070], [1, 10]])
    np.testing.assert_array_equal(after, np.zeros((2, 2)))
