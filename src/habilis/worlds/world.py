"""A world: walls, and where the agent, the tools, the objects and their goals start."""

import re
from dataclasses import dataclass, replace
from functools import cached_property
from importlib.resources import files
from pathlib import Path

from habilis.files import shown
from habilis.own_code import is_own
from habilis.reprs import quietly, short, unfailing
from habilis.worlds.grid import Cell as Cell
from habilis.worlds.grid import Grid
from habilis.worlds.map_text import FLOOR, WALL
from habilis.worlds.map_writing import Mark, binding, described, header_of, marks_of
from habilis.worlds.own_tools import as_tool, tool_named
from habilis.worlds.parsing import parsed
from habilis.worlds.things import (
    Door,
    PlacedObject,
    PlacedTool,
    Vacancy,
    Where,
    cells_of,
    moved,
    named,
)
from habilis.worlds.tools import Reading, Tool, name_of
from habilis.worlds.world_checks import check_one_agent, check_things

NO_TOOL = "none"
ENVIRONMENT = "gym:"
"""Before the name of a Gymnasium environment on the command line."""

_TABLES = (".npz", ".drn")
"""The ends of names of files with a table: ours, and Storm's."""

_MUJOCO = ".xml"

_PYTHON = re.compile(r"\.py(:\w*)?$")


