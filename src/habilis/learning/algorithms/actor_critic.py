"""The shared parts of algorithms with a policy and a value network."""

from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from habilis.checks import above_zero, at_least, check_types, one_of, share, widths
from habilis.learning.dynamics import Dynamics
from habilis.learning.networks import (
    ACTIVATIONS,
    INITIALISATIONS,
    NETWORKS,
    ActorCritic,
    Inputs,
    Separate,
    actor_critic_network,
)
from habilis.learning.rollout import (
    Context,
    Experience,
    Number,
    linear_schedule,
    masked,
    sample_action,
)

if TYPE_CHECKING:
    from habilis.learning.algorithms.a2c import A2C
    from habilis.learning.algorithms.ppo import PPO

SCHEDULES = ("steps", "episodes")
OPTIMIZERS = {
    "rmsprop": optax.scale_by_rms(decay=0.99, eps=1e-5),
    "rmsprop-torch": optax.scale_by_rms(decay=0.99, eps=1e-5, eps_in_sqrt=False),
    "adam": optax.scale_by_adam(),
}
"""The optimisers, before their step size."""


class TrainState(NamedTuple):
    """A network whose outputs are the logits of the actions, then the value; its optimiser."""

    parameters: ActorCritic
    optimizer: optax.OptState


class Decision(NamedTuple):
    """The record of a decision: the network's inputs, and the outputs of its layers."""

    inputs: Inputs
    activations: list[Float[Array, "*time _"]]


def check_settings(settings: "A2C | PPO") -> None:
    """Refuses what is out of range.

    Raises:
        ValueError: names the setting.
    """
    object.__setattr__(settings, "hidden", widths(settings.hidden))
    check_types(settings)
    at_least(settings, envs=1, rollout=0, clip=0, entropy=0, entropy_end=0, value=0)
    at_least(settings, entropy_steps=0, entropy_hold=0, learning_rate_end=0)
    at_least(settings, learning_rate_steps=0, learning_rate_every=0)
    above_zero(settings, "learning_rate", "learning_rate_decay", "reward_scale")
    share(settings, "discount", "gae_lambda")
    one_of(settings, "optimizer", tuple(OPTIMIZERS))
    one_of(settings, "schedule", SCHEDULES)
    one_of(settings, "networks", NETWORKS)
    one_of(settings, "activation", tuple(ACTIVATIONS))
    one_of(settings, "initialisation", INITIALISATIONS)
    if settings.unbiased and not settings.normalise:
        raise ValueError(
            "unbiased is True and normalise False; turn on normalise, or turn off unbiased"
        )


def init(settings: "A2C | PPO", dynamics: Dynamics, rows: int, key: PRNGKeyArray) -> TrainState:
    """A train state with the initial weights that the settings name."""
    network = actor_critic_network(
        settings.networks,
        rows,
        dynamics.inputs.shape[1],
        dynamics.actions,
        settings.hidden,
        key,
        settings.activation,
        settings.initialisation,
    )
    tree: Any = network
    return TrainState(network, OPTIMIZERS[settings.optimizer].init(tree))


def act(
    context: Context,
    train_state: TrainState,
    state: Int[Array, "E"],
    draw: Float[Array, "E"],
) -> tuple[Int[Array, "E"], Decision]:
    """An action drawn from the policy in each state."""
    inputs = context.dynamics.inputs[state]
    activations = train_state.parameters.activations(inputs)
    available = context.dynamics.available_in(state)
    return sample_action(activations[-1][:, :-1], draw, available), Decision(inputs, activations)


def policy(dynamics: Dynamics, network: ActorCritic) -> Float[Array, "S A"]:
    return jax.nn.softmax(masked(network(dynamics.inputs)[:, :-1], dynamics.available))


def values(dynamics: Dynamics, network: ActorCritic) -> Float[Array, "S"]:
    return network(dynamics.inputs)[:, -1]


def masked_outputs(
    outputs: Float[Array, "*n outputs"], available: Bool[Array, "*n A"] | None
) -> Float[Array, "*n outputs"]:
    """Outputs whose logits leave unavailable actions a probability of 0, and no gradient."""
    if available is None:
        return outputs
    return jnp.concatenate([masked(outputs[..., :-1], available), outputs[..., -1:]], axis=-1)


def advantages(
    settings: "A2C | PPO", context: Context, network: ActorCritic, experience: Experience
) -> tuple[Float[Array, "T E"], Float[Array, "T E"]]:
    """Advantages, and the targets of the values."""

    def value_of(states: Int[Array, "E"]) -> Float[Array, "E"]:
        return network(context.dynamics.inputs[states])[..., -1]

    def bootstrapped(later: Float[Array, "T E"]) -> Float[Array, "T E"]:
        # An environment is truncated at most once a rollout.
        cut = jnp.where(experience.truncated, experience.next_state, 0).sum(axis=0)
        return jnp.where(experience.truncated, value_of(cut), later)

    value = experience.aux.activations[-1][..., -1]
    later = jnp.concatenate([value[1:], value_of(experience.last_state)[None]])
    # Most rollouts have no truncated episode.
    truncated = context.in_any_lane(experience.truncated.any())
    advantage = generalised_advantages(
        experience.reward,
        value,
        jax.lax.cond(truncated, bootstrapped, lambda later: later, later),
        experience.terminated,
        experience.truncated,
        settings.discount,
        settings.gae_lambda,
    )
    return advantage, advantage + value


