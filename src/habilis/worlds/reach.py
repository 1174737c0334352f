"""The part of a world's table that can be reached from given placements."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Int64
from numpy.typing import ArrayLike

from habilis.mdp import TabularMDP
from habilis.progress import progress_bar
from habilis.worlds.described import actions_of, describe
from habilis.worlds.placements import WANTED, Keys, Packing, Placement, places_of
from habilis.worlds.rules import Grid, Kinds, Places, successor, taken_up
from habilis.worlds.world import World

MAX_STATES = 50_000_000


class TooManyPlacementsError(ValueError):
    """More placements can be reached than are accepted."""


_BLOCK = 1 << 13  # placements moved at once: the arrays of one block stay in the cache


def reachable(
    world: World,
    placements: "Placement | Sequence[Placement] | Places | ArrayLike",
    horizon: int | None,
    max_states: int = MAX_STATES,
    show_progress: bool = False,
) -> tuple[TabularMDP, Int64[np.ndarray, "n"]]:
    """Enumerates what h actions from some placements can reach, breadth first.

    Args:
        world: the map.
        placements: where everything is, once or several times; any distinct free cells, also where
            tools lie elsewhere than on the map. The first tool beside the agent is in hand, unless
            "held" says another. Or such placements as arrays, already checked.
        horizon: h, in actions; `None` for all that can ever be reached.
        max_states: how many placements to accept.
        show_progress: whether to draw a progress bar on standard error.

    Returns:
        A table with the same factors and flags as `tabulate` gives, whose states reached last stay
        where they are; and the states of the placements asked about, the first of which is its
        start.

    Raises:
        ValueError: a placement that is none, or more states than max_states.

    Example:
        >>> from habilis.worlds.world import World
        >>> line = World.parse("A.C..G", name="line")
        >>> mdp, asked = reachable(line, [{"agent": (0, 0), "object": (0, 2)}], horizon=2)
        >>> mdp.states
        3
    """
    # Numba takes as long to import as everything else together: only who needs it pays.
    from habilis.worlds.interning import Interned

    ways = [True, False] if any(tool.slip for tool in world.tools) else [True]
    rows: list[np.ndarray] = []
    done = level = 0
    with progress_bar("placements", show_progress) as tell:  # reading a large map takes time too
        grid = Grid.of(world)
        packing = Packing.of(world, grid)
        if not isinstance(placements, Places):
            placements = places_of(world, grid, _listed(placements))
        asked = packing.packed(placements)
        found = Interned()
        found.add(asked)
        while done < len(found) and (horizon is None or level < horizon):
            frontier = len(found)
            for first in range(done, frontier, _BLOCK):
                keys = found.keys[first : min(first + _BLOCK, frontier)]
                after = _after(world, grid, packing, keys, ways)
                rows.append(found.add(after.ravel()).reshape(after.shape))
                if len(found) > max_states:
                    raise too_many(world, horizon, max_states)
                tell(first + len(keys), len(found))
            done, level = frontier, level + 1
    known = found.keys
    order = np.argsort(known)
    rank = np.empty(len(known), np.int32)
    rank[order] = np.arange(len(known), dtype=np.int32)
    shape = len(known), len(ways), len(actions_of(world))
    leads = np.empty(shape, np.int32)
    leads[:] = np.arange(len(known))[:, None, None]
    if rows:
        leads[rank[:done]] = rank[np.concatenate(rows)]
    states = rank[found.add(asked)].astype(np.int64)
    failing = np.ascontiguousarray(leads[:, 1]) if len(ways) > 1 else None
    return (
        describe(
            world,
            grid,
            packing.unpacked(grid, known[order]),
            np.ascontiguousarray(leads[:, 0]),
            int(states[0]) if len(states) else 0,
            failing,
        ),
        states,
    )


def _listed(placements: Any) -> list[Any]:
    if isinstance(placements, Mapping):
        return [placements]
    if isinstance(placements, Sequence) and not isinstance(placements, str):
        return list(placements)
    raise ValueError(WANTED.format(placements))


def _after(
    world: World, grid: Grid, packing: Packing, keys: Keys, ways: list[bool]
) -> Int64[np.ndarray, "states ways A"]:
    """Where each action leads from each placement, if the tool works and if it fails."""
    at, kinds = packing.unpacked(grid, keys), Kinds.of(world)
    actions = range(len(actions_of(world)))
    return np.stack(
        [
            np.stack(
                [
                    packing.packed(taken_up(grid, successor(grid, kinds, action, at, works)))
                    for action in actions
                ],
                axis=1,
            )
            for works in ways
        ],
        axis=1,
    )


def too_many(world: World, horizon: int | None, max_states: int) -> TooManyPlacementsError:
    """The error that says how many placements there are, and what to do."""
    if horizon is None:
        return TooManyPlacementsError(
            f"{world.name}: more than {max_states:,} placements can be reached; take things away "
            "or make the map smaller"
        )
    return TooManyPlacementsError(
        f"{world.name}: {horizon} actions reach more than {max_states:,} placements; "
        "ask for a lower horizon"
    )
