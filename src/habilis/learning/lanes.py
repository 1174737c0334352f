"""Runs side by side: one is a lane of a `vmap`, and all of it is compiled."""

from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, Key, PRNGKeyArray, UInt32

from habilis.learning import intrinsic
from habilis.learning.algorithms.protocol import Algorithm, bound, hyperparams_of, static_part
from habilis.learning.config import Config
from habilis.learning.dynamics import Dynamics
from habilis.learning.rollout import (
    Context,
    EnvState,
    Experience,
    Hyperparams,
    rollout,
    whole_episodes,
)

_LANES = "lanes"
"""The axis of a batch."""


@dataclass(frozen=True)
class Program:
    """The static settings of the compiled loop, shared by all lanes of a batch.

    Attributes:
        algorithm: its static settings; all others are at their defaults here.
        intrinsic: the kind of intrinsic reward, "table", "followed", "count" or "rnd".
        rows: how many rows the first weights of a network have.
        updates: in one stretch of training.
        rollout_length: steps of each environment between two updates, at most.
    """

    algorithm: Algorithm
    intrinsic: str
    rows: int
    updates: int
    rollout_length: int

    @classmethod
    def of(cls, config: Config, rows: int, steps: int) -> "Program":
        """The program of a configuration, with about so many environment steps a stretch.

        Where the reward follows the policy, it is computed between two stretches.
        """
        algorithm = config.algorithm
        length = algorithm.rollout or config.episode_limit
        updates = max(1, steps // (algorithm.envs * length))
        if every := config.policy_every:
            updates = max(n for n in range(1, min(updates, every) + 1) if every % n == 0)
        kind = intrinsic.kind_of(config)
        return cls(static_part(algorithm), kind, rows, updates, length)

    @property
    def steps(self) -> int:
        """Environment steps of one lane in a stretch, at most."""
        return self.updates * self.algorithm.envs * self.rollout_length

    @property
    def whole_episodes(self) -> bool:
        """Whether an update has one episode of each environment, however long."""
        return self.algorithm.rollout == 0

    @property
    def counts(self) -> bool:
        """Whether steps and episodes have to be counted, since updates do not tell."""
        return self.whole_episodes or self.algorithm.counts_episodes


class Settings(NamedTuple):
    """The settings that may differ between lanes."""

    table: Float[Array, "S"]
    """M, the intrinsic value of every state, where it is a table."""
    hyperparams: Hyperparams


class Counts(NamedTuple):
    """Steps made and episodes ended so far."""

    steps: Int[Array, ""]
    episodes: Int[Array, ""]


class Lane(NamedTuple):
    """All that changes while one run learns."""

    train_state: Any
    """The algorithm's: `parameters`, and what else it needs."""
    novelty: Any
    """The state of an intrinsic reward that changes while it is earned."""
    env_state: EnvState
    key: UInt32[Array, "2"]
    """The data of the key from which all its random numbers come."""
    updates: Int[Array, ""]
    counts: Counts | tuple[()] = ()
    """Where a program counts."""


class Log(NamedTuple):
    """The transitions and losses of a stretch of training."""

    transition: Int[Array, "updates T E"]
    """-1 where no step was made."""
    truncated: Bool[Array, "updates T E"]
    loss: Float[Array, "updates"]


def settings_of(config: Config, table: Float[np.ndarray, "S"]) -> Settings:
    """The hyperparameters of a configuration as the compiled loop wants them."""
    hyperparams = hyperparams_of(config.algorithm) | intrinsic.weights(config)
    hyperparams |= {
        "episode_limit": config.episode_limit,
        "limit_is_terminal": config.limit_is_terminal,
    }
    arrays: Any = {name: np.float32(number) for name, number in hyperparams.items()}
    values: Any = table.astype(np.float32)
    return Settings(values, arrays)


# It runs once, and compiles in a third of the time to the same numbers.
@partial(jax.jit, static_argnames="program", compiler_options={"xla_backend_optimization_level": 1})
def start_lanes(dynamics: Dynamics, program: Program, keys: Key[Array, "L"]) -> Lane:
    """Runs before their first step, one for each key."""

    def one_lane(key: PRNGKeyArray) -> Lane:
        for_learner, for_novelty, for_acting = jax.random.split(key, 3)
        envs = program.algorithm.envs
        begin = (
            jnp.full(envs, dynamics.start)
            if dynamics.start.ndim == 0
            else _first(dynamics, for_acting, envs)
        )
        return Lane(
            train_state=program.algorithm.init(dynamics, program.rows, for_learner),
            novelty=intrinsic.init(program.intrinsic, dynamics, program.rows, for_novelty),
            env_state=EnvState(begin, jnp.zeros(envs, jnp.int32)),
            key=jax.random.key_data(for_acting),
            updates=jnp.int32(0),
            counts=Counts(jnp.int32(0), jnp.int32(0)) if program.counts else (),
        )

    return jax.vmap(one_lane)(keys)


@partial(jax.jit, static_argnames="program")
def advance(
    dynamics: Dynamics, settings: Settings, lanes: Lane, program: Program
) -> tuple[Lane, Log]:
    """Trains every lane for a stretch.

    Args:
        dynamics: shared by all lanes.
        settings, lanes: with a leading axis of lanes.
        program: fixed at compilation.

    Returns:
        The lanes, and a log with a leading axis of lanes.
    """
    algorithm = program.algorithm

    def one_lane(settings: Settings, lane: Lane) -> tuple[Lane, Log]:
        # All random numbers of a stretch at once: drawn one by one they cost as much as acting.
        stretch = jax.random.fold_in(jax.random.wrap_key_data(lane.key), lane.updates)
        shape = (program.updates, program.rollout_length, algorithm.envs)
        draws = jax.random.uniform(stretch, shape)
        several = dynamics.start.ndim > 0
        starts = jax.random.uniform(jax.random.fold_in(stretch, 1), shape) if several else None
        stochastic = dynamics.transitions.outcomes > 1
        noise = jax.random.uniform(jax.random.fold_in(stretch, 3), shape) if stochastic else None
        drawn = draws, starts, noise
        return jax.lax.scan(partial(_update, dynamics, settings, program), lane, drawn)

    return jax.vmap(one_lane, axis_name=_LANES)(settings, lanes)


def _in_any_lane(here: Bool[Array, ""]) -> Bool[Array, ""]:
    return jax.lax.pmax(here.astype(jnp.int32), _LANES) > 0


def _first(dynamics: Dynamics, key: PRNGKeyArray, envs: int) -> Int[Array, "E"]:
    """Where the first episodes begin, if there are several initial states."""
    before = jax.random.fold_in(jax.random.fold_in(key, 0), 2)  # no key of any stretch
    return dynamics.begin(jax.random.uniform(before, (envs,)))


def _update(
    dynamics: Dynamics, settings: Settings, program: Program, lane: Lane, drawn: tuple
) -> tuple[Lane, Log]:
    """One rollout, and what is learned from it."""
    draws, starts, noise = drawn
    hyperparams = settings.hyperparams
    global_step = lane.updates.astype(jnp.float32) * draws.size
    episodes: Any = 0.0
    if isinstance(lane.counts, Counts):
        global_step, episodes = (number.astype(jnp.float32) for number in lane.counts)

    def value(states: Int[Array, "*n"]) -> Float[Array, "*n"]:
        return intrinsic.values(program.intrinsic, lane.novelty, settings.table, dynamics, states)

    def reward_fn(transition: Int[Array, "*n"]) -> Float[Array, "*n"]:
        return intrinsic.reward(
            hyperparams,
            dynamics.transitions.reward[transition],
            value(dynamics.transitions.next_state[transition]),
            value(dynamics.state_of(transition)),
            dynamics.terminated(transition),
            global_step,
        )

    algorithm = bound(program.algorithm, hyperparams)
    context = Context(
        dynamics=dynamics,
        global_step=global_step,
        key=jax.random.fold_in(jax.random.wrap_key_data(lane.key), -1 - lane.updates),
        reward_fn=reward_fn,
        episodes=episodes,
        in_any_lane=_in_any_lane,
    )
    env_state, trajectory = (whole_episodes if program.whole_episodes else rollout)(
        dynamics,
        partial(algorithm.act, context, lane.train_state),
        lane.env_state,
        hyperparams["episode_limit"],
        draws,
        starts,
        noise,
    )
    terminated = dynamics.terminated(trajectory.transition)
    truncated = trajectory.truncated
    terminal = truncated & (hyperparams["limit_is_terminal"] > 0)
    experience = Experience(
        state=trajectory.state,
        action=dynamics.action_of(trajectory.transition),
        next_state=dynamics.transitions.next_state[trajectory.transition],
        reward=reward_fn(trajectory.transition),
        terminated=terminated | terminal,
        truncated=truncated & ~terminal,
        aux=trajectory.aux,
        last_state=env_state.state,
        mask=trajectory.mask,
    )
    train_state, loss = algorithm.update(context, lane.train_state, experience)
    novelty = intrinsic.visited(
        program.intrinsic, lane.novelty, dynamics, experience.next_state, experience.mask
    )
    counts = lane.counts
    if isinstance(counts, Counts):
        made = trajectory.transition >= 0
        ended = made & (terminated | truncated)
        counts = Counts(counts.steps + made.sum(), counts.episodes + ended.sum())
    after = Lane(train_state, novelty, env_state, lane.key, lane.updates + 1, counts)
    return after, Log(trajectory.transition, truncated, loss)
