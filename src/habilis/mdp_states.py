"""Methods of `TabularMDP` that say what its states stand for: cells, models, environments."""

import operator
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Int32

if TYPE_CHECKING:
    from habilis.mdp import TabularMDP

HELD, LAID = "held", "laid"
"""The factors of a world that are no cells: which tool is in hand, and which was put down."""

_NOWHERE = -2  # a label of no state: cells are 0 and up, what a world lacks is -1


@runtime_checkable
class Origin(Protocol):
    """The environment that a table was made of."""

    @property
    def verified(self) -> int:
        """How many transitions of the table were seen in replays of the environment."""
        ...

    def restore(self, state: int | np.integer) -> Any:
        """The environment in a state."""
        ...

    def observation(self, state: int | np.integer) -> Any:
        """Its observation of a state."""
        ...


@runtime_checkable
class ModelStates(Protocol):
    """The states of the model that a table was made of."""

    def state(self, index: int) -> Any:
        """A state as the model has it."""
        ...

    def index(self, state: Any) -> int:
        """The number of a state; -1 if it is not in the table."""
        ...


def restore(self: "TabularMDP", state: int | np.integer) -> Any:
    """An environment in a state of a table that `from_gymnasium` made.

    Args:
        state: its index.

    Returns:
        A copy of the environment that was passed, with its wrappers, led there along a shortest
        path or, of a `P`, put there; with `state=(save, load)`, or an environment's own
        `set_state`, that environment itself.

    Raises:
        ValueError: the table was not made from an environment, there is no such state, or the
            wrappers do not let it be reached.

    Example:
        >>> import gymnasium
        >>> from habilis import TabularMDP
        >>> lake = TabularMDP.from_gymnasium(gymnasium.make("FrozenLake-v1"))
        >>> int(lake.restore(7).unwrapped.s)
        7
    """
    return _environment(self, state).restore(int(state))


def observation(self: "TabularMDP", state: int | np.integer) -> Any:
    """The observation of a state by the environment of `from_gymnasium`, with its wrappers.

    Args:
        state: its index.

    Returns:
        An observation, as `step` returns it.

    Raises:
        ValueError: as in `restore`.

    Example:
        >>> import gymnasium
        >>> from habilis import TabularMDP
        >>> lake = TabularMDP.from_gymnasium(gymnasium.make("FrozenLake-v1"))
        >>> lake.observation(7)
        7
    """
    return _environment(self, state).observation(int(state))


def state(self: "TabularMDP", index: int | np.integer) -> Any:
    """A state of the model that `explore` made this table of.

    Args:
        index: its number here.

    Returns:
        The state as the model has it.

    Raises:
        ValueError: the table was not made of a model, or there is no such state.

    Example:
        >>> class Coin:
        ...     actions, initial = ("turn",), "heads"
        ...
        ...     def step(self, state, action):
        ...         return "tails" if state == "heads" else "heads"
        >>> from habilis.models import explore
        >>> explore(Coin()).state(1)
        'tails'
    """
    states = _of_model(self)
    _check_index(self, index)
    return states.state(int(index))


def index(self: "TabularMDP", state: Any) -> int:
    """The number of a state of the model that `explore` made this table of.

    Args:
        state: as the model has it.

    Returns:
        Its index.

    Raises:
        KeyError: it was not reached.
        ValueError: the table was not made of a model.

    Example:
        >>> class Coin:
        ...     actions, initial = ("turn",), "heads"
        ...
        ...     def step(self, state, action):
        ...         return "tails" if state == "heads" else "heads"
        >>> from habilis.models import explore
        >>> explore(Coin()).index("tails")
        1
    """
    found = _of_model(self).index(state)
    if found < 0:
        raise KeyError(f"the table has no state {state!r:.80}: it is not reached")
    return found


def _of_model(self: "TabularMDP") -> "ModelStates":
    if self.model_states is None:
        raise ValueError("this table was not made of a model; habilis.explore makes one of it")
    return self.model_states


