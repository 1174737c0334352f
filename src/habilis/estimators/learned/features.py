"""What networks are given of states and readings: rows of one-hot labels, or scaled numbers."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from habilis.estimators.protocol import Simulator, is_finite
from habilis.estimators.sensors import Reading, checked_reading

Rows = Int[np.ndarray, "n labels"] | Float[np.ndarray, "n numbers"]

_TABULAR = 8192  # states up to which each has a row of its own
_LABELS = 4096  # of a sensor's component


@dataclass(frozen=True, eq=False)
class Features:
    """The inputs of a network.

    Attributes:
        size: how many different labels there are, or how many numbers.
        of: from what is described, one a row, to labels or numbers.
    """

    size: int
    of: Callable[[Any], Rows]


def state_features(simulator: Simulator, states: Float[np.ndarray, "n d"]) -> Features:
    """The inputs that stand for states.

    Args:
        simulator: the world.
        states: some, by which numbers are scaled.

    Returns:
        Of a table the state and its factors as labels, of many states the factors alone if they
        tell states apart; of anything else the state's numbers, scaled.
    """
    mdp = getattr(simulator, "mdp", None)
    if mdp is None or not is_finite(simulator):
        return _scaled(states)
    labels = [np.unique(one, return_inverse=True)[1] for one in mdp.factors.values()]
    apart = bool(labels) and len(np.unique(np.stack(labels), axis=1).T) == mdp.states
    if mdp.states <= _TABULAR or not apart:
        labels.append(np.arange(mdp.states))
    table, size = _offset(np.stack(labels, axis=1))
    return Features(size, lambda given: table[np.asarray(given)[:, 0].astype(np.int64)])


def outcome_features(
    simulator: Simulator,
    shown: Reading,
    sensor: Any,
    of_state: Features,
    states: Float[np.ndarray, "n d"],
    outcomes: Float[np.ndarray, "n p"],
    with_change: bool = True,
) -> Features:
    """The inputs that stand for what the sensor shows in the end.

    Args:
        simulator: the world.
        shown: its sensor, see `reading`.
        sensor: as it was given.
        of_state: what `state_features` gave.
        states: some starts.
        outcomes: of these, by which numbers are scaled.
        with_change: whether numbers have their change beside them, which tells of the start too.

    Returns:
        Of pairs (start, outcome): labels where there are few; otherwise the outcome's numbers, and
        by how much they have changed, scaled.
    """
    mdp = getattr(simulator, "mdp", None)
    if mdp is not None and is_finite(simulator):
        if isinstance(sensor, str) and sensor == "state":
            return Features(of_state.size, lambda pair: of_state.of(pair[1]))
        every = checked_reading(shown(np.arange(mdp.states, dtype=float)[:, None]), mdp.states)
        values = [np.unique(column) for column in every.T]
        if max(map(len, values)) <= _LABELS:
            starts = np.cumsum([0, *map(len, values)])

            def labels(pair: Any) -> Rows:
                columns = zip(values, pair[1].T, strict=True)
                ranks = [np.searchsorted(known, column) for known, column in columns]
                return (np.stack(ranks, axis=1) + starts[:-1]).astype(np.int32)

            return Features(int(starts[-1]), labels)
    absolute = _scaled(outcomes)
    if not with_change:
        return Features(absolute.size, lambda pair: absolute.of(pair[1]))
    change = _scaled(outcomes - checked_reading(shown(states), len(states)))

    def numbers(pair: Any) -> Rows:
        begun = checked_reading(shown(pair[0]), len(pair[0]))
        return np.concatenate([absolute.of(pair[1]), change.of(pair[1] - begun)], axis=1)

    return Features(absolute.size + change.size, numbers)


def _offset(labels: Int[np.ndarray, "n labels"]) -> tuple[Int[np.ndarray, "n labels"], int]:
    """Labels of several kinds as rows of one table, and how many rows it has."""
    counts = labels.max(axis=0) + 1
    starts = np.cumsum([0, *counts])
    return (labels + starts[:-1]).astype(np.int32), int(starts[-1])


def _scaled(numbers: Float[np.ndarray, "n numbers"]) -> Features:
    middle, spread = numbers.mean(axis=0), numbers.std(axis=0)
    width = np.where(spread > 1e-9 * np.maximum(1, abs(middle)), spread, 1.0)
    return Features(numbers.shape[1], lambda given: ((given - middle) / width).astype(np.float32))
