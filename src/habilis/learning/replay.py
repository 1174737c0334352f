"""What an agent learned, acted out."""

from dataclasses import dataclass

import jax
import numpy as np

from habilis.learning.lanes import Program
from habilis.learning.runs import Run
from habilis.learning.task import make_task
from habilis.mdp import TabularMDP
from habilis.worlds.table import tabulate


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


def greedy_actions(run: Run, mdp: TabularMDP, index: int) -> np.ndarray:
    """The most probable action in every state, int[S].

    Args:
        run: a trained run.
        mdp: the table of its world.
        index: which of its runs.
    """
    parameters = jax.tree.map(lambda leaf: leaf[index], run.parameters)
    task, rows = make_task(mdp)
    module = Program.of(run.config, rows, 1).module
    return np.asarray(module.preferences(task, parameters).argmax(axis=-1))


def play(run: Run, index: int = 0) -> Episode:
    """Acts out one run's greedy policy from the start.

    The policy and the world are deterministic, so an episode that comes back to a state will
    never reach the goal: it ends there.

    Args:
        run: what `train` returned, or `load_run`.
        index: which of its runs, from 0.

    Returns:
        The episode.

    Raises:
        ValueError: there is no such run.
    """
    if not 0 <= index < run.config.runs:
        raise ValueError(f"run is {index}; use 0 to {run.config.runs - 1}")
    mdp = tabulate(run.world)
    policy = greedy_actions(run, mdp, index)
    states, actions, total = [mdp.start], [], 0.0
    while True:
        action = int(policy[states[-1]])
        total += float(mdp.reward[states[-1], action])
        reached = int(mdp.next_state[states[-1], action])
        actions.append(action)
        again = reached in states
        states.append(reached)
        if mdp.terminal[reached] or again:
            finished = bool(mdp.terminal[reached])
            return Episode(tuple(states), tuple(actions), total, finished)
