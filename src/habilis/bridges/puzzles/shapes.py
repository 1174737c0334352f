"""The things of a puzzle as drawings: each body outlined as one shape.

Coordinates are those of `habilis.worlds.pictures.shapes`, in cells of the whole map.
"""

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

from habilis.bridges.puzzles.bodies import Body
from habilis.worlds.grid import Cell
from habilis.worlds.pictures.shapes import (
    BLUE,
    GREEN,
    INK,
    LEAF,
    PAPER,
    RED,
    SHAPES,
    STEEL,
    VIOLET,
    WHITE,
    WOOD,
    YELLOW,
    Drawing,
    Shape,
    box,
    placed,
    polygon,
    rod,
)

if TYPE_CHECKING:
    from habilis.bridges.puzzles.pushworld import PushWorld

_WITH_GOAL = (RED, GREEN, VIOLET, YELLOW, "#c08414", "#5b6270")
"""The colours of movables that have a goal of their own."""
_OTHERS = ("#a9cbe0", "#c3d3dd", "#8fb8d3", "#d3dfe6")
"""Those of the others."""
_SEGMENTS = {  # of digits: their ends, in units of a digit's width
    "a": ((0.0, 0.0), (1.0, 0.0)),
    "b": ((1.0, 0.0), (1.0, 1.0)),
    "c": ((1.0, 1.0), (1.0, 2.0)),
    "d": ((0.0, 2.0), (1.0, 2.0)),
    "e": ((0.0, 1.0), (0.0, 2.0)),
    "f": ((0.0, 0.0), (0.0, 1.0)),
    "g": ((0.0, 1.0), (1.0, 1.0)),
}
_DIGITS = ("abcdef", "bc", "abged", "abgcd", "fgbc", "afgcd", "afgedc", "abc", "abcdefg", "abcdfg")
_DIGIT, _STROKE = 0.17, 0.055  # width of a digit and of its lines, in cells


def puzzle_drawings(puzzle: "PushWorld", agent: bool = True) -> list[Drawing]:
    """Everything on a puzzle's map but walls and floor, from the back to the front.

    A movable has the colour of its goal, where it has one of its own, and the green of the bins
    about it once it is there. Movables bear their numbers.
    """
    colours = body_colours(puzzle)
    bodies = {body.name: body for body in puzzle.bodies}
    drawings = [placed(AGENT_WALL, column, row) for row, column in sorted(puzzle.agent_walls)]
    filled = set()
    for goal in puzzle.goals:
        first = bodies[goal.bodies[0]]
        alone = len(goal.bodies) == 1
        drawings.append(goal_drawing(first, colours[first.name], goal.corner, alone))
        filled |= {name for name in goal.bodies if bodies[name].corner == goal.corner}
    for body in puzzle.bodies[1:]:
        drawings.append(movable_drawing(body, colours[body.name], body.corner, body.name in filled))
    if agent:
        drawings.append(agent_drawing(puzzle.bodies[0].covered()))
    return drawings


def goal_drawing(body: Body, colour: str, corner: Cell, numbered: bool) -> Drawing:
    """The place for a body whose corner belongs into a cell."""
    cells = body.covered(corner)
    ring = (*_solid(colour, cells, 0.08, 0.1), *_solid(_pale(colour), cells, 0.17, 0.06))
    return (*ring, *(_number(body.name, cells, colour) if numbered else ()))


def movable_drawing(body: Body, colour: str, corner: Cell, filled: bool) -> Drawing:
    """A movable whose corner is in a cell, and whether it fills a goal there."""
    line, width = (LEAF, 0.11) if filled else (INK, 0.05)
    cells = body.covered(corner)
    outline = (*_solid(line, cells, 0.04, 0.16), *_solid(colour, cells, 0.04 + width, 0.1))
    return (*outline, *_number(body.name, cells, ink_on(colour)))


def body_colours(puzzle: "PushWorld") -> dict[str, str]:
    """The colour of each body, by its name."""
    own = [goal.bodies[0] for goal in puzzle.goals if len(goal.bodies) == 1]
    shared = {name for goal in puzzle.goals for name in goal.bodies} - {*own}
    others = [name for name in puzzle.objects if name not in own and name not in shared]
    colours = {name: _WITH_GOAL[place % len(_WITH_GOAL)] for place, name in enumerate(own)}
    colours |= dict.fromkeys(shared, WOOD)
    colours |= {name: _OTHERS[place % len(_OTHERS)] for place, name in enumerate(others)}
    return colours | {puzzle.bodies[0].name: BLUE}


