"""A puzzle in coloured text, for terminals."""

from typing import TYPE_CHECKING

from rich.text import Text

from habilis.bridges.puzzles.shapes import body_colours, ink_on
from habilis.worlds.grid import Cell

if TYPE_CHECKING:
    from habilis.bridges.puzzles.pushworld import PushWorld

_WALL, _AGENT_WALL, _FLOOR = (
    ("##", "#5b6270 on #5b6270"),
    ("//", "#5b6270 on #dde1e6"),
    (". ", "dim"),
)


def colored(puzzle: "PushWorld") -> Text:
    """The map; see `PushWorld.colored_text`."""
    looks: dict[Cell, tuple[str, str]] = dict.fromkeys(puzzle.walls, _WALL)
    looks |= dict.fromkeys(puzzle.agent_walls, _AGENT_WALL)
    colours = body_colours(puzzle)
    bodies = {body.name: body for body in puzzle.bodies}
    goals: set[Cell] = set()
    for goal in puzzle.goals:
        first = goal.bodies[0]
        mark = f"G{_number(first)}" if len(goal.bodies) == 1 else "G"
        cells = bodies[first].covered(goal.corner)
        looks |= dict.fromkeys(cells, (f"{mark:<2}"[:2], f"bold {colours[first]}"))
        goals |= {*cells}
    for name, body in bodies.items():
        mark = "A" if body is puzzle.bodies[0] else _number(name)
        style = f"bold {ink_on(colours[name])} on {colours[name]}"
        for cell in body.covered():
            looks[cell] = f"{mark}{'G' if cell in goals else ' '}"[:2], style
    lines = []
    for row in range(puzzle.height):
        cells = (looks.get((row, column), _FLOOR) for column in range(puzzle.width))
        lines.append(Text.assemble(*cells))
    return Text("\n").join(lines)


def _number(name: str) -> str:
    return name[1:]
