"""Maps with two agents: the rule that moves both, and their placements.

Both act in every step, the first agent before the second, each as if it were alone: what the other
agent and closed doors occupy is taken, as a wall is. The rule of the moves, and of the things that
are pushed, is that of all worlds (`rules.successor`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64, Int, Int64

from habilis.mdp import TabularMDP
from habilis.mdp_players import JOINS
from habilis.models.explore import explore
from habilis.worlds.grid import MOVES, Cell, Cells, Grid
from habilis.worlds.rules import NONE, Kinds, Places, successor
from habilis.worlds.things import OBJECTS, moved
from habilis.worlds.world import World

AGENTS = "agent", "agent2"
"""The names of the two agents, as players and as factors."""
STAY, USE_DOOR = "stay", "door"
"""The actions of an agent besides the moves; the second one on maps with doors alone."""

Rows = Int64[np.ndarray, "n k"]


@dataclass(frozen=True)
class TwoAgents:
    """The model of a map with two agents; a state is the cells of both, the objects, and the doors.

    Attributes:
        world: the map.
    """

    world: World

    @property
    def own_actions(self) -> tuple[str, ...]:
        """The names of one agent's actions."""
        return (*MOVES, STAY, USE_DOOR) if self.world.doors else (*MOVES, STAY)

    @property
    def actions(self) -> tuple[str, ...]:
        """The names of the joint actions."""
        own = self.own_actions
        return tuple(f"{first}{JOINS}{second}" for first in own for second in own)

    @property
    def players(self) -> Mapping[str, int]:
        """How many actions each agent has."""
        return MappingProxyType(dict.fromkeys(AGENTS, len(self.own_actions)))

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the map."""
        return self.world.height, self.world.width

    @cached_property
    def grid(self) -> Grid:
        """The map as a flat array of cells."""
        return self.world.grid

    @property
    def things(self) -> tuple[str, ...]:
        """The factors of the objects."""
        names = [thing.name for thing in self.world.objects]
        return ("object",) if len(names) == 1 else tuple(f"object:{name}" for name in names)

    @property
    def doors(self) -> tuple[str, ...]:
        """The factors of the doors: 1 where one is open."""
        count = len(self.world.doors)
        return tuple(f"{USE_DOOR}{n}" if n > 1 else USE_DOOR for n in range(1, count + 1))

    def row(self, placement: Mapping[str, Any]) -> tuple[int, ...]:
        """A placement as a row.

        Raises:
            ValueError: it is none of this map's.
        """
        known = (*AGENTS, *self.things, *self.doors)
        cells = known[: len(known) - len(self.doors)]
        if not isinstance(placement, Mapping) or set(placement) - set(self.doors) != set(cells):
            raise ValueError(
                f"{self.world.name}: a placement has "
                f"{', '.join(map(str, placement)) or 'nothing'}; give cells for {', '.join(cells)}"
            )
        found = start_of(self.world) | dict(placement)
        return tuple(
            int(self.grid.index(found[name]) if name in cells else bool(found[name]))
            for name in known
        )

    def step_many(self, states: Rows, actions: Int[np.ndarray, "n"]) -> Rows:
        """The next states."""
        after = np.empty_like(states)
        for joint in np.unique(actions).tolist():
            those = actions == joint
            rows = states[those]
            for agent, action in enumerate(divmod(joint, len(self.own_actions))):
                rows = self._acted(rows, agent, action)
            after[those] = rows
        return after

    def _acted(self, rows: Rows, agent: int, action: int) -> Rows:
        """The states after one agent's action."""
        name = self.own_actions[action]
        if name == STAY:
            return rows
        if name == USE_DOOR:
            return self._with_doors_used(rows, agent)
        things = 2 + len(self.things)
        kinds = Kinds((), tuple(OBJECTS[thing.kind] for thing in self.world.objects), ())
        objects = tuple(rows[:, column] for column in range(2, things))
        at = Places(rows[:, agent], (), objects, np.full(len(rows), NONE))
        to = successor(self.grid, kinds, action, at)
        stays = np.zeros(len(rows), bool)
        for cells in to.cells:
            stays |= (cells == rows[:, 1 - agent]) | self._behind_door(rows, cells)
        after = rows.copy()
        for column, cells in zip((agent, *range(2, things)), to.cells, strict=True):
            after[:, column] = np.where(stays, rows[:, column], cells)
        return after

    def _behind_door(self, rows: Rows, cells: Cells) -> Bool[np.ndarray, "n"]:
        """Where a cell has a closed door."""
        found = np.zeros(len(rows), bool)
        for column, door in enumerate(self.world.doors, start=2 + len(self.things)):
            found |= (cells == self.grid.index(door.cell)) & (rows[:, column] == 0)
        return found

    def _with_doors_used(self, rows: Rows, agent: int) -> Rows:
        """Every door beside the agent turned, unless something stands in it."""
        after = rows.copy()
        first = 2 + len(self.things)
        for column, door in enumerate(self.world.doors, start=first):
            cell = np.full(len(rows), self.grid.index(door.cell))
            turned = self.grid.adjacent(rows[:, agent], cell)
            turned &= (rows[:, :first] != cell[:, None]).all(axis=1)
            after[:, column] ^= turned
        return after

    def factors_many(self, states: Rows) -> dict[str, np.ndarray]:
        """The cells of agents and objects, and which doors are open."""
        names = (*AGENTS, *self.things)
        found: dict[str, np.ndarray] = {}
        for column, name in enumerate(names):
            label = self.grid.label(states[:, column])
            found[name] = np.stack(np.divmod(label, self.world.width), axis=1)
        for column, name in enumerate(self.doors, start=len(names)):
            found[name] = states[:, column]
        return found

    def terminal_many(self, states: Rows) -> Bool[np.ndarray, "n"]:
        """Whether every object that has a goal is in it."""
        goals = [(2 + n, thing.goal) for n, thing in enumerate(self.world.objects) if thing.goal]
        found = np.full(len(states), bool(goals))
        for column, goal in goals:
            found &= states[:, column] == self.grid.index(goal)
        return found

    def reward_many(
        self, states: Rows, actions: Int[np.ndarray, "n"], after: Rows
    ) -> Float64[np.ndarray, "n"]:
        """Rule 6 of the worlds where there are goals, and 0 without any."""
        if not any(thing.goal for thing in self.world.objects):
            return np.zeros(len(states))
        return -(~self.terminal_many(after)).astype(float)


