"""An algorithm that does not come with the package: expected SARSA with a softmax policy."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PRNGKeyArray

from habilis.checks import above_zero, at_least, check_types, setting, share
from habilis.learning.dynamics import Dynamics
from habilis.learning.rollout import Context, Experience, masked, sample_action


class Values(NamedTuple):
    parameters: Float[Array, "S A"]


@dataclass(frozen=True)
class ExpectedSarsa:
    """Q(s, a) <- Q(s, a) + rate * (r + gamma * sum over b of pi(b|s') Q(s', b) - Q(s, a))."""

    envs: int = setting(8, "environments of a run", static=True)
    rollout: int = setting(4, "steps between two updates", static=True)
    passes: int = setting(1, "passes over a rollout", static=True)
    learning_rate: float = setting(0.3, "step size of the value update")
    softness: float = setting(0.2, "temperature of the policy")
    discount: float = setting(0.95, "gamma")
    reward_scale: float = setting(1.0, "factor on the reward")

    tabular: ClassVar[bool] = True
    ignores: ClassVar[tuple[str, ...]] = ("observation",)

    def __post_init__(self) -> None:
        check_types(self)
        at_least(self, envs=1, rollout=1, passes=1)
        above_zero(self, "softness", "reward_scale")
        share(self, "learning_rate", "discount")

    @property
    def counts_episodes(self) -> bool:
        return False

    def init(self, dynamics: Dynamics, rows: int, key: PRNGKeyArray) -> Values:
        return Values(jnp.zeros((dynamics.states, dynamics.actions)))

    def act(
        self,
        context: Context,
        train_state: Values,
        state: Int[Array, "E"],
        draw: Float[Array, "E"],
    ) -> tuple[Int[Array, "E"], tuple[()]]:
        logits = train_state.parameters[state] / self.softness
        return sample_action(logits, draw, context.dynamics.available_in(state)), ()

    def update(
        self, context: Context, train_state: Values, experience: Experience
    ) -> tuple[Values, Float[Array, ""]]:
        e, dynamics = experience, context.dynamics

        def once(q: Float[Array, "S A"], _: None) -> tuple[Array, Array]:
            value = jnp.where(e.terminated, 0.0, self.values(dynamics, q)[e.next_state])
            error = e.reward + self.discount * value - q[e.state, e.action]
            return q.at[e.state, e.action].add(self.learning_rate * error / self.envs), error

        q, errors = jax.lax.scan(once, train_state.parameters, length=self.passes)
        return Values(q), jnp.square(errors).mean()

    def policy(self, dynamics: Dynamics, parameters: Float[Array, "S A"]) -> Float[Array, "S A"]:
        return jax.nn.softmax(masked(parameters / self.softness, dynamics.available))

    def values(self, dynamics: Dynamics, parameters: Float[Array, "S A"]) -> Float[Array, "S"]:
        return (self.policy(dynamics, parameters) * parameters).sum(axis=-1)
