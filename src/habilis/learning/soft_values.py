"""Soft value iteration: a baseline that knows the table."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PRNGKeyArray

from habilis.learning.algorithms import SoftValueIteration
from habilis.learning.q_learning import Learner
from habilis.learning.rollout import Context, Experience, masked, sampled
from habilis.learning.task import Task


def start(task: Task, rows: int, algorithm: SoftValueIteration, key: PRNGKeyArray) -> Learner:
    return Learner(jnp.zeros((task.states, task.actions)))


def act(
    context: Context,
    learner: Learner,
    state: Int[Array, "E"],
    draw: Float[Array, "E"],
) -> tuple[Int[Array, "E"], tuple[()]]:
    logits = learner.parameters[state] / context.numbers["temperature"]
    return sampled(logits, draw, context.task.available_in(state)), ()


def preferences(task: Task, values: Float[Array, "S A"]) -> Float[Array, "S A"]:
    return masked(values, task.available)


def learn(
    context: Context,
    learner: Learner,
    experience: Experience,
) -> tuple[Learner, Float[Array, ""]]:
    """The values after some backups of all states, and the largest change of the last.

    What was experienced does not matter; the table is known, and with it how likely what is. The
    soft maximum is over the actions that are available.
    """
    task, numbers = context.task, context.numbers
    reward = context.worth(jnp.arange(len(task.goes_on)))
    ends, shares = task.goes_on < 0, task.transitions.probabilities

    def backup(values: Float[Array, "S A"], _: None) -> tuple[Array, Array]:
        logits = masked(values / numbers["temperature"], task.available)
        soft = jax.nn.logsumexp(logits, axis=-1) * numbers["temperature"]
        future = jnp.where(ends, 0.0, soft[task.transitions.next_state])
        worth = (reward + numbers["discount"] * future).reshape(shares.shape)
        new = (shares * worth).sum(axis=1).reshape(values.shape)
        if task.available is not None:
            new = jnp.where(task.available, new, 0.0)
        return new, jnp.abs(new - values).max()

    values, changes = jax.lax.scan(backup, learner.parameters, length=context.algorithm.sweeps)
    return Learner(values), changes[-1]
