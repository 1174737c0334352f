"""Tabular Q-learning (Watkins 1989)."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int, PRNGKeyArray

from habilis.checks import above_zero, at_least, check_types, setting, share
from habilis.learning.algorithms import help_texts
from habilis.learning.dynamics import Dynamics
from habilis.learning.rollout import Context, Experience, linear_schedule, masked


class ActionValues(NamedTuple):
    """Q(s, a)."""

    parameters: Float[Array, "S A"]


@dataclass(frozen=True)
class QLearning:
    """Tabular Q-learning with an epsilon-greedy policy (Watkins 1989)."""

    envs: int = setting(16, help_texts.ENVS, static=True)
    rollout: int = setting(5, help_texts.ROLLOUT, static=True)
    learning_rate: float = setting(0.5, "step size of the value update")
    epsilon: float = setting(0.1, "probability of a random action")
    epsilon_end: float = setting(0.002, "that probability after epsilon_steps")
    epsilon_steps: int = setting(200_000, "environment steps over which it changes; 0: constant")
    discount: float = setting(0.99, help_texts.DISCOUNT)
    reward_scale: float = setting(1.0, help_texts.REWARD_SCALE)

    tabular: ClassVar[bool] = True
    ignores: ClassVar[tuple[str, ...]] = ("observation", "policy_every")  # greedy: of 0 bits

    def __post_init__(self) -> None:
        check_types(self)
        at_least(self, envs=1, rollout=1, epsilon_steps=0)
        above_zero(self, "reward_scale")
        share(self, "learning_rate", "epsilon", "epsilon_end", "discount")

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
        """Epsilon-greedy: one draw decides both whether to explore and where."""
        available = context.dynamics.available_in(state)
        actions = context.dynamics.actions if available is None else available.sum(axis=-1)
        epsilon = linear_schedule(
            self.epsilon, self.epsilon_end, self.epsilon_steps, context.global_step
        )
        anything = jnp.floor(draw / jnp.maximum(epsilon, 1e-9) * actions).astype(jnp.int32)
        best = masked(train_state.parameters[state], available).argmax(axis=-1)
        explored = jnp.minimum(anything, actions - 1)
        if available is not None:  # an index into the available actions: which action that is
            explored = (jnp.cumsum(available, axis=-1) > explored[:, None]).argmax(axis=-1)
        return jnp.where(draw < epsilon, explored, best), ()

    def update(
        self, context: Context, train_state: ActionValues, experience: Experience
    ) -> tuple[ActionValues, Float[Array, ""]]:
        """The values after every step of a rollout in turn, and the mean squared error.

        Q(s, a) <- Q(s, a) + rate * (r + gamma * max over b in A(s') of Q(s', b) - Q(s, a))
        """
        dynamics = context.dynamics

        def step(values: Float[Array, "S A"], one: tuple) -> tuple[Array, Array]:
            state, action, reward, next_state, terminated = one
            best = masked(values[next_state], dynamics.available_in(next_state)).max()
            future = jnp.where(terminated, 0.0, best)
            error = reward + self.discount * future - values[state, action]
            return values.at[state, action].add(self.learning_rate * error), jnp.square(error)

        e = experience
        steps = jax.tree.map(
            lambda x: x.reshape(-1), (e.state, e.action, e.reward, e.next_state, e.terminated)
        )
        values, errors = jax.lax.scan(step, train_state.parameters, steps)
        return ActionValues(values), errors.mean()

    def policy(
        self, dynamics: Dynamics, parameters: Float[Array | np.ndarray, "S A"]
    ) -> Float[Array, "S A"]:
        """The greedy policy."""
        best = masked(parameters, dynamics.available).argmax(axis=-1)
        return jax.nn.one_hot(best, dynamics.actions)

    def values(
        self, dynamics: Dynamics, parameters: Float[Array | np.ndarray, "S A"]
    ) -> Float[Array, "S"]:
        return jnp.max(masked(parameters, dynamics.available), axis=-1)
