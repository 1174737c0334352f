"""Training: from configurations to runs."""

import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from threading import Event
from typing import overload

import jax
import jax.numpy as jnp
import numpy as np

from habilis.empowerment import empowerment
from habilis.learning.a2c import Settings, Shape, Task, advance, start_lanes
from habilis.learning.config import Config
from habilis.learning.runs import Progress, Record, Run, episode_table, progress
from habilis.mdp import TabularMDP
from habilis.processors import processors
from habilis.worlds.plans import solve
from habilis.worlds.table import tabulate
from habilis.worlds.world import World, load_world

_LANES = 5
"""Runs in one compiled batch. Always the same number, since XLA's rounding depends on it: only
so is a run the same whatever trains beside it. More lanes are no faster on a CPU."""
_STEPS_A_STRETCH = 20_000  # of one run between two looks at it from Python

OnProgress = Callable[[Progress], None]


@overload
def train(config: Config, on_progress: OnProgress | None = None) -> Run: ...
@overload
def train(config: Sequence[Config], on_progress: OnProgress | None = None) -> list[Run]: ...


def train(
    config: Config | Sequence[Config], on_progress: OnProgress | None = None
) -> Run | list[Run]:
    """Trains all runs of one or several configurations, side by side.

    Runs advance in batches of lanes, batches on as many threads as there are processors. A run
    ends by itself when it has converged (`convergence.episodes_to_convergence`) or has used up
    its episodes, and is the same, bit for bit, whatever trains beside it.

    Args:
        config: one configuration, or several.
        on_progress: called after every stretch of training, from the thread it ran on.

    Returns:
        A `Run`, or a list of them in the order of the configurations.

    Raises:
        ValueError: a world, tool or sensor that does not exist, or a goal out of reach.
        FloatingPointError: a loss was not finite.
    """
    configs = [config] if isinstance(config, Config) else config
    jobs = [_Job.of(i, c) for i, c in enumerate(configs)]
    stop = Event()
    with ThreadPoolExecutor(processors()) as pool:
        batches = [pool.submit(_train_batch, b, on_progress, stop) for b in _batches(jobs)]
        try:
            for batch in batches:
                batch.result()
        finally:
            stop.set()
            for batch in batches:
                batch.cancel()
    runs = [job.result() for job in jobs]
    return runs[0] if isinstance(config, Config) else runs


@dataclass(frozen=True, eq=False)
class _Job:
    """A configuration, made ready."""

    index: int
    config: Config
    world: World
    mdp: TabularMDP
    best_return: float
    bonus: np.ndarray
    records: list[Record]

    @classmethod
    def of(cls, index: int, config: Config) -> "_Job":
        world = load_world(config.world, config.tool)
        mdp = tabulate(world)
        plan = solve(mdp)
        if plan is None:
            raise ValueError(f"{world.name}: the goal cannot be reached; open a way to it")
        records = [Record(config, plan.best_return) for _ in range(config.runs)]
        bonus = intrinsic_reward(mdp, config)
        return cls(index, config, world, mdp, plan.best_return, bonus, records)

    @property
    def program(self) -> tuple:
        """What must be equal for runs to share a batch: the world and the compiled shape."""
        c = self.config
        return self.world, c.envs, c.rollout, c.optimizer, c.hidden

    def result(self) -> Run:
        return Run(
            config=self.config,
            world=self.world,
            best_return=self.best_return,
            episodes=episode_table(self.records, list(self.mdp.flags)),
            converged_at=tuple(record.converged_at for record in self.records),
            networks=jax.tree.map(
                lambda *leaves: jnp.stack(leaves), *[record.network for record in self.records]
            ),
        )


_Lanes = list[tuple[_Job, int]]
"""The runs of a batch: of which job, and which of its runs."""


def _batches(jobs: list[_Job]) -> list[_Lanes]:
    by_program: dict[tuple, _Lanes] = {}
    for job in jobs:
        runs = by_program.setdefault(job.program, [])
        runs += [(job, run) for run in range(job.config.runs)]
    return [
        runs[first : first + _LANES]
        for runs in by_program.values()
        for first in range(0, len(runs), _LANES)
    ]


def _train_batch(batch: _Lanes, on_progress: OnProgress | None, stop: Event) -> None:
    """Trains one batch until all its runs have ended; what they did goes into their records."""
    config, mdp = batch[0][0].config, batch[0][0].mdp
    task, rows = make_task(mdp)
    shape = Shape(config.envs, config.rollout, config.optimizer, config.hidden, rows)
    lanes_of = (batch * _LANES)[:_LANES]  # a batch that is not full repeats its runs, unseen
    settings = make_settings(
        [job.config for job, _ in lanes_of], np.stack([job.bonus for job, _ in lanes_of])
    )
    keys = jnp.stack(
        [jax.random.fold_in(jax.random.key(job.config.seed), run) for job, run in lanes_of]
    )
    lanes = start_lanes(task, settings, shape, keys)
    updates = max(1, _STEPS_A_STRETCH // (shape.envs * shape.rollout))
    records = [job.records[run] for job, run in batch]
    for record in records:
        record.began = time.perf_counter()
    while not (stop.is_set() or all(record.ended for record in records)):
        lanes, log = advance(task, settings, lanes, shape, updates)
        ended, tally, loss = np.asarray(log.ended), np.asarray(log.tally), np.asarray(log.loss)
        for lane, ((job, run), record) in enumerate(zip(batch, records, strict=True)):
            if record.ended:
                continue
            if not np.isfinite(loss[lane]).all():
                raise FloatingPointError(
                    f"{job.world.name}: the loss of run {run} is not finite after "
                    f"{record.count} episodes; lower learning_rate or reward_scale"
                )
            steps = updates * shape.envs * shape.rollout
            record.add(tally[lane][ended[lane]], steps, lanes.network, lane)
        if on_progress is not None:
            for job in {job.index: job for job, _ in batch}.values():
                on_progress(progress(job.index, job.records))


def make_task(mdp: TabularMDP) -> tuple[Task, int]:
    """The table as the compiled loop wants it, and how many rows its inputs name.

    A state is shown to the network by its factors; without factors, by its index.
    """
    factors = list(mdp.factors.values()) or [np.arange(mdp.states)]
    inputs, rows = [], 0
    for labels in factors:
        values, compact = np.unique(labels, return_inverse=True)
        inputs.append(compact + rows)
        rows += len(values)
    counted = np.stack([*mdp.flags.values()], axis=1) if mdp.flags else np.empty((mdp.states, 0))
    task = Task(
        next_state=jnp.asarray(mdp.next_state),
        reward=jnp.asarray(mdp.reward),
        terminal=jnp.asarray(mdp.terminal),
        inputs=jnp.asarray(np.stack(inputs, axis=1), jnp.int32),
        counted=jnp.asarray(counted, jnp.float32),
        start=jnp.int32(mdp.start),
    )
    return task, rows


def intrinsic_reward(mdp: TabularMDP, config: Config) -> np.ndarray:
    """Beta * M, float64[S]: what the agent gets for entering a state besides the reward."""
    if not config.regularised:
        return np.zeros(mdp.states)
    return config.beta * empowerment(mdp, config.horizon, config.intrinsic)


def make_settings(configs: Sequence[Config], bonus: np.ndarray) -> Settings:
    """The numbers of some lanes' configurations as the compiled loop wants them."""
    numbers = {
        name: jnp.asarray(np.array([getattr(config, name) for config in configs], np.float32))
        for name in Settings._fields
        if name != "bonus"
    }
    return Settings(bonus=jnp.asarray(bonus, jnp.float32), **numbers)
