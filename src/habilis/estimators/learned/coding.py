"""Action sequences as what networks have distributions over: symbols, or vectors of numbers."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from jaxtyping import Float, Shaped

from habilis.estimators.actions import ActionBox, action_size, check_size, how_many

_ONE_SYMBOL = 1024  # sequences up to which each is a symbol
_MOST_NUMBERS = 48  # of a vector: its covariance is learned whole


@dataclass(frozen=True, eq=False)
class Coding:
    """How sequences are coded.

    Attributes:
        kind: "symbols", or "numbers": any real ones, which a box is mapped to.
        symbols: how many symbols there are.
        length: how many symbols or numbers code one sequence.
        actions: of the simulator.
        horizon: h.
    """

    kind: Literal["symbols", "numbers"]
    symbols: int
    length: int
    actions: Any
    horizon: int

    def sequences(self, coded: Shaped[np.ndarray, "n length"]) -> Float[np.ndarray, "n h k"]:
        """The action sequences that are coded."""
        if self.kind == "symbols":
            if self.length == 1 and self.horizon > 1:
                count = len(self.actions)
                places = count ** np.arange(self.horizon - 1, -1, -1)
                coded = coded.astype(np.int64) // places % count
            return self.actions[coded]
        numbers = coded.astype(np.float64).reshape(len(coded), self.horizon, -1)
        if not self.actions.is_bounded:
            return numbers
        share = 1 / (1 + np.exp(-numbers))
        return self.actions.low + (self.actions.high - self.actions.low) * share


def coding_of(actions: Any, horizon: int, power: float | None) -> Coding:
    """How the sequences of a simulator are coded.

    Args:
        actions: float[m, k] or an `ActionBox`.
        horizon: h, 1 or more.
        power: the bound on actions of an unbounded box.

    Raises:
        ValueError: the box is unbounded and there is no power, or it is half open; or sequences are
            too long.
    """
    if not isinstance(actions, ActionBox):
        if power is not None:
            raise ValueError(
                "power is for unbounded actions, these are finitely many; leave it out"
            )
        count = how_many(actions, horizon)
        if count <= _ONE_SYMBOL:
            return Coding("symbols", int(count), 1, actions, horizon)
        check_size(len(actions), horizon, 1)
        return Coding("symbols", len(actions), horizon, actions, horizon)
    ends = np.isfinite([actions.low, actions.high])
    if power is None and not actions.is_bounded:
        raise ValueError(
            "the action box is unbounded, so that its capacity is infinite; give power=, the bound "
            "on E ||(a_1 ... a_h)||^2"
        )
    if power is not None and ends.any():
        raise ValueError("power is for unbounded actions, the box has bounds; leave it out")
    size = horizon * action_size(actions)
    if size > _MOST_NUMBERS:
        raise ValueError(
            f"sequences have {size} numbers, above {_MOST_NUMBERS}; give a shorter horizon or "
            "finitely many actions"
        )
    return Coding("numbers", 0, size, actions, horizon)
