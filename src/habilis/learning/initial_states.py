"""Random placements that episodes begin in."""

from collections.abc import Iterator
from itertools import islice
from math import perm

import numpy as np
from jaxtyping import Int64

from habilis.mdp import TabularMDP
from habilis.worlds.placements import Factors, Placement, start_of
from habilis.worlds.plans import distances
from habilis.worlds.reach import reachable
from habilis.worlds.world import World


def random_initial_states(
    world: World, count: int, seed: int
) -> tuple[TabularMDP, Int64[np.ndarray, "count"]]:
    """A table with random placements from which the goal can be reached, and where they are in it.

    Args:
        world: the map.
        count: how many placements.
        seed: of the random numbers.

    Returns:
        The table of all that can be reached from them, or from the map's own placement, which is
        its start; and their states.

    Raises:
        ValueError: the goal cannot be reached from so many.
    """
    candidates, found = random_placements(world, seed), list[Placement]()
    while len(found) < count:
        batch = list(islice(candidates, count - len(found)))
        if not batch:
            raise ValueError(
                f"{world.name}: the goal can be reached from {len(found)} placements, not from "
                f"{count}; ask for fewer starts"
            )
        mdp, states = reachable(world, batch, None)
        found += [one for one, far in zip(batch, distances(mdp)[states], strict=True) if far > 0]
    mdp, states = reachable(world, [start_of(world), *found], None)
    return mdp, states[1:]


def random_placements(world: World, seed: int) -> Iterator[Placement]:
    """Tools and objects in random free cells, the agent where the map has it.

    Args:
        world: the map.
        seed: of the random numbers.

    Yields:
        Every placement once, in random order; in some the goal may be out of reach.
    """
    free = [cell for cell in world.free_cells if cell != world.agent]
    names = Factors.of(world).things
    random, met = np.random.default_rng(seed), set[tuple[int, ...]]()
    while len(met) < perm(len(free), len(names)):
        chosen = tuple(random.choice(len(free), len(names), replace=False).tolist())
        if chosen not in met:
            met.add(chosen)
            things = {name: free[place] for name, place in zip(names, chosen, strict=True)}
            yield {"agent": world.agent, **things}
