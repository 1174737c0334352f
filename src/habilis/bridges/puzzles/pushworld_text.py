"""The text of PushWorld files."""

import re
from collections.abc import Mapping
from itertools import product

from habilis.worlds.grid import Cell

Covered = dict[str, list[Cell]]
"""The cells of things by their names, the agent first, then by their numbers."""

_CELL = re.compile(r"\S+")
_ELEMENT = re.compile(r"W|AW|A|[MG](0|[1-9]\d*)")
_FLOOR, _WALL, _AGENT_WALL, _AGENT, _MOVABLE, _GOAL = ".", "W", "AW", "A", "M", "G"
_APART = {  # what cannot share a cell with what
    _WALL: (_WALL, _AGENT_WALL, _AGENT, _MOVABLE, _GOAL),
    _AGENT_WALL: (_AGENT_WALL, _AGENT),
    _AGENT: (_AGENT, _MOVABLE),
    _MOVABLE: (_MOVABLE,),
    _GOAL: (),
}
_ELEMENTS = "W, AW, A, M0, M1, ... or G0, G1, ..."


def parsed(
    text: str, name: str
) -> tuple[tuple[int, int], frozenset[Cell], frozenset[Cell], Covered, Covered]:
    """The shape, the walls, the agent's own walls, the bodies and the goals of a puzzle.

    Goals are by the name of their movable.

    Raises:
        ValueError: the text is no puzzle; the message names line and column.
    """
    lines = [line.rstrip() for line in text.removeprefix("\ufeff").split("\n")]
    while lines and not lines[-1]:
        lines.pop()
    above = next((place for place, line in enumerate(lines) if line), len(lines))
    rows = [(number, line) for number, line in enumerate(lines, 1) if number > above]
    if not rows:
        raise ValueError(f"{name}: there are no cells; draw at least one row, such as 'A M0 . G0'")
    where: dict[Cell, str] = {}
    found: dict[str, list[Cell]] = {}
    width = len(_CELL.findall(rows[0][1]))
    for row, (number, line) in enumerate(rows):
        cells = [*_CELL.finditer(line)]
        if len(cells) != width:
            column = cells[width].start() if len(cells) > width else len(line)
            raise ValueError(
                f"{name}, line {number}, column {column + 1}: the row has {len(cells)} cells and "
                f"the first row has {width}; give all rows the same length"
            )
        for column, cell in enumerate(cells):
            place = f"{name}, line {number}, column {cell.start() + 1}"
            where[row, column] = place
            for element in _elements(cell[0].upper(), place):
                found.setdefault(element, []).append((row, column))
    if _AGENT not in found:
        raise ValueError(f"{where[0, 0]}: the puzzle has no agent; put an A on a cell without W")
    bodies = {"agent": found[_AGENT]} | _numbered(found, _MOVABLE)
    goals = _numbered(found, _GOAL)
    for movable, cells in goals.items():
        _check_goal(movable.upper(), cells, bodies.get(movable), where)
    walls, own = (frozenset(found.get(element, [])) for element in (_WALL, _AGENT_WALL))
    return (len(rows), width), walls, own, bodies, goals


def _elements(cell: str, place: str) -> list[str]:
    """The elements of a cell, in capitals.

    Raises:
        ValueError: one is unknown, or two cannot share a cell.
    """
    elements = cell.split("+") if cell != _FLOOR else []
    for element in elements:
        if not _ELEMENT.fullmatch(element):
            raise ValueError(
                f"{place}: unknown element {element!r}; write '.' or {_ELEMENTS} joined by '+'"
            )
    for one, other in product(range(len(elements)), repeat=2):
        kinds = [elements[each].rstrip("0123456789") for each in (one, other)]
        again = elements[one] == elements[other]
        if one != other and (again or kinds[1] in _APART[kinds[0]]):
            raise ValueError(
                f"{place}: {elements[one]} and {elements[other]} share a cell; leave out one of "
                "them"
            )
    return elements


def _numbered(found: Mapping[str, list[Cell]], kind: str) -> Covered:
    """The cells of movables or goals by the names of the movables, in their order."""
    numbers = sorted(int(element[1:]) for element in found if element[0] == kind)
    return {f"m{number}": found[f"{kind}{number}"] for number in numbers}


def _check_goal(
    movable: str, cells: list[Cell], body: list[Cell] | None, where: Mapping[Cell, str]
) -> None:
    """Refuses a goal that nothing can fill."""
    goal = movable.replace(_MOVABLE, _GOAL)
    if body is None:
        raise ValueError(
            f"{where[cells[0]]}: {goal} has no movable; draw {movable}, or leave it out"
        )
    if _outline(cells) != _outline(body):
        raise ValueError(
            f"{where[cells[0]]}: {goal} has another shape than {movable}; draw it with the same "
            f"{len(body)} cells"
        )


def _outline(cells: list[Cell]) -> set[Cell]:
    top, left = (min(cell[axis] for cell in cells) for axis in (0, 1))
    return {(row - top, column - left) for row, column in cells}
