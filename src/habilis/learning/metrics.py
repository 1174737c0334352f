"""Metrics of the runs that train, noted from time to time."""

import time
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from habilis.learning import intrinsic
from habilis.learning.algorithms.protocol import bound
from habilis.learning.dynamics import Dynamics
from habilis.learning.jobs import Job
from habilis.learning.lanes import Lane, Program, Settings
from habilis.learning.runs import Metrics
from habilis.rewards.shaping import beta_after

EPISODES = 100
"""Over how many of the last episodes return and length are averaged."""


def note_metrics(job: Job) -> None:
    """Notes the metrics of every run that has trained on since they were last noted."""
    for run, record in enumerate(job.records):
        noted = record.metrics()
        if record.last is not None and (not len(noted) or noted[-1, 0] < record.steps):
            record.note(_metrics(job, run))


def _metrics(job: Job, run: int) -> Metrics:
    record = job.records[run]
    assert record.last is not None
    assert record.began is not None
    recent = record.episodes()[-EPISODES:]
    steps, episode_return = recent[:, :2].mean(axis=0) if len(recent) else (np.nan, np.nan)
    entropy, bonus, beta = _measured(
        job.dynamics[0],
        job.settings,
        job.lane(run),
        jnp.asarray(record.last.transitions),
        np.float32(record.steps),
        job.program,
    )
    return Metrics(
        step=record.steps,
        time=time.time(),
        episode=record.count,
        episode_return=float(episode_return),
        episode_length=float(steps),
        loss=record.last.loss,
        entropy=float(entropy),
        bonus=float(bonus) if job.config.regularised else np.nan,
        beta=float(beta) if job.config.regularised else np.nan,
        steps_per_second=(record.steps - record.before[0]) / (time.perf_counter() - record.began),
    )


@partial(jax.jit, static_argnames="program")
def _measured(
    dynamics: Dynamics,
    settings: Settings,
    lane: Lane,
    transitions: Int[Array, "n"],
    global_step: Float[Array, ""],
    program: Program,
) -> tuple[Float[Array, ""], Float[Array, ""], Float[Array, ""]]:
    """Entropy of the policy, intrinsic value of the states entered, and its weight.

    A tabular policy explores in other ways than by its entropy, which is NaN.
    """
    states, reached = dynamics.state_of(transitions), dynamics.transitions.next_state[transitions]
    entropy = jnp.float32(jnp.nan)
    if not program.algorithm.tabular:
        algorithm = bound(program.algorithm, settings.hyperparams)
        policy = algorithm.policy(dynamics.only(states), lane.train_state.parameters)
        entropy = jax.scipy.special.entr(policy).sum(axis=-1).mean()
    bonus = intrinsic.values(
        program.intrinsic, lane.novelty, settings.table, dynamics, reached
    ).mean()
    return entropy, bonus, beta_after(settings.hyperparams, global_step, jnp)
