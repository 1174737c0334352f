"""Tiny tasks with known answers, each of which one kind of mistake would break."""

from dataclasses import replace
from typing import NamedTuple

import jax
import numpy as np

from habilis.learning.algorithms.a2c import A2C
from habilis.learning.config import Config
from habilis.learning.dynamics import make_dynamics
from habilis.learning.episodes import Ledger
from habilis.learning.lanes import Lane, Program, advance, settings_of, start_lanes
from habilis.learning.networks import Network, Separate
from habilis.mdp import TabularMDP

QUICK_A2C = A2C(
    envs=8,
    rollout=4,
    learning_rate=5e-3,
    optimizer="rmsprop",
    reward_scale=1.0,
    entropy=0.001,
    entropy_hold=0,
    entropy_steps=0,
    discount=0.5,
    hidden=(16,),
)
"""Learns such a task in a second; its values are in units of the reward."""


class Learned(NamedTuple):
    """The result of one agent."""

    policy: np.ndarray  # float[S, A]
    values: np.ndarray  # of a network, float[S]; of a table Q, float[S, A]
    episodes: np.ndarray  # steps, return and counts of flags
    lane: Lane
    loss: np.ndarray


def learn(mdp: TabularMDP, config: Config, updates: int = 1500, table=None) -> Learned:
    """Trains one agent on a table."""
    dynamics, rows = make_dynamics(mdp, observation=config.observation)
    program = replace(Program.of(config, rows, 1), updates=updates)
    settings = settings_of(config, np.zeros(mdp.states) if table is None else np.asarray(table))
    settings = jax.tree.map(lambda leaf: np.asarray(leaf)[None], settings)
    lanes = start_lanes(dynamics, program, jax.random.key(config.seed)[None])
    lanes, log = jax.tree.map(np.asarray, advance(dynamics, settings, lanes, program))
    lane = jax.tree.map(lambda leaf: leaf[0], lanes)
    parameters = lane.train_state.parameters
    policy = config.algorithm.policy(dynamics, parameters)
    is_network = isinstance(parameters, Network | Separate)
    values = parameters(dynamics.inputs)[:, -1] if is_network else parameters
    ledger, envs = Ledger.of(mdp), config.algorithm.envs
    transition, truncated = (part[0].reshape(-1, envs) for part in (log.transition, log.truncated))
    episodes, _ = ledger.entries(ledger.nothing(envs), transition, truncated)
    return Learned(np.asarray(policy), np.asarray(values), episodes, lane, log.loss[0])


def row(states: int, actions: int, reward, terminal_last: bool = True) -> TabularMDP:
    """States in a row, whatever is done; the last is terminal."""
    next_state = np.minimum(np.arange(states)[:, None] + 1, states - 1)
    terminal = np.arange(states) == states - 1
    return TabularMDP.deterministic(
        np.repeat(next_state, actions, axis=1), reward, terminal & terminal_last
    )
