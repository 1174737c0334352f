"""Episodes of a trained agent, and what it learned of every state."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from habilis.learning.dynamics import make_dynamics
from habilis.learning.runs import Run
from habilis.learning.sources import NamedTable
from habilis.learning.training_problem import (
    Conditions,
    expected_returns,
    success_rate,
    training_problem,
)
from habilis.mdp import TabularMDP
from habilis.transitions import Transitions
from habilis.worlds.plans import policy_returns, solve


@dataclass(frozen=True)
class Episode:
    """An episode of the greedy policy.

    Attributes:
        states: passed through, the first to the last (one more than actions).
        actions: taken.
        episode_return: extrinsic, undiscounted.
        finished: whether the goal was reached.
    """

    states: tuple[int, ...]
    actions: tuple[int, ...]
    episode_return: float
    finished: bool


def table_of(run: Run) -> TabularMDP:
    """The table that a run learned on."""
    return training_problem(run.world, Conditions.of(run.config)).mdp


class Success(NamedTuple):
    """The share of placements from which an agent reaches the goal; `None` without any.

    In a stochastic world, the probability that it does, the mean over the placements.

    Attributes:
        seen: of those that training began from.
        unseen: of those that were held out.
    """

    seen: float
    unseen: float | None


def success(run: Run, index: int = 0) -> Success:
    """How often one run's greedy policy reaches the goal, from where it was trained and elsewhere.

    Args:
        run: what `train` returned, or `load_run`.
        index: which of its runs, from 0.

    Returns:
        The shares, each within `episode_limit` actions.

    Raises:
        ValueError: there is no such run.
    """
    check_index(run, index)
    mdp, seen, unseen, _ = training_problem(run.world, Conditions.of(run.config))
    policy = greedy_actions(run, mdp, index)
    limit = run.config.episode_limit
    return Success(
        success_rate(mdp, policy, seen, limit),
        success_rate(mdp, policy, unseen, limit) if len(unseen) else None,
    )


def expected_return(run: Run, index: int = 0) -> float:
    """The return that one run's greedy policy expects of an episode, from where it was trained.

    Args:
        run: what `train` returned, or `load_run`.
        index: which of its runs, from 0.

    Returns:
        Extrinsic and undiscounted, within `episode_limit` actions; compare `Run.best_return`.

    Raises:
        ValueError: there is no such run.
    """
    check_index(run, index)
    mdp, seen, _, _ = training_problem(run.world, Conditions.of(run.config))
    policy = np.eye(mdp.action_count)[greedy_actions(run, mdp, index)]
    return float(policy_returns(mdp, policy, run.config.episode_limit)[seen].mean())


def greedy_actions(run: Run, mdp: TabularMDP, index: int) -> np.ndarray:
    """The most probable action in every state, int[S].

    Args:
        run: a trained run.
        mdp: the table of its world.
        index: which of its runs.
    """
    dynamics, _ = make_dynamics(mdp, observation=run.config.observation)
    policy = run.config.algorithm.policy(dynamics, _parameters(run, index))
    return np.asarray(policy.argmax(axis=-1))


def learned(run: Run, mdp: TabularMDP, index: int) -> tuple[np.ndarray, np.ndarray]:
    """The policy and values of a run for every state.

    Args:
        run: a trained run.
        mdp: the table of its world.
        index: which of its runs.

    Returns:
        float[S, A], the probability of each action (Q-learning's policy is the greedy one, without
        what it explores), and float[S], the value: the discounted sum of rewards that it expects,
        intrinsic ones included.
    """
    algorithm, parameters = run.config.algorithm, _parameters(run, index)
    dynamics, _ = make_dynamics(mdp, observation=run.config.observation)
    policy, values = algorithm.policy(dynamics, parameters), algorithm.values(dynamics, parameters)
    return np.asarray(policy), np.asarray(values) / algorithm.reward_scale


def _parameters(run: Run, index: int) -> Any:
    return jax.tree.map(lambda leaf: jnp.asarray(leaf[index]), run.parameters)


def best_return_from(run: Run, start: int) -> float | None:
    """The most that any policy can expect from a state; `None` where the goal is unreachable.

    Args:
        run: a trained run.
        start: the state to begin in, of `table_of(run)`.

    Returns:
        Extrinsic, undiscounted: of a shortest plan in a deterministic world.
    """
    mdp = table_of(run)
    if mdp.is_stochastic or isinstance(run.world, NamedTable):
        limit = run.config.episode_limit
        best = float(expected_returns(run.world, Conditions.of(run.config), limit)[start])
        return None if mdp.is_stochastic and best <= -limit else best
    plan = solve(mdp, start)
    return None if plan is None else plan.best_return


def play(run: Run, index: int = 0, start: int | None = None, seed: int = 0) -> Episode:
    """Acts out one run's greedy policy.

    Where policy and world are deterministic, an episode that comes back to a state will never
    reach the goal: it ends there. In a stochastic world, and of a table, whose rewards may be any,
    it ends after `episode_limit` actions.

    Args:
        run: what `train` returned, or `load_run`.
        index: which of its runs, from 0.
        start: the state to begin in, of `tabulate(run.world)`; by default the map's own.
        seed: of the random outcomes in a stochastic world.

    Returns:
        The episode.

    Raises:
        ValueError: there is no such run, no such state, or the seed is negative.
    """
    check_index(run, index)
    if seed < 0:
        raise ValueError(f"seed is {seed}; give one of 0 or more")
    mdp = table_of(run)
    policy = greedy_actions(run, mdp, index)
    start = mdp.start if start is None else start
    if not 0 <= start < mdp.states:
        raise ValueError(f"start is {start}; use a state from 0 to {mdp.states - 1}")
    transitions, random = Transitions.of(mdp), np.random.default_rng(seed)
    ends, may_return = mdp.ends, mdp.is_stochastic or isinstance(run.world, NamedTable)
    states, actions, total = [start], [], 0.0
    while True:
        action = int(policy[states[-1]])
        chosen = states[-1] * mdp.action_count + action
        made = transitions.drawn(chosen, random.random())
        reached = int(transitions.next_state[made])
        total += float(transitions.reward[made])
        actions.append(action)
        in_vain = len(actions) >= run.config.episode_limit if may_return else reached in states
        states.append(reached)
        if ends[reached] or in_vain:
            finished = bool(mdp.terminal[reached])
            return Episode(tuple(states), tuple(actions), total, finished)


def check_index(run: Run, index: int) -> None:
    if not 0 <= index < run.config.runs:
        raise ValueError(f"run is {index}; use 0 to {run.config.runs - 1}")
