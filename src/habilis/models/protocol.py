"""Models: everything that says where actions lead."""

from collections.abc import Hashable, Sequence
from typing import Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Int

State = Hashable
Outcomes = State | list[tuple[float, State]]


@runtime_checkable
class Model(Protocol):
    """A discrete model, one state at a time.

    A state is any hashable value; what happens next depends on it and on the action alone.
    Besides what is below, a model may have

    - `initial`: the state in which episodes begin;
    - `factors(state) -> dict[str, int | (row, column)]`: labels of the things in a state. Cells
      are (row, column), counted from 0;
    - `shape`: (rows, columns) of the map whose cells these are; by default as large as they need;
    - `reward(state, action, next_state) -> float`; by default 0;
    - `terminal(state) -> bool`: whether an episode ends when this state is entered;
    - `available(state)`: the indices of the actions that are available; by default all;
    - `players`: how many actions each player has, by name, where actions are joint ones
      (`TabularMDP.players`).

    Example:
        >>> class Line:
        ...     actions = "left", "right"
        ...     initial = 0
        ...
        ...     def step(self, state, action):
        ...         return min(max(state + (-1, 1)[action], 0), 4)
        >>> isinstance(Line(), Model)
        True
    """

    @property
    def actions(self) -> Sequence[str] | int:
        """The names of the actions, or how many there are."""
        ...

    def step(self, state: Any, action: int) -> Any:
        """The outcome of an action.

        Args:
            state: the state.
            action: the action's index.

        Returns:
            The next state; or a list of (probability, state), whose probabilities sum to 1.
        """
        ...


@runtime_checkable
class VectorModel(Protocol):
    """A deterministic model whose states are rows of k integers, many at a time.

    It may have what a `Model` may have; a state is a tuple of k integers then. Each of
    `factors_many(states)`, `reward_many(states, actions, next_states)`, `terminal_many(states)` and
    `available_many(states) -> bool[n, A]` takes the place of the one without "_many", and returns
    arrays; it is called with many states at once.

    Example:
        >>> class Line:
        ...     actions = "left", "right"
        ...     initial = (0,)
        ...
        ...     def step_many(self, states, actions):
        ...         return np.clip(states + np.array([-1, 1])[actions][:, None], 0, 4)
        >>> isinstance(Line(), VectorModel)
        True
    """

    @property
    def actions(self) -> Sequence[str] | int:
        """The names of the actions, or how many there are."""
        ...

    def step_many(
        self, states: Int[np.ndarray, "n k"], actions: Int[np.ndarray, "n"]
    ) -> Int[np.ndarray, "n k"]:
        """The next states.

        It may be called from several threads at once.

        Args:
            states: int[n, k], one state a row.
            actions: int[n], the index of the action that is taken in each.

        Returns:
            int[n, k].
        """
        ...


def action_names(model: Model | VectorModel) -> tuple[tuple[str, ...], int]:
    """The names of a model's actions, none if it has none, and how many there are.

    Raises:
        ValueError: they are no names and no number, as those of a simulator.
    """
    given = model.actions
    if isinstance(given, int | np.integer) and not isinstance(given, bool) and given > 0:
        return (), int(given)
    names = tuple(given) if isinstance(given, Sequence) and not isinstance(given, str) else ()
    if names and all(isinstance(name, str) for name in names) and len({*names}) == len(names):
        return names, len(names)
    if is_simulator(model):
        raise ValueError(
            f"{type(model).__name__} is a simulator, whose actions are vectors; name an estimator, "
            "as hb.empowerment(..., method=hb.Counting(0.1))"
        )
    raise ValueError(f"the model's actions are {given!r}; give different names, or a number")


def is_simulator(model: Any) -> bool:
    """Whether the actions of a model are vectors, as those of a `habilis.Simulator`."""
    given = getattr(model, "actions", None)
    return getattr(given, "ndim", 0) == 2 or (hasattr(given, "low") and hasattr(given, "high"))