def start_of(world: World) -> dict[str, Any]:
    """The placement that a map with two agents has."""
    model = TwoAgents(world)
    found: dict[str, Any] = dict(zip(AGENTS, (world.agent, world.second), strict=True))
    found |= zip(model.things, (thing.cell for thing in world.objects), strict=True)
    return found | dict(zip(model.doors, (int(door.is_open) for door in world.doors), strict=True))


def reachable_by_two(
    world: World,
    placements: Sequence[Mapping[str, Any]],
    horizon: int | None,
    max_states: int,
    show_progress: bool,
) -> tuple[TabularMDP, Int64[np.ndarray, "n"]]:
    """`reach.reachable` of a map with two agents, each placement a valid one of the map.

    Raises:
        ValueError: a placement that is none, or more states than max_states.
    """
    model = TwoAgents(world)
    rows = []
    for placement in placements:
        row = model.row(placement)
        placed_by_two(world, dict(start_of(world)) | dict(placement))
        rows.append(row)
    mdp = explore(model, rows, horizon, max_states, show_progress=show_progress)
    states = np.array([mdp.index(row) for row in rows], np.int64)
    return replace(mdp, drawn=world, model_states=None), states


def placed_by_two(world: World, placement: Mapping[str, Any]) -> World:
    """A placement as a map, which refuses cells that are not free, or are taken."""
    model = TwoAgents(world)
    doors = [
        replace(door, is_open=bool(placement[name]))
        for door, name in zip(world.doors, model.doors, strict=True)
    ]
    cells: list[Cell] = [placement[name] for name in model.things]
    first, second = (placement[name] for name in AGENTS)
    return replace(
        world,
        agent=first,
        second=second,
        objects=moved(world.objects, cells),
        doors=tuple(doors),
    )


def placement_of_two(world: World, mdp: TabularMDP, state: int | np.integer) -> World:
    """A state of its table as a map."""
    model = TwoAgents(world)
    labels = {name: int(factor[state]) for name, factor in mdp.factors.items()}
    cells = {name: divmod(labels[name], world.width) for name in (*AGENTS, *model.things)}
    return placed_by_two(world, {**labels, **cells})
