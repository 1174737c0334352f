"""Proximal policy optimisation: several passes over a rollout, the policy held near the old."""

from dataclasses import dataclass
from typing import ClassVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PRNGKeyArray

from habilis.checks import above_zero, at_least, setting
from habilis.learning.algorithms import actor_critic, help_texts
from habilis.learning.algorithms.actor_critic import Decision, TrainState
from habilis.learning.dynamics import Dynamics
from habilis.learning.networks import ActorCritic
from habilis.learning.rollout import Context, Experience, Number, masked


@dataclass(frozen=True)
class PPO:
    """Proximal policy optimisation with a clipped objective (Schulman et al. 2017)."""

    envs: int = setting(16, help_texts.ENVS, static=True)
    rollout: int = setting(32, help_texts.ROLLOUT, static=True)
    epochs: int = setting(4, "passes over each rollout", static=True)
    minibatches: int = setting(4, "parts of a rollout, with one gradient step each", static=True)
    learning_rate: float = setting(1e-3, help_texts.LEARNING_RATE)
    learning_rate_end: float = setting(0.0, help_texts.LEARNING_RATE_END)
    learning_rate_steps: int = setting(0, help_texts.LEARNING_RATE_STEPS)
    learning_rate_decay: float = setting(1.0, help_texts.LEARNING_RATE_DECAY)
    learning_rate_every: int = setting(0, help_texts.LEARNING_RATE_EVERY)
    optimizer: str = setting("adam", help_texts.OPTIMIZER, static=True)
    clip: float = setting(0.5, help_texts.CLIP)
    clip_range: float = setting(
        0.2, "clipping range of the ratio of new to old action probabilities"
    )
    entropy: float = setting(0.02, help_texts.ENTROPY)
    entropy_end: float = setting(0.0, help_texts.ENTROPY_END)
    entropy_steps: int = setting(0, help_texts.ENTROPY_STEPS)
    entropy_hold: int = setting(0, help_texts.ENTROPY_HOLD)
    schedule: str = setting("steps", help_texts.SCHEDULE, static=True)
    value: float = setting(0.5, help_texts.VALUE)
    discount: float = setting(0.99, help_texts.DISCOUNT)
    gae_lambda: float = setting(0.95, help_texts.GAE_LAMBDA)
    normalise: bool = setting(False, help_texts.NORMALISE, static=True)
    unbiased: bool = setting(False, help_texts.UNBIASED, static=True)
    reward_scale: float = setting(0.1, help_texts.REWARD_SCALE)
    hidden: tuple[int, ...] = setting((64, 64), help_texts.HIDDEN, static=True)
    networks: str = setting("shared", help_texts.NETWORKS, static=True)
    activation: str = setting("tanh", help_texts.ACTIVATION, static=True)
    initialisation: str = setting("lecun", help_texts.INITIALISATION, static=True)

    tabular: ClassVar[bool] = False
    ignores: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self) -> None:
        actor_critic.check_settings(self)
        at_least(self, rollout=1, epochs=1, minibatches=1)
        above_zero(self, "clip_range")
        if self.envs * self.rollout % self.minibatches:
            raise ValueError(
                f"minibatches is {self.minibatches}; give a divisor of envs * rollout, "
                f"{self.envs * self.rollout}"
            )

    @property
    def counts_episodes(self) -> bool:
        return self.schedule == "episodes"

    def init(self, dynamics: Dynamics, rows: int, key: PRNGKeyArray) -> TrainState:
        return actor_critic.init(self, dynamics, rows, key)

    def act(
        self,
        context: Context,
        train_state: TrainState,
        state: Int[Array, "E"],
        draw: Float[Array, "E"],
    ) -> tuple[Int[Array, "E"], Decision]:
        return actor_critic.act(context, train_state, state, draw)

    def update(
        self, context: Context, train_state: TrainState, experience: Experience
    ) -> tuple[TrainState, Float[Array, ""]]:
        """The train state after `epochs * minibatches` steps on a rollout, and the mean loss."""
        network = train_state.parameters
        advantage, target = actor_critic.advantages(self, context, network, experience)
        available = context.dynamics.available_in(experience.state)
        logits = experience.aux.activations[-1][..., :-1]
        log_policy = jax.nn.log_softmax(masked(logits, available))
        old = jnp.take_along_axis(log_policy, experience.action[..., None], axis=-1)[..., 0]
        batch = (experience.aux.inputs, experience.action, old, advantage, target, available)
        size = advantage.size
        flat = jax.tree.map(lambda x: x.reshape(size, *x.shape[2:]), batch)
        order = jax.vmap(lambda k: jax.random.permutation(k, size))(
            jax.random.split(context.key, self.epochs)
        ).reshape(-1, size // self.minibatches)
        entropy = actor_critic.entropy_weight(self, context)

        def step(
            train_state: TrainState, chosen: Int[Array, "n"]
        ) -> tuple[TrainState, Float[Array, ""]]:
            inputs, action, old, advantage, target, there = jax.tree.map(lambda x: x[chosen], flat)
            if self.normalise:
                advantage = actor_critic.normalised(advantage, self.unbiased)

            def loss(network: ActorCritic) -> Float[Array, ""]:
                return clipped_loss(
                    actor_critic.masked_outputs(network(inputs), there),
                    action,
                    old,
                    advantage,
                    target,
                    self.clip_range,
                    entropy,
                    self.value,
                )

            value, gradient = jax.value_and_grad(loss)(train_state.parameters)
            return actor_critic.apply_gradient(self, context, train_state, gradient), value

        train_state, losses = jax.lax.scan(step, train_state, order)
        return train_state, losses.mean()

    def policy(self, dynamics: Dynamics, parameters: ActorCritic) -> Float[Array, "S A"]:
        return actor_critic.policy(dynamics, parameters)

    def values(self, dynamics: Dynamics, parameters: ActorCritic) -> Float[Array, "S"]:
        return actor_critic.values(dynamics, parameters)


def clipped_loss(
    outputs: Float[Array, "n outputs"],
    action: Int[Array, "n"],
    old: Float[Array, "n"],
    advantage: Float[Array, "n"],
    target: Float[Array, "n"],
    clip_range: Number,
    entropy: Number,
    value: Number,
) -> Float[Array, ""]:
    """The mean over the batch of

        - min(k A, clip(k, 1 - c, 1 + c) A)  +  value * (V(s) - target)^2  -  entropy * H

    with k = pi(a|s) / pi_old(a|s) (Schulman et al. 2017, equation 7); `old` is log pi_old(a|s).
    """
    log_policy = jax.nn.log_softmax(outputs[:, :-1])
    chosen = jnp.take_along_axis(log_policy, action[:, None], axis=-1)[:, 0]
    ratio = jnp.exp(chosen - old)
    clipped = jnp.clip(ratio, 1 - clip_range, 1 + clip_range)
    uncertainty = -(jnp.exp(log_policy) * log_policy).sum(axis=-1)
    return (
        -jnp.minimum(ratio * advantage, clipped * advantage)
        + value * jnp.square(outputs[:, -1] - target)
        - entropy * uncertainty
    ).mean()
