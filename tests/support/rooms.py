"""Worlds of one object and at most one tool, at random and by the cells of their things."""

from collections.abc import Callable, Sequence
from itertools import product

from hypothesis import strategies as st

from habilis.worlds.things import CAN, PlacedObject, PlacedTool
from habilis.worlds.tools import OURS, Reading
from habilis.worlds.world import World

TOOLS = ("picker", "broom", "none")


@st.composite
def rooms(
    draw: st.DrawFn,
    sizes: Sequence[tuple[int, int]],
    most_walls: Callable[[int], int],
    tools: Sequence[str] = TOOLS,
    readings: st.SearchStrategy[Reading] | None = None,
) -> World:
    """A map of one of some sizes, with walls in some of the cells that nothing else is in.

    Args:
        draw: given by Hypothesis.
        sizes: rows and columns.
        most_walls: from the number of these cells to that of walls at most.
        tools: one of which it has.
        readings: of the rules for the tool.
    """
    height, width = draw(st.sampled_from(sizes))
    cells = draw(st.permutations(list(product(range(height), range(width)))))
    agent, can, goal, tool, *others = cells
    walls = frozenset(others[: draw(st.integers(0, most_walls(len(others))))])
    reading = OURS if readings is None else draw(readings)
    picker = PlacedTool("picker", tool, reading=reading)
    things = (PlacedObject(CAN, can, goal),)
    world = World("random", height, width, walls, agent, things, (picker,))
    return world.with_tool(draw(st.sampled_from(tools)))


def sizes(heights: range, widths: range) -> list[tuple[int, int]]:
    """All of some heights and widths."""
    return list(product(heights, widths))
