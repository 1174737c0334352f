"""Small tables in which some actions are not available, and all sequences that surely are."""

from collections.abc import Iterator
from itertools import product

import numpy as np


def random_table(rng: np.random.Generator) -> np.ndarray:
    """int[S, A], -1 where an action is not available; dead ends among the states."""
    states, actions = int(rng.integers(1, 7)), int(rng.integers(1, 4))
    table = rng.integers(states, size=(states, actions))
    table[rng.random(table.shape) < rng.choice([0.0, 0.2, 0.6])] = -1
    return table


def random_probabilities(rng: np.random.Generator) -> np.ndarray:
    """float[S, A, S], rows of zeros where an action is not available."""
    states, actions = int(rng.integers(1, 6)), int(rng.integers(1, 4))
    P = rng.dirichlet(np.full(states, rng.choice([0.1, 1.0])), (states, actions))
    P[P < 0.05] = 0
    P /= P.sum(axis=2, keepdims=True)
    certain = rng.random((states, actions)) < 0.4
    P[certain] = np.eye(states)[rng.integers(states, size=int(certain.sum()))]
    P[rng.random((states, actions)) < rng.choice([0.1, 0.3])] = 0
    return P


def as_probabilities(table: np.ndarray) -> np.ndarray:
    """A transition table as float[S, A, S]."""
    return np.where((table >= 0)[..., None], np.eye(len(table))[table], 0.0)


def sure_sequences(
    P: np.ndarray, state: int, horizon: int, actions: list[int]
) -> Iterator[tuple[tuple[int, ...], np.ndarray]]:
    """Every sequence that can surely be carried out, and the distribution of its last state."""
    for sequence in product(actions, repeat=horizon):
        belief = np.eye(len(P))[state]
        for action in sequence:
            if not P[belief > 0, action].any(axis=1).all():
                break
            belief = belief @ P[:, action]
        else:
            yield sequence, belief


def channel_of_sure_sequences(
    P: np.ndarray, sensor: np.ndarray, state: int, horizon: int, actions: list[int]
) -> np.ndarray:
    """float[n, O]; no rows where no sequence can surely be carried out."""
    rows = [belief @ sensor for _, belief in sure_sequences(P, state, horizon, actions)]
    return np.array(rows).reshape(-1, sensor.shape[1])
