"""Runs side by side: one is a lane of a `vmap`, and all of it is compiled."""

from dataclasses import dataclass, fields, replace
from functools import partial
from types import ModuleType
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, Key, PRNGKeyArray, UInt32

from habilis.learning import a2c, intrinsic, ppo, q_learning, soft_values
from habilis.learning.algorithms import ALGORITHMS, Algorithm, name_of
from habilis.learning.config import Config
from habilis.learning.rollout import (
    Context,
    Experience,
    Numbers,
    Place,
    rollout,
    whole_episodes,
)
from habilis.learning.task import Task

_MODULES: dict[str, ModuleType] = {
    "a2c": a2c,
    "ppo": ppo,
    "q-learning": q_learning,
    "soft-value-iteration": soft_values,
}
assert _MODULES.keys() == ALGORITHMS.keys()


@dataclass(frozen=True)
class Program:
    """What the compiled loop depends on, and so must be the same in all lanes of a batch.

    Attributes:
        algorithm: its static settings; all others are at their defaults here.
        intrinsic: the kind of intrinsic reward, "table", "count" or "rnd".
        rows: how many rows the first weights of a network have.
        updates: in one stretch of training.
        steps_between: steps of each environment between two updates, at most.
    """

    algorithm: Algorithm
    intrinsic: str
    rows: int
    updates: int
    steps_between: int

    @classmethod
    def of(cls, config: Config, rows: int, steps: int) -> "Program":
        """The program of a configuration, with about so many environment steps a stretch."""
        algorithm = config.algorithm
        default = type(algorithm)()
        free = {f.name: getattr(default, f.name) for f in _dynamic(algorithm)}
        between = algorithm.rollout or config.episode_limit
        updates = max(1, steps // (algorithm.envs * between))
        fixed = replace(algorithm, **free)
        return cls(fixed, intrinsic.kind_of(config), rows, updates, between)

    @property
    def module(self) -> ModuleType:
        """`start`, `act`, `learn` and `preferences` of its algorithm."""
        return _MODULES[name_of(self.algorithm)]

    @property
    def steps(self) -> int:
        """Environment steps of one lane in a stretch, at most."""
        return self.updates * self.algorithm.envs * self.steps_between

    @property
    def whole_episodes(self) -> bool:
        """Whether an update has one episode of each environment, however long."""
        return self.algorithm.rollout == 0

    @property
    def counts(self) -> bool:
        """Whether what was done has to be counted, since updates do not tell."""
        by_episodes = getattr(self.algorithm, "schedule", "steps") == "episodes"
        return self.whole_episodes or by_episodes


class Settings(NamedTuple):
    """What may differ from lane to lane."""

    table: Float[Array, "S"]
    """M, the intrinsic value of every state, where it is a table."""
    numbers: Numbers


class Count(NamedTuple):
    """What a lane has done so far."""

    steps: Int[Array, ""]
    episodes: Int[Array, ""]


class Lane(NamedTuple):
    """All that changes while one run learns."""

    learner: Any
    """The algorithm's: `parameters`, and what else it needs."""
    novelty: Any
    """What an intrinsic reward keeps that changes while it is earned."""
    place: Place
    key: UInt32[Array, "2"]
    """The data of the key from which all its random numbers come."""
    updates: Int[Array, ""]
    done: Count | tuple[()] = ()
    """What it did, where a program counts it."""


class Log(NamedTuple):
    """What a stretch of training tells."""

    transition: Int[Array, "updates T E"]
    """-1 where no step was made."""
    truncated: Bool[Array, "updates T E"]
    loss: Float[Array, "updates"]


def settings_of(config: Config, table: Float[np.ndarray, "S"]) -> Settings:
    """A configuration's numbers as the compiled loop wants them."""
    algorithm = config.algorithm
    numbers = {f.name: getattr(algorithm, f.name) for f in _dynamic(algorithm)}
    numbers |= intrinsic.weights(config) | {
        "episode_limit": config.episode_limit,
        "limit_is_terminal": config.limit_is_terminal,
    }
    arrays: Any = {name: np.float32(number) for name, number in numbers.items()}
    values: Any = table.astype(np.float32)
    return Settings(values, arrays)


@partial(jax.jit, static_argnames="program")
def start_lanes(task: Task, program: Program, keys: Key[Array, "L"]) -> Lane:
    """Runs before their first step, one for each key."""

    def one_lane(key: PRNGKeyArray) -> Lane:
        for_learner, for_novelty, for_acting = jax.random.split(key, 3)
        envs = program.algorithm.envs
        begin = (
            jnp.full(envs, task.start) if task.start.ndim == 0 else _first(task, for_acting, envs)
        )
        return Lane(
            learner=program.module.start(task, program.rows, program.algorithm, for_learner),
            novelty=intrinsic.start(program.intrinsic, task, program.rows, for_novelty),
            place=Place(begin, jnp.zeros(envs, jnp.int32)),
            key=jax.random.key_data(for_acting),
            updates=jnp.int32(0),
            done=Count(jnp.int32(0), jnp.int32(0)) if program.counts else (),
        )

    return jax.vmap(one_lane)(keys)


@partial(jax.jit, static_argnames="program")
def advance(task: Task, settings: Settings, lanes: Lane, program: Program) -> tuple[Lane, Log]:
    """Trains every lane for a stretch.

    Args:
        task: shared by all lanes.
        settings, lanes: with a leading axis of lanes.
        program: fixed at compilation.

    Returns:
        The lanes, and a log with a leading axis of lanes.
    """
    algorithm = program.algorithm

    def one_lane(settings: Settings, lane: Lane) -> tuple[Lane, Log]:
        # All random numbers of a stretch at once: drawn one by one they cost as much as acting.
        stretch = jax.random.fold_in(jax.random.wrap_key_data(lane.key), lane.updates)
        shape = (program.updates, program.steps_between, algorithm.envs)
        draws = jax.random.uniform(stretch, shape)
        several = task.start.ndim > 0
        picks = jax.random.uniform(jax.random.fold_in(stretch, 1), shape) if several else None
        stochastic = task.transitions.outcomes > 1
        noise = jax.random.uniform(jax.random.fold_in(stretch, 3), shape) if stochastic else None
        drawn = draws, picks, noise
        return jax.lax.scan(partial(_update, task, settings, program), lane, drawn)

    return jax.vmap(one_lane)(settings, lanes)


def _first(task: Task, key: PRNGKeyArray, envs: int) -> Int[Array, "E"]:
    """Where the first episodes begin, if there are several starts."""
    before = jax.random.fold_in(jax.random.fold_in(key, 0), 2)  # no key of any stretch
    return task.begin(jax.random.uniform(before, (envs,)))


def _update(
    task: Task, settings: Settings, program: Program, lane: Lane, drawn: tuple
) -> tuple[Lane, Log]:
    """One rollout, and what is learned from it."""
    draws, picks, noise = drawn
    taken = lane.updates.astype(jnp.float32) * draws.size
    episodes: Any = 0.0
    if isinstance(lane.done, Count):
        taken, episodes = (number.astype(jnp.float32) for number in lane.done)

    def value(states: Int[Array, "*n"]) -> Float[Array, "*n"]:
        return intrinsic.values(program.intrinsic, lane.novelty, settings.table, task, states)

    def worth(transition: Int[Array, "*n"]) -> Float[Array, "*n"]:
        return intrinsic.reward(
            settings.numbers,
            task.transitions.reward[transition],
            value(task.transitions.next_state[transition]),
            value(task.state_of(transition)),
            task.terminated(transition),
            taken,
        )

    context = Context(
        task=task,
        algorithm=program.algorithm,
        numbers=settings.numbers,
        taken=taken,
        key=jax.random.fold_in(jax.random.wrap_key_data(lane.key), -1 - lane.updates),
        worth=worth,
        episodes=episodes,
    )
    module = program.module
    place, passed = (whole_episodes if program.whole_episodes else rollout)(
        task,
        partial(module.act, context, lane.learner),
        lane.place,
        settings.numbers["episode_limit"],
        draws,
        picks,
        noise,
    )
    terminated = task.terminated(passed.transition)
    cut_off = passed.truncated
    terminal = cut_off & (settings.numbers["limit_is_terminal"] > 0)
    experience = Experience(
        state=passed.state,
        action=task.action_of(passed.transition),
        reached=task.transitions.next_state[passed.transition],
        reward=worth(passed.transition),
        terminated=terminated | terminal,
        truncated=cut_off & ~terminal,
        kept=passed.kept,
        now=place.state,
        made=passed.made,
    )
    learner, loss = module.learn(context, lane.learner, experience)
    novelty = intrinsic.visited(
        program.intrinsic, lane.novelty, task, experience.reached, experience.made
    )
    done = lane.done
    if isinstance(done, Count):
        made = passed.transition >= 0
        ended = made & (terminated | cut_off)
        done = Count(done.steps + made.sum(), done.episodes + ended.sum())
    after = Lane(learner, novelty, place, lane.key, lane.updates + 1, done)
    return after, Log(passed.transition, cut_off, loss)


def _dynamic(algorithm: Algorithm):
    return [f for f in fields(algorithm) if not f.metadata["static"]]
