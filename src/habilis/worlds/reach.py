"""The part of a world's table that can be reached from given placements."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import prod
from typing import Any

import numpy as np
from jaxtyping import Int64, Integer
from numpy.typing import ArrayLike

from habilis.mdp import TabularMDP
from habilis.progress import progress_bar
from habilis.worlds.placements import WANTED, Placement, actions_of, describe, places_of
from habilis.worlds.rules import NONE, Kinds, Places, successor, taken_up
from habilis.worlds.world import World

MAX_STATES = 50_000_000
Keys = Int64[np.ndarray, "states"]


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

    ways = [True, False] if world.may_fail else [True]
    rows: list[np.ndarray] = []
    done = level = 0
    with progress_bar("placements", show_progress) as report:  # reading a large map takes time too
        packing = Packing.of(world)
        if not isinstance(placements, Places):
            placements = places_of(world, _listed(placements))
        asked = packing.packed(placements)
        found = Interned()
        found.add(asked)
        while done < len(found) and (horizon is None or level < horizon):
            frontier = len(found)
            for first in range(done, frontier, _BLOCK):
                keys = found.keys[first : min(first + _BLOCK, frontier)]
                after = _after(world, packing, keys, ways)
                rows.append(found.add(after.ravel()).reshape(after.shape))
                if len(found) > max_states:
                    raise too_many(world, horizon, max_states)
                report(first + len(keys), len(found))
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
            packing.unpacked(known[order]),
            np.ascontiguousarray(leads[:, 0]),
            int(states[0]) if len(states) else 0,
            failing,
        ),
        states,
    )


@dataclass(frozen=True)
class Packing:
    """Each placement as one number, in the order of its cells.

    Attributes:
        free: the cells of the map that are no walls.
        rank: of each cell among them.
        tools, objects: how many there are.
        drop: whether tools may be put down.
    """

    free: Integer[np.ndarray, "free"]
    rank: Integer[np.ndarray, "cells"]
    tools: int
    objects: int
    drop: bool

    @classmethod
    def of(cls, world: World) -> "Packing":
        """The packing of a world.

        Raises:
            ValueError: there are too many things for so large a map.
        """
        free = world.grid.free
        rank = np.full(len(world.grid.wall), -1)
        rank[free] = np.arange(len(free))
        counts = len(world.tools), len(world.objects)
        packing = cls(free, rank, *counts, world.drop)
        if prod(packing._bases) >= 2**63:
            raise ValueError(
                f"{world.name}: {sum(counts)} things on {len(free)} free cells have more "
                "placements than can be numbered; remove things, or make the map smaller"
            )
        return packing

    @property
    def _bases(self) -> list[int]:
        cells = [len(self.free)] * (1 + self.tools + self.objects)
        return cells + [self.tools + 1] * (1 + self.drop)

    def packed(self, at: Places) -> Keys:
        hands = (at.held,) if at.laid is None else (at.held, at.laid)
        digits = [*(self.rank[cells] for cells in at.cells), *(hand - NONE for hand in hands)]
        keys = np.zeros(at.agent.shape, np.int64)
        for base, digit in zip(self._bases, digits, strict=True):
            keys = keys * base + digit
        return keys

    def unpacked(self, keys: Keys) -> Places:
        digits = []
        for base in reversed(self._bases):
            keys, digit = np.divmod(keys, base)
            digits.append(digit)
        digits.reverse()
        cells = [self.free[digit] for digit in digits[: 1 + self.tools + self.objects]]
        hands = [digit + NONE for digit in digits[len(cells) :]]
        agent, tools, objects = cells[0], cells[1 : 1 + self.tools], cells[1 + self.tools :]
        return Places(agent, tuple(tools), tuple(objects), *hands)


def _listed(placements: Any) -> list[Any]:
    if isinstance(placements, Mapping):
        return [placements]
    if isinstance(placements, Sequence) and not isinstance(placements, str):
        return list(placements)
    raise ValueError(WANTED.format(placements))


def _after(
    world: World, packing: Packing, keys: Keys, ways: list[bool]
) -> Int64[np.ndarray, "states ways A"]:
    """The keys that each action leads to from each placement, if the tool works and if it fails."""
    at, grid, kinds = packing.unpacked(keys), world.grid, Kinds.of(world)
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
            f"{world.name}: more than {max_states:,} placements can be reached; remove things, "
            "or make the map smaller"
        )
    return TooManyPlacementsError(
        f"{world.name}: {horizon} actions reach more than {max_states:,} placements; "
        "ask for a lower horizon"
    )
