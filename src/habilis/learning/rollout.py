"""Steps of many environments under one policy."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from habilis.learning.dynamics import Dynamics

_UNROLL = 5  # more steps compile longer and run no faster

Number = Float[Array | np.floating, ""] | float
"""A number of JAX, of NumPy or of Python."""

Hyperparams = dict[str, Float[Array, ""]]
"""The settings that are no part of the compiled program, by their names."""


@dataclass(frozen=True)
class Context:
    """The inputs of an update of one lane, besides the settings and the train state.

    Attributes:
        dynamics: the table.
        global_step: environment steps so far.
        key: for random numbers of the update.
        reward_fn: the reward to learn from, extrinsic and intrinsic, of any transitions.
        episodes: that have ended so far, where the algorithm counts them.
        in_any_lane: whether something is so in any lane of the batch. A branch on the answer is
            taken by all lanes at once, and so only one of its sides is computed.
    """

    dynamics: Dynamics
    global_step: Float[Array, ""]
    key: PRNGKeyArray
    reward_fn: Callable[[Int[Array, "*n"]], Float[Array, "*n"]]
    episodes: Number = 0.0
    in_any_lane: Callable[[Bool[Array, ""]], Bool[Array, ""]] = lambda here: here


class EnvState(NamedTuple):
    """Where E environments are: the state, and the steps of the running episode."""

    state: Int[Array, "E"]
    steps: Int[Array, "E"]


class Trajectory(NamedTuple):
    """T steps of E environments."""

    state: Int[Array, "T E"]
    transition: Int[Array, "T E"]
    truncated: Bool[Array, "T E"]
    aux: Any
    """The policy's record of each decision."""
    mask: Bool[Array, "T E"] | None = None
    """Which of the steps were made; `None`: all."""


class Experience(NamedTuple):
    """The training data of an update: a trajectory and its rewards."""

    state: Int[Array, "T E"]
    action: Int[Array, "T E"]
    next_state: Int[Array, "T E"]
    """Where each step led, before any reset."""
    reward: Float[Array, "T E"]
    terminated: Bool[Array, "T E"]
    truncated: Bool[Array, "T E"]
    aux: Any
    last_state: Int[Array, "E"]
    """Where the environments are after the last step, after any reset."""
    mask: Bool[Array, "T E"] | None = None
    """Which of the steps were made; `None`: all."""


Act = Callable[[Int[Array, "E"], Float[Array, "E"]], tuple[Int[Array, "E"], Any]]
"""From states and a uniform number each to actions, and what to remember."""


def rollout(
    dynamics: Dynamics,
    act: Act,
    env_state: EnvState,
    episode_limit: Float[Array, ""],
    draws: Float[Array, "T E"],
    starts: Float[Array, "T E"] | None = None,
    noise: Float[Array, "T E"] | None = None,
) -> tuple[EnvState, Trajectory]:
    """T steps of E environments; ended episodes are reset.

    The draws decide on actions, `starts` on where an episode begins, if there are several initial
    states, and the noise on the outcome of an action, if there are several.
    """

    def step(env_state: EnvState, drawn: tuple) -> tuple[EnvState, Trajectory]:
        after, made, _ = _step(dynamics, act, env_state, episode_limit, *drawn)
        return after, made

    # A few steps a turn of the compiled loop: its turns cost as much as the small operations in it.
    return jax.lax.scan(step, env_state, (draws, starts, noise), unroll=min(_UNROLL, len(draws)))


def _step(
    dynamics: Dynamics,
    act: Act,
    env_state: EnvState,
    episode_limit: Float[Array, ""],
    draw: Float[Array, "E"],
    start: Float[Array, "E"] | None,
    noise: Float[Array, "E"] | None,
) -> tuple[EnvState, Trajectory, Bool[Array, "E"]]:
    """One step of E environments: where they are then, the step, and which episodes ended."""
    action, aux = act(env_state.state, draw)
    transition = dynamics.transition(env_state.state, action, noise)
    reached = dynamics.goes_on[transition]
    steps = env_state.steps + 1
    truncated = (reached >= 0) & (steps >= episode_limit)
    ended = (reached < 0) | truncated
    after = EnvState(jnp.where(ended, dynamics.begin(start), reached), jnp.where(ended, 0, steps))
    return after, Trajectory(env_state.state, transition, truncated, aux), ended


