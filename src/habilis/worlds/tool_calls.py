"""Calls of a tool's methods, with validation of their results.

Built-in or custom, a tool is called only for placements with the tool in hand, and gets arrays that
it cannot write to by mistake. A result outside the map is an error that names the tool: it never
becomes a cell somewhere else.
"""

from typing import Any, Literal

import numpy as np

from habilis.own_code import failure
from habilis.probabilities import as_array
from habilis.worlds.grid import BORDER, MOVES, Cells, Flags, Grid
from habilis.worlds.tools import Tool, name_of

Method = Literal["attached", "carry", "swing"]
Placements = tuple[Cells, Cells, Cells]
"""The cells of agent, tool and object."""

_WRITE = "leave the arguments as they are and return new arrays, as np.where makes them"


def call_in_hand(
    grid: Grid,
    rule: Tool,
    method: Method,
    placements: Placements,
    *step: int,
    where: Flags,
    elsewhere: Any,
    seen: Cells | None = None,
) -> Any:
    """A tool's results for the placements in which it is in hand.

    Args:
        grid: the map.
        rule: the tool.
        method: the method's name.
        placements: the cells of agent, tool and object.
        step: of the move or swing; none for "attached".
        where: in which the tool is in hand.
        elsewhere: the result for all others, an array of the shape of the cells.
        seen: for a tool that sees, the first cell ahead of it where something is.

    Raises:
        ValueError: it fails, or its result is of another shape or kind, or no place on the map.
    """
    if where.all():
        return call(grid, rule, method, placements, *step, seen=seen)
    result = elsewhere.copy()
    if where.any():
        agent, tool, thing = (cells[where] for cells in placements)
        seen = None if seen is None else seen[where]
        result[where] = call(grid, rule, method, (agent, tool, thing), *step, seen=seen)
    return result


def call(
    grid: Grid,
    rule: Tool,
    method: Method,
    placements: Placements,
    *step: int,
    seen: Cells | None = None,
) -> Any:
    """A tool's results for placements in all of which it is in hand; see `call_in_hand`."""
    more = {} if seen is None else {"seen": _unwritable(seen)}
    try:
        returned = getattr(rule, method)(*map(_unwritable, placements), *step, **more)
        result = as_array("the answer", returned)
    except (Exception, SystemExit) as error:
        fix = _WRITE if "read-only" in str(error) else "fix it"
        raise refusal(rule, method, f"fails with {failure(error)}", fix) from error
    thing = placements[2]
    wanted, kind = ("bool", "b") if method == "attached" else ("integer cells", "iu")
    if result.shape != thing.shape or result.dtype.kind not in kind:
        raise refusal(
            rule,
            method,
            f"returns {result.dtype} of shape {result.shape} for cells of shape {thing.shape}",
            f"return {wanted} of that shape",
        )
    if method == "attached":
        return result
    result = result.astype(thing.dtype, copy=False)
    moved = result != thing
    if moved.any():
        _check_near(grid, rule, method, placements, step[0], result, moved)
    return result


def refusal(
    rule: Tool,
    method: str,
    problem: str,
    fix: str,
    placement: str = "",
) -> ValueError:
    """The error that names the tool, what is wrong, where, and the fix."""
    where = f" with {placement}" if placement else ""
    return ValueError(f"tool {name_of(rule)!r}: {method} {problem}{where}; {fix}")


def in_words(grid: Grid, placements: Placements, index: int, *step: int) -> str:
    """One of some placements in words, and the direction of the step."""
    agent, tool, thing = (grid.cell(cells[index]) for cells in placements)
    words = f"agent {agent}, tool {tool}, object {thing}"
    return f"{words}, {MOVES[grid.steps.index(step[0])]}" if step else words


def _check_near(
    grid: Grid,
    rule: Tool,
    method: Method,
    placements: Placements,
    step: int,
    result: Cells,
    moved: Flags,
) -> None:
    """Refuses an object that lands where the map's border may not reach."""
    target = result[moved]
    near = np.zeros(target.shape, bool)
    for cells in placements:
        away = target - cells[moved]
        # Within the border rows do not run into each other: this is the distance in both.
        corner = BORDER * grid.stride + BORDER
        columns = (away + corner) % grid.stride
        near |= (columns <= 2 * BORDER) & (away >= -corner) & (away <= corner)
    if not near.all():
        index = int(np.flatnonzero(moved)[np.argmin(near)])
        raise refusal(
            rule,
            method,
            f"puts the object at {grid.cell(result[index])}",
            f"let it land within {BORDER} rows and columns of the agent, the tool or where it was",
            in_words(grid, placements, index, step),
        )


def _unwritable(cells: Cells) -> Cells:
    view = np.asarray(cells).view()
    view.flags.writeable = False
    return view
