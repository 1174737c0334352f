"""A scene: a world on the page, and the question asked about it."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from jaxtyping import Int

from habilis.analysis.averages import held
from habilis.mdp import HELD, LAID, TabularMDP
from habilis.studio.drawn_worlds import world_of
from habilis.studio.fields import cell, checked, number, one_of, text
from habilis.studio.limits import HORIZON, SIDES, SLIP
from habilis.worlds.map_text import header, map_lines
from habilis.worlds.own_tools import is_own
from habilis.worlds.placements import Factors, Placement, placed_at, start_of
from habilis.worlds.world import NO_TOOL, Cell, World

SENSORS = ("state", "object", "tool", "agent", "cells")
ACTIONS = {"all": None, "moves": (0, 1, 2, 3), "tool": (4, 5, 6, 7)}
ELSEWHERE = -1
"""The observation of the sensor "cells" if the object is in none of the chosen cells."""

_MAP = "map"  # its name in the library's errors
_MOST_CELLS = SIDES[1] ** 2


@dataclass(frozen=True)
class Scene:
    """A world on the page, and the question asked about it.

    Attributes:
        world: with the selected tool.
        sensor: one of `SENSORS`.
        thing: the index of the tool of the sensor "tool", or of the object of all others.
        cells: those that the sensor "cells" distinguishes.
        horizon: in actions.
        actions: one of `ACTIONS`.
        slip: the probability that a random action replaces the chosen one.
    """

    world: World
    sensor: str = "state"
    cells: tuple[Cell, ...] = ()
    thing: int = 0
    horizon: int = 0
    actions: str = "all"
    slip: float = 0.0

    @classmethod
    def of(cls, value: Any, tools: Collection[str]) -> "Scene":
        """A scene from a message.

        Args:
            value: the message's field.
            tools: the names of all tools.

        Raises:
            ValueError: the value is invalid, or exceeds the limits; the message says why.
        """
        given = _DEFAULTS | checked("scene", value, required=(), optional=tuple(_DEFAULTS))
        cells = given["cells"]
        if not isinstance(cells, list) or len(cells) > _MOST_CELLS:
            raise ValueError(
                f"cells is not a list of at most {_MOST_CELLS} cells, as [[0, 1], [2, 3]]"
            )
        if (given["map"] is None) == (given["drawn"] is None):
            raise ValueError("scene has no map; give it as text, map, or as drawn")
        if given["map"] is not None:
            world = _read(text("map", given["map"]), frozenset(tools))
        else:
            world = world_of(given["drawn"], tools, _MAP)
        check_size(world)
        if given["tool"] is not None:
            world = world.with_tool(one_of("tool", given["tool"], [*tools, NO_TOOL]))
        sensor = one_of("sensor", given["sensor"], SENSORS)
        among = max(len(world.tools if sensor == "tool" else world.objects), 1)
        return cls(
            world,
            sensor,
            tuple(cell("cells", one) for one in cells),
            number("thing", given["thing"], 0, among - 1, whole=True),
            number("horizon", given["horizon"], 0, HORIZON, whole=True),
            one_of("actions", given["actions"], tuple(ACTIONS)),
            number("slip", given["slip"], 0, SLIP),
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

    def with_things(self, at: Placement) -> "Scene":
        """The same scene with its things elsewhere.

        Raises:
            ValueError: a thing is not on a free cell.
        """
        missing = [name for name in ("agent", *Factors.of(self.world).objects) if name not in at]
        unknown = [name for name in at if name not in self.placement and name not in _HANDS]
        if missing or unknown:
            raise ValueError(
                f"placement has {', '.join(at)}; give the cells of {', '.join(self.placement)}"
            )
        there = {name: at.get(name, cell) for name, cell in self.placement.items()}
        return replace(self, world=placed_at(self.world, there))

    def with_tool(self, tool: str) -> "Scene":
        """The scene of a tool's average: all actions, observing the object."""
        world = held(self.world.with_object(self.object).with_tool(tool))
        return replace(self, world=world, sensor="object", thing=0, actions="all", cells=())

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

    @property
    def seen(self) -> str:
        """The factor of the observed object."""
        return Factors.of(self.world).objects[0 if self.sensor == "tool" else self.thing]


_HANDS = (HELD, LAID)
_DEFAULTS: dict[str, Any] = {
    "map": None,
    "drawn": None,
    "tool": None,
    "sensor": "state",
    "cells": [],
    "thing": 0,
    "horizon": 0,
    "actions": "all",
    "slip": 0.0,
}


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
