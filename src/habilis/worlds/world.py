"""A world: walls, and where the agent, the tool, the object and the goal start."""

from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path

from habilis.worlds.tools import TOOLS, Tool, tool_named

Cell = tuple[int, int]
"""(row, column), row 0 at the top."""

WALL, FLOOR, AGENT, OBJECT, GOAL = "#.ACG"
TOOL = "tool"  # any tool's character: a map has one tool at most
COMMENT = ";"
_BYTE_ORDER_MARK = "\ufeff"  # what some editors put at the start of a file
NO_TOOL = "none"


@dataclass(frozen=True)
class World:
    """A map and the things that start on it.

    Attributes:
        name: what tables and pictures call it.
        height, width: rows and columns of the map.
        walls: the wall cells.
        agent, object, goal: start cell of the agent and of the object, and the object's goal.
        tool: the kind of tool ("picker", "broom", or "none").
        tool_cell: the cell the tool starts in; stays known when the tool is "none", so that
            another tool can take its place; `None` if the map never had one.
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

    def __post_init__(self) -> None:
        """Refuses things that are not on free cells of the map, or on each other.

        Raises:
            ValueError: naming the thing and its cell.
        """
        tool_rule = self.tool_rule
        if tool_rule is not None and self.tool_cell is None:
            raise ValueError(
                f"{self.name}: the map has no tool whose place a {self.tool} could take; "
                f"put {tool_rule.character!r} on a floor cell"
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
    def parse(cls, text: str, name: str = "map") -> "World":
        """Reads a map: one character a cell, lines starting with `;` are comments.

        Args:
            text: `#` wall, `.` floor, `A` agent, `P` picker, `B` broom, `C` can, `G` goal.
            name: what to call the world; errors begin with it.

        Returns:
            The world.

        Raises:
            ValueError: the map is ragged or empty, has an unknown character, or does not have
                exactly one agent, can and goal and at most one tool. The message names line
                and column (both from 1) and the mend.

        Example:
            >>> World.parse("AP.CG").tool
            'picker'
        """
        lines = _map_lines(text, name)
        width = len(lines[0][1])
        tool_of = {tool.character: kind for kind, tool in TOOLS.items()}
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
                        f"{' '.join(sorted(known))}"
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
        return cls(
            name=name,
            height=len(lines),
            width=width,
            walls=frozenset(walls),
            agent=seen[AGENT][0],
            object=seen[OBJECT][0],
            goal=seen[GOAL][0],
            tool=tool_of[seen[TOOL][2]] if TOOL in seen else NO_TOOL,
            tool_cell=seen[TOOL][0] if TOOL in seen else None,
        )

    def with_tool(self, tool: str) -> "World":
        """The same map with another tool in the place of its own.

        Args:
            tool: "picker", "broom", or "none", which leaves plain floor there.

        Returns:
            Another world; this one stays as it is.

        Raises:
            ValueError: no such tool, or the map has no cell marked for a tool.
        """
        return replace(self, tool=tool)

    @property
    def tool_rule(self) -> Tool | None:
        """How the world's tool moves the object; `None` without a tool."""
        return None if self.tool == NO_TOOL else tool_named(self.tool)

    def text(self) -> str:
        """The map as text, which `World.parse` reads back."""
        cells = [[FLOOR] * self.width for _ in range(self.height)]
        marks = [(cell, WALL) for cell in self.walls]
        marks += [(self.goal, GOAL), (self.object, OBJECT), (self.agent, AGENT)]
        if self.tool_rule is not None and self.tool_cell is not None:
            marks.append((self.tool_cell, self.tool_rule.character))
        for (row, column), character in marks:
            cells[row][column] = character
        return "\n".join("".join(row) for row in cells) + "\n"


_ROLE_NAMES = {AGENT: "agent", OBJECT: "can", GOAL: "goal", TOOL: "tool"}


def _map_lines(text: str, name: str) -> list[tuple[int, str]]:
    """The rows of the map with their line numbers; blank lines around the map do not count."""
    lines = [
        (number, line.rstrip())
        for number, line in enumerate(text.removeprefix(_BYTE_ORDER_MARK).split("\n"), start=1)
        if not line.startswith(COMMENT)
    ]
    while lines and not lines[0][1]:
        lines.pop(0)
    while lines and not lines[-1][1]:
        lines.pop()
    if not lines:
        raise ValueError(f"{name}: the map is empty; draw at least one row, such as 'AP.CG'")
    return lines


def world_names() -> list[str]:
    """The built-in worlds' names."""
    return sorted(file.name.removesuffix(".txt") for file in _builtin_files())


def load_world(name: str | Path, tool: str | None = None) -> World:
    """A built-in world by its name, or a map from a file.

    Args:
        name: "corridor", "yard", or the path of a map file.
        tool: takes the place of the map's own tool; `None` keeps that.

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


def _source(name: str | Path) -> tuple[str, str]:
    if str(name) in world_names():
        text = next(f for f in _builtin_files() if f.name == f"{name}.txt").read_text("utf-8")
        return text, str(name)
    path = Path(name)
    if path.exists() and not path.is_file():
        raise ValueError(f"{path}: is not a file; give the path of a map file")
    shown = repr(str(name)) if not str(name).isprintable() else str(name)
    try:
        return path.read_text("utf-8"), path.name
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
