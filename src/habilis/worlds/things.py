"""Tools and objects: their kinds, and where a map has them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

from habilis.own_code import is_own
from habilis.worlds.grid import Cell
from habilis.worlds.own_tools import is_in_file, located, tool_named
from habilis.worlds.tools import OURS, Reading, Tool

Where = Cell | Mapping[str, Cell]
"""The cell of the only tool or object, or cells by names."""


@dataclass(frozen=True)
class ObjectKind:
    """How an object can be moved.

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
        kind: one of `OBJECTS`.
        cell: where it starts.
        goal: the cell that it is to be brought to; `None` if it does not matter where it is.
        name: what factors call it; by default its kind, the second of a kind as "can2".
    """

    kind: str
    cell: Cell
    goal: Cell | None = None
    name: str = ""


@dataclass(frozen=True)
class PlacedTool:
    """A tool on a map.

    Attributes:
        kind: a built-in one's, or where one's own is, as "mytools.py:Rake".
        cell: where it lies.
        slip: the probability that what it does to objects fails.
        name: what factors call it; by default its kind, or its class, the second of a name as
            "picker2".
        reading: of the rules by which it moves.
        own: a tool of one's own; found by its kind, unless it is given.

    Raises:
        ValueError: no such tool.
    """

    kind: str
    cell: Cell
    slip: float = 0.0
    name: str = ""
    reading: Reading = OURS
    own: Tool | None = field(default=None, repr=False, hash=False)

    def __post_init__(self) -> None:
        """Finds one's own tool: what it does stays the same, whatever becomes of its file."""
        if self.own is None:
            found = tool_named(self.kind)
            object.__setattr__(self, "own", found if is_own(self.kind) else None)

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
        """A file with a tool is rerun elsewhere: its module cannot be imported by name."""
        values = self.kind, self.cell, self.slip, self.name, self.reading
        if self.own is None or not is_in_file(self.kind):
            return PlacedTool, (*values, self.own)
        return _placed_tool, (*values, located(self.kind))


@dataclass(frozen=True)
class Door:
    """A door on a map with two agents, who open and close it.

    Attributes:
        cell: where it is; while it is closed, nothing else can be there.
        is_open: whether it is open at the start.
    """

    cell: Cell
    is_open: bool = False


@dataclass(frozen=True)
class Vacancy:
    """The place of a tool that was taken off a map; another tool can be put there.

    Attributes:
        cell: where the tool was.
        reading: of the rules by which the tool moved, and any that takes its place.
    """

    cell: Cell
    reading: Reading = OURS


Thing = TypeVar("Thing", PlacedTool, PlacedObject)


def named(things: Sequence[Thing]) -> tuple[Thing, ...]:
    """The same things, those without a name named by their kinds: the second can is "can2"."""
    kinds = [thing.kind.rpartition(":")[2] for thing in things]
    found = []
    for place, (thing, kind) in enumerate(zip(things, kinds, strict=True)):
        before = kinds[:place].count(kind)
        name = f"{kind}{before + 1}" if before else kind
        found.append(thing if thing.name else replace(thing, name=name))
    return tuple(found)


def moved(things: Sequence[Thing], cells: Sequence[Cell]) -> tuple[Thing, ...]:
    """The same things in these cells."""
    return tuple(replace(one, cell=cell) for one, cell in zip(things, cells, strict=True))


def cells_of(
    world: str,
    kind: str,
    things: Sequence[PlacedTool] | Sequence[PlacedObject],
    where: Where | None,
) -> list[Cell]:
    """The cell of each thing, some of them given.

    Args:
        world: what errors call the map.
        kind: what they call a thing.
        things: the tools or the objects.
        where: a cell where there is one of them, or cells by names; others stay where they are.

    Raises:
        ValueError: no thing of that name, or it is not said which.
    """
    names = [thing.name for thing in things]
    if where is None:
        where = {}
    elif not isinstance(where, Mapping):
        if not names:
            raise ValueError(f"{world} has no {kind} here; leave out its cell")
        if len(names) > 1:
            at = ",".join(map(str, where))
            raise ValueError(
                f"{world} has several {kind}s, {', '.join(names)}; specify which is at "
                f"{where}, as {names[0]}={at}"
            )
        where = {names[0]: where}
    for name in where:
        if name not in names:
            known = f"name one of {', '.join(names)}" if names else "it has none"
            raise ValueError(f"{world} has no {kind} {name!r}; {known}")
    return [where.get(thing.name, thing.cell) for thing in things]


def _placed_tool(
    kind: str, cell: Cell, slip: float, name: str, reading: Reading, place: str
) -> PlacedTool:
    return PlacedTool(kind, cell, slip, name, reading, tool_named(place))
