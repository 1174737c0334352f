"""A world: walls, and where the agent, the tool, the object and the goal start."""

from dataclasses import dataclass, field, fields, replace
from importlib.resources import files
from pathlib import Path
from typing import Any

from habilis.files import shown
from habilis.worlds.characters import FLOOR, WALL
from habilis.worlds.map_writing import binding, header_of, marks_of
from habilis.worlds.own_tools import as_tool, is_in_file, is_own, located, tool_named
from habilis.worlds.parsing import numbered, parsed
from habilis.worlds.things import CAN, PlacedObject, PlacedTool
from habilis.worlds.things import Cell as Cell
from habilis.worlds.tools import OURS, Reading, Tool, name_of

NO_TOOL = "none"
ENVIRONMENT = "gym:"
"""Before the name of a Gymnasium environment on the command line."""


@dataclass(frozen=True)
class World:
    """A map and the things that start on it.

    Attributes:
        name: what tables and pictures call it.
        height, width: rows and columns of the map.
        walls: the wall cells.
        agent, object, goal: start cell of the agent and of the object, and the object's goal.
        tool: the kind of tool ("picker", "broom", "none", or one's own as "mytools.py:Rake").
        tool_cell: the cell the tool starts in; stays known when the tool is "none", so that
            another tool can take its place; `None` if the map never had one.
        own: a tool of one's own and the name it goes by, `tool`. It is found by that name, unless
            it is given by `with_tool`; under another name it is dropped.
        object_kind: the kind of the object ("can", "ball", "crate").
        tool_slip: the probability that what the tool does to objects fails.
        reading: of the rules by which the tool moves, and any other that takes its place.
        more_tools, more_objects: the others of a map with several; `tools` and `objects` are all.
        drop: whether there is a ninth action, which puts the tool in hand down.
        held: which of `tools` is in hand at the start, -1 for none; `None`: the first beside the
            agent.
    """

    name: str
    height: int
    width: int
    walls: frozenset[Cell]
    agent: Cell
    object: Cell
    goal: Cell
    tool: str = NO_TOOL
    tool_cell: Cell | None = None
    own: tuple[str, Tool] | None = field(default=None, repr=False, hash=False)
    object_kind: str = CAN
    tool_slip: float = 0.0
    more_tools: tuple[PlacedTool, ...] = ()
    more_objects: tuple[PlacedObject, ...] = ()
    drop: bool = False
    held: int | None = None
    reading: Reading = OURS

    def __post_init__(self) -> None:
        """Finds its own tool, refuses things that are not on free cells or are on each other.

        Raises:
            ValueError: naming the thing and its cell.
        """
        if self.own is None or self.own[0] != self.tool:
            own = (self.tool, tool_named(self.tool)) if is_own(self.tool) else None
            object.__setattr__(self, "own", own)
        tool_rule = self.tool_rule
        if tool_rule is not None and self.tool_cell is None:
            line = binding(tool_rule.character, self.tool)
            above = f", and a line {line!r} above the map" if line else ""
            raise ValueError(
                f"{self.name}: the map has no tool whose place a {self.tool} could take; "
                f"put {tool_rule.character!r} on a floor cell{above}"
            )
        placed = {"agent": self.agent, self.object_kind: self.object}
        placed |= {tool.name if self.several else "tool": tool.cell for tool in self.tools}
        placed |= {thing.name: thing.cell for thing in self.more_objects}
        goals = {"goal": self.goal} | {
            f"goal of {thing.name}": thing.goal for thing in self.more_objects if thing.goal
        }
        for thing, cell in {**placed, **goals}.items():
            row, column = cell
            if not (0 <= row < self.height and 0 <= column < self.width) or cell in self.walls:
                raise ValueError(
                    f"{self.name}: the {thing} is at {cell}; put it on a free cell of the "
                    f"{self.height} x {self.width} map"
                )
        if len(set(placed.values())) < len(placed):
            raise ValueError(f"{self.name}: {placed} share a cell; give each its own")

    @classmethod
    def parse(cls, text: str, name: str = "map", folder: Path | None = None) -> "World":
        r"""Reads a map: one character a cell, lines starting with `;` are comments.

        Above the map, lines bind characters: `R = rake` to a tool, `R = mytools.py:Rake` to one of
        one's own, `P = picker slip 0.2` to one that may fail, `P = picker pushes` to one under
        another `Reading` of the rules, `D = ball` to an object, `H = goal of D` to its goal.
        `drop: true` adds the action that puts a tool down.

        Args:
            text: `#` wall, `.` floor, `A` agent, `P` picker, `B` broom, `C` can, `G` goal, and what
                is bound.
            name: what to call the world; errors begin with it.
            folder: where the files of tools are looked for before the working directory.

        Returns:
            The world.

        Raises:
            ValueError: the map is ragged or empty, has an unknown character or one of them twice,
                has no agent, object or goal, or a goal of no object, or a line above it binds to
                nothing known. The message names line and column (both from 1) and the mend.

        Example:
            >>> World.parse("AP.CG").tool
            'picker'
            >>> several = World.parse("X = broom\nD = ball\nG = goal of C\nAX.CG\nP..D.")
            >>> [tool.name for tool in several.tools], [thing.name for thing in several.objects]
            (['broom', 'picker'], ['can', 'ball'])
        """
        return cls(**parsed(text, name, folder))

    @classmethod
    def read_back(cls, text: str, name: str, tool: str) -> "World":
        """A world from its own `text`, which does not say what "none" took the place of.

        Args:
            text: what `text` gave.
            name: what it is called.
            tool: its `tool`.

        Returns:
            The same world.

        Raises:
            ValueError: as in `parse` and `with_tool`.
        """
        world = cls.parse(text, name)
        return world if world.several else world.with_tool(tool)

    def with_tool(self, tool: str | Tool | type | PlacedTool) -> "World":
        """The same map with another tool in the place of its own ("none" leaves plain floor).

        What the map says of the rules (`reading`) holds for the other tool, too.

        Args:
            tool: the name of one (of one's own: "mytools.py:Rake" or "package.module:Rake"), the
                tool itself or its class, or one of the world's `tools`, which then is alone.

        Returns:
            Another world; this one stays as it is.

        Raises:
            ValueError: no such tool, or the map has no cell marked for a tool.
        """
        if isinstance(tool, PlacedTool):
            return replace(
                self.with_tool(NO_TOOL),
                tool=tool.kind,
                own=None if tool.own is None else (tool.kind, tool.own),
                tool_cell=tool.cell,
                tool_slip=tool.slip,
                reading=tool.reading,
                drop=self.drop,
            )
        if not isinstance(tool, str):
            tool = as_tool(tool)
            name = name_of(tool)
            own = (name, tool) if is_own(name) else None
            return replace(self.with_tool(NO_TOOL), tool=name, own=own, drop=self.drop)
        there = next((one for one in self.tools if one.kind == tool), None)
        changed: dict[str, Any] = {"tool": tool, "own": None, "tool_slip": 0.0, "more_tools": ()}
        if there is not None:
            changed |= {"tool_cell": there.cell, "tool_slip": there.slip}
            changed["reading"] = there.reading
        changed["held"] = None
        return replace(self, **changed, drop=self.drop and tool != NO_TOOL)

    def with_object(self, name: str) -> "World":
        """The same map with one of its objects alone.

        Args:
            name: of the object, as in `objects`.

        Returns:
            Another world. An object that has no goal has the world's.

        Raises:
            ValueError: no such object.
        """
        there = {thing.name: thing for thing in self.objects}
        if name not in there:
            raise ValueError(f"{self.name} has no {name!r}; name one of {', '.join(there)}")
        thing = there[name]
        return replace(
            self,
            object=thing.cell,
            object_kind=thing.kind,
            goal=thing.goal or self.goal,
            more_objects=(),
        )

    @property
    def several(self) -> bool:
        """Whether there is more than one tool or object, or tools can be put down."""
        return bool(self.more_tools or self.more_objects or self.drop)

    @property
    def tools(self) -> tuple[PlacedTool, ...]:
        """All tools, in the order in which the map is read."""
        if self.tool == NO_TOOL or self.tool_cell is None:
            return self.more_tools
        kinds = [self.tool, *(tool.kind for tool in self.more_tools)]
        own = None if self.own is None else self.own[1]
        name = numbered(kinds)[0]
        first = PlacedTool(
            name, self.tool, self.tool_cell, self.tool_slip, own, reading=self.reading
        )
        return first, *self.more_tools

    @property
    def objects(self) -> tuple[PlacedObject, ...]:
        """All objects, those with goals first."""
        kinds = [self.object_kind, *(thing.kind for thing in self.more_objects)]
        first = PlacedObject(numbered(kinds)[0], self.object_kind, self.object, self.goal)
        return first, *self.more_objects

    @property
    def in_hand(self) -> int:
        """The place among `tools` of the one in hand; -1 for none."""
        if self.held is not None:
            return self.held
        row, column = self.agent
        beside = (abs(t.cell[0] - row) + abs(t.cell[1] - column) == 1 for t in self.tools)
        return next((place for place, is_beside in enumerate(beside) if is_beside), -1)

    @property
    def rules(self) -> tuple[Tool, ...]:
        """How each of the tools moves objects."""
        first = () if self.tool_rule is None else (self.tool_rule,)
        return *first, *(tool.rule for tool in self.more_tools)

    @property
    def tool_rule(self) -> Tool | None:
        """How the world's tool moves the object; `None` without a tool."""
        if self.own is not None:
            return self.own[1]
        return None if self.tool == NO_TOOL else tool_named(self.tool)

    def located(self) -> "World":
        """The same world, its tools' files named so that they are found from any folder."""
        others = tuple(tool.located() for tool in self.more_tools)
        if self.own is None:
            return replace(self, more_tools=others)
        name = located(self.tool)
        return replace(self, tool=name, own=(name, self.own[1]), more_tools=others)

    @property
    def own_tools(self) -> tuple[str, ...]:
        """The kinds of those tools that are one's own."""
        return tuple(tool.kind for tool in self.tools if is_own(tool.kind))

    def __reduce__(self) -> Any:
        """A file with a tool is run anew elsewhere: its module cannot be imported by name."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        if self.own is None or not is_in_file(self.tool):
            return _world, (values,)
        return _world, (values | {"own": None}, located(self.tool))

    def text(self) -> str:
        """The map as text, which `World.parse` reads back.

        Raises:
            ValueError: something is on a goal, which a map of one character a cell cannot show.
        """
        cells = [mark.cell for mark in marks_of(self)]
        hidden = next((cell for cell in cells if cells.count(cell) > 1), None)
        if hidden is not None:
            raise ValueError(
                f"{self.name}: something else is on the goal at {hidden}, and a map's text has one "
                "character a cell; put it elsewhere"
            )
        return "\n".join([*header_of(self), *self.rows]) + "\n"

    @property
    def rows(self) -> tuple[str, ...]:
        """The rows of the map, one character a cell."""
        cells = [[FLOOR] * self.width for _ in range(self.height)]
        for cell in self.walls:
            cells[cell[0]][cell[1]] = WALL
        for mark in marks_of(self):
            cells[mark.cell[0]][mark.cell[1]] = mark.character
        return tuple("".join(row) for row in cells)


def _world(values: dict[str, Any], place: str | None = None) -> World:
    """A world from its fields, and perhaps where its own tool is to be read."""
    own: Any = values["own"] if place is None else (values["tool"], tool_named(place))
    return World(**(values | {"own": own}))


def world_names() -> list[str]:
    """The built-in worlds' names."""
    return sorted(file.name.removesuffix(".txt") for file in _builtin_files())


