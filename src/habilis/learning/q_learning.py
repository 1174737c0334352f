"""Tabular Q-learning."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PRNGKeyArray

from habilis.learning.algorithms import QLearning
from habilis.learning.rollout import Context, Experience, linearly, masked
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
    n, there = context.numbers, context.task.available_in(state)
    actions = context.task.actions if there is None else there.sum(axis=-1)
    epsilon = linearly(n["epsilon"], n["epsilon_end"], n["epsilon_steps"], context.taken)
    anything = jnp.floor(draw / jnp.maximum(epsilon, 1e-9) * actions).astype(jnp.int32)
    best = masked(learner.parameters[state], there).argmax(axis=-1)
    explored = jnp.minimum(anything, actions - 1)
    if there is not None:  # the so manieth of those available
        explored = (jnp.cumsum(there, axis=-1) > explored[:, None]).argmax(axis=-1)
    return jnp.where(draw < epsilon, explored, best), ()


def preferences(task: Task, values: Float[Array, "S A"]) -> Float[Array, "S A"]:
    return masked(values, task.available)


def learn(
    context: Context,
    learner: Learner,
    experience: Experience,
) -> tuple[Learner, Float[Array, ""]]:
    """The values after every step of a rollout, one after the other, and the mean squared error.

    Q(s, a) <- Q(s, a) + rate * (r + gamma * max over b in A(s') of Q(s', b) - Q(s, a))
    """
    numbers, task = context.numbers, context.task

    def step(values: Float[Array, "S A"], one):
        state, action, reward, reached, terminated = one
        best = masked(values[reached], task.available_in(reached)).max()
        future = jnp.where(terminated, 0.0, best)
        error = reward + numbers["discount"] * future - values[state, action]
        return values.at[state, action].add(numbers["learning_rate"] * error), jnp.square(error)

    e = experience
    steps = jax.tree.map(
        lambda x: x.reshape(-1), (e.state, e.action, e.reward, e.reached, e.terminated)
    )
    values, errors = jax.lax.scan(step, learner.parameters, steps)
    return Learner(values), errors.mean()
