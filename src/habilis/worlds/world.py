"""A world: walls, and where the agent, the tool, the object and the goal start."""

from dataclasses import dataclass, field, fields, replace
from importlib.resources import files
from pathlib import Path
from typing import Any

from habilis.worlds.characters import AGENT, BINDS, FLOOR, GOAL, OBJECT, WALL
from habilis.worlds.map_text import bindings, map_lines
from habilis.worlds.own_tools import as_tool, beside, is_in_file, is_own, located, tool_named
from habilis.worlds.tools import TOOLS, Tool, name_of

Cell = tuple[int, int]
"""(row, column), row 0 at the top."""

TOOL = "tool"  # any tool's character: a map has one tool at most
NO_TOOL = "none"


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
            binding = f", and a line {self._binding!r} above the map" if self._binding else ""
            raise ValueError(
                f"{self.name}: the map has no tool whose place a {self.tool} could take; "
                f"put {tool_rule.character!r} on a floor cell{binding}"
            )
        placed = {"agent": self.agent, "can": self.object}
        if tool_rule is not None and self.tool_cell is not None:
            placed["tool"] = self.tool_cell
        for thing, cell in {**placed, "goal": self.goal}.items():
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

        Above the map, lines such as `R = mytools.py:Rake` or `X = broom` bind a character to a tool
        of one's own or to a built-in one.

        Args:
            text: `#` wall, `.` floor, `A` agent, `P` picker, `B` broom, `C` can, `G` goal.
            name: what to call the world; errors begin with it.
            folder: where the files of tools are looked for before the working directory.

        Returns:
            The world.

        Raises:
            ValueError: the map is ragged or empty, has an unknown character, or does not have
                exactly one agent, can and goal and at most one tool, or a tool of one's own is
                none. The message names line and column (both from 1) and the mend.

        Example:
            >>> World.parse("AP.CG").tool
            'picker'
            >>> World.parse("X = broom\nAX.CG").tool
            'broom'
        """
        bound, lines = bindings(map_lines(text, name), name)
        width = len(lines[0][1])
        tool_of = {tool.character: kind for kind, tool in TOOLS.items()}
        tool_of |= {character: kind for character, (_, kind) in bound.items()}
        known = {WALL, FLOOR, AGENT, OBJECT, GOAL, *tool_of}
        walls: set[Cell] = set()
        seen: dict[str, tuple[Cell, str, str]] = {}
        for row, (line, cells) in enumerate(lines):
            if len(cells) != width:
                column = min(len(cells), width) + 1
                raise ValueError(
                    f"{name}, line {line}, column {column}: the row has {len(cells)} cells and the "
                    f"first row has {width}; make all rows equally long"
                )
            for column, character in enumerate(cells):
                place = f"line {line}, column {column + 1}"
                if character not in known:
                    raise ValueError(
                        f"{name}, {place}: unknown character {character!r}; use one of "
                        f"{' '.join(sorted(known))}, or bind it above the map, as in "
                        "'R = mytools.py:Rake'"
                    )
                if character == WALL:
                    walls.add((row, column))
                elif character != FLOOR:
                    role = TOOL if character in tool_of else character
                    if role in seen:
                        raise ValueError(
                            f"{name}, {place}: a second {_ROLE_NAMES[role]} {character!r}, the "
                            f"first is at {seen[role][1]}; keep one and put {FLOOR!r} for the other"
                        )
                    seen[role] = ((row, column), place, character)
        for role in (AGENT, OBJECT, GOAL):
            if role not in seen:
                raise ValueError(
                    f"{name}: the map has no {_ROLE_NAMES[role]}; put one {role!r} on a floor cell"
                )
        tool, own = NO_TOOL, None
        if TOOL in seen:
            character = seen[TOOL][2]
            tool = tool_of[character]
            if character in bound:
                tool = tool if folder is None else beside(folder, tool)
                try:
                    own = (tool, tool_named(tool))
                except ValueError as error:
                    line = bound[character][0]
                    raise type(error)(f"{name}, line {line}: {error}") from None
        return cls(
            name=name,
            height=len(lines),
            width=width,
            walls=frozenset(walls),
            agent=seen[AGENT][0],
            object=seen[OBJECT][0],
            goal=seen[GOAL][0],
            tool=tool,
            tool_cell=seen[TOOL][0] if TOOL in seen else None,
            own=own if is_own(tool) else None,
        )

    def with_tool(self, tool: str | Tool | type) -> "World":
        """The same map with another tool in the place of its own ("none" leaves plain floor).

        Args:
            tool: the name of one (of one's own: "mytools.py:Rake" or "package.module:Rake"), or
                the tool itself or its class.

        Returns:
            Another world; this one stays as it is.

        Raises:
            ValueError: no such tool, or the map has no cell marked for a tool.
        """
        if isinstance(tool, str):
            return replace(self, tool=tool, own=None)
        tool = as_tool(tool)
        name = name_of(tool)
        return replace(self, tool=name, own=(name, tool) if is_own(name) else None)

    @property
    def tool_rule(self) -> Tool | None:
        """How the world's tool moves the object; `None` without a tool."""
        if self.own is not None:
            return self.own[1]
        return None if self.tool == NO_TOOL else tool_named(self.tool)

    def located(self) -> "World":
        """The same world, its tool's file named so that it is found from any folder."""
        if self.own is None:
            return self
        name = located(self.tool)
        return replace(self, tool=name, own=(name, self.own[1]))

    def __reduce__(self) -> Any:
        """A file with a tool is run anew elsewhere: its module cannot be imported by name."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        if self.own is None or not is_in_file(self.tool):
            return _world, (values,)
        return _world, (values | {"own": None}, located(self.tool))

    def text(self) -> str:
        """The map as text, which `World.parse` reads back."""
        above = [self._binding] if self._binding else []
        return "\n".join([*above, *self.rows]) + "\n"

    @property
    def _binding(self) -> str | None:
        """The line above the map that says which tool of one's own a character stands for."""
        return self.own and f"{self.own[1].character} {BINDS} {self.tool}"

    @property
    def rows(self) -> tuple[str, ...]:
        """The rows of the map, one character a cell."""
        cells = [[FLOOR] * self.width for _ in range(self.height)]
        marks = [(cell, WALL) for cell in self.walls]
        marks += [(self.goal, GOAL), (self.object, OBJECT), (self.agent, AGENT)]
        if self.tool_rule is not None and self.tool_cell is not None:
            marks.append((self.tool_cell, self.tool_rule.character))
        for (row, column), character in marks:
            cells[row][column] = character
        return tuple("".join(row) for row in cells)


def _world(values: dict[str, Any], place: str | None = None) -> World:
    """A world from its fields, and perhaps where its own tool is to be read."""
    own: Any = values["own"] if place is None else (values["tool"], tool_named(place))
    return World(**(values | {"own": own}))


_ROLE_NAMES = {AGENT: "agent", OBJECT: "can", GOAL: "goal", TOOL: "tool"}


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
    if str(name) in world_names():
        text = next(f for f in _builtin_files() if f.name == f"{name}.txt").read_text("utf-8")
        return text, str(name), None
    path = Path(name)
    if path.exists() and not path.is_file():
        raise ValueError(f"{path}: is not a file; give the path of a map file")
    shown = repr(str(name)) if not str(name).isprintable() else str(name)
    try:
        return path.read_text("utf-8"), path.name, path.parent
    except UnicodeDecodeError as error:
        raise ValueError(f"{shown}: not a text file; give a map drawn in characters") from error
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise ValueError(
            f"{shown}: no such world ({reason}); name one of "
            f"{', '.join(world_names())}, or the path of a map file (World.parse reads map text)"
        ) from error


def _builtin_files():
    folder = files("habilis.worlds") / "builtin"
    return [file for file in folder.iterdir() if file.name.endswith(".txt")]
