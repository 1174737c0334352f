"""Steps of many environments under one policy."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from habilis.learning.task import Task

_TOGETHER = 5  # more steps compile longer and run no faster

Numbers = dict[str, Float[Array, ""]]
"""The settings that are no part of the compiled program, by their names."""


@dataclass(frozen=True)
class Context:
    """What an algorithm is told besides its own state, in one update of one lane."""

    task: Task
    algorithm: Any
    """The settings that the compiled program depends on."""
    numbers: Numbers
    """All others."""
    taken: Float[Array, ""]
    """Environment steps so far."""
    key: PRNGKeyArray
    worth: Callable[[Int[Array, "*n"]], Float[Array, "*n"]]
    """The reward to learn from, intrinsic and extrinsic, of any transitions."""
    episodes: Any = 0.0
    """Episodes that have ended so far, where something is scheduled by them."""


class Place(NamedTuple):
    """Where E environments are: the state, and the steps of the running episode."""

    state: Int[Array, "E"]
    steps: Int[Array, "E"]


class Passed(NamedTuple):
    """T steps of E environments."""

    state: Int[Array, "T E"]
    transition: Int[Array, "T E"]
    truncated: Bool[Array, "T E"]
    kept: Any
    """What the policy wants to remember of each decision."""
    made: Bool[Array, "T E"] | None = None
    """Which of the steps were made; `None`: all."""


class Experience(NamedTuple):
    """What an algorithm learns from: a rollout, and what it was worth."""

    state: Int[Array, "T E"]
    action: Int[Array, "T E"]
    reached: Int[Array, "T E"]
    reward: Float[Array, "T E"]
    terminated: Bool[Array, "T E"]
    truncated: Bool[Array, "T E"]
    kept: Any
    now: Int[Array, "E"]
    """Where the environments are after it."""
    made: Bool[Array, "T E"] | None = None
    """Which of the steps were made; `None`: all."""


Act = Callable[[Int[Array, "E"], Float[Array, "E"]], tuple[Int[Array, "E"], Any]]
"""From states and a uniform number each to actions, and what to keep."""


def rollout(
    task: Task,
    act: Act,
    place: Place,
    episode_limit: Float[Array, ""],
    draws: Float[Array, "T E"],
    picks: Float[Array, "T E"] | None = None,
    noise: Float[Array, "T E"] | None = None,
) -> tuple[Place, Passed]:
    """T steps of E environments; ended episodes start anew.

    The draws decide on actions, the picks on where an episode begins, if there are several starts,
    and the noise on the outcome of an action, if there are several.
    """

    def step(place: Place, drawn: tuple) -> tuple[Place, Passed]:
        after, passed, _ = _step(task, act, place, episode_limit, *drawn)
        return after, passed

    # A few steps a turn of the compiled loop: its turns cost as much as the small operations in it.
    return jax.lax.scan(step, place, (draws, picks, noise), unroll=min(_TOGETHER, len(draws)))


def _step(
    task: Task,
    act: Act,
    place: Place,
    episode_limit: Float[Array, ""],
    draw: Float[Array, "E"],
    pick: Float[Array, "E"] | None,
    noise: Float[Array, "E"] | None,
) -> tuple[Place, Passed, Bool[Array, "E"]]:
    """One step of E environments: where they are then, what was done, and which episodes ended."""
    action, kept = act(place.state, draw)
    transition = task.transition(place.state, action, noise)
    reached = task.goes_on[transition]
    steps = place.steps + 1
    truncated = (reached >= 0) & (steps >= episode_limit)
    ended = (reached < 0) | truncated
    after = Place(jnp.where(ended, task.begin(pick), reached), jnp.where(ended, 0, steps))
    return after, Passed(place.state, transition, truncated, kept), ended


def whole_episodes(
    task: Task,
    act: Act,
    place: Place,
    episode_limit: Float[Array, ""],
    draws: Float[Array, "T E"],
    picks: Float[Array, "T E"] | None = None,
    noise: Float[Array, "T E"] | None = None,
) -> tuple[Place, Passed]:
    """One episode of each of E environments, of up to T steps; see `rollout`.

    An environment whose episode has ended waits for the others where it begins its next one: its
    further steps are not made, and their transitions are -1.
    """
    steps, envs = draws.shape

    def step(t: Int[Array, ""], place: Place) -> tuple[Place, Passed, Bool[Array, "E"]]:
        drawn = jax.tree.map(lambda drawn: drawn[t], (draws, picks, noise))
        return _step(task, act, place, episode_limit, *drawn)

    def more(carry: tuple) -> Bool[Array, ""]:
        t, _, _, acting = carry
        return (t < steps) & acting.any()

    def one(carry: tuple) -> tuple:
        t, place, passed, acting = carry
        after, now, ended = step(t, place)
        place = jax.tree.map(lambda new, old: jnp.where(acting, new, old), after, place)
        now = now._replace(
            transition=jnp.where(acting, now.transition, -1),
            truncated=now.truncated & acting,
            made=acting,
        )
        passed = jax.tree.map(lambda all_of, part: all_of.at[t].set(part), passed, now)
        return t + 1, place, passed, acting & ~ended

    like = jax.eval_shape(lambda: step(jnp.int32(0), place)[1])
    empty = jax.tree.map(lambda part: jnp.zeros((steps, *part.shape), part.dtype), like)
    empty = empty._replace(
        transition=jnp.full((steps, envs), -1, like.transition.dtype),
        made=jnp.zeros((steps, envs), bool),
    )
    begun = jnp.int32(0), place, empty, jnp.ones(envs, bool)
    _, place, passed, _ = jax.lax.while_loop(more, one, begun)
    return place, passed


def masked(
    logits: Float[Array, "*n A"], available: Bool[Array, "*n A"] | None
) -> Float[Array, "*n A"]:
    """Logits that leave unavailable actions a probability of 0.

    The least number there is stands for minus infinity, which would make entropies NaN.
    """
    if available is None:
        return logits
    return jnp.where(available, logits, jnp.finfo(logits.dtype).min)


def sampled(
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


def linearly(
    start: Float[Array, ""], end: Float[Array, ""], over: Float[Array, ""], steps: Array
) -> Float[Array, ""]:
    """A number that goes from start to end over so many steps; for ever at start if 0."""
    share = jnp.where(over > 0, jnp.clip(steps / jnp.maximum(over, 1), 0, 1), 0)
    return start + (end - start) * share
