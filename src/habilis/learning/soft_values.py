"""Soft value iteration: a baseline that knows the table."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PRNGKeyArray

from habilis.learning.algorithms import SoftValueIteration
from habilis.learning.q_learning import Learner
from habilis.learning.rollout import Context, Experience, sampled
from habilis.learning.task import Task


def start(task: Task, rows: int, algorithm: SoftValueIteration, key: PRNGKeyArray) -> Learner:
    return Learner(jnp.zeros((task.states, task.actions)))


def act(
    context: Context,
    learner: Learner,
    state: Int[Array, "E"],
    draw: Float[Array, "E"],
) -> tuple[Int[Array, "E"], tuple[()]]:
    return sampled(learner.parameters[state] / context.numbers["temperature"], draw), ()


def preferences(task: Task, values: Float[Array, "S A"]) -> Float[Array, "S A"]:
    return values


def learn(
    context: Context,
    learner: Learner,
    experience: Experience,
) -> tuple[Learner, Float[Array, ""]]:
    """The values after some backups of all states, and the largest change of the last.

    What was experienced does not matter; the table is known, and with it how likely what is.
    """
    task, numbers = context.task, context.numbers
    reward = context.worth(jnp.arange(len(task.next_state)))
    ends, shares = task.goes_on < 0, task.shares()

    def backup(values: Float[Array, "S A"], _: None) -> tuple[Array, Array]:
        soft = jax.nn.logsumexp(values / numbers["temperature"], axis=-1) * numbers["temperature"]
        future = jnp.where(ends, 0.0, soft[task.next_state])
        worth = (reward + numbers["discount"] * future).reshape(-1, task.outcomes)
        new = (shares * worth).sum(axis=1).reshape(values.shape)
        return new, jnp.abs(new - values).max()

    values, changes = jax.lax.scan(backup, learner.parameters, length=context.algorithm.sweeps)
    return Learner(values), changes[-1]