@dataclass(frozen=True)
class World:
    """A map and the things that start on it.

    Attributes:
        name: what tables and pictures call it.
        height, width: rows and columns of the map.
        walls: the wall cells.
        agent: start cell of the agent.
        objects: the objects, those with goals first.
        tools: the tools, in the order in which the map is read.
        drop: whether there is a ninth action, which puts the tool in hand down.
        held: which of `tools` is in hand at the start, -1 for none; `None`: the first beside the
            agent.
        vacancy: the place of the tool that `with_tool("none")` took off the map.
        second: start cell of a second agent, if there is one: then there are no tools, and objects
            and goals need not be.
        doors: of a map with two agents.
    """

    name: str
    height: int
    width: int
    walls: frozenset[Cell]
    agent: Cell
    objects: tuple[PlacedObject, ...]
    tools: tuple[PlacedTool, ...] = ()
    drop: bool = False
    held: int | None = None
    vacancy: Vacancy | None = None
    second: Cell | None = None
    doors: tuple[Door, ...] = ()

    def __post_init__(self) -> None:
        """Names the things, and refuses those not on free cells or on each other.

        Raises:
            ValueError: naming the thing and its cell.
        """
        object.__setattr__(self, "objects", named(self.objects))
        object.__setattr__(self, "tools", named(self.tools))
        check_things(self)

    @unfailing
    def __repr__(self) -> str:
        return short(f"World {self.name}", *described(self))

    def __str__(self) -> str:
        return "\n".join([*self.header, *self.rows])

    @quietly
    def _repr_svg_(self) -> str | None:
        """The picture, for notebooks."""
        from habilis.worlds.pictures.svg import world_svg

        return world_svg(self)

    @classmethod
    def parse(cls, text: str, name: str = "map", folder: Path | None = None) -> "World":
        r"""Reads a map: one character a cell, lines starting with `;` are comments.

        Above the map, lines bind characters: `R = rake` to a tool, `R = mytools.py:Rake` to one of
        one's own, `P = picker slip 0.2` to one that may fail, `P = picker pushes` to one under
        another `Reading` of the rules, `D = ball` to an object, `H = goal of D` to its goal.
        `drop: true` adds the action that puts a tool down. `E = agent` binds the second of two
        agents, `D = door` and `D = open door` a door of theirs.

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
                nothing known. The message names line and column (both counted from 1) and the fix.

        Example:
            >>> World.parse("AP.CG").tool
            'picker'
            >>> several = World.parse("X = broom\nD = ball\nG = goal of C\nAX.CG\nP..D.")
            >>> [tool.name for tool in several.tools], [thing.name for thing in several.objects]
            (['broom', 'picker'], ['can', 'ball'])
        """
        return cls(**parsed(text, name, folder))

    def with_tool(self, tool: str | Tool | type | PlacedTool) -> "World":
        """The same map with another tool in the place of its own ("none" leaves plain floor).

        Where there are several tools, it takes the place of the first, and the others go. The
        rules are read for it as for the tool whose place it takes.

        Args:
            tool: the name of one (of one's own: "mytools.py:Rake" or "package.module:Rake"), the
                tool itself or its class, or one of the world's `tools`, which then is alone.

        Returns:
            Another world; this one stays as it is.

        Raises:
            ValueError: no such tool, or the map has no cell marked for a tool.
        """
        check_one_agent(self)
        first = self.tools[0] if self.tools else self.vacancy
        if isinstance(tool, str) and tool == NO_TOOL:
            vacancy = None if first is None else Vacancy(first.cell, first.reading)
            return replace(self, tools=(), vacancy=vacancy, drop=False, held=None)
        if isinstance(tool, PlacedTool):
            return replace(self, tools=(replace(tool, name=""),), vacancy=None, held=None)
        if isinstance(tool, str):
            kind, rule = tool, tool_named(tool)
            there = next((one for one in self.tools if one.kind == tool), None)
        else:
            rule = as_tool(tool)
            kind, there = name_of(rule), None
        if first is None:
            line = binding(rule.character, kind)
            above = f", and a line {line!r} above the map" if line else ""
            raise ValueError(
                f"{self.name}: the map has no tool whose place a {kind} could take; "
                f"put {rule.character!r} on a floor cell{above}"
            )
        own = rule if is_own(kind) else None
        if there is not None:
            placed = replace(there, name="", own=own)
        else:
            placed = PlacedTool(kind, first.cell, reading=first.reading, own=own)
        return replace(self, tools=(placed,), vacancy=None, held=None)

    def with_reading(self, reading: Reading) -> "World":
        """The same map with its tools under a reading of rules 3 to 5.

        Args:
            reading: of every tool, and of any that takes the place of one.

        Returns:
            Another world; this one stays as it is.
        """
        tools = tuple(replace(tool, reading=reading) for tool in self.tools)
        vacancy = None if self.vacancy is None else Vacancy(self.vacancy.cell, reading)
        return replace(self, tools=tools, vacancy=vacancy)

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
        alone = replace(there[name], goal=there[name].goal or self.goal, name="")
        return replace(self, objects=(alone,))

    def with_cells(
        self,
        *,
        agent: Cell | None = None,
        tool: Where | None = None,
        object: Where | None = None,
        goal: Cell | None = None,
        held: int | None = None,
    ) -> "World":
        r"""The same map with some of its things in other cells: a state is a world, too.

        Args:
            agent: its cell; `None` leaves it where it is, or, if something else comes there, puts
                it on the first cell that is free.
            tool, object: a cell where there is one of them, or cells by names.
            goal: the cell of the first object's goal.
            held: as in the attributes.

        Returns:
            Another world.

        Raises:
            ValueError: no such tool or object, it is not said which, or a cell that is not free.

        Example:
            >>> world = World.parse("R = rake\nA.PRCG")
            >>> world.with_cells(agent=(0, 2), tool={"picker": (0, 1)}).rows
            ('.PARCG',)
        """
        objects = moved(self.objects, cells_of(self.name, "object", self.objects, object))
        tools = moved(self.tools, cells_of(self.name, "tool", self.tools, tool))
        if goal is not None:
            objects = (replace(objects[0], goal=goal), *objects[1:])
        if agent is None:
            agent, taken = self.agent, {thing.cell for thing in (*tools, *objects)}
            if agent in taken:
                agent = next((cell for cell in self.free_cells if cell not in taken), agent)
        return replace(self, agent=agent, objects=objects, tools=tools, held=held)

    @property
    def single(self) -> bool:
        """Whether there is one object and at most one tool, which cannot be put down.

        Of such a world a table has all placements, and the factors "tool" and "object".
        """
        alone = self.second is None
        return len(self.objects) == 1 and len(self.tools) <= 1 and not self.drop and alone

    @property
    def tool(self) -> str:
        """The kind of the tool, or of the first ("picker", "mytools.py:Rake"); "none" if none."""
        return self.tools[0].kind if self.tools else NO_TOOL

    @property
    def tool_cell(self) -> Cell | None:
        """The cell of the tool, or of the first.

        If there is none, the cell of which one was taken; `None` if the map never had one.
        """
        first = self.tools[0] if self.tools else self.vacancy
        return None if first is None else first.cell

    @property
    def object(self) -> Cell:
        """The cell of the object, or of the first."""
        return self.objects[0].cell

    @property
    def goal(self) -> Cell:
        """The goal of the object, or of the first."""
        goal = self.objects[0].goal
        assert goal is not None, "the first object has one"
        return goal

    @property
    def in_hand(self) -> int:
        """The place among `tools` of the one in hand; -1 for none."""
        if self.held is not None:
            return self.held
        row, column = self.agent
        beside = (abs(t.cell[0] - row) + abs(t.cell[1] - column) == 1 for t in self.tools)
        return next((place for place, is_beside in enumerate(beside) if is_beside), -1)

    @property
    def may_fail(self) -> bool:
        """Whether some tool's work may fail."""
        return any(tool.slip for tool in self.tools)

    @property
    def own_tools(self) -> tuple[str, ...]:
        """The kinds of those tools that are one's own."""
        return tuple(tool.kind for tool in self.tools if is_own(tool.kind))

    def located(self) -> "World":
        """The same world, its tools' files named so that they are found from any folder."""
        return replace(self, tools=tuple(tool.located() for tool in self.tools))

    def is_free(self, cell: Cell) -> bool:
        """Whether a cell is on the map and no wall.

        Args:
            cell: (row, column), on the map or not.

        Returns:
            `True` where agent, tool or object could be.
        """
        row, column = cell
        return 0 <= row < self.height and 0 <= column < self.width and cell not in self.walls

    @property
    def free_cells(self) -> list[Cell]:
        """The cells that are no walls, row by row."""
        cells = ((row, column) for row in range(self.height) for column in range(self.width))
        return [cell for cell in cells if cell not in self.walls]

    @property
    def agent_cells(self) -> list[Cell]:
        """The cells in which the agent can be, everything else as on the map, row by row."""
        taken = {thing.cell for thing in (*self.tools, *self.objects)}
        return [cell for cell in self.free_cells if cell not in taken]

    @cached_property
    def grid(self) -> Grid:
        """The map as a flat array of cells."""
        return Grid.of(self.height, self.width, self.walls)

    def text(self) -> str:
        """The map as text, which `World.parse` reads back.

        Raises:
            ValueError: something is on a goal, which a map of one character a cell cannot show.
        """
        cells = [mark.cell for mark in self.marks]
        hidden = next((cell for cell in cells if cells.count(cell) > 1), None)
        if hidden is not None:
            below = "in the door" if hidden in [door.cell for door in self.doors] else "on the goal"
            raise ValueError(
                f"{self.name}: something else is {below} at {hidden}, and a map's text has one "
                "character a cell; put it elsewhere"
            )
        return "\n".join([*self.header, *self.rows]) + "\n"

    @property
    def header(self) -> list[str]:
        """The lines above the rows of the map: what its characters stand for."""
        return header_of(self.marks, self.drop)

    @property
    def rows(self) -> tuple[str, ...]:
        """The rows of the map, one character a cell."""
        cells = [[FLOOR] * self.width for _ in range(self.height)]
        for cell in self.walls:
            cells[cell[0]][cell[1]] = WALL
        for mark in self.marks:
            cells[mark.cell[0]][mark.cell[1]] = mark.character
        return tuple("".join(row) for row in cells)

    @property
    def marks(self) -> list[Mark]:
        """The characters of the things and goals, the goals first: what is on them hides them."""
        return marks_of(self.agent, self.tools, self.objects, self.second, self.doors)


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
    if path.suffix.lower() in (*_TABLES, _MUJOCO) or _PYTHON.search(str(name)):
        raise ValueError(f"{shown(name)}: {_not_a_world(str(name), None)}")
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


