"""The slow, plain ways that the fast ones are compared with."""

from itertools import product

import numpy as np


def divergences(P: np.ndarray, q: np.ndarray) -> np.ndarray:
    """D(P_x || q) of every input, in bits, term by term as it is written."""
    with np.errstate(divide="ignore", invalid="ignore"):
        terms = np.where(P > 0, P * (np.log2(P) - np.log2(q)), 0)
    return terms.sum(axis=1)


def blahut_arimoto(P: np.ndarray, gap: float = 1e-7) -> float:
    """The iteration of 1972, as slow as it is: bits, to within the gap."""
    p = np.full(len(P), 1 / len(P))
    for _ in range(2_000_000):
        each = divergences(P, p @ P)
        if each.max() - p @ each <= gap:
            return float(p @ each)
        p = p * np.exp2(each)
        p /= p.sum()
    raise AssertionError("no convergence")


def channel_of_sequences(
    P: np.ndarray, sensor: np.ndarray, start: int, horizon: int, actions: list[int]
) -> np.ndarray:
    """The channel from every sequence of actions, one after the other, to observations.

    Args:
        P: float[S, A, S].
        sensor: float[S, O].
    """
    rows = []
    for sequence in product(actions, repeat=horizon):
        belief = np.eye(len(P))[start]
        for action in sequence:
            belief = belief @ P[:, action]
        rows.append(belief @ sensor)
    return np.array(rows)
