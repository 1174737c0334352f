"""A scene: a world on the page, and the question asked about it."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Int
from msgspec import UNSET

from habilis.analysis.averages import held
from habilis.mdp import TabularMDP
from habilis.own_code import is_own
from habilis.studio.drawn_worlds import check_known, order_of, world_of
from habilis.studio.limits import REACHED, SIDES
from habilis.studio.measured_kinds import OPEN, Measured
from habilis.studio.placements import Order, named, placed
from habilis.studio.protocol import scenes as protocol
from habilis.worlds.map_text import header, map_lines
from habilis.worlds.placements import Factors, Placement, placed_at, start_of
from habilis.worlds.plans import Plan, check_certain, solve
from habilis.worlds.reach import TooManyPlacementsError, reachable
from habilis.worlds.table import tabulate
from habilis.worlds.world import NO_TOOL, Cell, World

Where = Any
"""All that a state says, in the format of a scene's model."""

ACTIONS = {"all": None, "moves": (0, 1, 2, 3), "tool": (4, 5, 6, 7)}
ELSEWHERE = -1
"""The observation of the sensor "cells" if the object is in none of the chosen cells."""

_MOST = 3_000_000  # placements that the search for a plan visits
_MAP = "map"  # its name in the library's errors


@runtime_checkable
class AnyScene(Protocol):
    """A model with a grid, and a question asked about it.

    Attributes:
        height, width: rows and columns.
        horizon: in actions.
        slip: the probability that a random action replaces the chosen one.
        measured: the kind of empowerment.
        is_stochastic: whether outcomes are random.
        action_indices: those that are counted; `None` for all.
        agents: by the cell of the agent, the state in which all else is where it begins.
    """

    @property
    def height(self) -> int: ...
    @property
    def width(self) -> int: ...
    @property
    def horizon(self) -> int: ...
    @property
    def slip(self) -> float: ...
    @property
    def measured(self) -> Measured: ...
    @property
    def is_stochastic(self) -> bool: ...
    @property
    def action_indices(self) -> Sequence[int] | None: ...
    @property
    def agents(self) -> Mapping[Cell, Where]: ...

    def with_things(self, at: protocol.Placement) -> "AnyScene":
        """The same scene with its things elsewhere."""
        ...

    def around(self, places: list[Where], horizon: int) -> tuple[TabularMDP, Int[np.ndarray, "n"]]:
        """A table of what can be reached from some states, without slip, and their indices."""
        ...

    def whole(self, places: list[Where]) -> tuple[TabularMDP, Int[np.ndarray, "n"]]:
        """The same of all that can ever be reached.

        Raises:
            ValueError: it is too much.
        """
        ...

    def sensed(self, mdp: TabularMDP) -> "str | Int[np.ndarray, 'S']":
        """The sensor in the library's format."""
        ...

    def seen_in(self, mdp: TabularMDP, observations: Int[np.ndarray, "m"]) -> Int[np.ndarray, "m"]:
        """The cell in which to mark each observation, `ELSEWHERE` where there is none."""
        ...

    def where(self, at: protocol.Placement) -> Where:
        """The state that a message means.

        Raises:
            ValueError: there is none such.
        """
        ...

    def placed(self, mdp: TabularMDP, state: int) -> protocol.Placement:
        """A state of a table of `around`, for a message."""
        ...

    def plan(self, at: protocol.Placement | None) -> tuple[Plan, list[protocol.Placement]] | None:
        """A shortest plan with its placements, `None` if there is none."""
        ...


