"""Rules as pictures: a map before and after some actions."""

from collections.abc import Iterator

from habilis.mdp import TabularMDP
from habilis.worlds.table import tabulate
from habilis.worlds.world import Cell, World

SIDES = ("north", "east", "south", "west")
STEPS = ((-1, 0), (0, 1), (1, 0), (0, -1))

Rows = tuple[str, ...]


def becomes(pictures: str, *actions: str, above: str = "") -> None:
    """Asserts that the map on the left becomes, by the actions in turn, the one on the right.

    Rules know no direction, so the picture must hold turned and mirrored too: eight times. `T`
    in it stands for picker and broom alike.

    Args:
        pictures: the maps side by side, a row a line.
        actions: by their names.
        above: what stands above the maps, such as a line that binds a character to a tool.
    """
    pairs = [line.split() for line in pictures.strip().splitlines()]
    before, after = (tuple(rows) for rows in zip(*pairs, strict=True))
    for tool in "PB" if "T" in pictures else "T":
        first = tuple(row.replace("T", tool) for row in before)
        last = tuple(row.replace("T", tool) for row in after)
        for start, plan, end in in_all_orientations(first, actions, last):
            played = play(World.parse("\n".join([above, *start])), plan)
            assert beside(start, played, plan) == beside(start, end, plan)


def stays(picture: str, *actions: str, above: str = "") -> None:
    """Asserts that nothing on the map changes by any of the actions."""
    rows = picture.split()
    for action in actions:
        becomes("\n".join(f"{row} {row}" for row in rows), action, above=above)


def play(world: World, actions: tuple[str, ...]) -> Rows:
    """The map after the actions."""
    mdp = tabulate(world)
    state = find(mdp, world)
    for action in actions:
        state = mdp.next_state[state, mdp.actions.index(action)]
    return drawn(world, {name: cell_of(mdp, name, state) for name in mdp.factors})


def find(mdp: TabularMDP, world: World) -> int:
    cells = {"agent": world.agent, "object": world.object}
    if world.tool_cell is not None:
        cells["tool"] = world.tool_cell
    return mdp.find(**cells)


def cell_of(mdp: TabularMDP, factor: str, state: int) -> Cell:
    assert mdp.shape is not None
    row, column = divmod(int(mdp.factor(factor)[state]), mdp.shape[1])
    return row, column


def drawn(world: World, cells: dict[str, Cell]) -> Rows:
    """The map with its things at the given cells."""
    grid = [["."] * world.width for _ in range(world.height)]
    for row, column in world.walls:
        grid[row][column] = "#"
    characters = {"agent": "A", "object": "C"}
    if world.tools:
        characters["tool"] = world.tools[0].rule.character
    marks = [(world.goal, "G"), *((cells[name], mark) for name, mark in characters.items())]
    for (row, column), mark in marks:
        grid[row][column] = mark
    return tuple("".join(row) for row in grid)


def beside(left: Rows, right: Rows, actions: tuple[str, ...]) -> str:
    rows = (f"{one}   {other}" for one, other in zip(left, right, strict=True))
    return "\n".join([", ".join(actions), *rows])


def in_all_orientations(
    before: Rows, actions: tuple[str, ...], after: Rows
) -> Iterator[tuple[Rows, tuple[str, ...], Rows]]:
    for mirrored in (False, True):
        for turns in range(4):
            yield (
                oriented(before, turns, mirrored),
                tuple(oriented_action(action, turns, mirrored) for action in actions),
                oriented(after, turns, mirrored),
            )


def oriented(rows: Rows, turns: int, mirrored: bool) -> Rows:
    """Mirrored left to right if so, then turned clockwise."""
    if mirrored:
        rows = tuple(row[::-1] for row in rows)
    for _ in range(turns):
        rows = tuple("".join(column) for column in zip(*rows[::-1], strict=True))
    return rows


def oriented_action(action: str, turns: int, mirrored: bool) -> str:
    side = action.split()[-1]
    if mirrored and side in ("east", "west"):
        side = "west" if side == "east" else "east"
    turned = SIDES[(SIDES.index(side) + turns) % 4]
    return f"tool {turned}" if action.startswith("tool") else turned
