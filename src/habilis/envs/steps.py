"""Resets and steps of a functional environment, as functions of arrays."""

from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, ArrayLike, Bool, Float, Int, Int8, Int32, PRNGKeyArray

from habilis.envs.params import Params, State
from habilis.envs.table import ACTION_MASK
from habilis.rewards.shaping import EMPOWERMENT, EXTRINSIC, regularised

Action = Int[ArrayLike, ""]

Info = dict[str, Any]

Stepped = tuple[Array, State, Float[Array, ""], Bool[Array, ""], Bool[Array, ""], Info]
"""Observation, state, reward, terminated, truncated, info."""

Alone = tuple[Array, State, Float[Array, ""], Bool[Array, ""], Info]
"""The same without truncated, of a step after which no episode is begun."""


@jax.jit
def begin(params: Params) -> tuple[Array, State]:
    """The first observation and state of an episode."""
    state = State(_start(params), jnp.int32(0))
    return observed(state.index, params), state


@jax.jit
def step(key: PRNGKeyArray, state: State, action: Action, params: Params) -> Stepped:
    """A step; where an episode has ended with it, the next one begins."""
    last, reached, reward, terminated, info = step_alone(key, state, action, params)
    truncated = cut_off(reached, params)
    ended = terminated | truncated
    after = State(
        jnp.where(ended, _start(params), reached.index), jnp.where(ended, 0, reached.time)
    )
    info |= {"terminated": terminated, "truncated": truncated, "final_observation": last}
    if params.available is not None:
        info[ACTION_MASK] = action_mask(after.index, params)
    return observed(after.index, params), after, reward, terminated, truncated, info


@jax.jit
def step_alone(key: PRNGKeyArray, state: State, action: Action, params: Params) -> Alone:
    """A step; an episode that has ended with it stays where it is."""
    actions, draw = params.actions, None
    if params.transitions.outcomes > 1:
        key, of_outcome = jax.random.split(key)
        draw = jax.random.uniform(of_outcome)
    if params.slip is not None:
        slips, draws = jax.random.split(key)
        drawn = _any_action(draws, state.index, actions, params.available)
        slipped = jax.random.uniform(slips) < params.slip
        if params.available is not None:  # an action that is not available stays what it is
            slipped &= params.available[state.index, action]
        action = jnp.where(slipped, drawn, action)
    choice = state.index * actions + jnp.asarray(action, jnp.int32)
    transition = params.transitions.drawn(choice, draw)
    index = params.transitions.next_state[transition]
    reward = params.transitions.reward[transition]
    terminated = params.terminal[index]
    info = {
        "state": index,
        "discount": goes_on(terminated),
        **{name: flag[index] for name, flag in params.flags.items()},
    }
    if params.available is not None:
        info[ACTION_MASK] = action_mask(index, params)
    if params.empowerment is not None:
        bits, weights = params.empowerment.bits, params.empowerment.weights
        info |= {EXTRINSIC: reward, EMPOWERMENT: bits[index]}
        reward = regularised(weights, reward, bits[index], bits[state.index], terminated, 0, jnp)
    return observed(index, params), State(index, state.time + 1), reward, terminated, info


def cut_off(state: State, params: Params) -> Bool[Array, ""]:
    """Whether an episode is truncated in this state; where it terminates, it is not."""
    return (state.time >= params.max_steps_in_episode) & ~params.terminal[state.index]


def goes_on(terminated: Bool[Array, ""]) -> Float[Array, ""]:
    """The discount: 0 after an end."""
    return jnp.where(terminated, jnp.float32(0), jnp.float32(1))


def observed(index: Int32[Array, ""], params: Params) -> Array:
    """The observation of a state."""
    seen = params.seen[index]
    if params.background is None:
        return seen
    return params.background.reshape(-1).at[seen].set(1).reshape(params.background.shape)


def action_mask(index: Int32[Array, ""], params: Params) -> Int8[Array, "A"]:
    """1 for the actions that are available in a state, 0 for others."""
    if params.available is None:
        return jnp.ones(params.actions, jnp.int8)
    return params.available[index].astype(jnp.int8)


def _any_action(
    key: PRNGKeyArray, index: Int32[Array, ""], actions: int, available: Bool[Array, "S A"] | None
) -> Int[Array, ""]:
    """An action drawn uniformly from those available in a state."""
    if available is None:
        return jax.random.randint(key, (), 0, actions)
    there = jnp.cumsum(available[index])
    return jnp.argmax(there > jax.random.randint(key, (), 0, jnp.maximum(there[-1], 1)))


def _start(params: Params) -> Int32[Array, ""]:
    return jnp.asarray(params.start, jnp.int32)
