"""A scene: a world on the page, and what is measured in it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from jaxtyping import Int

from habilis.mdp import TabularMDP
from habilis.studio.fields import cell, checked, number, one_of, text
from habilis.studio.limits import HORIZON, SIDES, SLIP
from habilis.worlds.characters import COMMENT
from habilis.worlds.map_text import header, map_lines
from habilis.worlds.placements import Placement
from habilis.worlds.tools import TOOLS
from habilis.worlds.world import NO_TOOL, Cell, World

SENSORS = ("state", "object", "tool", "agent", "cells")
ACTIONS = {"all": None, "moves": (0, 1, 2, 3), "tool": (4, 5, 6, 7)}
ELSEWHERE = -1
"""What the sensor "cells" shows where the object is in none of the chosen cells."""

_MAP = "map"  # what the library's errors call it
_MOST_CELLS = SIDES[1] ** 2
_ANY_TOOL = TOOLS["picker"].character  # stands on the map for a tool of one's own while it is read


@dataclass(frozen=True)
class Scene:
    """A world on the page, and what is measured in it.

    Attributes:
        world: with the tool that is chosen.
        sensor: one of `SENSORS`.
        cells: those that the sensor "cells" tells apart.
        horizon: in actions.
        actions: one of `ACTIONS`.
        slip: the probability that chance replaces an action.
    """

    world: World
    sensor: str = "state"
    cells: tuple[Cell, ...] = ()
    horizon: int = 0
    actions: str = "all"
    slip: float = 0.0

    @classmethod
    def of(cls, value: Any, tools: Mapping[str, str]) -> "Scene":
        """A scene from a message.

        Args:
            value: what the page sent.
            tools: by the characters that stand for them on a map, the names of all tools.

        Raises:
            ValueError: it is none, or beyond the limits; the message names what is wrong.
        """
        given = checked("scene", value, required=("map", "tool"), optional=tuple(_DEFAULTS))
        given = _DEFAULTS | given
        cells = given["cells"]
        if not isinstance(cells, list) or len(cells) > _MOST_CELLS:
            raise ValueError(
                f"cells is no list of at most {_MOST_CELLS} cells, as [[0, 1], [2, 3]]"
            )
        return cls(
            _world(text("map", given["map"]), text("tool", given["tool"]), tuple(tools.items())),
            one_of("sensor", given["sensor"], SENSORS),
            tuple(cell("cells", one) for one in cells),
            number("horizon", given["horizon"], 0, HORIZON, whole=True),
            one_of("actions", given["actions"], tuple(ACTIONS)),
            number("slip", given["slip"], 0, SLIP),
        )

    @property
    def action_indices(self) -> Sequence[int] | None:
        return ACTIONS[self.actions]

    @property
    def placement(self) -> Placement:
        """Where the map has everything."""
        return placement_of(self.world, agent=self.world.agent)

    def with_things(self, at: Placement) -> "Scene":
        """The same scene with its things elsewhere.

        Raises:
            ValueError: something is not on a free cell of its own.
        """
        tool = at.get("tool", self.world.tool_cell)
        world = replace(self.world, agent=at["agent"], object=at["object"], tool_cell=tool)
        return replace(self, world=world)

    def with_tool(self, tool: str) -> "Scene":
        """What averages are of: a tool, what all actions can do to the object with it."""
        world = self.world.with_tool(tool)
        return replace(self, world=world, sensor="object", actions="all", cells=())

    def agent_places(self) -> list[Cell]:
        """The cells that the agent can be in, tool and object where the map has them."""
        world = self.world
        taken = {world.object, *world.walls} | (
            {world.tool_cell} - {None} if has_tool(world) else set()
        )
        every = ((row, column) for row in range(world.height) for column in range(world.width))
        return [place for place in every if place not in taken]

    def sensed(self, mdp: TabularMDP) -> "str | Int[np.ndarray, 'S']":
        """The sensor as the library takes it."""
        if self.sensor != "cells":
            return self.sensor
        at = mdp.factor("object")
        return np.where(np.isin(at, [mdp.label(place) for place in self.cells]), at, ELSEWHERE)


_DEFAULTS: dict[str, Any] = {
    "sensor": "state",
    "cells": [],
    "horizon": 0,
    "actions": "all",
    "slip": 0.0,
}


def has_tool(world: World) -> bool:
    return world.tool != NO_TOOL


def placement_of(world: World, **cells: Cell) -> Placement:
    """Where things are: where the map has them but for those that are given."""
    places = {"agent": world.agent, "object": world.object}
    if has_tool(world) and world.tool_cell is not None:
        places["tool"] = world.tool_cell
    return places | cells


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
def _world(drawn: str, tool: str, tools: tuple[tuple[str, str], ...]) -> World:
    """A world from a map without lines that bind characters: these would run any file."""
    head, _ = header(map_lines(drawn, _MAP), _MAP)
    if head.bound:
        line = next(iter(head.bound.values()))[0]
        raise ValueError(
            f"{_MAP}, line {line}: binds a character to a tool; start the studio with "
            "--tool FILE.py:CLASS, and leave the line out"
        )
    one_of("tool", tool, [*dict(tools).values(), NO_TOOL])
    own = {ord(mark): _ANY_TOOL for mark, name in tools if name not in TOOLS}
    text = "\n".join(
        line if line.startswith(COMMENT) else line.translate(own) for line in drawn.split("\n")
    )
    world = World.parse(text, _MAP)
    check_size(world)
    return world.with_tool(tool)
