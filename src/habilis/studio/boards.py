"""Boards: puzzles and environments that the studio shows as they are, and measures."""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Int64

from habilis.bridges.puzzles.pushworld import AGENT, OBJECT, PushWorld
from habilis.mdp import TabularMDP
from habilis.models import explore
from habilis.studio.limits import BOARD_STATES
from habilis.studio.protocol.scenes import Placement
from habilis.worlds.grid import Cell
from habilis.worlds.plans import Plan, solve

State = tuple[int, ...]
"""Of a puzzle, as it has it; of an environment, the index of the state alone."""

_MOST = 3_000_000  # states that the search for a plan visits


@runtime_checkable
class Board(Protocol):
    """A model with the picture of a grid.

    Attributes:
        name: what the page calls it.
        height, width: rows and columns.
        actions: their names.
        factors: the names of those that can be observed; the first has the cell of the agent.
        cells: those whose labels are cells.
        random: whether actions have random outcomes.
        start: the state in which episodes begin.
    """

    @property
    def name(self) -> str: ...
    @property
    def height(self) -> int: ...
    @property
    def width(self) -> int: ...
    @property
    def actions(self) -> tuple[str, ...]: ...
    @property
    def factors(self) -> tuple[str, ...]: ...
    @property
    def cells(self) -> frozenset[str]: ...
    @property
    def random(self) -> bool: ...
    @property
    def start(self) -> State: ...

    def agents(self, state: State) -> dict[Cell, State]:
        """The states that differ from one in the agent's cell alone, by that."""
        ...

    def around(
        self, states: list[State], horizon: int | None
    ) -> tuple[TabularMDP, Int64[np.ndarray, "n"]]:
        """A table of what can be reached from some states, and their indices in it.

        Without a horizon, of all that can ever be reached.
        """
        ...

    def plan(self, state: State) -> Plan | None:
        """A shortest plan, with its states."""
        ...

    def state(self, at: Placement) -> State:
        """The state that a page means."""
        ...

    def reached(self, mdp: TabularMDP, index: int) -> State:
        """The state of an index in a table of `around`."""
        ...

    def placement(self, state: State) -> Placement:
        """A state as a page has it."""
        ...


@dataclass(frozen=True)
class PuzzleBoard:
    """A puzzle of bodies that are pushed."""

    puzzle: PushWorld

    @property
    def name(self) -> str:
        return self.puzzle.name

    @property
    def height(self) -> int:
        return self.puzzle.height

    @property
    def width(self) -> int:
        return self.puzzle.width

    @property
    def actions(self) -> tuple[str, ...]:
        return self.puzzle.actions

    @property
    def factors(self) -> tuple[str, ...]:
        return AGENT, *(f"{OBJECT}{name}" for name in self.puzzle.objects)

    @property
    def cells(self) -> frozenset[str]:
        return frozenset(self.factors)

    @property
    def random(self) -> bool:
        return False

    @property
    def start(self) -> State:
        return self.puzzle.initial

    def agents(self, state: State) -> dict[Cell, State]:
        there = self.puzzle.at(state)
        return {
            (row, column): (row * self.width + column, *state[1:])
            for row, column in there.agent_cells
        }

    def around(
        self, states: list[State], horizon: int | None
    ) -> tuple[TabularMDP, Int64[np.ndarray, "n"]]:
        mdp = explore(self.puzzle, states, horizon, BOARD_STATES)
        return mdp, np.array([mdp.index(state) for state in states], np.int64)

    def plan(self, state: State) -> Plan | None:
        return solve(self.puzzle, state, max_states=_MOST)

    def state(self, at: Placement) -> State:
        wanted = len(self.puzzle.objects)
        if len(at.objects) != wanted or at.tools:
            raise ValueError(
                f"placement has {len(at.tools)} tools and {len(at.objects)} objects; {self.name} "
                f"has 0 and {wanted}: give a cell for each"
            )
        for row, column in (at.agent, *at.objects):
            if not (0 <= row < self.height and 0 <= column < self.width):
                raise ValueError(f"the cell {(row, column)} is outside the board; give one on it")
        state = tuple(row * self.width + column for row, column in (at.agent, *at.objects))
        self.puzzle.at(state)  # raises if bodies overlap
        return state

    def reached(self, mdp: TabularMDP, index: int) -> State:
        return tuple(int(cell) for cell in mdp.state(index))

    def placement(self, state: State) -> Placement:
        agent, *objects = (divmod(cell, self.width) for cell in state)
        return Placement(agent=agent, tools=[], objects=objects)


@dataclass(frozen=True)
class TableBoard:
    """An environment whose states are all in one table.

    Attributes:
        name, height, width, actions, factors, cells, random: as in `Board`.
        first: the index of the state in which episodes begin.
        agent: the factor of the agent's cell.
        path: the file of the table, from which workers read it.
    """

    name: str
    height: int
    width: int
    actions: tuple[str, ...]
    factors: tuple[str, ...]
    cells: frozenset[str]
    random: bool
    first: int
    agent: str
    path: str

    @property
    def start(self) -> State:
        return (self.first,)

    @property
    def table(self) -> TabularMDP:
        return _read(self.path)

    def agents(self, state: State) -> dict[Cell, State]:
        mdp = self.table
        same = np.ones(mdp.states, bool)
        for name, labels in mdp.factors.items():
            same &= (labels == labels[state[0]]) | (name == self.agent)
        found: dict[Cell, State] = {self._cell(state[0]): state}
        for index in np.flatnonzero(same):
            found.setdefault(self._cell(int(index)), (int(index),))
        return dict(sorted(found.items()))

    def around(
        self, states: list[State], horizon: int | None
    ) -> tuple[TabularMDP, Int64[np.ndarray, "n"]]:
        return self.table, np.array([index for (index,) in states], np.int64)

    def plan(self, state: State) -> Plan | None:
        if self.random:
            raise ValueError(f"{self.name} is stochastic: it has no shortest plan")
        found = solve(with_goals(self.table), state[0])
        if found is None:
            return None
        return replace(found, states=tuple((int(index),) for index in found.states))

    def state(self, at: Placement) -> State:
        most = self.table.states - 1
        if not isinstance(at.state, int) or at.state > most:
            raise ValueError(f"placement has no state of {self.name}; give one from 0 to {most:,}")
        return (at.state,)

    def reached(self, mdp: TabularMDP, index: int) -> State:
        return (index,)

    def placement(self, state: State) -> Placement:
        return Placement(agent=self._cell(state[0]), tools=[], objects=[], state=state[0])

    def _cell(self, index: int) -> Cell:
        row, column = divmod(int(self.table.factor(self.agent)[index]), self.width)
        return row, column


def with_goals(mdp: TabularMDP) -> TabularMDP:
    """A deterministic table that ends well: in those terminal states whose entry is rewarded most.

    The others, such as holes in the ice, are never left.
    """
    rows = np.arange(mdp.states)[:, None]
    enters = mdp.available & (mdp.next_state != rows)
    enters &= mdp.terminal[mdp.next_state] & ~mdp.terminal[:, None]
    if not enters.any():
        return mdp
    best = enters & (mdp.reward == mdp.reward[enters].max())
    goals = np.zeros(mdp.states, bool)
    goals[mdp.next_state[best]] = True
    lost = mdp.terminal & ~goals
    return replace(
        mdp,
        transitions=np.where(lost[:, None], rows, mdp.next_state).astype(np.int32),
        terminal=goals,
    )


@lru_cache(1)
def _read(path: str) -> TabularMDP:
    return TabularMDP.load(path)