def _not_a_world(name: str, error: Exception | None) -> str:
    """The problem with a name, and what to name instead."""
    known = f"name one of {', '.join(world_names())}, or the path of a map file"
    if "\n" in name:
        return f"no such world (this is the text of a map); {known} (World.parse reads map text)"
    if name.startswith(ENVIRONMENT):
        return (
            "no such world (it is a Gymnasium environment, which habilis empowerment and train "
            f"take, and in Python TabularMDP.from_gymnasium); here {known}"
        )
    if Path(name).suffix.lower() in _TABLES:
        return (
            "no such world (it is a table, which habilis empowerment and train take, and in Python "
            f"TabularMDP.load); here {known}"
        )
    if Path(name).suffix.lower() == _MUJOCO:
        return (
            "no such world (it is a MuJoCo model, of which habilis compare measures the hand and "
            f"its tools: habilis compare {name} --out landscape.png); here {known}"
        )
    if _PYTHON.search(name):
        return (
            "no such world (it is Python; of a model in it, habilis.explore(model).save(path) "
            f"makes a table, .npz, which habilis empowerment and train take); here {known}"
        )
    reason = getattr(error, "strerror", None) or error
    return f"no such world ({reason}); {known} (World.parse reads map text)"


def _builtin_files():
    folder = files("habilis.worlds") / "builtin"
    return [file for file in folder.iterdir() if file.name.endswith(".txt")]
