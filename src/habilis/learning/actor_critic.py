"""What the algorithms with a policy and a value network share."""

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from habilis.learning.algorithms import A2C, PPO
from habilis.learning.networks import Network
from habilis.learning.returns import generalised_advantages
from habilis.learning.rollout import Context, Experience, Numbers, linearly, masked, sampled
from habilis.learning.task import Task


class Learner(NamedTuple):
    """A network with one trunk for policy and value: logits of the actions, then the value."""

    parameters: Network
    optimizer: optax.OptState


class Decision(NamedTuple):
    """What is remembered of a decision: the network's inputs and what its layers gave out."""

    inputs: Int[Array, "*time factors"]
    activations: list[Float[Array, "*time _"]]


def start(task: Task, rows: int, algorithm: A2C | PPO, key: PRNGKeyArray) -> Learner:
    """A learner before its first step: an undecided policy, and a value that is near zero."""
    network = Network(rows, task.inputs.shape[1], task.actions + 1, algorithm.hidden, key)
    tree: Any = network
    return Learner(network, direction(algorithm).init(tree))


def act(
    context: Context,
    learner: Learner,
    state: Int[Array, "E"],
    draw: Float[Array, "E"],
) -> tuple[Int[Array, "E"], Decision]:
    inputs = context.task.inputs[state]
    activations = learner.parameters.activations(inputs)
    available = context.task.available_in(state)
    return sampled(activations[-1][:, :-1], draw, available), Decision(inputs, activations)


def preferences(task: Task, network: Network) -> Float[Array, "S A"]:
    """The logits of all actions in all states."""
    return masked(network(task.inputs)[:, :-1], task.available)


def masked_outputs(
    outputs: Float[Array, "*n A+1"], available: Bool[Array, "*n A"] | None
) -> Float[Array, "*n A+1"]:
    """Outputs whose logits leave unavailable actions a probability of 0, and no gradient."""
    if available is None:
        return outputs
    return jnp.concatenate([masked(outputs[..., :-1], available), outputs[..., -1:]], axis=-1)


def advantages(
    context: Context, network: Network, experience: Experience
) -> tuple[Float[Array, "T E"], Float[Array, "T E"]]:
    """Advantages, and the targets of the values."""
    value = experience.kept.activations[-1][..., -1]
    # An environment is cut off at most once a rollout, so the states whose value stands in for
    # a future not seen are two an environment: where it was cut off, and where it is now.
    cut = jnp.where(experience.truncated, experience.reached, 0).sum(axis=0)
    value_cut, value_now = network(context.task.inputs[jnp.stack([cut, experience.now])])[..., -1]
    later = jnp.concatenate([value[1:], value_now[None]])
    advantage = generalised_advantages(
        experience.reward,
        value,
        jnp.where(experience.truncated, value_cut, later),
        experience.terminated,
        experience.truncated,
        context.numbers["discount"],
        context.numbers["gae_lambda"],
    )
    return advantage, advantage + value


def normalised(advantage: Float[Array, "*n"]) -> Float[Array, "*n"]:
    return (advantage - advantage.mean()) / (advantage.std() + 1e-8)


def entropy_weight(context: Context) -> Float[Array, ""]:
    """After so many environment steps."""
    n = context.numbers
    since = context.taken - n["entropy_hold"]
    return linearly(n["entropy"], n["entropy_end"], n["entropy_steps"], since)


def descended(context: Context, learner: Learner, gradient: Any) -> Learner:
    """A learner after one step of its optimiser, on the gradient clipped to its largest norm."""
    numbers: Numbers = context.numbers
    norm = optax.tree.norm(gradient)
    shrink = jnp.minimum(1, numbers["clip"] / jnp.maximum(norm, 1e-30))
    gradient = jax.tree.map(partial(jnp.multiply, shrink), gradient)
    change, optimizer = direction(context.algorithm).update(gradient, learner.optimizer)
    network = jax.tree.map(
        lambda weight, step: weight - numbers["learning_rate"] * step,
        learner.parameters,
        change,
    )
    return Learner(network, optimizer)


def direction(algorithm: A2C | PPO) -> optax.GradientTransformation:
    """The optimiser, before its step size."""
    known = {
        "rmsprop": optax.scale_by_rms(decay=0.99, eps=1e-5),
        "adam": optax.scale_by_adam(),
    }
    return known[algorithm.optimizer]
