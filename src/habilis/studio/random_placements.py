"""Placements drawn at random, to estimate from what is too much to compute everywhere."""

import numpy as np

from habilis.worlds.grid import STEPS
from habilis.worlds.placements import Placement
from habilis.worlds.world import Cell, World

_TRIES = 8  # draws for each placement; most are good


def random_placements(world: World, count: int, seed: int = 0) -> list[Placement]:
    """Placements of those that averages go over, each as likely: with a tool, it is in hand.

    Args:
        world: the map.
        count: how many at most.
        seed: of the random numbers.

    Returns:
        The placements, for the same arguments the same.

    Raises:
        ValueError: the tool can never be in hand.
    """
    free = world.free_cells
    inside = set(free)
    held: list[tuple[Cell, ...]] = [(agent,) for agent in free]
    if world.tools:
        held = [(agent, tool) for agent in free for tool in _beside(agent) if tool in inside]
    if not held:
        raise ValueError("there is no room to hold the tool; leave two free cells side by side")
    random = np.random.default_rng(seed)
    draws = random.integers((len(held), len(free)), size=(_TRIES * count, 2))
    good = [(held[a], free[b]) for a, b in draws if free[b] not in held[a]]
    names = ("agent", "tool")
    return [dict(zip(names, hand, strict=False)) | {"object": at} for hand, at in good[:count]]


def _beside(cell: Cell) -> list[Cell]:
    return [(cell[0] + down, cell[1] + right) for down, right in STEPS]
