"""Tabular Q-learning."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PRNGKeyArray

from habilis.learning.algorithms import QLearning
from habilis.learning.rollout import Context, Experience, linearly
from habilis.learning.task import Task


class Learner(NamedTuple):
    """Q(s, a)."""

    parameters: Float[Array, "S A"]


def start(task: Task, rows: int, algorithm: QLearning, key: PRNGKeyArray) -> Learner:
    return Learner(jnp.zeros((task.states, task.actions)))


def act(
    context: Context,
    learner: Learner,
    state: Int[Array, "E"],
    draw: Float[Array, "E"],
) -> tuple[Int[Array, "E"], tuple[()]]:
    """Epsilon-greedy: one draw says both whether to explore and where."""
    n, actions = context.numbers, context.task.actions
    epsilon = linearly(n["epsilon"], n["epsilon_end"], n["epsilon_steps"], context.taken)
    anything = jnp.floor(draw / jnp.maximum(epsilon, 1e-9) * actions).astype(jnp.int32)
    best = learner.parameters[state].argmax(axis=-1)
    explored = jnp.minimum(anything, actions - 1)
    return jnp.where(draw < epsilon, explored, best), ()


def preferences(task: Task, values: Float[Array, "S A"]) -> Float[Array, "S A"]:
    return values


def learn(
    context: Context,
    learner: Learner,
    experience: Experience,
) -> tuple[Learner, Float[Array, ""]]:
    """The values after every step of a rollout, one after the other, and the mean squared error.

    Q(s, a) <- Q(s, a) + rate * (r + gamma * max over b of Q(s', b) - Q(s, a))
    """
    numbers = context.numbers

    def step(values: Float[Array, "S A"], one):
        state, action, reward, reached, terminated = one
        future = jnp.where(terminated, 0.0, values[reached].max())
        error = reward + numbers["discount"] * future - values[state, action]
        return values.at[state, action].add(numbers["learning_rate"] * error), jnp.square(error)

    e = experience
    steps = jax.tree.map(
        lambda x: x.reshape(-1), (e.state, e.action, e.reward, e.reached, e.terminated)
    )
    values, errors = jax.lax.scan(step, learner.parameters, steps)
    return Learner(values), errors.mean()
