"""Placements of messages, by index, and those of the library, by the names of factors."""

from dataclasses import dataclass
from typing import Any

from msgspec import UNSET

from habilis.mdp import HELD, LAID, TabularMDP
from habilis.studio.protocol import scenes as protocol
from habilis.worlds.placements import Factors
from habilis.worlds.rules import NONE
from habilis.worlds.world import World


@dataclass(frozen=True)
class Order:
    """The order in which messages list the things of a world.

    Attributes:
        tools, objects: of each thing in a message, its index in the world.
    """

    tools: tuple[int, ...]
    objects: tuple[int, ...]

    @classmethod
    def of(cls, world: World) -> "Order":
        """The world's own order."""
        return cls(tuple(range(len(world.tools))), tuple(range(len(world.objects))))


def named(world: World, order: Order, at: protocol.Placement) -> dict[str, Any]:
    """A placement in the library's format, which checks whether it is possible.

    Raises:
        ValueError: it has the wrong number of things.
    """
    counts, wanted = (len(at.tools), len(at.objects)), (len(order.tools), len(order.objects))
    if counts != wanted:
        raise ValueError(
            f"placement has {counts[0]} tools and {counts[1]} objects; the scene has {wanted[0]} "
            f"and {wanted[1]}: give a cell for each"
        )
    factors = Factors.of(world)
    found: dict[str, Any] = {"agent": at.agent}
    for k, cell in zip(order.tools, at.tools, strict=True):
        found[factors.tools[k]] = cell
    for k, cell in zip(order.objects, at.objects, strict=True):
        found[factors.objects[k]] = cell
    for name, tool in ((HELD, at.held), (LAID, at.laid)):
        if tool is UNSET:
            continue
        if tool >= len(order.tools):
            raise ValueError(f"{name} is {tool}; give the index of a tool, or -1 for none")
        found[name] = order.tools[tool] if tool >= 0 else NONE
    return found


def placed(world: World, order: Order, mdp: TabularMDP, state: int) -> protocol.Placement:
    """The placement of a state of the world's table."""
    factors = Factors.of(world)

    def cell(name: str) -> tuple[int, int]:
        row, column = divmod(int(mdp.factor(name)[state]), world.width)
        return row, column

    def hand(name: str) -> Any:
        if name not in mdp.factors:
            return UNSET
        tool = int(mdp.factor(name)[state])
        return order.tools.index(tool) if tool >= 0 else NONE

    return protocol.Placement(
        agent=cell("agent"),
        tools=[cell(factors.tools[k]) for k in order.tools],
        objects=[cell(factors.objects[k]) for k in order.objects],
        held=hand(HELD),
        laid=hand(LAID),
    )