def generalised_advantages(
    reward: Float[Array, "T E"],
    value: Float[Array, "T E"],
    next_value: Float[Array, "T E"],
    terminated: Bool[Array, "T E"],
    truncated: Bool[Array, "T E"],
    discount: Number,
    gae_lambda: Number,
) -> Float[Array, "T E"]:
    """The generalised advantage estimate (Schulman et al. 2016).

        delta_t = r_t + discount * V(s'_t) - V(s_t)          V(s'_t) = 0 where s'_t is terminal
        A_t     = delta_t + discount * lambda * A_{t+1}      the sum ends where an episode does

    With lambda 1 the estimate plus `value` is the n-step return.

    Args:
        reward, value: r_t and V(s_t) of step t in environment e.
        next_value: V(s'_t) of the state the step led to, before any reset. Where an episode is
            truncated, it is bootstrapped from; where it terminates, it is not used.
        terminated, truncated: whether the step ended its episode, and how.
        discount, gae_lambda: between 0 and 1.
    """
    delta = reward + discount * jnp.where(terminated, 0.0, next_value) - value
    decay = discount * gae_lambda * ~(terminated | truncated)

    def back(later: Float[Array, "E"], step: tuple) -> tuple[Array, Array]:
        advantage = jax.lax.optimization_barrier(step[0] + step[1] * later)
        return advantage, advantage

    _, advantages = jax.lax.scan(
        back, jnp.zeros_like(value[0]), (delta, decay), reverse=True, unroll=8
    )
    return advantages


def normalised(
    advantage: Float[Array, "*n"],
    unbiased: bool = False,
    mask: Bool[Array, "*n"] | None = None,
) -> Float[Array, "*n"]:
    """Advantages of mean 0 and deviation 1.

    Args:
        advantage: of the steps of a batch.
        unbiased: whether the deviation is the unbiased one, of n - 1. A single step has none, and
            an advantage of 0.
        mask: which of the steps were made; `None`: all.
    """
    centred = advantage - advantage.mean(where=mask)
    count = advantage.size if mask is None else mask.sum()
    squares = jnp.square(centred).sum(where=mask)
    deviation = jnp.sqrt(squares / jnp.maximum(count - int(unbiased), 1))
    return centred / (deviation + 1e-8)


def entropy_weight(settings: "A2C | PPO", context: Context) -> Float[Array, ""]:
    """The weight of the entropy in the loss, at this step or after so many episodes."""
    s = settings
    since = _clock(settings, context) - s.entropy_hold
    return linear_schedule(s.entropy, s.entropy_end, s.entropy_steps, since)


def learning_rate(settings: "A2C | PPO", context: Context) -> Float[Array, ""]:
    """The step size, at this step or after so many episodes."""
    s, clock = settings, _clock(settings, context)
    rate = linear_schedule(s.learning_rate, s.learning_rate_end, s.learning_rate_steps, clock)
    every = s.learning_rate_every
    decays = jnp.where(every > 0, jnp.floor(clock / jnp.maximum(every, 1)), 0.0)
    return rate * s.learning_rate_decay**decays


def _clock(settings: "A2C | PPO", context: Context) -> Number:
    return context.global_step if settings.schedule == "steps" else context.episodes


def apply_gradient(
    settings: "A2C | PPO", context: Context, train_state: TrainState, gradient: Any
) -> TrainState:
    """One step of the optimiser, on the gradient clipped to its largest norm."""
    largest = settings.clip
    if isinstance(gradient, Separate):
        gradient = Separate(_clipped(gradient.policy, largest), _clipped(gradient.value, largest))
    else:
        gradient = _clipped(gradient, largest)
    change, optimizer = OPTIMIZERS[settings.optimizer].update(gradient, train_state.optimizer)
    rate = learning_rate(settings, context)
    network = jax.tree.map(
        lambda weight, step: weight - rate * step,
        train_state.parameters,
        change,
    )
    return TrainState(network, optimizer)


def _clipped(gradient: Any, largest: Number) -> Any:
    """A gradient whose norm is at most so large; 0: as it is."""
    norm = optax.tree.norm(gradient)
    shrink = jnp.minimum(1, largest / jnp.maximum(norm, 1e-30))
    return jax.tree.map(partial(jnp.multiply, jnp.where(largest > 0, shrink, 1.0)), gradient)