def _check_index(self: "TabularMDP", state: Any) -> None:
    if not isinstance(state, int | np.integer) or not 0 <= state < self.states:
        raise ValueError(f"state is {state!r}; use 0 to {self.states - 1}")


def _environment(self: "TabularMDP", state: int | np.integer) -> "Origin":
    if self.origin is None:
        raise ValueError(
            "this table was not made from an environment; TabularMDP.from_gymnasium makes one"
        )
    _check_index(self, state)
    return self.origin


def factor(self: "TabularMDP", name: str) -> Int32[np.ndarray, "S"]:
    """The label of one thing in every state.

    Args:
        name: of the factor, as "object". Where there is only one of them, "object" stands for
            "object:can" too, and "tool" for "tool:picker".

    Returns:
        int32[S]; in a world the cell of the thing, `row * columns + column`.

    Raises:
        ValueError: the MDP has no such factor, or several that could be meant; the message
            lists those it has.
    """
    return self.factors[self.factor_named(name)]


def factor_named(
    self: "TabularMDP", name: str, what: str = "factor", besides: Sequence[str] = ()
) -> str:
    """The whole name of a factor: "object" is "object:can" where that is the only object.

    Args:
        name: of the factor, or what stands before the colon in it.
        what: to call it in the message.
        besides: what else there is to choose.

    Returns:
        A key of `factors`.

    Raises:
        ValueError: as in `factor`.
    """
    if name in self.factors:
        return name
    meant = [one for one in self.factors if one.partition(":")[0] == name]
    if len(meant) == 1:
        return meant[0]
    problem = "could be several things" if meant else "is unknown"
    known = ", ".join([*besides, *self.factors]) or "none"
    fix = f"use one of {known}" if besides else f"this MDP has: {known}"
    raise ValueError(f"{what} {name!r} {problem}; {fix}")


def is_cell(self: "TabularMDP", name: str) -> bool:
    """Whether a factor's labels are cells of a map.

    Args:
        name: of the factor, in full.

    Returns:
        Not for "held" and "laid", and in an MDP without a map for none; see `cells`.
    """
    if self.cells is not None:
        return name in self.cells
    return self.shape is not None and name not in (HELD, LAID)


def label(self: "TabularMDP", cell: tuple[int, int]) -> int:
    """The label that factors have for a cell, `row * columns + column`.

    Args:
        cell: (row, column), from 0.

    Returns:
        A label; one that no state has for a cell outside the map.

    Raises:
        ValueError: the MDP has no cells, or this is none.
    """
    if self.shape is None:
        raise ValueError("this MDP has no cells; only the table of a world has them")
    try:
        row, column = (operator.index(part) for part in cell)
    except (TypeError, ValueError):
        raise ValueError(f"cell is {cell!r}; give (row, column)") from None
    inside = 0 <= row < self.shape[0] and 0 <= column < self.shape[1]
    return row * self.shape[1] + column if inside else _NOWHERE


def find(self: "TabularMDP", **cells: tuple[int, int] | int) -> int:
    """The state in which things are at given cells.

    Args:
        **cells: for each factor the (row, column) of the thing; its label if it is no cell, as
            `find(**{"agent": (0, 0), "object:can": (1, 0), "held": -1})`.

    Returns:
        The state's index.

    Raises:
        KeyError: no state, or more than one, has everything there.
        ValueError: the MDP has no such factor.
    """
    found = np.ones(self.states, bool)
    for name, cell in cells.items():
        label = _label_of(self, name, cell)
        found &= self.factor(name) == label
    matches = np.flatnonzero(found)
    if len(matches) != 1:
        where = ", ".join(f"{name}={cell}" for name, cell in cells.items())
        others = [name for name in self.factors if name not in cells]
        fix = f"; give {', '.join(others)} too" if len(matches) and others else ""
        raise KeyError(f"{len(matches) or 'no'} states have {where}{fix}")
    return int(matches[0])


def _label_of(self: "TabularMDP", name: str, value: Any) -> int:
    if (self.shape is None and self.cells is None) or self.is_cell(self.factor_named(name)):
        return self.label(value)
    return operator.index(value)
