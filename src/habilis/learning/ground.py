"""What agents learn on: a table, where in it episodes begin, and the best that can be expected."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64, Int32, Int64

from habilis.learning.config import Config
from habilis.learning.starts import begun_anywhere
from habilis.mdp import TabularMDP
from habilis.transitions import Transitions
from habilis.worlds.plans import best_returns, distances, solve
from habilis.worlds.table import tabulate
from habilis.worlds.world import World

KEPT = 16
"""How many worlds are kept for the jobs that share them."""


class Conditions(NamedTuple):
    """What a configuration says of episodes that its map does not; see the fields of `Config`."""

    starts: int = 0
    unseen: int = 0
    starts_seed: int = 0
    slip: float = 0.0

    @classmethod
    def of(cls, config: Config) -> "Conditions":
        return cls(*(getattr(config, name) for name in cls._fields))


THE_MAPS = Conditions()


class Ground(NamedTuple):
    """A world's table, and the states in it that episodes begin from.

    Attributes:
        mdp: the table; its start is where the map has everything.
        seen: int64[n], those that training begins from.
        unseen: int64[m], those held out.
        shortest_return: of a shortest plan, the mean over those that training begins from; where
            the world is stochastic, of one in which no tool fails and no action slips.
    """

    mdp: TabularMDP
    seen: Int64[np.ndarray, "n"]
    unseen: Int64[np.ndarray, "m"]
    shortest_return: float


@lru_cache(KEPT)
def ground(world: World, conditions: Conditions = THE_MAPS) -> Ground:
    """What agents learn on.

    Args:
        world: the map.
        conditions: whether episodes begin where it has everything, or elsewhere, and whether
            actions slip.

    Returns:
        Its table, with all that can be reached from where episodes begin.

    Raises:
        ValueError: the goal is out of reach, from the map or from so many placements.
    """
    starts, unseen, seed, slip = conditions
    if starts:
        sure, states = begun_anywhere(world, starts + unseen, seed)
    else:
        sure = tabulate(world)
        states = np.array([sure.start])
    seen, held_out = states[: starts or 1], states[starts or 1 :]
    shortest = _shortest_return(sure, seen)
    if shortest is None:
        raise ValueError(f"{world.name}: the goal cannot be reached; open a way to it")
    return Ground(sure.slippery(slip), seen, held_out, shortest)


def _shortest_return(mdp: TabularMDP, starts: Int64[np.ndarray, "n"]) -> float | None:
    """The mean; `None` where there is a start from which there is no plan."""
    if len(starts) == 1 and not mdp.is_stochastic:
        plan = solve(mdp, int(starts[0]))
        return None if plan is None else plan.best_return
    steps = distances(mdp)[starts]
    return float(1 - steps.mean()) if (steps > 0).all() else None


def best_return(world: World, conditions: Conditions, limit: int) -> float:
    """What the best policy expects of an episode, the mean over where training begins.

    Args:
        world, conditions: as in `ground`.
        limit: how many steps an episode has, at most. Of a shortest plan, which is what is best
            in a deterministic world, all are counted.

    Returns:
        Extrinsic and undiscounted.

    Raises:
        ValueError: as in `ground`.
    """
    on = ground(world, conditions)
    if not on.mdp.is_stochastic:
        return on.shortest_return
    return float(expected_returns(world, conditions, limit)[on.seen].mean())


@lru_cache(KEPT)
def expected_returns(world: World, conditions: Conditions, limit: int) -> Float64[np.ndarray, "S"]:
    """What the best policy expects from every state, as in `best_returns`.

    Args:
        world, conditions, limit: as in `best_return`.
    """
    returns = best_returns(ground(world, conditions).mdp, limit)
    returns.flags.writeable = False
    return returns


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
        In a stochastic world, the mean probability.
    """
    transitions = Transitions.of(mdp)
    chosen = np.arange(mdp.states) * mdp.action_count + policy
    leads = transitions.next_state.reshape(-1, transitions.outcomes)[chosen]
    shares = transitions.probabilities[chosen]
    there = np.where(mdp.terminal, 1.0, 0.0)
    for _ in range(limit):
        before = there
        there = np.where(mdp.terminal, 1.0, (shares * before[leads]).sum(axis=1))
        if np.array_equal(there, before):
            break
    return float(there[states].mean())
