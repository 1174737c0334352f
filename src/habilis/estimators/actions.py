"""The actions of a simulator, and sequences of them."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64, Int64

Sequences = Float64[np.ndarray, "N h k"]

_MOST = 2**31 - 1  # numbers of an array of sequences
_BITS = 50  # of a number of sequences that is computed


@dataclass(frozen=True, eq=False)
class ActionBox:
    """All actions between two.

    Attributes:
        low: float[k], the least of each component; it may be infinite.
        high: float[k], the largest.

    Raises:
        ValueError: they are no two vectors of one length, or low is not below high.

    Example:
        >>> ActionBox([-1.0, -2.0], [1.0, 2.0]).size
        2
    """

    low: Any
    high: Any

    def __post_init__(self) -> None:
        low, high = (np.asarray(end, np.float64) for end in (self.low, self.high))
        if low.ndim != 1 or low.shape != high.shape or not (low < high).all():
            raise ValueError(
                f"an action box from {self.low!r} to {self.high!r} is none; give two lists of one "
                "length, each number of the first below that of the second"
            )
        object.__setattr__(self, "low", low)
        object.__setattr__(self, "high", high)

    @property
    def size(self) -> int:
        """k, the length of an action."""
        return len(self.low)

    @property
    def is_bounded(self) -> bool:
        """Whether no side is infinite."""
        return bool(np.isfinite(self.low).all() and np.isfinite(self.high).all())


def checked_actions(given: Any) -> "Float64[np.ndarray, 'm k'] | ActionBox":
    """The actions of a simulator as float64[m, k] or as a box, else a ValueError."""
    if isinstance(given, ActionBox):
        return given
    actions = np.asarray(given)
    if actions.ndim != 2 or not actions.size or actions.dtype.kind not in "biuf":
        raise ValueError(
            f"actions has shape {actions.shape} and type {actions.dtype}; give float[m, k], one "
            "action a row, or habilis.estimators.ActionBox(low, high)"
        )
    if not np.isfinite(actions).all():
        raise ValueError("actions has numbers that are not finite; give finite ones")
    return actions.astype(np.float64)


def action_size(actions: "Float64[np.ndarray, 'm k'] | ActionBox") -> int:
    """k, the length of an action."""
    return actions.size if isinstance(actions, ActionBox) else actions.shape[1]


def how_many(actions: "Float64[np.ndarray, 'm k'] | ActionBox", horizon: int) -> float:
    """The number of sequences: m ** h; of a box, or beyond 2 ** 50, infinite."""
    if horizon == 0:
        return 1.0
    if isinstance(actions, ActionBox) or horizon * np.log2(len(actions)) > _BITS:
        return float("inf")
    return float(len(actions) ** horizon)


def check_size(rows: int, horizon: int, size: int) -> None:
    """Refuses arrays of sequences that no memory holds."""
    if rows * max(horizon, 1) * size > _MOST:
        raise ValueError(
            f"horizon is {horizon}, and {rows:,} sequences of it need more than {_MOST:,} numbers; "
            "give a shorter horizon or fewer sequences"
        )


def drawn_actions(
    actions: "Float64[np.ndarray, 'm k'] | ActionBox",
    shape: tuple[int, ...],
    generator: np.random.Generator,
) -> Float64[np.ndarray, "*shape k"]:
    """Actions drawn uniformly, independent of each other.

    Raises:
        ValueError: of a box with an infinite side.
    """
    if not isinstance(actions, ActionBox):
        return actions[generator.integers(len(actions), size=shape)]
    if not actions.is_bounded:
        raise ValueError(
            "the action box is unbounded, so that no action can be drawn from it; give finite "
            "low and high, or use hb.Gaussian, whose power bounds the actions"
        )
    return generator.uniform(actions.low, actions.high, (*shape, actions.size))


def chosen_sequences(
    actions: "Float64[np.ndarray, 'm k'] | ActionBox",
    horizon: int,
    most: int,
    generator: np.random.Generator,
) -> tuple[Sequences, bool]:
    """All sequences if there are at most so many, else as many drawn uniformly.

    Args:
        actions: of a simulator.
        horizon: h.
        most: how many sequences at most.
        generator: to draw from. The first sequences do not depend on how many there are.

    Returns:
        float64[N, h, k], and whether these are all there are.
    """
    size = action_size(actions)
    if how_many(actions, horizon) <= most:
        if isinstance(actions, ActionBox):
            return np.empty((1, 0, size)), True
        check_size(len(actions) ** horizon, horizon, size)
        return actions[_every(len(actions), horizon)], True
    check_size(most, horizon, size)
    return drawn_actions(actions, (most, horizon), generator), False


def _every(count: int, horizon: int) -> Int64[np.ndarray, "N h"]:
    """All sequences of indices, in the order of counting."""
    number = np.arange(count**horizon)[:, None]
    return number // count ** np.arange(horizon - 1, -1, -1) % count