def agent_drawing(cells: Sequence[Cell]) -> Drawing:
    """The robot, or its face on a body of several cells."""
    row, column = _middle(cells)
    if len(cells) == 1:
        return placed(SHAPES["agent"], column, row)
    eyes = (box("#eaf5fc", 0.2, 0.28, 0.8, 0.68, 0.14),)
    eyes += tuple(box(INK, x - 0.06, 0.37, x + 0.06, 0.55, 0.06) for x in (0.37, 0.63))
    body = (*_solid(INK, cells, 0.04, 0.16), *_solid(BLUE, cells, 0.09, 0.12))
    return (*body, *placed(eyes, column, row))


def _solid(fill: str, cells: Collection[Cell], margin: float, radius: float) -> Drawing:
    """Cells as one area that keeps a margin from all others, its outer corners rounded.

    It is laid of pieces that overlap, so that it may have holes, and no light shows between them.
    """
    there, near, far = {*cells}, margin, 1 - margin
    low, high = far - radius, 1 + near + radius  # a bridge reaches into the cells it connects
    pieces: list[Shape] = []
    for row, column in there:
        right, below = (row, column + 1) in there, (row + 1, column) in there

        def piece(
            left: float,
            top: float,
            to: float,
            bottom: float,
            r: float = 0.0,
            at: Cell = (row, column),
        ) -> None:
            x, y = at[1], at[0]
            corners = (x + left, y + top, x + to, y + bottom)
            if r:
                pieces.append(box(fill, *corners, r))
            else:
                pieces.append(_rectangle(fill, *corners))

        piece(near, near, far, far, radius)
        if right:
            piece(low, near, high, far)
        if below:
            piece(near, low, far, high)
        if right and below and (row + 1, column + 1) in there:
            piece(low, low, high, high)
    return tuple(pieces)


def _rectangle(fill: str, left: float, top: float, right: float, bottom: float) -> Shape:
    return polygon(fill, (left, top), (right, top), (right, bottom), (left, bottom))


def _number(name: str, cells: Sequence[Cell], colour: str) -> Drawing:
    """A movable's number, in the cell of its body that is nearest to the middle."""
    row, column = _middle(cells)
    digits = name[1:]
    width = len(digits) * _DIGIT + (len(digits) - 1) * 1.6 * _STROKE
    x, y = column + (1 - width) / 2, row + 0.5 - _DIGIT
    strokes = []
    for place, digit in enumerate(digits):
        left = x + place * (_DIGIT + 1.6 * _STROKE) - (_DIGIT / 2 if digits == "1" else 0)
        for segment in _DIGITS[int(digit)]:
            ends = ((left + _DIGIT * dx, y + _DIGIT * dy) for dx, dy in _SEGMENTS[segment])
            strokes.append(rod(colour, _STROKE, *ends))
    return tuple(strokes)


def _middle(cells: Sequence[Cell]) -> Cell:
    """The cell nearest to the middle of all, the upper left one of several."""
    row, column = (sum(cell[axis] for cell in cells) / len(cells) for axis in (0, 1))
    return min(sorted(cells), key=lambda cell: (cell[0] - row) ** 2 + (cell[1] - column) ** 2)


def _channels(colour: str) -> list[int]:
    return [int(colour[place : place + 2], 16) for place in (1, 3, 5)]


def _pale(colour: str) -> str:
    """Mostly paper, and a little of a colour."""
    mixed = (
        round(0.8 * paper + 0.2 * own)
        for paper, own in zip(_channels(PAPER), _channels(colour), strict=True)
    )
    return "#" + "".join(f"{channel:02x}" for channel in mixed)


def ink_on(colour: str) -> str:
    """Black or white, whichever is easier to read on a colour."""
    red, green, blue = _channels(colour)
    return INK if 0.299 * red + 0.587 * green + 0.114 * blue > 130 else WHITE


def _stripe(start: float, end: float) -> Shape:
    """A part of the unit cell between two of its diagonals x + y."""
    if end <= 1:
        return polygon(STEEL, (0, start), (start, 0), (end, 0), (0, end))
    return polygon(STEEL, (start - 1, 1), (1, start - 1), (1, end - 1), (end - 1, 1))


AGENT_WALL: Drawing = (
    _rectangle("#dde1e6", 0, 0, 1, 1),
    *(_stripe(start, start + 0.2) for start in (0.15, 0.65, 1.15, 1.65)),
)
