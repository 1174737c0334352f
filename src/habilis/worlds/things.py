"""The things of a world that holds several: tools and objects of various kinds."""

from dataclasses import dataclass, field, replace
from typing import Any

from habilis.worlds.own_tools import is_in_file, is_own, located, tool_named
from habilis.worlds.tools import OURS, Reading, Tool

Cell = tuple[int, int]
"""(row, column), row 0 at the top."""


@dataclass(frozen=True)
class ObjectKind:
    """What moves an object.

    Attributes:
        character: that usually stands for it on a map.
        pulled: whether tools may hold, pull and draw it; if not, it can only be pushed.
        slides: whether it goes on in the direction in which it was moved until something stops it.
    """

    character: str
    pulled: bool = True
    slides: bool = False


CAN = "can"
OBJECTS: dict[str, ObjectKind] = {
    CAN: ObjectKind("C"),
    "ball": ObjectKind("D", slides=True),
    "crate": ObjectKind("E", pulled=False),
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
        own: a tool of one's own; found by its kind, unless it is given.
        reading: of the rules by which it moves.
    """

    name: str
    kind: str
    cell: Cell
    slip: float = 0.0
    own: Tool | None = field(default=None, repr=False, hash=False)
    reading: Reading = OURS

    def __post_init__(self) -> None:
        """Finds one's own tool: what it does stays the same, whatever becomes of its file."""
        if self.own is None and is_own(self.kind):
            object.__setattr__(self, "own", tool_named(self.kind))

    @property
    def rule(self) -> Tool:
        """How it moves objects."""
        return tool_named(self.kind) if self.own is None else self.own

    def located(self) -> "PlacedTool":
        """The same, its file named so that it is found from any folder.

        Returns:
            Another, or this one if it is built in.
        """
        return self if self.own is None else replace(self, kind=located(self.kind))

    def __reduce__(self) -> Any:
        """A file with a tool is run anew elsewhere: its module cannot be imported by name."""
        values = self.name, self.kind, self.cell, self.slip
        if self.own is None or not is_in_file(self.kind):
            return PlacedTool, (*values, self.own, self.reading)
        return _placed_tool, (*values, located(self.kind), self.reading)


def _placed_tool(
    name: str, kind: str, cell: Cell, slip: float, place: str, reading: Reading
) -> PlacedTool:
    return PlacedTool(name, kind, cell, slip, tool_named(place), reading)
