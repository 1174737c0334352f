"""Where episodes begin: where the map has everything, or in random placements."""

from collections.abc import Iterator
from functools import lru_cache
from itertools import islice
from math import perm
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64, Int32, Int64

from habilis.learning.config import Config
from habilis.mdp import TabularMDP
from habilis.worlds.chance import Chance
from habilis.worlds.moving import free_cells
from habilis.worlds.placements import Placement, object_factors, start_of, tool_factors
from habilis.worlds.plans import best_returns, distances, solve
from habilis.worlds.reach import reachable
from habilis.worlds.table import tabulate
from habilis.worlds.world import World

KEPT = 16
"""How many worlds are kept for the jobs that share them."""


class Begins(NamedTuple):
    """Which placements episodes begin from; see the fields of `Config`."""

    starts: int = 0
    unseen: int = 0
    seed: int = 0

    @classmethod
    def of(cls, config: Config) -> "Begins":
        return cls(config.starts, config.unseen, config.starts_seed)


THE_MAPS = Begins()


class Ground(NamedTuple):
    """A world's table, and the states in it that episodes begin from.

    Attributes:
        mdp: the table; its start is where the map has everything.
        seen: int64[n], those that training begins from.
        unseen: int64[m], those held out.
        shortest_return: of a shortest plan, the mean over those that training begins from; where
            tools may fail, of one in which they do not.
    """

    mdp: TabularMDP
    seen: Int64[np.ndarray, "n"]
    unseen: Int64[np.ndarray, "m"]
    shortest_return: float


@lru_cache(KEPT)
def ground(world: World, begins: Begins = THE_MAPS) -> Ground:
    """What agents learn on.

    Args:
        world: the map.
        begins: whether episodes begin where it has everything, or elsewhere.

    Returns:
        Its table, with all that can be reached from where episodes begin.

    Raises:
        ValueError: the goal is out of reach, from the map or from so many placements.
    """
    if not begins.starts:
        mdp = tabulate(world)
        steps = _least_steps(mdp)
        if steps is None:
            raise ValueError(f"{world.name}: the goal cannot be reached; open a way to it")
        return Ground(mdp, np.array([mdp.start]), np.empty(0, np.int64), 1.0 - steps)
    wanted = begins.starts + begins.unseen
    candidates, found = random_placements(world, begins.seed), list[Placement]()
    while len(found) < wanted:
        batch = list(islice(candidates, wanted - len(found)))
        if not batch:
            raise ValueError(
                f"{world.name}: the goal can be reached from {len(found)} placements, not from "
                f"{wanted}; ask for fewer starts"
            )
        mdp, states = reachable(world, batch, None)
        found += [one for one, far in zip(batch, distances(mdp)[states], strict=True) if far > 0]
    mdp, states = reachable(world, [start_of(world), *found], None)
    seen, unseen = states[1 : 1 + begins.starts], states[1 + begins.starts :]
    return Ground(mdp, seen, unseen, float(1 - distances(mdp)[seen].mean()))


def _least_steps(mdp: TabularMDP) -> int | None:
    """From a table's start to a terminal state, with luck where chance has a say."""
    if mdp.is_stochastic:
        far = int(distances(mdp)[mdp.start])
        return far if far > 0 else None
    plan = solve(mdp)
    return None if plan is None else plan.steps


def best_return(world: World, begins: Begins, limit: int) -> float:
    """What the best policy expects to get in an episode, the mean over where training begins.

    Args:
        world, begins: as in `ground`.
        limit: how many steps an episode has, at most; of a shortest plan, which is what is best
            where nothing is left to chance, all are counted.

    Returns:
        Extrinsic and undiscounted.

    Raises:
        ValueError: as in `ground`.
    """
    on = ground(world, begins)
    if on.mdp.is_stochastic:
        return float(expected_returns(world, begins, limit)[on.seen].mean())
    return on.shortest_return


@lru_cache(KEPT)
def expected_returns(world: World, begins: Begins, limit: int) -> Float64[np.ndarray, "S"]:
    """What the best policy expects from every state, as in `best_returns`.

    Args:
        world, begins, limit: as in `best_return`.
    """
    returns = best_returns(ground(world, begins).mdp, limit)
    returns.flags.writeable = False
    return returns


def random_placements(world: World, seed: int) -> Iterator[Placement]:
    """Tools and objects in random free cells, the agent where the map has it.

    Args:
        world: the map.
        seed: of the random numbers.

    Yields:
        Every placement once, in random order; in some the goal may be out of reach.
    """
    free = [cell for cell in free_cells(world) if cell != world.agent]
    names = [*tool_factors(world), *object_factors(world)]
    random, met = np.random.default_rng(seed), set[tuple[int, ...]]()
    while len(met) < perm(len(free), len(names)):
        chosen = tuple(random.choice(len(free), len(names), replace=False).tolist())
        if chosen not in met:
            met.add(chosen)
            things = {name: free[place] for name, place in zip(names, chosen, strict=True)}
            yield {"agent": world.agent, **things}


def success_rate(
    mdp: TabularMDP, policy: Int32[np.ndarray, "S"], states: Int64[np.ndarray, "n"], limit: int
) -> float:
    """The share of states from which a policy gets to a terminal one.

    Args:
        mdp: a world's table.
        policy: the action in every state.
        states: where it begins.
        limit: of how many actions.

    Returns:
        Where chance has a say, the mean probability.
    """
    chance = Chance.in_any(mdp)
    chosen = np.arange(mdp.states) * mdp.action_count + policy
    leads, shares = chance.next_state[chosen], chance.shares[chosen]
    there = np.where(mdp.terminal, 1.0, 0.0)
    for _ in range(limit):
        before = there
        there = np.where(mdp.terminal, 1.0, (shares * before[leads]).sum(axis=1))
        if np.array_equal(there, before):
            break
    return float(there[states].mean())
