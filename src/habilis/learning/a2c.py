"""Advantage actor-critic on a table, compiled whole, many runs side by side.

A step of the environment is a gather from the table, the intrinsic reward is a gather from an
array, and one run is one lane of a `vmap`.
"""

from functools import partial
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from habilis.learning.networks import ActorCritic
from habilis.learning.returns import generalised_advantages


class Task(NamedTuple):
    """What all lanes share: a table to act on, as the loop wants it."""

    next_state: Int[Array, "S A"]
    reward: Float[Array, "S A"]
    terminal: Bool[Array, "S"]
    inputs: Int[Array, "S factors"]
    """The rows of the network's embedding that stand for a state."""
    counted: Float[Array, "S flags"]
    """What to count over the states that an episode enters."""
    start: Int[Array, ""]


class Settings(NamedTuple):
    """What may differ from lane to lane."""

    bonus: Float[Array, "S"]
    """beta * M, the intrinsic reward for entering a state."""
    learning_rate: Float[Array, ""]
    clip: Float[Array, ""]
    entropy: Float[Array, ""]
    value: Float[Array, ""]
    discount: Float[Array, ""]
    gae_lambda: Float[Array, ""]
    reward_scale: Float[Array, ""]
    episode_limit: Float[Array, ""]


class Shape(NamedTuple):
    """What the compiled program depends on, and so must be the same in all lanes."""

    envs: int
    rollout: int
    optimizer: str
    hidden: tuple[int, ...]
    rows: int
    """How many rows `Task.inputs` names."""


class Lane(NamedTuple):
    """All that changes while one run learns."""

    network: ActorCritic
    optimizer: optax.OptState
    state: Int[Array, "E"]
    tally: Float[Array, "E 2+flags"]
    """Of the running episodes: steps, extrinsic return, and counts."""
    key: PRNGKeyArray
    updates: Int[Array, ""]


class Log(NamedTuple):
    """What a stretch of training tells: per step and environment, and per update."""

    ended: Bool[Array, "*time E"]
    tally: Float[Array, "*time E 2+flags"]
    loss: Float[Array, "*updates"]


class _Steps(NamedTuple):
    """One rollout: T steps of E environments."""

    state: Int[Array, "T E"]
    action: Int[Array, "T E"]
    reward: Float[Array, "T E"]
    value: Float[Array, "T E"]
    terminated: Bool[Array, "T E"]
    truncated: Bool[Array, "T E"]
    tally: Float[Array, "T E 2+flags"]


@partial(jax.jit, static_argnames="shape")
def start_lanes(task: Task, settings: Settings, shape: Shape, keys: PRNGKeyArray) -> Lane:
    """Runs before their first step, one for each key; settings have a leading axis of lanes."""

    def one_lane(settings: Settings, key: PRNGKeyArray) -> Lane:
        for_network, for_acting = jax.random.split(key)
        network = ActorCritic(
            rows=shape.rows,
            factors=task.inputs.shape[1],
            actions=task.next_state.shape[1],
            hidden=shape.hidden,
            key=for_network,
        )
        return Lane(
            network=network,
            optimizer=_optimizer(settings, shape).init(eqx.filter(network, eqx.is_array)),
            state=jnp.full(shape.envs, task.start),
            tally=jnp.zeros((shape.envs, 2 + task.counted.shape[1])),
            key=for_acting,
            updates=jnp.int32(0),
        )

    return jax.vmap(one_lane)(settings, keys)


@partial(jax.jit, static_argnames=("shape", "updates"), donate_argnames="lanes")
def advance(
    task: Task, settings: Settings, lanes: Lane, shape: Shape, updates: int
) -> tuple[Lane, Log]:
    """Trains every lane for a number of updates.

    Args:
        task: shared by all lanes.
        settings, lanes: with a leading axis of lanes.
        shape, updates: fixed at compilation.

    Returns:
        The lanes, and a log with a leading axis of lanes, then updates (and steps within).
    """

    def one_lane(settings: Settings, lane: Lane) -> tuple[Lane, Log]:
        def body(lane: Lane, _: None) -> tuple[Lane, Log]:
            return _update(task, settings, shape, lane)

        return jax.lax.scan(body, lane, length=updates)

    return jax.vmap(one_lane)(settings, lanes)


