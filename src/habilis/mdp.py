"""A finite Markov decision process as arrays."""

import operator
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float32, Int32
from numpy.typing import ArrayLike

_NOWHERE = -2  # a label of no state: cells are 0 and up, what a world lacks is -1


@dataclass(frozen=True, eq=False)
class TabularMDP:
    """A deterministic finite MDP; state and action are indices.

    Attributes:
        next_state: int32[S, A], the state that each action leads to. Terminal states have
            successors too: the dynamics do not know of episodes.
        reward: float32[S, A].
        terminal: bool[S], the states whose entry ends an episode.
        factors: by name, an int32[S] label of what the state says of one thing in it. In a
            world: "agent", "tool", "object", each `row * width + column`.
        flags: by name, a bool[S] property of the state. In a world: "equipped", "attached".
        start: the state in which episodes begin.
        shape: (rows, columns) of the world whose cells the factors name; `None` without one.
        actions: the names of the actions.
    """

    next_state: Int32[np.ndarray, "S A"]
    reward: Float32[np.ndarray, "S A"]
    terminal: Bool[np.ndarray, "S"]
    factors: Mapping[str, Int32[np.ndarray, "S"]] = field(default_factory=dict)
    flags: Mapping[str, Bool[np.ndarray, "S"]] = field(default_factory=dict)
    start: int = 0
    shape: tuple[int, int] | None = None
    actions: tuple[str, ...] = ()

    @classmethod
    def deterministic(
        cls,
        next_state: ArrayLike,
        reward: ArrayLike | None = None,
        terminal: ArrayLike | None = None,
        start: int = 0,
    ) -> "TabularMDP":
        """An MDP from its transition table.

        Args:
            next_state: int[S, A], the state that each action leads to.
            reward: float[S, A]; zero everywhere if left out.
            terminal: bool[S]; nowhere if left out.
            start: the state in which episodes begin.

        Raises:
            ValueError: the arrays do not fit each other, are empty, or name a state that
                does not exist.

        Example:
            >>> TabularMDP.deterministic([[0, 1], [1, 0]]).states
            2
        """
        table = as_array("next_state", next_state)
        if table.ndim != 2 or table.size == 0 or not np.issubdtype(table.dtype, np.integer):
            raise ValueError(
                f"next_state has shape {table.shape} and type {table.dtype}; "
                "give integers of shape [states, actions]"
            )
        outside = np.argwhere((table < 0) | (table >= len(table)))
        if len(outside):
            state, action = outside[0]
            raise ValueError(
                f"next_state[{state}, {action}] is {table[state, action]}; "
                f"use states 0 to {len(table) - 1}"
            )
        reward = np.zeros(table.shape) if reward is None else as_array("reward", reward)
        terminal = (
            np.zeros(len(table), bool) if terminal is None else as_array("terminal", terminal)
        )
        if reward.shape != table.shape:
            raise ValueError(f"reward has shape {reward.shape}; give {table.shape} as next_state")
        if reward.dtype.kind not in "biuf" or not (abs(reward) <= np.finfo(np.float32).max).all():
            raise ValueError("reward has entries that are not finite (in float32); give numbers")
        if terminal.shape != table.shape[:1]:
            raise ValueError(f"terminal has shape {terminal.shape}; give ({len(table)},)")
        if not isinstance(start, int | np.integer) or not 0 <= start < len(table):
            raise ValueError(f"start is {start}; use a state from 0 to {len(table) - 1}")
        return cls(
            np.array(table, np.int32, order="C"),
            reward.astype(np.float32),
            terminal.astype(bool),
            start=int(start),
        )

    @property
    def states(self) -> int:
        """S, how many states there are."""
        return self.next_state.shape[0]

    def factor(self, name: str) -> Int32[np.ndarray, "S"]:
        """The label of one thing in every state.

        Raises:
            ValueError: the MDP has no such factor; the message lists those it has.
        """
        if name not in self.factors:
            known = ", ".join(self.factors) or "none"
            raise ValueError(f"factor {name!r} is unknown; this MDP has: {known}")
        return self.factors[name]

    def label(self, cell: tuple[int, int]) -> int:
        """The label that factors have for a cell, `row * columns + column`.

        Returns:
            A label; one that no state has for a cell outside the map.

        Raises:
            ValueError: the MDP has no cells, or this is none.
        """
        if self.shape is None:
            raise ValueError("this MDP has no cells; only a world's table has")
        try:
            row, column = (operator.index(part) for part in cell)
        except (TypeError, ValueError):
            raise ValueError(f"cell is {cell!r}; give (row, column)") from None
        inside = 0 <= row < self.shape[0] and 0 <= column < self.shape[1]
        return row * self.shape[1] + column if inside else _NOWHERE

    def find(self, **cells: tuple[int, int]) -> int:
        """The state in which things are at given cells.

        Args:
            **cells: for each factor the (row, column) of the thing.

        Raises:
            KeyError: no state, or more than one, has everything there.
            ValueError: the MDP has no such factor.
        """
        found = np.ones(self.states, bool)
        for name, cell in cells.items():
            label = self.label(cell)
            found &= self.factor(name) == label
        matches = np.flatnonzero(found)
        if len(matches) != 1:
            where = ", ".join(f"{name}={cell}" for name, cell in cells.items())
            raise KeyError(f"{len(matches) or 'no'} states have {where}")
        return int(matches[0])


def as_array(name: str, values: ArrayLike) -> np.ndarray:
    """`values` as an array.

    Raises:
        ValueError: they are lists of different lengths.
    """
    try:
        return np.asarray(values)
    except ValueError:
        raise ValueError(f"{name} is ragged; give rows of one length") from None
