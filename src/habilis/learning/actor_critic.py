"""What the algorithms with a policy and a value network share."""

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from habilis.learning.algorithms import A2C, PPO
from habilis.learning.networks import Inputs, Network, Separate, actor_critic_network
from habilis.learning.returns import generalised_advantages
from habilis.learning.rollout import Context, Experience, linearly, masked, sampled
from habilis.learning.task import Task


class Learner(NamedTuple):
    """A network whose outputs are the logits of the actions, then the value."""

    parameters: Network | Separate
    optimizer: optax.OptState


class Decision(NamedTuple):
    """What is remembered of a decision: the network's inputs and what its layers gave out."""

    inputs: Inputs
    activations: list[Float[Array, "*time _"]]


def start(task: Task, rows: int, algorithm: A2C | PPO, key: PRNGKeyArray) -> Learner:
    """A learner before its first step, with the initial weights that the settings name."""
    network = actor_critic_network(
        algorithm.networks,
        rows,
        task.inputs.shape[1],
        task.actions,
        algorithm.hidden,
        key,
        algorithm.activation,
        algorithm.initialisation,
    )
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


def preferences(task: Task, network: Network | Separate) -> Float[Array, "S A"]:
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
    context: Context, network: Network | Separate, experience: Experience
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


def normalised(
    advantage: Float[Array, "*n"],
    unbiased: bool = False,
    counted: Bool[Array, "*n"] | None = None,
) -> Float[Array, "*n"]:
    """Advantages of mean 0 and deviation 1.

    Args:
        advantage: of the steps of a batch.
        unbiased: whether the deviation is the unbiased one, of n - 1. A single step has none, and
            an advantage of 0.
        counted: which of the steps there are; `None`: all.
    """
    centred = advantage - advantage.mean(where=counted)
    count = advantage.size if counted is None else counted.sum()
    squares = jnp.square(centred).sum(where=counted)
    deviation = jnp.sqrt(squares / jnp.maximum(count - int(unbiased), 1))
    return centred / (deviation + 1e-8)


def entropy_weight(context: Context) -> Float[Array, ""]:
    """After so many environment steps, or episodes."""
    n = context.numbers
    since = _clock(context) - n["entropy_hold"]
    return linearly(n["entropy"], n["entropy_end"], n["entropy_steps"], since)


def learning_rate(context: Context) -> Float[Array, ""]:
    """After so many environment steps, or episodes."""
    n, clock = context.numbers, _clock(context)
    rate = linearly(n["learning_rate"], n["learning_rate_end"], n["learning_rate_steps"], clock)
    every = n["learning_rate_every"]
    decays = jnp.where(every > 0, jnp.floor(clock / jnp.maximum(every, 1)), 0.0)
    return rate * n["learning_rate_decay"] ** decays


def _clock(context: Context) -> Float[Array, ""]:
    return context.taken if context.algorithm.schedule == "steps" else context.episodes


def descended(context: Context, learner: Learner, gradient: Any) -> Learner:
    """A learner after one step of its optimiser, on the gradient clipped to its largest norm."""
    largest = context.numbers["clip"]
    if isinstance(gradient, Separate):
        gradient = Separate(_clipped(gradient.policy, largest), _clipped(gradient.value, largest))
    else:
        gradient = _clipped(gradient, largest)
    change, optimizer = direction(context.algorithm).update(gradient, learner.optimizer)
    rate = learning_rate(context)
    network = jax.tree.map(
        lambda weight, step: weight - rate * step,
        learner.parameters,
        change,
    )
    return Learner(network, optimizer)


def _clipped(gradient: Any, largest: Float[Array, ""]) -> Any:
    """A gradient whose norm is at most so large; 0: as it is."""
    norm = optax.tree.norm(gradient)
    shrink = jnp.minimum(1, largest / jnp.maximum(norm, 1e-30))
    return jax.tree.map(partial(jnp.multiply, jnp.where(largest > 0, shrink, 1.0)), gradient)


def direction(algorithm: A2C | PPO) -> optax.GradientTransformation:
    """The optimiser, before its step size."""
    known = {
        "rmsprop": optax.scale_by_rms(decay=0.99, eps=1e-5),
        "rmsprop-torch": optax.scale_by_rms(decay=0.99, eps=1e-5, eps_in_sqrt=False),
        "adam": optax.scale_by_adam(),
    }
    return known[algorithm.optimizer]