@dataclass(frozen=True)
class Scene:
    """A world on the page, and the question asked about it.

    Attributes:
        world: with the selected tool.
        sensor: as in a message.
        thing: the index of the tool of the sensor "tool", or of the object of all others.
        cells: those that the sensor "cells" distinguishes.
        horizon: in actions.
        actions: one of `ACTIONS`.
        slip: the probability that a random action replaces the chosen one.
        order: of its things in messages.
        measured: the kind of empowerment.
    """

    world: World
    sensor: str = "state"
    cells: tuple[Cell, ...] = ()
    thing: int = 0
    horizon: int = 0
    actions: str = "all"
    slip: float = 0.0
    order: Order | None = None
    measured: Measured = OPEN

    @classmethod
    def of(cls, asked: protocol.Scene, tools: Collection[str]) -> "Scene":
        """A scene from a message.

        Args:
            asked: as the message has it.
            tools: the names of all tools.

        Raises:
            ValueError: there is no such world or thing; the message says why.
        """
        if (asked.map is UNSET) == (asked.drawn is UNSET):
            raise ValueError("scene has no map; give it as text, map, or as drawn")
        if asked.sensor == "factor":
            raise ValueError("the sensor 'factor' is for boards; give another")
        if asked.only is not UNSET:
            raise ValueError("only is for boards; give actions")
        if asked.drawn is UNSET:
            world = _read(asked.map, frozenset(tools))
            order = Order.of(world)
        else:
            world = world_of(asked.drawn, tools, _MAP)
            order = order_of(asked.drawn)
        check_size(world)
        if asked.tool is not UNSET:
            check_known("tool", asked.tool, [*tools, NO_TOOL])
            world = world.with_tool(asked.tool)
            order = Order(Order.of(world).tools, order.objects)
        by_index = order.tools if asked.sensor == "tool" else order.objects
        if by_index and asked.thing >= len(by_index):
            raise ValueError(
                f"thing is {asked.thing}; give a whole number from 0 to {len(by_index) - 1}"
            )
        return cls(
            world,
            asked.sensor,
            tuple(asked.cells),
            by_index[asked.thing] if by_index else 0,
            asked.horizon,
            asked.actions,
            asked.slip,
            order,
            Measured.of(asked),
        )

    @property
    def action_indices(self) -> Sequence[int] | None:
        return ACTIONS[self.actions]

    @property
    def is_stochastic(self) -> bool:
        """Whether outcomes are random: actions may slip, or tools fail."""
        return bool(self.slip) or self.world.may_fail

    @property
    def object(self) -> str:
        """The name of the observed object."""
        of = 0 if self.sensor == "tool" else self.thing
        return self.world.objects[of].name

    @property
    def placement(self) -> dict[str, Cell]:
        """The placement on the map."""
        return start_of(self.world)

    @property
    def listed(self) -> Order:
        """The order of its things in messages; by default, the world's."""
        return Order.of(self.world) if self.order is None else self.order

    @property
    def height(self) -> int:
        return self.world.height

    @property
    def width(self) -> int:
        return self.world.width

    @property
    def agents(self) -> dict[Cell, Placement]:
        here = self.placement
        return {cell: here | {"agent": cell} for cell in self.world.agent_cells}

    def around(self, places: list[Where], horizon: int) -> tuple[TabularMDP, Int[np.ndarray, "n"]]:
        return reachable(self.world, places, horizon)

    def whole(self, places: list[Where]) -> tuple[TabularMDP, Int[np.ndarray, "n"]]:
        return reachable(self.world, places, None, REACHED)

    def where(self, at: protocol.Placement) -> Placement:
        return named(self.world, self.listed, at)

    def placed(self, mdp: TabularMDP, state: int) -> protocol.Placement:
        return placed(self.world, self.listed, mdp, state)

    def plan(self, at: protocol.Placement | None) -> tuple[Plan, list[protocol.Placement]] | None:
        world = check_certain(self.world)
        if world.single:
            mdp = tabulate(world)
            start = mdp.start if at is None else state_of(world, mdp, self.where(at))
        else:
            mdp, start = _within_reach(world, self.placement if at is None else self.where(at))
        found = solve(mdp, start)
        return found and (found, [self.placed(mdp, state) for state in found.states])

    def with_things(self, at: protocol.Placement) -> "Scene":
        """The same scene with its things elsewhere.

        Raises:
            ValueError: a thing is not on a free cell.
        """
        return replace(self, world=placed_at(self.world, self.where(at)))

    def with_tool(self, tool: str) -> "Scene":
        """The scene of a tool's average: all actions, observing the object."""
        world = held(self.world.with_object(self.object).with_tool(tool))
        return replace(
            self,
            world=world,
            sensor="object",
            thing=0,
            actions="all",
            cells=(),
            order=None,
            measured=OPEN,
        )

    def sensed(self, mdp: TabularMDP) -> "str | Int[np.ndarray, 'S']":
        """The sensor in the library's format."""
        if self.sensor == "tool" and self.world.tools:
            return Factors.of(self.world).tools[self.thing]
        if self.sensor == "object":
            return self.seen
        if self.sensor != "cells":
            return self.sensor
        at = mdp.factor(self.seen)
        return np.where(np.isin(at, [mdp.label(place) for place in self.cells]), at, ELSEWHERE)

    def seen_in(self, mdp: TabularMDP, observations: Int[np.ndarray, "m"]) -> Int[np.ndarray, "m"]:
        return mdp.factor(self.seen)[observations] if self.sensor == "state" else observations

    @property
    def seen(self) -> str:
        """The factor of the observed object."""
        return Factors.of(self.world).objects[0 if self.sensor == "tool" else self.thing]


def of_a_map(scene: AnyScene) -> Scene:
    """The scene of a map.

    Raises:
        ValueError: it is one of a board.
    """
    if not isinstance(scene, Scene):
        raise ValueError("a board has no map; give one as text or drawn")
    return scene


def _within_reach(world: World, at: Placement) -> tuple[TabularMDP, int]:
    """The table reachable from a placement, and the placement's state."""
    try:
        mdp, states = reachable(world, at, None, _MOST)
    except TooManyPlacementsError:
        raise ValueError(
            f"more than {_MOST:,} placements can be reached; remove things, or make the map smaller"
        ) from None
    return mdp, int(states[0])


def state_of(world: World, mdp: TabularMDP, at: Placement) -> int:
    """The state of a placement in a table of its world.

    Raises:
        ValueError: it is no placement, or the table has none such.
    """
    asked, states = reachable(world, at, 0)
    same = np.ones(mdp.states, bool)
    for name in mdp.factors:
        same &= mdp.factor(name) == asked.factor(name)[states[0]]
    if not same.any():
        raise ValueError("that cannot be reached from where episodes start; put things elsewhere")
    return int(np.flatnonzero(same)[0])


def check_size(world: World) -> None:
    """Refuses maps that are too small or too large to draw.

    Raises:
        ValueError: naming the map's size.
    """
    least, most = SIDES
    if not all(least <= side <= most for side in (world.height, world.width)):
        raise ValueError(
            f"{world.name}: has {world.height} x {world.width} cells; draw {least} to {most} a side"
        )


@lru_cache(256)
def _read(drawn: str, tools: frozenset[str]) -> World:
    """A world from map text that names known tools only: other files would be executed."""
    head, _ = header(map_lines(drawn, _MAP), _MAP)
    for line, said in head.bound.values():
        kind = said.partition(" slip ")[0].strip()
        if is_own(kind) and kind not in tools:
            raise ValueError(
                f"{_MAP}, line {line}: binds a character to a file; start the studio with "
                "--tool FILE.py:CLASS to let maps name it"
            )
    return World.parse(drawn, _MAP)
