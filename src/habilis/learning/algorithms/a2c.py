"""Advantage actor-critic (Mnih et al. 2016): one gradient step a rollout."""

from dataclasses import dataclass
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray, Shaped

from habilis.checks import setting
from habilis.learning.algorithms import actor_critic, help_texts
from habilis.learning.algorithms.actor_critic import Decision, TrainState
from habilis.learning.dynamics import Dynamics
from habilis.learning.networks import ActorCritic
from habilis.learning.rollout import Context, Experience, Number


@dataclass(frozen=True)
class A2C:
    """Advantage actor-critic (Mnih et al. 2016), the paper's.

    The defaults result from the calibration of the paper's tables (`research/calibration.py`).
    """

    envs: int = setting(16, help_texts.ENVS, static=True)
    rollout: int = setting(5, f"{help_texts.ROLLOUT}; 0 (A2C only): whole episodes", static=True)
    learning_rate: float = setting(1e-3, help_texts.LEARNING_RATE)
    learning_rate_end: float = setting(0.0, help_texts.LEARNING_RATE_END)
    learning_rate_steps: int = setting(0, help_texts.LEARNING_RATE_STEPS)
    learning_rate_decay: float = setting(1.0, help_texts.LEARNING_RATE_DECAY)
    learning_rate_every: int = setting(0, help_texts.LEARNING_RATE_EVERY)
    optimizer: str = setting("adam", help_texts.OPTIMIZER, static=True)
    clip: float = setting(0.5, help_texts.CLIP)
    entropy: float = setting(0.02, help_texts.ENTROPY)
    entropy_end: float = setting(0.0, help_texts.ENTROPY_END)
    entropy_steps: int = setting(2_500_000, help_texts.ENTROPY_STEPS)
    entropy_hold: int = setting(2_500_000, help_texts.ENTROPY_HOLD)
    schedule: str = setting("steps", help_texts.SCHEDULE, static=True)
    value: float = setting(0.5, help_texts.VALUE)
    discount: float = setting(0.99, help_texts.DISCOUNT)
    gae_lambda: float = setting(1.0, help_texts.GAE_LAMBDA)
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
        """The train state after one gradient step on a rollout, and the loss.

        The policy that acted is the one that learns, so the activations are those of the loss.
        """
        network = train_state.parameters
        advantage, target = actor_critic.advantages(self, context, network, experience)
        if self.normalise:
            advantage = actor_critic.normalised(advantage, self.unbiased, experience.mask)
        inputs, activations = jax.tree.map(_flat, experience.aux)
        available = context.dynamics.available_in(experience.state.reshape(-1))

        def loss_of(outputs: Float[Array, "n outputs"], *rest: Any) -> Float[Array, ""]:
            return actor_critic_loss(actor_critic.masked_outputs(outputs, available), *rest)

        loss, of_outputs = jax.value_and_grad(loss_of)(
            activations[-1],
            experience.action.reshape(-1),
            advantage.reshape(-1),
            target.reshape(-1),
            actor_critic.entropy_weight(self, context),
            self.value,
            None if experience.mask is None else experience.mask.reshape(-1),
        )
        gradient = network.gradient(inputs, activations, of_outputs)
        return actor_critic.apply_gradient(self, context, train_state, gradient), loss

    def policy(self, dynamics: Dynamics, parameters: ActorCritic) -> Float[Array, "S A"]:
        return actor_critic.policy(dynamics, parameters)

    def values(self, dynamics: Dynamics, parameters: ActorCritic) -> Float[Array, "S"]:
        return actor_critic.values(dynamics, parameters)


def actor_critic_loss(
    outputs: Float[Array, "n outputs"],
    action: Int[Array, "n"],
    advantage: Float[Array, "n"],
    target: Float[Array, "n"],
    entropy: Number,
    value: Number,
    mask: Bool[Array, "n"] | None = None,
) -> Float[Array, ""]:
    """The mean over the batch, or over its steps that were made, of

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
    ).mean(where=mask)


def _flat(x: Shaped[Array, "T E *rest"]) -> Shaped[Array, "n *rest"]:
    return x.reshape(-1, *x.shape[2:])
