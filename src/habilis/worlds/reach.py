"""The part of a world's table that can be reached from given placements."""

from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np
from jaxtyping import Int64
from numpy.typing import ArrayLike

from habilis.mdp import TabularMDP
from habilis.models.limits import Limits, TooManyStatesError
from habilis.progress import progress_bar
from habilis.worlds.placements import WANTED, Placement, actions_of, describe, places_of
from habilis.worlds.rules import Kinds, Places, successor, taken_up
from habilis.worlds.two_agents import reachable_by_two
from habilis.worlds.world import World

MAX_STATES = 50_000_000
Rows = Int64[np.ndarray, "n k"]


class TooManyPlacementsError(TooManyStatesError):
    """More placements can be reached than are accepted."""


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
    if world.second is not None:
        if isinstance(placements, Places):
            raise ValueError(f"{world.name} has two agents; give placements by name")
        listed = _listed(placements)
        return reachable_by_two(world, listed, horizon, max_states, show_progress)
    # Numba takes as long to import as everything else together: only who needs it pays.
    from habilis.models.rows import reach_rows

    ways = [True, False] if world.may_fail else [True]
    actions = len(actions_of(world))
    with progress_bar("placements", show_progress) as report:  # reading a large map takes time too
        if not isinstance(placements, Places):
            placements = places_of(world, _listed(placements))
        asked = _rows(placements)
        try:
            found = reach_rows(
                lambda rows: (_after(world, rows, ways), None),
                *(len(ways) * actions, asked, Limits(horizon, max_states), report),
            )
        except TooManyStatesError:
            raise too_many(world, horizon, max_states) from None
    order = found.found.order()  # by the cells of all things, whatever was met first
    count, expanded = len(order), len(found.next_state)
    rank = np.empty(count, np.int32)
    rank[order] = np.arange(count, dtype=np.int32)
    leads = np.empty((count, len(ways), actions), np.int32)
    leads[:] = np.arange(count)[:, None, None]
    leads[rank[:expanded]] = rank[found.next_state].reshape(-1, len(ways), actions)
    states = rank[found.found.find(asked)].astype(np.int64)
    failing = np.ascontiguousarray(leads[:, 1]) if len(ways) > 1 else None
    return (
        describe(
            world,
            _places(world, found.take(order)),
            np.ascontiguousarray(leads[:, 0]),
            int(states[0]) if len(states) else 0,
            failing,
        ),
        states,
    )


def _rows(at: Places) -> Rows:
    """Placements, one a row: all cells, and what is in hand and was put down."""
    hands = (at.held,) if at.laid is None else (at.held, at.laid)
    return np.stack([*at.cells, *hands], axis=1).astype(np.int64, copy=False)


def _places(world: World, rows: Rows) -> Places:
    """The placements of some rows."""
    columns = list(np.ascontiguousarray(rows.T))
    tools = 1 + len(world.tools)
    things = tools + len(world.objects)
    return Places(
        columns[0], tuple(columns[1:tools]), tuple(columns[tools:things]), *columns[things:]
    )


def _listed(placements: Any) -> list[Any]:
    if isinstance(placements, Mapping):
        return [placements]
    if isinstance(placements, Sequence) and not isinstance(placements, str):
        return list(placements)
    raise ValueError(WANTED.format(placements))


def _after(world: World, rows: Rows, ways: list[bool]) -> Int64[np.ndarray, "states branches k"]:
    """Where each action leads from each placement, if the tool works and if it fails."""
    at, grid, kinds = _places(world, rows), world.grid, Kinds.of(world)
    actions = range(len(actions_of(world)))
    after = np.empty((len(rows), len(ways) * len(actions), rows.shape[1]), np.int64)
    for branch, (works, action) in enumerate(product(ways, actions)):
        after[:, branch] = _rows(taken_up(grid, successor(grid, kinds, action, at, works)))
    return after


def too_many(world: World, horizon: int | None, max_states: int) -> TooManyPlacementsError:
    """The error that says how many placements there are, and what to do."""
    if horizon is None:
        return TooManyPlacementsError(
            f"{world.name}: more than {max_states:,} placements can be reached; remove things, "
            "or make the map smaller"
        )
    return TooManyPlacementsError(
        f"{world.name}: {horizon} actions reach more than {max_states:,} placements; "
        "ask for a lower horizon"
    )
