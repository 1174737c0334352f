"""States that a puzzle does not have, refused by name."""

from collections.abc import Collection, Sequence
from operator import index
from typing import Any

import numpy as np
from jaxtyping import Int64

from habilis.bridges.puzzles.bodies import ACTIONS, Body
from habilis.worlds.grid import Cell


def check_rows(
    name: str,
    states: np.ndarray,
    actions: Int64[np.ndarray, "n"],
    bodies: int,
    shape: tuple[int, int],
) -> None:
    """Refuses rows that are no states of a puzzle with so many bodies, and unknown actions.

    Raises:
        ValueError: the rows have another length, or a cell or an action does not exist.
    """
    if states.ndim != 2 or states.shape[1] != bodies:
        raise ValueError(
            f"{name}: states have shape {states.shape}; give [n, {bodies}], a cell for each body"
        )
    cells = shape[0] * shape[1]
    for what, values, count in (("cell", states, cells), ("action", actions, len(ACTIONS))):
        if values.size and not 0 <= values.min() <= values.max() < count:
            wrong = values[(values < 0) | (values >= count)][0]
            raise ValueError(f"{name}: there is no {what} {wrong}; give one from 0 to {count - 1}")


def check_on_map(
    name: str,
    state: Sequence[int],
    bodies: Sequence[Body],
    room: Sequence[tuple[int, int]],
    shape: tuple[int, int],
) -> None:
    """Refuses a state in which not every body is on the map.

    Args:
        name: of the puzzle.
        state: the cells of the bodies' corners.
        bodies: the agent and the movables.
        room: how many rows and columns the corner of each can be in.
        shape: of the map.

    Raises:
        ValueError: it is one.
    """
    if len(state) != len(bodies):
        raise ValueError(
            f"{name}: the state {state!r:.80} has {len(state)} cells; give one for each of the "
            f"{len(bodies)} bodies"
        )
    for body, label, (down, right) in zip(bodies, state, room, strict=True):
        row, column = divmod(label, shape[1])
        if not (0 <= row < down and 0 <= column < right):
            raise ValueError(
                f"{name}: in the state {state!r:.80} the {body.name} is not on the map of "
                f"{shape[0]} x {shape[1]} cells; give cells at which it is"
            )


def check_apart(
    name: str,
    state: Sequence[int],
    bodies: Sequence[Body],
    walls: Collection[Cell],
    agent_walls: Collection[Cell],
) -> None:
    """Refuses a state in which bodies overlap each other or walls.

    Args:
        name: of the puzzle.
        state: for the message.
        bodies: the agent and the movables, where they are in the state.
        walls, agent_walls: of the puzzle.

    Raises:
        ValueError: it is one.
    """
    taken = dict.fromkeys(walls, "a wall")
    for body in bodies:
        for cell in body.covered():
            own = body is bodies[0] and cell in agent_walls
            if own or cell in taken:
                other = taken.get(cell, "a wall of its own")
                raise ValueError(
                    f"{name}: in the state {state!r:.80} the {body.name} and {other} are both at "
                    f"{cell}; give cells at which nothing overlaps"
                )
            taken[cell] = f"the {body.name}"


def whole(puzzle: str, what: str, value: Any) -> int:
    """A whole number as Python's own.

    Raises:
        ValueError: it is another kind of number, or none.
    """
    try:
        return index(value)
    except TypeError:
        raise ValueError(f"{puzzle}: {what} is {value!r:.80}; give a whole number") from None


def as_cells(puzzle: str, state: Any) -> Sequence[Any]:
    """A state as a sequence.

    Raises:
        ValueError: it is none.
    """
    if isinstance(state, Sequence | np.ndarray) and not isinstance(state, str):
        return list(state)
    raise ValueError(f"{puzzle}: a state is {state!r:.80}; give a tuple with a cell for each body")
