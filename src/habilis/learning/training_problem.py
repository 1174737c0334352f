"""The problem that agents learn: a table, the states episodes begin in, and the best return."""

from dataclasses import fields, replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float64, Int32, Int64

from habilis.learning.config import Config
from habilis.learning.convergence import MARGIN
from habilis.learning.initial_states import random_initial_states
from habilis.learning.sources import NamedTable, Source, source_of
from habilis.mdp import TabularMDP
from habilis.transitions import Transitions
from habilis.worlds.plans import best_returns, distances, policy_returns, solve
from habilis.worlds.table import tabulate

_SHARE, _GAIN = 0.05, 2.0
_NOTHING = 1e-9

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
            the world is stochastic, of one in which no tool fails and no action slips. NaN of a
            table, whose rewards may be any.
    """

    mdp: TabularMDP
    seen: Int64[np.ndarray, "n"]
    unseen: Int64[np.ndarray, "m"]
    shortest_return: float


@lru_cache(KEPT)
def training_problem(world: Source, conditions: Conditions = DEFAULT_CONDITIONS) -> TrainingProblem:
    """The problem of a world under some conditions.

    Args:
        world: the map, or a table.
        conditions: whether episodes begin where it has everything, or elsewhere, and whether
            actions slip.

    Returns:
        Its table, with all that can be reached from where episodes begin.

    Raises:
        ValueError: the goal is unreachable, from the map or from so many placements; or a table has
            no rewards, or other starts are asked for than its own.
    """
    starts, unseen, seed, slip = conditions
    if isinstance(world, NamedTable):
        return _of_table(world, conditions)
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


def _of_table(table: NamedTable, conditions: Conditions) -> TrainingProblem:
    if conditions.starts:
        raise ValueError(
            f"{table.name} is not a map, on which things could be elsewhere; leave out starts"
        )
    if not table.mdp.reward.any():
        raise ValueError(f"{table.name} has no rewards, so there is nothing to learn; give it some")
    none = np.empty(0, np.int64)
    start = np.array([table.mdp.start])
    return TrainingProblem(table.mdp.slippery(conditions.slip), start, none, np.nan)


def _shortest_return(mdp: TabularMDP, starts: Int64[np.ndarray, "n"]) -> float | None:
    """The mean; `None` where there is a start from which there is no plan."""
    if len(starts) == 1 and not mdp.is_stochastic:
        plan = solve(mdp, int(starts[0]))
        return None if plan is None else plan.best_return
    steps = distances(mdp)[starts]
    return float(1 - steps.mean()) if (steps > 0).all() else None


def best_return(world: Source, conditions: Conditions, limit: int) -> float:
    """The expected return of the best policy, the mean over the initial states of training.

    Args:
        world, conditions: as in `training_problem`.
        limit: how many steps an episode has, at most. In a deterministic world it does not
            count: the return is that of a shortest plan. Of a table it does.

    Returns:
        Extrinsic and undiscounted.

    Raises:
        ValueError: as in `training_problem`.
    """
    problem = training_problem(world, conditions)
    if not problem.mdp.is_stochastic and not isinstance(world, NamedTable):
        return problem.shortest_return
    return float(expected_returns(world, conditions, limit)[problem.seen].mean())


@lru_cache(KEPT)
def expected_returns(world: Source, conditions: Conditions, limit: int) -> Float64[np.ndarray, "S"]:
    """The expected return of the best policy from every state, as in `best_returns`.

    Args:
        world, conditions, limit: as in `best_return`.
    """
    returns = best_returns(training_problem(world, conditions).mdp, limit)
    returns.flags.writeable = False
    return returns


@lru_cache(KEPT)
def margin(world: Source, conditions: Conditions, limit: int) -> float:
    """How close to the best return is close enough to have converged.

    Args:
        world, conditions, limit: as in `best_return`.

    Returns:
        0.9 in a world, where a step costs 1. Of a table, whose rewards have any size, 5 % of what
        the best policy gains over the one that chooses uniformly.

    Raises:
        ValueError: that is nothing.
    """
    if not isinstance(world, NamedTable):
        return MARGIN
    problem = training_problem(world, conditions)
    there = problem.mdp.available
    uniform = there / np.maximum(there.sum(axis=1, keepdims=True), 1)
    random = policy_returns(problem.mdp, uniform, limit)[problem.seen].mean()
    gain = best_return(world, conditions, limit) - float(random)
    if gain <= _NOTHING:
        raise ValueError(
            f"{world.name}: every policy earns {random:g} within {limit} steps, so there is "
            "nothing to learn; check that its goal can be reached, or raise episode_limit"
        )
    return _SHARE * gain


def prepared(config: Config) -> tuple[Config, Source]:
    """A configuration as it is trained, and its world or table.

    A table's rewards may have any size, and the default `reward_scale` is for steps that cost 1.
    Where it would make of what the best policy gains over a uniform one less than 2, it is raised
    so that it does not. Episodes are no longer than those of the table's Gymnasium environment.

    Raises:
        ValueError: as in `source_of` and `training_problem`.
    """
    source = source_of(config)
    if not isinstance(source, NamedTable):
        return config, source
    if source.limit is not None and source.limit < config.episode_limit:
        config = replace(config, episode_limit=source.limit)
    default: Any = {f.name: f.default for f in fields(config.algorithm)}.get("reward_scale")
    if default is not None and config.algorithm.reward_scale == default:
        gain = margin(source, Conditions.of(config), config.episode_limit) / _SHARE
        if 0 < gain * default < _GAIN:
            config = config.changed(reward_scale=_GAIN / gain)
    return config, source


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
