"""Puzzles of rigid bodies that an agent pushes, as models; PushWorld's files."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float64, Int, Int64

from habilis.bridges.puzzles.bodies import ACTIONS, Body, Collisions
from habilis.bridges.puzzles.pushworld_text import parsed
from habilis.bridges.puzzles.states import as_cells, check_apart, check_on_map, check_rows, whole
from habilis.files import shown, text_of
from habilis.reprs import counted, quietly, short, unfailing
from habilis.worlds.grid import Cell

if TYPE_CHECKING:
    from rich.text import Text

    from habilis.worlds.pictures.shapes import Drawing

State = tuple[int, ...]
"""The cells of the corners of all bodies, `row * columns + column`, the agent's first."""

AGENT, OBJECT = "agent", "object:"
"""The factor of the agent, and the beginning of those of the movables."""


@dataclass(frozen=True)
class Goal:
    """A place for a body.

    Attributes:
        corner: where the upper left corner of its bounding box has to be.
        bodies: the names of those that fill it, each alone.
    """

    corner: Cell
    bodies: tuple[str, ...]


@dataclass(frozen=True)
class PushWorld:
    r"""A puzzle of rigid bodies that an agent pushes, as a `VectorModel`.

    The agent moves by a cell. Every body that it would overlap then, or that a pushed one would, is
    pushed the same way; where a pushed body would come onto a wall, or the agent onto a wall or a
    wall of its own, nothing moves. It is PushWorld (Kansky et al. 2023); Sokoban is the same with
    bodies of one cell, of which one at a time is pushed.

    A state is a tuple of int: the cell of each body, the agent's first, then the movables' in the
    order of `objects`. A body's cell is the upper left corner of its bounding box, as
    `row * columns + column`. Factors are these cells, "agent", "object:m0", "object:m1", ... The
    reward is 0 for a transition into a solved state, and -1 otherwise; solved states are terminal.

    Attributes:
        name: what messages and pictures call it.
        shape: rows and columns of the map; around it are walls.
        walls: cells that stop everything.
        agent_walls: cells that stop the agent alone.
        bodies: the agent, then the movables, where they start.
        goals: the places to be filled. Without any, no state is solved.
        most_pushed: how many movables can be pushed at once; `None` for any number.

    Example:
        >>> puzzle = PushWorld.parse("A M0 . G0")
        >>> puzzle.initial, puzzle.step(puzzle.initial, 1)
        ((0, 1), (1, 2))
        >>> puzzle.solved((2, 3))
        True
    """

    name: str
    shape: tuple[int, int]
    walls: frozenset[Cell]
    agent_walls: frozenset[Cell]
    bodies: tuple[Body, ...]
    goals: tuple[Goal, ...]
    most_pushed: int | None = None

    actions = ACTIONS

    @unfailing
    def __repr__(self) -> str:
        size = f"{self.height} × {self.width} cells, {counted(len(self.walls), 'wall')}"
        bodies = ", ".join(f"{body.name} {body.corner}" for body in self.bodies)
        goals = (f"{' or '.join(goal.bodies)} to {goal.corner}" for goal in self.goals)
        return short(f"PushWorld {self.name}", size, bodies, ", ".join(goals))

    @quietly
    def _repr_svg_(self) -> str | None:
        """The picture, for notebooks."""
        from habilis.worlds.pictures.svg import world_svg

        return world_svg(self)

    @classmethod
    def parse(cls, text: str, name: str = "puzzle") -> "PushWorld":
        """Reads the text of a PushWorld file.

        Args:
            text: a row a line, its cells separated by white space. A cell is `.` or elements
                joined by `+`, in capitals or not: `W` a wall, `AW` one for the agent alone, `A`
                the agent, `M0`, `M1`, ... movables, `G0`, `G1`, ... their goals.
            name: errors begin with it.

        Returns:
            The puzzle.

        Raises:
            ValueError: rows are not equally long, there is no agent, a goal has no movable or
                another shape, bodies overlap, or an element is unknown. The message names line and
                column, counted from 1, and the fix.
        """
        shape, walls, agent_walls, covered, goals = parsed(text, name)
        bodies = tuple(Body.covering(*one) for one in covered.items())
        places = tuple(Goal(Body.covering(*one).corner, (one[0],)) for one in goals.items())
        return cls(name, shape, walls, agent_walls, bodies, places)

    @property
    def height(self) -> int:
        """The rows of the map."""
        return self.shape[0]

    @property
    def width(self) -> int:
        """The columns of the map."""
        return self.shape[1]

    @property
    def initial(self) -> State:
        """The state in which episodes begin."""
        return tuple(self._label(body.corner) for body in self.bodies)

    @property
    def objects(self) -> tuple[str, ...]:
        """The names of the movables, without "object:"."""
        return tuple(body.name for body in self.bodies[1:])

    def step(self, state: State, action: int) -> State:
        """The next state.

        Args:
            state: any.
            action: an index into `actions`.

        Returns:
            The state after it.

        Raises:
            ValueError: there is no such state or action.
        """
        chosen = np.array([whole(self.name, "action", action)])
        after = self.step_many(np.array([self._checked(state)]), chosen)
        return tuple(after[0].tolist())

    def step_many(
        self, states: Int[np.ndarray, "n k"], actions: Int[np.ndarray, "n"]
    ) -> Int64[np.ndarray, "n k"]:
        """The next states of many, as in `VectorModel`.

        Args:
            states: int[n, k], one state a row.
            actions: int[n], the index of the action that is taken in each.

        Returns:
            int64[n, k].

        Raises:
            ValueError: there is no such state or action.
        """
        from habilis.bridges.puzzles.pushing import pushed  # Numba takes long to import

        states, actions = np.asarray(states, np.int64), np.asarray(actions, np.int64)
        check_rows(self.name, states, actions, len(self.bodies), self.shape)
        most = len(self.bodies) if self.most_pushed is None else self.most_pushed
        return pushed(self._collisions, most, np.ascontiguousarray(states), actions)

    def solved(self, state: State) -> bool:
        """Whether every goal is filled in a state.

        Args:
            state: any.

        Returns:
            `True` if so; never without goals.

        Raises:
            ValueError: there is no such state.
        """
        return bool(self.terminal_many(np.array([self._checked(state)]))[0])

    def terminal_many(self, states: Int[np.ndarray, "n k"]) -> Bool[np.ndarray, "n"]:
        """Which of some states are solved, and end an episode.

        Args:
            states: int[n, k], one state a row.

        Returns:
            bool[n].
        """
        solved = np.full(len(states), bool(self.goals))
        places = {body.name: place for place, body in enumerate(self.bodies)}
        for goal in self.goals:
            able = [places[name] for name in goal.bodies]
            solved &= (states[:, able] == self._label(goal.corner)).any(axis=1)
        return solved

    def reward_many(
        self,
        states: Int[np.ndarray, "n k"],
        actions: Int[np.ndarray, "n"],
        next_states: Int[np.ndarray, "n k"],
    ) -> Float64[np.ndarray, "n"]:
        """The rewards of transitions.

        Args:
            states, actions: before, and what is done; they do not matter.
            next_states: int[n, k], the states that are entered.

        Returns:
            float64[n], 0 for solved ones, -1 otherwise.
        """
        return np.where(self.terminal_many(next_states), 0.0, -1.0)

    def factors_many(self, states: Int[np.ndarray, "n k"]) -> dict[str, Int64[np.ndarray, "n 2"]]:
        """The cells of all bodies in some states.

        Args:
            states: int[n, k], one state a row.

        Returns:
            By the factor's name int64[n, 2], row and column.
        """
        cells = np.stack(np.divmod(states, self.shape[1]), axis=-1)
        names = [AGENT, *(f"{OBJECT}{name}" for name in self.objects)]
        return {name: cells[:, place] for place, name in enumerate(names)}

    def at(self, state: State) -> "PushWorld":
        """The puzzle that starts in another state.

        Args:
            state: any in which nothing overlaps.

        Returns:
            Another puzzle; this one stays as it is.

        Raises:
            ValueError: there is no such state.
        """
        bodies = self._moved(self._checked(state))
        check_apart(self.name, state, bodies, self.walls, self.agent_walls)
        return replace(self, bodies=bodies)

    def without(self, name: str, state: State | None = None) -> "PushWorld":
        """The puzzle with a movable removed, and with it any goal that only this one fills.

        Args:
            name: the movable's, as in `objects` or with "object:" before it.
            state: where all bodies are; by default where they start.

        Returns:
            Another puzzle, whose states lack the movable's cell.

        Raises:
            ValueError: there is no such movable or state.
        """
        place = self.place(name)
        there = self if state is None else self.at(state)
        gone = self.bodies[place].name
        left = (replace(g, bodies=tuple(b for b in g.bodies if b != gone)) for g in self.goals)
        return replace(
            there,
            bodies=there.bodies[:place] + there.bodies[place + 1 :],
            goals=tuple(goal for goal in left if goal.bodies),
        )

    def fixed(self, name: str, state: State | None = None) -> "PushWorld":
        """The puzzle with a movable turned into walls where it is.

        Args:
            name, state: as in `without`.

        Returns:
            Another puzzle, whose states lack the movable's cell.

        Raises:
            ValueError: there is no such movable or state.
        """
        there = self if state is None else self.at(state)
        walls = there.walls | {*there.bodies[self.place(name)].covered()}
        return replace(there.without(name), walls=walls)

    def drawings(self, agent: bool = True) -> "list[Drawing]":
        """The goals and bodies as a picture shows them.

        Args:
            agent: whether the agent is among them.

        Returns:
            The drawings from the back to the front, in cells of the map.
        """
        from habilis.bridges.puzzles.shapes import puzzle_drawings

        return puzzle_drawings(self, agent)

    def colored_text(self) -> "Text":
        """The map in colours for a terminal: two characters a cell, one line a row.

        `A` is the agent, a number a movable, `G` with a number its goal, `##` a wall, and `//` one
        for the agent alone. A `G` after another character is a goal under it.
        """
        from habilis.bridges.puzzles.colored_text import colored

        return colored(self)

    @property
    def agent_cells(self) -> list[Cell]:
        """The cells in which the agent's corner can be, all else as at the start, row by row."""
        taken = {*self.walls, *self.agent_walls}
        taken |= {cell for body in self.bodies[1:] for cell in body.covered()}
        down, right = self._room[0]
        corners = ((row, column) for row in range(down) for column in range(right))
        agent = self.bodies[0]
        return [corner for corner in corners if taken.isdisjoint(agent.covered(corner))]

    def with_cells(
        self, *, agent: Cell | None = None, objects: Mapping[str, Cell] | None = None
    ) -> "PushWorld":
        """The puzzle that starts with some bodies elsewhere.

        Args:
            agent: the cell of the agent's corner; `None` leaves it where it is, or, if something
                else comes there, puts it where there is room.
            objects: those of movables, by their names.

        Returns:
            Another puzzle; this one stays as it is.

        Raises:
            ValueError: there is no such movable, or bodies and walls would overlap.
        """
        state = [*self.initial]
        for name, cell in (objects or {}).items():
            state[self.place(name)] = self._label(self._on_map(name, cell))
        if agent is not None:
            state[0] = self._label(self._on_map(AGENT, agent))
        elif objects:
            agentless = replace(self, bodies=self._moved(state))
            if self.bodies[0].corner not in (cells := agentless.agent_cells) and cells:
                state[0] = self._label(cells[0])
        return self.at(tuple(state))

    def place(self, name: str) -> int:
        """The place of a movable's cell in a state.

        Args:
            name: as in `objects`, or with "object:" before it.

        Returns:
            Its index in a state, from 1 up.

        Raises:
            ValueError: there is no such movable.
        """
        bare = name.removeprefix(OBJECT) if isinstance(name, str) else name
        if bare not in self.objects:
            known = ", ".join(self.objects) or "none"
            raise ValueError(f"{self.name}: there is no movable {name!r}; the movables are {known}")
        return 1 + self.objects.index(bare)

    def _moved(self, state: Sequence[int]) -> tuple[Body, ...]:
        corners = (divmod(int(label), self.shape[1]) for label in state)
        pairs = zip(self.bodies, corners, strict=True)
        return tuple(replace(body, corner=corner) for body, corner in pairs)

    def _on_map(self, name: str, cell: Cell) -> Cell:
        """A cell of the map.

        Raises:
            ValueError: it is none.
        """
        if not (0 <= cell[0] < self.height and 0 <= cell[1] < self.width):
            raise ValueError(
                f"{self.name}: the {name} is at {cell}; put it on the map of {self.height} x "
                f"{self.width} cells"
            )
        return cell

    def _label(self, corner: Cell) -> int:
        return corner[0] * self.shape[1] + corner[1]

    def _checked(self, state: Sequence[int]) -> Sequence[int]:
        """A state in which every body is on the map.

        Raises:
            ValueError: it is none.
        """
        cells = tuple(whole(self.name, "cell", cell) for cell in as_cells(self.name, state))
        check_on_map(self.name, cells, self.bodies, self._room, self.shape)
        return cells

    @cached_property
    def _room(self) -> list[tuple[int, int]]:
        """How many rows and columns the corner of each body can be in."""
        extents = (np.max(body.cells, axis=0).tolist() for body in self.bodies)
        return [(self.shape[0] - down, self.shape[1] - right) for down, right in extents]

    @cached_property
    def _collisions(self) -> Collisions:
        of_agent = self.walls | self.agent_walls
        walls = [of_agent, *[self.walls] * len(self.objects)]
        return Collisions.of(self.shape, self.bodies, walls)


def load_pushworld(path: str | Path) -> PushWorld:
    """A puzzle from a PushWorld file (.pwp).

    Args:
        path: of the file; see `PushWorld.parse` for what is in it.

    Returns:
        The puzzle, a model: `explore`, `empowerment` and their like take it.

    Raises:
        ValueError: the file cannot be read, or is none; the message names line and column.

    Example:
        >>> puzzle = load_pushworld("Pick A Tool.pwp")  # doctest: +SKIP
        >>> puzzle.actions  # doctest: +SKIP
        ('left', 'right', 'up', 'down')
    """
    return PushWorld.parse(text_of(path, "a PushWorld puzzle"), shown(Path(path).name))
