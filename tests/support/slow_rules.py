"""The rules of worlds with several things once more: slowly, one placement at a time, in sets of
coordinates, with nothing in common with the rules over arrays.
"""

from dataclasses import dataclass, replace

from hypothesis import strategies as st

import habilis as hb
from habilis.mdp import TabularMDP

Cell = tuple[int, int]
WAYS = {"north": (-1, 0), "east": (0, 1), "south": (1, 0), "west": (0, -1)}


@dataclass(frozen=True)
class State:
    agent: Cell
    tools: tuple[Cell, ...]
    objects: tuple[Cell, ...]
    held: int | None
    laid: int | None


@st.composite
def worlds(draw: st.DrawFn) -> hb.World:
    """Small maps with up to two tools and two objects, several of something."""
    height, width = draw(st.integers(2, 4)), draw(st.integers(3, 4))
    tools = draw(
        st.lists(st.sampled_from(["picker", "broom", "rake", "stick", "magnet"]), max_size=2)
    )
    kinds = draw(st.lists(st.sampled_from(["can", "ball", "crate"]), min_size=1, max_size=2))
    drop = draw(st.booleans())
    if len(tools) < 2 and len(kinds) < 2 and not drop:
        kinds = [*kinds, "ball"]
    count = 2 + len(tools) + len(kinds)
    cells = draw(st.permutations([(r, c) for r in range(height) for c in range(width)]))
    things, others = cells[:count], cells[count:]
    walls = others[: draw(st.integers(0, len(others) // 2))]
    rows = [["."] * width for _ in range(height)]
    for row, column in walls:
        rows[row][column] = "#"
    marks = "AG" + "CD"[: len(kinds)] + "TU"[: len(tools)]
    for mark, (row, column) in zip(marks, things, strict=True):
        rows[row][column] = mark
    above = ["G = goal of C", *(f"{m} = {k}" for m, k in zip("CD", kinds, strict=False))]
    above += [f"{m} = {k}" for m, k in zip("TU", tools, strict=False)]
    above += ["drop: true"] if drop else []
    return hb.World.parse("\n".join([*above, *("".join(row) for row in rows)]))


def read(world: hb.World, mdp: TabularMDP, state: int) -> State:
    """A state of the table."""

    def cells(prefix: str) -> tuple[Cell, ...]:
        names = [name for name in mdp.factors if name.startswith(prefix)]
        return tuple(divmod(int(mdp.factors[name][state]), world.width) for name in names)

    def which(name: str) -> int | None:
        value = int(mdp.factors[name][state]) if name in mdp.factors else -1
        return None if value < 0 else value

    (agent,) = cells("agent")
    return State(agent, cells("tool:"), cells("object:"), which("held"), which("laid"))


def by_the_rules(world: hb.World, at: State, action: str) -> State:
    """The state after an action."""
    to = moved(world, at, action)
    laid = to.laid
    if laid is not None and not beside(to.agent, to.tools[laid]):
        laid = None
    held = to.held
    if held is None:
        near = [k for k, cell in enumerate(to.tools) if beside(to.agent, cell) and k != laid]
        held = near[0] if near else None
    return replace(to, held=held, laid=laid)


def moved(world: hb.World, at: State, action: str) -> State:
    if action == "drop":
        return at if at.held is None else replace(at, held=None, laid=at.held)
    way = WAYS[action.split()[-1]]
    carried = not action.startswith("tool")
    tools, objects = list(at.tools), list(at.objects)
    agent = plus(at.agent, way) if carried else at.agent
    if at.held is not None:
        tools[at.held] = plus(at.tools[at.held], way) if carried else plus(at.agent, way)
    for k, cell in enumerate(at.objects):
        objects[k] = after_tool(world, at, tools, k, way, carried)
        if carried and agent == cell:
            objects[k] = plus(cell, way)
    everything = [agent, *tools, *objects]
    if len(set(everything)) < len(everything) or not all(is_floor(world, c) for c in everything):
        return at
    for k, thing in enumerate(world.objects):
        if thing.kind == "ball" and objects[k] != at.objects[k] and not gripped(world, at, k):
            going = minus(objects[k], at.objects[k])
            while is_floor(world, ahead := plus(objects[k], going)) and ahead not in {
                agent,
                *tools,
                *objects,
            }:
                objects[k] = ahead
    return State(agent, tuple(tools), tuple(objects), at.held, at.laid)


def after_tool(
    world: hb.World, at: State, tools: list[Cell], k: int, way: Cell, carried: bool
) -> Cell:
    """Where the tool in hand brings an object."""
    cell, kind = at.objects[k], world.objects[k].kind
    if at.held is None:
        return cell
    name, tool = world.tools[at.held].kind, at.tools[at.held]
    out = minus(tool, at.agent)  # the way in which the tool is held
    if name == "picker" and gripped(world, at, k):
        return plus(cell, way) if carried else plus(plus(at.agent, way), way)
    if name in ("broom", "stick") and carried:
        ends = [tool, plus(tool, out)] if name == "stick" else [tool]
        return plus(cell, way) if cell in [plus(end, way) for end in ends] else cell
    if kind == "crate":
        return cell
    if name == "rake" and carried and cell == plus(tool, out) and way == minus((0, 0), out):
        return plus(cell, way)
    if name == "magnet" and not carried:
        others = {*at.objects, *(t for j, t in enumerate(at.tools) if j != at.held)}
        seen = plus(tools[at.held], way)
        while is_floor(world, seen) and seen not in others:
            seen = plus(seen, way)
        first = plus(tools[at.held], way)
        return minus(cell, way) if seen == cell and cell != first else cell
    return cell


def gripped(world: hb.World, at: State, k: int) -> bool:
    if at.held is None or world.tools[at.held].kind != "picker":
        return False
    tool = at.tools[at.held]
    in_line = at.objects[k] == plus(tool, minus(tool, at.agent))
    return in_line and world.objects[k].kind != "crate"


def is_floor(world: hb.World, cell: Cell) -> bool:
    inside = 0 <= cell[0] < world.height and 0 <= cell[1] < world.width
    return inside and cell not in world.walls


def beside(one: Cell, other: Cell) -> bool:
    return abs(one[0] - other[0]) + abs(one[1] - other[1]) == 1


def plus(one: Cell, other: Cell) -> Cell:
    return one[0] + other[0], one[1] + other[1]


def minus(one: Cell, other: Cell) -> Cell:
    return one[0] - other[0], one[1] - other[1]