def whole_episodes(
    dynamics: Dynamics,
    act: Act,
    env_state: EnvState,
    episode_limit: Float[Array, ""],
    draws: Float[Array, "T E"],
    starts: Float[Array, "T E"] | None = None,
    noise: Float[Array, "T E"] | None = None,
) -> tuple[EnvState, Trajectory]:
    """One episode of each of E environments, of up to T steps; see `rollout`.

    An environment whose episode has ended waits for the others where it begins its next one: its
    further steps are not made, and their transitions are -1.
    """
    steps, envs = draws.shape

    def step(
        t: Int[Array, ""], env_state: EnvState
    ) -> tuple[EnvState, Trajectory, Bool[Array, "E"]]:
        drawn = jax.tree.map(lambda drawn: drawn[t], (draws, starts, noise))
        return _step(dynamics, act, env_state, episode_limit, *drawn)

    def more(carry: tuple) -> Bool[Array, ""]:
        t, _, _, acting = carry
        return (t < steps) & acting.any()

    def one(carry: tuple) -> tuple:
        t, env_state, trajectory, acting = carry
        after, now, ended = step(t, env_state)
        env_state = jax.tree.map(lambda new, old: jnp.where(acting, new, old), after, env_state)
        now = now._replace(
            transition=jnp.where(acting, now.transition, -1),
            truncated=now.truncated & acting,
            mask=acting,
        )
        trajectory = jax.tree.map(lambda all_of, part: all_of.at[t].set(part), trajectory, now)
        return t + 1, env_state, trajectory, acting & ~ended

    like = jax.eval_shape(lambda: step(jnp.int32(0), env_state)[1])
    empty = jax.tree.map(lambda part: jnp.zeros((steps, *part.shape), part.dtype), like)
    empty = empty._replace(
        transition=jnp.full((steps, envs), -1, like.transition.dtype),
        mask=jnp.zeros((steps, envs), bool),
    )
    begun = jnp.int32(0), env_state, empty, jnp.ones(envs, bool)
    _, env_state, trajectory, _ = jax.lax.while_loop(more, one, begun)
    return env_state, trajectory


def masked(
    logits: Float[Array | np.ndarray, "*n A"], available: Bool[Array, "*n A"] | None
) -> Float[Array | np.ndarray, "*n A"]:
    """Logits that leave unavailable actions a probability of 0.

    The least number there is stands for minus infinity, which would make entropies NaN.
    """
    if available is None:
        return logits
    return jnp.where(available, logits, jnp.finfo(logits.dtype).min)


def sample_action(
    logits: Float[Array, "E A"],
    draw: Float[Array, "E"],
    available: Bool[Array, "E A"] | None = None,
) -> Int[Array, "E"]:
    """The action in whose share of [0, 1) each uniform draw falls."""
    below = jnp.cumsum(jax.nn.softmax(masked(logits, available)), axis=-1) <= draw[:, None]
    last: Any = logits.shape[-1] - 1  # shares may sum to a little less than 1
    if available is not None:
        last = last - available[:, ::-1].argmax(axis=-1)
    return jnp.minimum(below.sum(axis=-1), last)


def linear_schedule(start: Number, end: Number, duration: Number, step: Number) -> Float[Array, ""]:
    """A number that goes from start to end over so many steps; at start for ever if 0."""
    share = jnp.where(duration > 0, jnp.clip(step / jnp.maximum(duration, 1), 0, 1), 0)
    return start + (end - start) * share
