"""Advantage actor-critic: one gradient step a rollout."""

from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from habilis.learning import actor_critic
from habilis.learning.actor_critic import Learner
from habilis.learning.rollout import Context, Experience

start, act, preferences = actor_critic.start, actor_critic.act, actor_critic.preferences


def learn(
    context: Context,
    learner: Learner,
    experience: Experience,
) -> tuple[Learner, Float[Array, ""]]:
    """The learner after one step on a rollout, and the loss.

    The policy that acted is the one that learns, so the activations are those of the loss.
    """
    network = learner.parameters
    advantage, target = actor_critic.advantages(context, network, experience)
    if context.algorithm.normalise:
        unbiased = context.algorithm.unbiased
        advantage = actor_critic.normalised(advantage, unbiased, experience.made)
    inputs, activations = jax.tree.map(_flat, experience.kept)
    available = context.task.available_in(experience.state.reshape(-1))

    def loss_of(outputs: Float[Array, "n A+1"], *rest: Any) -> Float[Array, ""]:
        return actor_critic_loss(actor_critic.masked_outputs(outputs, available), *rest)

    loss, of_outputs = jax.value_and_grad(loss_of)(
        activations[-1],
        experience.action.reshape(-1),
        advantage.reshape(-1),
        target.reshape(-1),
        actor_critic.entropy_weight(context),
        context.numbers["value"],
        None if experience.made is None else experience.made.reshape(-1),
    )
    gradient = network.gradient(inputs, activations, of_outputs)
    return actor_critic.descended(context, learner, gradient), loss


def actor_critic_loss(
    outputs: Float[Array, "n A+1"],
    action: Int[Array, "n"],
    advantage: Float[Array, "n"],
    target: Float[Array, "n"],
    entropy: Float[Array, ""] | float,
    value: Float[Array, ""] | float,
    made: Bool[Array, "n"] | None = None,
) -> Float[Array, ""]:
    """The mean over the batch, or those of its steps that were made, of

        - log pi(a|s) * A  +  value * (V(s) - target)^2  -  entropy * H(pi(.|s))

    (Mnih et al. 2016), with H in nats; A and target are constants of the gradient.
    """
    logits, estimate = outputs[:, :-1], outputs[:, -1]
    log_policy = jax.nn.log_softmax(logits)
    # A product with zeros and ones: its gradient is no scatter, as that of an index would be.
    chosen = (log_policy * jax.nn.one_hot(action, logits.shape[-1])).sum(axis=-1)
    uncertainty = -(jnp.exp(log_policy) * log_policy).sum(axis=-1)
    return (
        -chosen * advantage + value * jnp.square(estimate - target) - entropy * uncertainty
    ).mean(where=made)


def _flat(x: Float[Array, "T E *rest"]) -> Float[Array, "n *rest"]:
    return x.reshape(-1, *x.shape[2:])
