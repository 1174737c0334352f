"""Whether something is a tool, as far as asking it shows.

It is asked about every placement with the tool in hand on a few small maps without walls. All that
the engine relies on is checked; what the tool does is its own affair.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from habilis.worlds.grid import Cells, Grid
from habilis.worlds.own_tools import as_tool
from habilis.worlds.pictures.shapes import Drawing, Shape
from habilis.worlds.tool_calls import Method, Placements, call, in_words, refusal
from habilis.worlds.tools import Tool, drawing_of

_HEIGHT, _WIDTH = 7, 8
_OTHER_WIDTHS = (13, 3, 1)  # of maps on which a tool must behave as on the first
_ONE_BY_ONE = 97  # placements are many: every so-manieth is asked about alone
_MOVING: tuple[Method, ...] = ("carry", "swing")


def check_tool(tool: "str | type | Tool") -> None:
    """Refuses what is no tool, or not one that the rules can rely on.

    Args:
        tool: a tool, its class, or its name, such as "mytools.py:Rake".

    Raises:
        ValueError: the first thing that is wrong, for which placement (cells as (row, column)),
            and the fix, in one line. Checked are its character and drawing; the shapes and kinds
            of what `attached`, `carry` and `swing` return, for many placements, one, and none;
            that they leave their arguments alone, answer each placement for itself, the same
            every time, and the same wherever on whatever map it is; that an object lands where
            the map's border reaches; and that what is called attached goes with the tool and
            stays attached.

    Example:
        >>> from habilis.worlds.tools import Picker
        >>> check_tool(Picker())
        >>> class Careless(Picker):
        ...     def carry(self, agent, tool, thing, step):
        ...         return thing
        >>> check_tool(Careless)  # doctest: +ELLIPSIS
        Traceback (most recent call last):
        ...
        ValueError: tool '...Careless': carry leaves behind an object that it reports as attached...
    """
    rule = as_tool(tool)
    _check_drawing(rule)
    room = _Room.of(_WIDTH)
    questions = list(room.questions(rule))
    _check_again(questions)
    for question in questions:
        _check_none_and_one(question)
        _check_place(question)
    for width in _OTHER_WIDTHS:
        _check_map(room, _Room.of(width), rule)
    _check_attached(room, rule)


@dataclass(frozen=True)
class _Room:
    """A map without walls, and every placement on it with the tool in hand."""

    grid: Grid
    placements: Placements

    @classmethod
    def of(cls, width: int) -> "_Room":
        grid = Grid.of(_HEIGHT, width)
        agent, tool = (
            np.concatenate(cells)
            for cells in zip(*((grid.free, grid.free + s) for s in grid.steps), strict=True)
        )
        inside = ~grid.wall[tool]
        agent, tool = (np.repeat(cells[inside], len(grid.free)) for cells in (agent, tool))
        thing = np.tile(grid.free, inside.sum())
        apart = (thing != agent) & (thing != tool)
        return cls(grid, (agent[apart], tool[apart], thing[apart]))

    def questions(self, rule: Tool) -> "Iterator[_Question]":
        """All that a tool can be asked about the placements."""
        yield _Question(self, rule, "attached")
        for step in self.grid.steps:
            for method in _MOVING:
                yield _Question(self, rule, method, (step,))


@dataclass(frozen=True)
class _Question:
    """Something asked of a tool about all placements in a room."""

    room: _Room
    rule: Tool
    method: Method
    step: tuple[int, ...] = ()

    def ask(self, *placements: Cells):
        agent, tool, thing = placements or self.room.placements
        return call(self.room.grid, self.rule, self.method, (agent, tool, thing), *self.step)

    def refuse(self, problem: str, fix: str, index: int) -> ValueError:
        where = in_words(self.room.grid, self.room.placements, index, *self.step)
        return refusal(self.rule, self.method, problem, fix, where)


def _check_drawing(rule: Tool) -> None:
    drawing: Drawing = drawing_of(rule)
    problem = ""
    if not isinstance(drawing, tuple) or not all(isinstance(shape, Shape) for shape in drawing):
        problem = f"is {type(drawing).__name__}, not a tuple of Shape"
    elif any(not (0 <= x <= 1 and 0 <= y <= 1) for shape in drawing for x, y in shape.points):
        problem = "leaves its cell"
    if problem:
        raise refusal(
            rule, "drawing", problem, "give a tuple of shapes.Shape, with points from 0 to 1"
        )


def _check_none_and_one(question: _Question) -> None:
    """Each placement is answered for itself, however many are asked about together."""
    none = question.room.placements[0][:0]
    question.ask(none, none, none)
    together = question.ask()
    for index in range(0, len(together), _ONE_BY_ONE):
        alone = question.ask(*(c[index : index + 1] for c in question.room.placements))
        if alone[0] != together[index]:
            raise question.refuse(
                "returns another result for one placement alone",
                "treat each entry of the arrays independently",
                index,
            )


def _check_again(questions: "list[_Question]") -> None:
    """The same question has the same answer, whatever was asked in between, and in what order."""
    answers = [question.ask() for question in questions]
    for question, first in reversed(list(zip(questions, answers, strict=True))):
        again = question.ask(*(cells[::-1] for cells in question.room.placements))[::-1]
        if (again != first).any():
            raise question.refuse(
                "returns another result when called again",
                "let nothing but its arguments decide: no random numbers, nothing remembered, and "
                "each entry of the arrays by itself",
                int(np.argmax(again != first)),
            )


def _check_place(question: _Question) -> None:
    """A placement further south or east has the same answer, further south or east."""
    grid, result = question.room.grid, question.ask()
    moving = question.method != "attached"
    for shift in (grid.stride, 1):
        moved = tuple(cells + shift for cells in question.room.placements)
        kept = ~(grid.wall[moved[0]] | grid.wall[moved[1]] | grid.wall[moved[2]])
        there = question.ask(*(cells[kept] for cells in moved))
        here = result[kept] + shift if moving else result[kept]
        if (there != here).any():
            index = int(np.flatnonzero(kept)[np.argmax(there != here)])
            raise question.refuse(
                "returns another result one cell to the " + ("south" if shift > 1 else "east"),
                "use differences of cells and `step`, not the cells' numbers",
                index,
            )


def _check_map(room: _Room, other: _Room, rule: Tool) -> None:
    """The same cells of a wider or narrower map have the same results."""
    for question, there in zip(room.questions(rule), other.questions(rule), strict=True):
        cells, results = _coordinates(question)
        other_cells, other_results = _coordinates(there)
        known = {key: at for at, key in enumerate(map(bytes, other_cells))}
        pairs = [(at, known[key]) for at, key in enumerate(map(bytes, cells)) if key in known]
        here, at = np.array(pairs).T
        differs = (results[here] != other_results[at]).any(axis=1)
        if differs.any():
            raise question.refuse(
                f"returns another result on a map {other.grid.width} columns wide",
                "use differences of cells and `step`, and look no further than four cells along a "
                "row: beyond that, the next row begins",
                int(here[np.argmax(differs)]),
            )


def _coordinates(question: _Question) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns of the placements, int[n, 6], and of the answers, or these as they are."""
    grid, result = question.room.grid, question.ask()

    def of(cells: Cells) -> list[np.ndarray]:
        row, column = np.divmod(cells, grid.stride)
        return [row, column]

    placed = [part for cells in question.room.placements for part in of(cells)]
    answer = [result] if question.method == "attached" else of(result)
    return np.stack(placed, axis=1), np.stack(answer, axis=1)


def _check_attached(room: _Room, rule: Tool) -> None:
    """An attached object goes where the tool goes, and stays attached."""
    grid = room.grid
    agent, _, thing = room.placements
    attached = _Question(room, rule, "attached").ask()
    for step in grid.steps:
        carried = _Question(room, rule, "carry", (step,))
        left = attached & (carried.ask() != thing + step)
        if left.any():
            raise carried.refuse(
                "leaves behind an object that it reports as attached",
                "return thing + step for an attached object, or do not report it as attached",
                int(np.argmax(left)),
            )
        swung = _Question(room, rule, "swing", (step,))
        side, lands = agent + step, swung.ask()
        fits = ~grid.wall[side] & ~grid.wall[lands] & (side != lands) & (agent != lands)
        asked = np.flatnonzero(attached & fits)
        still = call(grid, rule, "attached", (agent[asked], side[asked], lands[asked]))
        if not still.all():
            raise swung.refuse(
                "releases an object that it reports as attached",
                "keep an attached object attached, or do not report it as attached",
                int(asked[np.argmin(still)]),
            )
