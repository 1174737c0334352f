"""Soft value iteration (Ziebart 2010): a baseline that knows the table."""

from dataclasses import dataclass
from typing import ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int, PRNGKeyArray

from habilis.checks import above_zero, at_least, check_types, setting, share
from habilis.learning.algorithms import help_texts
from habilis.learning.algorithms.q_learning import ActionValues
from habilis.learning.dynamics import Dynamics
from habilis.learning.rollout import Context, Experience, masked, sample_action


@dataclass(frozen=True)
class SoftValueIteration:
    """Soft value iteration on the known table (Ziebart 2010), a policy that is not learned.

    Q(s, a) = E[r + gamma * V(s')],    V(s) = T * log sum over a of exp(Q(s, a) / T)
    """

    envs: int = setting(16, help_texts.ENVS, static=True)
    rollout: int = setting(50, help_texts.ROLLOUT, static=True)
    sweeps: int = setting(1, "backups of all states between two rollouts", static=True)
    temperature: float = setting(0.1, "T: the policy is the softmax of Q / T")
    discount: float = setting(0.99, help_texts.DISCOUNT)
    reward_scale: float = setting(1.0, help_texts.REWARD_SCALE)

    tabular: ClassVar[bool] = True
    ignores: ClassVar[tuple[str, ...]] = ("observation", "limit_is_terminal", "policy_every")

    def __post_init__(self) -> None:
        check_types(self)
        at_least(self, envs=1, rollout=1, sweeps=1)
        above_zero(self, "temperature", "reward_scale")
        share(self, "discount")

    @property
    def counts_episodes(self) -> bool:
        return False

    def init(self, dynamics: Dynamics, rows: int, key: PRNGKeyArray) -> ActionValues:
        return ActionValues(jnp.zeros((dynamics.states, dynamics.actions)))

    def act(
        self,
        context: Context,
        train_state: ActionValues,
        state: Int[Array, "E"],
        draw: Float[Array, "E"],
    ) -> tuple[Int[Array, "E"], tuple[()]]:
        logits = train_state.parameters[state] / self.temperature
        return sample_action(logits, draw, context.dynamics.available_in(state)), ()

    def update(
        self, context: Context, train_state: ActionValues, experience: Experience
    ) -> tuple[ActionValues, Float[Array, ""]]:
        """The values after some backups of all states, and the largest change of the last.

        The experience does not matter: transitions and their probabilities are known. The soft
        maximum is over the available actions.
        """
        dynamics = context.dynamics
        reward = context.reward_fn(jnp.arange(len(dynamics.goes_on)))
        ends, shares = dynamics.goes_on < 0, dynamics.transitions.probabilities

        def backup(values: Float[Array, "S A"], _: None) -> tuple[Array, Array]:
            soft = self.values(dynamics, values)
            future = jnp.where(ends, 0.0, soft[dynamics.transitions.next_state])
            outcome = (reward + self.discount * future).reshape(shares.shape)
            new = (shares * outcome).sum(axis=1).reshape(values.shape)
            if dynamics.available is not None:
                new = jnp.where(dynamics.available, new, 0.0)
            return new, jnp.abs(new - values).max()

        values, changes = jax.lax.scan(backup, train_state.parameters, length=self.sweeps)
        return ActionValues(values), changes[-1]

    def policy(
        self, dynamics: Dynamics, parameters: Float[Array | np.ndarray, "S A"]
    ) -> Float[Array, "S A"]:
        return jax.nn.softmax(masked(parameters / self.temperature, dynamics.available))

    def values(
        self, dynamics: Dynamics, parameters: Float[Array | np.ndarray, "S A"]
    ) -> Float[Array, "S"]:
        logits = masked(parameters / self.temperature, dynamics.available)
        return jax.nn.logsumexp(logits, axis=-1) * self.temperature