def _update(task: Task, settings: Settings, shape: Shape, lane: Lane) -> tuple[Lane, Log]:
    """One rollout and one gradient step."""
    key = jax.random.fold_in(lane.key, lane.updates)
    draws = jax.random.uniform(key, (shape.rollout, shape.envs))
    state, tally, cut, steps = _rollout(task, settings, lane, draws)

    # An environment is cut off at most once a rollout, so the states whose value stands in for
    # a future not seen are two an environment: where it was cut off, and where it is now.
    _, (value_cut, value_now) = lane.network(task.inputs[jnp.stack([cut, state])])
    later = jnp.concatenate([steps.value[1:], value_now[None]])
    next_value = jnp.where(steps.truncated, value_cut, later)
    advantage = generalised_advantages(
        steps.reward,
        steps.value,
        next_value,
        steps.terminated,
        steps.truncated,
        settings.discount,
        settings.gae_lambda,
    )

    loss, gradient = jax.value_and_grad(actor_critic_loss)(
        lane.network,
        task.inputs[steps.state],
        steps.action,
        advantage,
        advantage + steps.value,
        settings.entropy,
        settings.value,
    )
    change, optimizer = _optimizer(settings, shape).update(gradient, lane.optimizer)
    network = eqx.apply_updates(lane.network, change)
    log = Log(steps.terminated | steps.truncated, steps.tally, loss)
    return Lane(network, optimizer, state, tally, lane.key, lane.updates + 1), log


def _rollout(
    task: Task, settings: Settings, lane: Lane, draws: Float[Array, "T E"]
) -> tuple[Int[Array, "E"], Float[Array, "E 2+flags"], Int[Array, "E"], _Steps]:
    """T steps of E environments under the lane's policy.

    Returns:
        The states and tallies after them, the last state in which each environment was cut
        off (its start if it was not), and the steps.
    """

    def step(carry, draw: Float[Array, "E"]):
        state, tally, cut = carry
        logits, value = lane.network(task.inputs[state])
        action = _sample(logits, draw)
        reached = task.next_state[state, action]
        reward = task.reward[state, action]
        tally = tally + jnp.concatenate(
            [jnp.ones_like(reward)[:, None], reward[:, None], task.counted[reached]], axis=1
        )
        terminated = task.terminal[reached]
        truncated = ~terminated & (tally[:, 0] >= settings.episode_limit)
        ended = terminated | truncated
        learned_from = settings.reward_scale * (reward + settings.bonus[reached])
        steps = _Steps(state, action, learned_from, value, terminated, truncated, tally)
        after = (
            jnp.where(ended, task.start, reached),
            jnp.where(ended[:, None], 0.0, tally),
            jnp.where(truncated, reached, cut),
        )
        return after, steps

    first = (lane.state, lane.tally, jnp.full_like(lane.state, task.start))
    (state, tally, cut), steps = jax.lax.scan(step, first, draws)
    return state, tally, cut, steps


def actor_critic_loss(
    network: ActorCritic,
    inputs: Int[Array, "*batch factors"],
    action: Int[Array, "*batch"],
    advantage: Float[Array, "*batch"],
    target: Float[Array, "*batch"],
    entropy: Float[Array, ""] | float,
    value: Float[Array, ""] | float,
) -> Float[Array, ""]:
    """The mean over the batch of

        - log pi(a|s) * A  +  value * (V(s) - target)^2  -  entropy * H(pi(.|s))

    (Mnih et al. 2016), with H in nats; A and target are constants of the gradient.
    """
    logits, estimate = network(inputs)
    log_policy = jax.nn.log_softmax(logits)
    chosen = jnp.take_along_axis(log_policy, action[..., None], axis=-1)[..., 0]
    uncertainty = -(jnp.exp(log_policy) * log_policy).sum(axis=-1)
    advantage, target = jax.lax.stop_gradient((advantage, target))
    return (
        -chosen * advantage + value * jnp.square(estimate - target) - entropy * uncertainty
    ).mean()


def _sample(logits: Float[Array, "E A"], draw: Float[Array, "E"]) -> Int[Array, "E"]:
    """The action in whose share of [0, 1) each uniform draw falls."""
    below = jnp.cumsum(jax.nn.softmax(logits), axis=-1) <= draw[:, None]
    return jnp.minimum(below.sum(axis=-1), logits.shape[-1] - 1)


def _optimizer(settings: Settings, shape: Shape) -> optax.GradientTransformation:
    scale = {
        "rmsprop": optax.scale_by_rms(decay=0.99, eps=1e-5),
        "adam": optax.scale_by_adam(),
    }[shape.optimizer]
    return optax.chain(
        optax.clip_by_global_norm(settings.clip),  # pyright: ignore[reportArgumentType]
        scale,
        optax.scale_by_learning_rate(settings.learning_rate),
    )
