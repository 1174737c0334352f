"""Rules of worlds with several things, as pictures: a map before and after some actions."""

import numpy as np
from before_after import in_all_orientations

from habilis.mdp import TabularMDP
from habilis.worlds.placements import start_of
from habilis.worlds.table import placement, tabulate
from habilis.worlds.world import World

GOAL = "\nH = goal of C"


def becomes(pictures: str, *actions: str, above: str = "", works: bool = True) -> None:
    """Asserts that the map on the left becomes, by the actions in turn, the one on the right.

    The pictures must hold turned and mirrored too. In maps of one object the goal may be left out:
    then it is in a corner behind a wall.

    Args:
        pictures: the maps side by side, a row a line.
        actions: by their names.
        above: what stands above the maps.
        works: whether the tool does what it does; of tools that may fail.
    """
    pairs = [line.split() for line in pictures.strip().splitlines()]
    before, after = (tuple(rows) for rows in zip(*pairs, strict=True))
    for start, plan, end in in_all_orientations(before, actions, after):
        world, wanted = (World.parse("\n".join([above, *fenced(rows)])) for rows in (start, end))
        found = played(world, plan, works)
        assert found == start_of(wanted), f"{plan} of\n" + "\n".join(start)


def fenced(rows: tuple[str, ...]) -> list[str]:
    """The map with a goal somewhere outside, which nothing can be brought to."""
    if any("G" in row for row in rows):
        return list(rows)
    width = len(rows[0])
    return [*rows, "#" * width, "G" + "#" * (width - 1)]


def stays(picture: str, *actions: str, above: str = "") -> None:
    """Asserts that nothing on the map changes by any of the actions."""
    for action in actions:
        becomes("\n".join(f"{row} {row}" for row in picture.split()), action, above=above)


def played(world: World, actions: tuple[str, ...], works: bool = True):
    """Where everything is after the actions."""
    mdp = tabulate(world, starts=[start_of(world)])
    state = mdp.start
    for action in actions:
        state = led(mdp, state, mdp.actions.index(action), works)
    return start_of(placement(world, mdp, state))


def led(mdp: TabularMDP, state: int, action: int, works: bool = True) -> int:
    """The next state; the more or the less probable one of two."""
    if not mdp.is_stochastic:
        return int(mdp.next_state[state, action])
    row = mdp.transition(action)[[state]]
    order = np.argsort(row.data)
    return int(row.indices[order[-1] if works else order[0]])
