"""How far an exploration goes, and which steps are made a second time."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Int64

MAX_STATES = 10_000_000
_CHECKED = 200_000  # transitions that are all made twice; of more, one in _EVERY
_EVERY = 20


class TooManyStatesError(ValueError):
    """More states can be reached than are accepted."""


@dataclass(frozen=True)
class Limits:
    """How far an exploration goes.

    Attributes:
        horizon: how many actions from the first states; `None` for any number.
        max_states: how many states are accepted.
        until: whether some states, as `factors_many` and its like take them, are where to stop:
            those that one more action reaches are not expanded then.
    """

    horizon: int | None
    max_states: int
    until: Callable[[Any], bool] | None = None

    def goes_on(self, level: int, newest: Callable[[], Any]) -> bool:
        """Whether states are expanded.

        Args:
            level: how many actions lead to them.
            newest: makes them.
        """
        if self.horizon is not None and level >= self.horizon:
            return False
        return self.until is None or level == 0 or not self.until(newest())

    def exceeded(self, expanded: int, level: int) -> TooManyStatesError:
        """The error that says how far the exploration came, and what to do.

        Args:
            expanded: how many states were expanded.
            level: how many actions lead to the last of them.
        """
        within = "" if self.horizon is None else f" within {self.horizon} actions"
        give = "give a horizon" if self.horizon is None else "give a lower horizon"
        return TooManyStatesError(
            f"more than {self.max_states:,} states can be reached{within}; {expanded:,} of them "
            f"are expanded, and the next is {level} actions from the first: raise max_states if "
            f"there is memory for it, {give}, or leave out of the states what no later step needs"
        )


def made_again(transitions: int) -> Int64[np.ndarray, "n"]:
    """Transitions to make a second time, in another order than they were made in."""
    chosen = max(_CHECKED, transitions // _EVERY)
    return np.random.default_rng(0).permutation(transitions)[:chosen]
