"""The things of a world that holds several: tools and objects of various kinds."""

from dataclasses import dataclass

from habilis.worlds.own_tools import tool_named
from habilis.worlds.tools import Tool

Cell = tuple[int, int]
"""(row, column), row 0 at the top."""


@dataclass(frozen=True)
class ObjectKind:
    """What moves an object.

    Attributes:
        pulled: whether tools may hold, pull and draw it; if not, it can only be pushed.
        slides: whether it goes on in the direction in which it was moved until something stops it.
    """

    pulled: bool = True
    slides: bool = False


CAN = "can"
OBJECTS: dict[str, ObjectKind] = {
    CAN: ObjectKind(),
    "ball": ObjectKind(slides=True),
    "crate": ObjectKind(pulled=False),
}


@dataclass(frozen=True)
class PlacedObject:
    """An object on a map.

    Attributes:
        name: what factors call it.
        kind: one of `OBJECTS`.
        cell: where it starts.
        goal: the cell that it is to be brought to; `None` if it does not matter where it is.
    """

    name: str
    kind: str
    cell: Cell
    goal: Cell | None = None


@dataclass(frozen=True)
class PlacedTool:
    """A tool on a map.

    Attributes:
        name: what factors call it.
        kind: a built-in one's, or where one's own is, as "mytools.py:Rake".
        cell: where it lies.
        slip: the probability that what it does to objects fails.
    """

    name: str
    kind: str
    cell: Cell
    slip: float = 0.0

    @property
    def rule(self) -> Tool:
        return tool_named(self.kind)
