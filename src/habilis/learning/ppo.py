"""Proximal policy optimisation: several passes over a rollout, the policy held near the old."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from habilis.learning import actor_critic
from habilis.learning.actor_critic import Learner
from habilis.learning.rollout import Context, Experience, masked

start, act, preferences = actor_critic.start, actor_critic.act, actor_critic.preferences


def learn(
    context: Context,
    learner: Learner,
    experience: Experience,
) -> tuple[Learner, Float[Array, ""]]:
    """The learner after `epochs * minibatches` steps on a rollout, and the mean loss."""
    algorithm, numbers = context.algorithm, context.numbers
    advantage, target = actor_critic.advantages(context, learner.parameters, experience)
    available = context.task.available_in(experience.state)
    logits = experience.kept.activations[-1][..., :-1]
    log_policy = jax.nn.log_softmax(masked(logits, available))
    old = jnp.take_along_axis(log_policy, experience.action[..., None], axis=-1)[..., 0]
    batch = (experience.kept.inputs, experience.action, old, advantage, target, available)
    size = advantage.size
    flat = jax.tree.map(lambda x: x.reshape(size, *x.shape[2:]), batch)
    order = jax.vmap(lambda k: jax.random.permutation(k, size))(
        jax.random.split(context.key, algorithm.epochs)
    ).reshape(-1, size // algorithm.minibatches)
    entropy = actor_critic.entropy_weight(context)

    def step(learner: Learner, chosen: Int[Array, "n"]) -> tuple[Learner, Float[Array, ""]]:
        inputs, action, old, advantage, target, there = jax.tree.map(lambda x: x[chosen], flat)
        if algorithm.normalise:
            advantage = actor_critic.normalised(advantage, algorithm.unbiased)

        def loss(network):
            return clipped_loss(
                actor_critic.masked_outputs(network(inputs), there),
                action,
                old,
                advantage,
                target,
                numbers["clip_range"],
                entropy,
                numbers["value"],
            )

        value, gradient = jax.value_and_grad(loss)(learner.parameters)
        return actor_critic.descended(context, learner, gradient), value

    learner, losses = jax.lax.scan(step, learner, order)
    return learner, losses.mean()


def clipped_loss(
    outputs: Float[Array, "n A+1"],
    action: Int[Array, "n"],
    old: Float[Array, "n"],
    advantage: Float[Array, "n"],
    target: Float[Array, "n"],
    clip_range: Float[Array, ""] | float,
    entropy: Float[Array, ""] | float,
    value: Float[Array, ""] | float,
) -> Float[Array, ""]:
    """The mean over the batch of

        - min(k A, clip(k, 1 - c, 1 + c) A)  +  value * (V(s) - target)^2  -  entropy * H

    with k = pi(a|s) / pi_old(a|s) (Schulman et al. 2017, equation 7); `old` is log pi_old(a|s).
    """
    log_policy = jax.nn.log_softmax(outputs[:, :-1])
    chosen = jnp.take_along_axis(log_policy, action[:, None], axis=-1)[:, 0]
    ratio = jnp.exp(chosen - old)
    held = jnp.clip(ratio, 1 - clip_range, 1 + clip_range)
    uncertainty = -(jnp.exp(log_policy) * log_policy).sum(axis=-1)
    return (
        -jnp.minimum(ratio * advantage, held * advantage)
        + value * jnp.square(outputs[:, -1] - target)
        - entropy * uncertainty
    ).mean()
