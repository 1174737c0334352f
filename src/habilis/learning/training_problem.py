"""The problem that agents learn: a table, the states episodes begin in, and the best return."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64, Int32, Int64

from habilis.learning.config import Config
from habilis.learning.initial_states import random_initial_states
from habilis.mdp import TabularMDP
from habilis.transitions import Transitions
from habilis.worlds.plans import best_returns, distances, solve
from habilis.worlds.table import tabulate
from habilis.worlds.world import World

KEPT = 16
"""How many worlds are kept for the jobs that share them."""


class Conditions(NamedTuple):
    """Settings of episodes besides their map; see the fields of `Config`."""

    starts: int = 0
    unseen: int = 0
    starts_seed: int = 0
    slip: float = 0.0

    @classmethod
    def of(cls, config: Config) -> "Conditions":
        return cls(*(getattr(config, name) for name in cls._fields))


DEFAULT_CONDITIONS = Conditions()
"""Episodes begin where the map has everything, and no action slips."""


class TrainingProblem(NamedTuple):
    """A world's table, and the states in it that episodes begin in.

    Attributes:
        mdp: the table; its start is where the map has everything.
        seen: int64[n], those that episodes of training begin in.
        unseen: int64[m], those held out.
        shortest_return: of a shortest plan, the mean over those of training; where
            the world is stochastic, of one in which no tool fails and no action slips.
    """

    mdp: TabularMDP
    seen: Int64[np.ndarray, "n"]
    unseen: Int64[np.ndarray, "m"]
    shortest_return: float


@lru_cache(KEPT)
def training_problem(world: World, conditions: Conditions = DEFAULT_CONDITIONS) -> TrainingProblem:
    """The problem of a world under some conditions.

    Args:
        world: the map.
        conditions: whether episodes begin where it has everything, or elsewhere, and whether
            actions slip.

    Returns:
        Its table, with all that can be reached from where episodes begin.

    Raises:
        ValueError: the goal is unreachable, from the map or from so many placements.
    """
    starts, unseen, seed, slip = conditions
    if starts:
        sure, states = random_initial_states(world, starts + unseen, seed)
    else:
        sure = tabulate(world)
        states = np.array([sure.start])
    seen, held_out = states[: starts or 1], states[starts or 1 :]
    shortest = _shortest_return(sure, seen)
    if shortest is None:
        raise ValueError(f"{world.name}: the goal cannot be reached; open a way to it")
    return TrainingProblem(sure.slippery(slip), seen, held_out, shortest)


def _shortest_return(mdp: TabularMDP, starts: Int64[np.ndarray, "n"]) -> float | None:
    """The mean; `None` where there is a start from which there is no plan."""
    if len(starts) == 1 and not mdp.is_stochastic:
        plan = solve(mdp, int(starts[0]))
        return None if plan is None else plan.best_return
    steps = distances(mdp)[starts]
    return float(1 - steps.mean()) if (steps > 0).all() else None


def best_return(world: World, conditions: Conditions, limit: int) -> float:
    """The expected return of the best policy, the mean over the initial states of training.

    Args:
        world, conditions: as in `training_problem`.
        limit: how many steps an episode has, at most. In a deterministic world it does not
            count: the return is that of a shortest plan.

    Returns:
        Extrinsic and undiscounted.

    Raises:
        ValueError: as in `training_problem`.
    """
    problem = training_problem(world, conditions)
    if not problem.mdp.is_stochastic:
        return problem.shortest_return
    return float(expected_returns(world, conditions, limit)[problem.seen].mean())


@lru_cache(KEPT)
def expected_returns(world: World, conditions: Conditions, limit: int) -> Float64[np.ndarray, "S"]:
    """The expected return of the best policy from every state, as in `best_returns`.

    Args:
        world, conditions, limit: as in `best_return`.
    """
    returns = best_returns(training_problem(world, conditions).mdp, limit)
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