def load_world(name: str | Path, tool: str | Tool | type | None = None) -> World:
    """A built-in world by its name, or a map from a file.

    Args:
        name: "corridor", "yard", or the path of a map file.
        tool: takes the place of the map's own tool, as in `World.with_tool`; `None` keeps that.

    Returns:
        The world.

    Raises:
        ValueError: no such world or file, the file cannot be read as text, or the map is
            malformed.

    Example:
        >>> load_world("yard", tool="broom").tool
        'broom'
    """
    world = World.parse(*_source(name))
    return world if tool is None else world.with_tool(tool)


def _source(name: str | Path) -> tuple[str, str, Path | None]:
    """The text of a map, what to call it, and the folder that it is in."""
    if not isinstance(name, str | Path):
        raise ValueError(
            f"world is {shown(repr(name))}; give a built-in world's name or the path of a map file"
        )
    if str(name) in world_names():
        text = next(f for f in _builtin_files() if f.name == f"{name}.txt").read_text("utf-8")
        return text, str(name), None
    path = Path(name)
    try:
        if path.exists() and not path.is_file():
            raise IsADirectoryError(0, "it is not a file")
        return path.read_text("utf-8"), path.name, path.parent
    except UnicodeDecodeError as error:
        raise ValueError(
            f"{shown(name)}: not a text file; give a map drawn in characters"
        ) from error
    except (OSError, ValueError) as error:
        named = shown(name) if str(name) else "''"
        raise ValueError(f"{named}: {_not_a_world(str(name), error)}") from error


def _not_a_world(name: str, error: Exception) -> str:
    """What is wrong with a name, and what to name instead."""
    known = f"name one of {', '.join(world_names())}, or the path of a map file"
    if "\n" in name:
        return f"no such world (this is the text of a map); {known} (World.parse reads map text)"
    if name.startswith(ENVIRONMENT):
        return (
            f"no such world (it is a Gymnasium environment, which habilis empowerment takes, and "
            f"in Python TabularMDP.from_gymnasium); here {known}"
        )
    reason = getattr(error, "strerror", None) or error
    return f"no such world ({reason}); {known} (World.parse reads map text)"


def _builtin_files():
    folder = files("habilis.worlds") / "builtin"
    return [file for file in folder.iterdir() if file.name.endswith(".txt")]
