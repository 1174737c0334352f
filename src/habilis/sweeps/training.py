"""Tasks of training: each is some runs of one configuration, at most one batch of lanes."""

import hashlib
import itertools
import json
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float32

from habilis.learning.algorithms import ALGORITHMS
from habilis.learning.batches import LANES, NotFiniteError, room, train_jobs
from habilis.learning.config import Config
from habilis.learning.jobs import Job, digest_of_own_tool
from habilis.learning.runs import Progress, Record, Run
from habilis.learning.sources import NamedTable, Source, source_of
from habilis.tasks.task import Arrays, Done, Stopped

BLOCK = 100
"""Episodes over which a learning curve, and the final return, are averaged."""

COLUMNS: dict[str, type] = {
    "run": np.int64,
    "converged_at": np.int64,  # -1 in a result: it did not
    "episodes_had": np.int64,
    "steps_had": np.int64,
    "best_return": np.float64,
    "final_return": np.float64,
    "finite": np.bool_,
    "seconds": np.float64,
}
"""The outcome of a run, besides its curve and its measurements; see `outcomes`."""

CURVE = ("curve", "curve_lengths")
"""The learning curves of all runs of a result, one after another, and their lengths."""

RunMeasure = Callable[[Run, int], Mapping[str, float | None]]
"""Measurements of a run, by its index in a `Run`: a function of a module, so that every process
finds it. It is called where the run was trained, once the runs of its task have ended."""


@dataclass(frozen=True)
class TrainingTask:
    """Some runs of one configuration, trained together (a `habilis.tasks.task.Task`).

    Attributes:
        config: the configuration.
        world: its world or table, so that the process that trains needs no map file.
        runs: their numbers.
        measures: measurements besides `COLUMNS`.
    """

    config: Config
    world: Source
    runs: tuple[int, ...]
    measures: tuple[RunMeasure, ...] = ()

    @property
    def name(self) -> str:
        """32 hexadecimal digits, equal for equal settings, map, runs and measures.

        Of a custom tool the effects count, not where its file is.
        """
        return self._name

    @cached_property
    def _name(self) -> str:
        identity = [plain(self.config), *_identity(self.world), self.runs]
        if self.measures:
            identity.append([f"{m.__module__}.{m.__qualname__}" for m in self.measures])
        return hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()[:32]

    @property
    def label(self) -> str:
        return f"{self.world.name}, runs {self.runs[0]} to {self.runs[-1]}"

    @property
    def size(self) -> float:
        if isinstance(self.world, NamedTable):
            return self.world.mdp.states
        return self.world.height * self.world.width

    def run(self) -> Arrays:
        """Trains the runs; their outcomes, see `outcomes`."""
        results: dict[str, Arrays] = {}
        train_tasks([self], results.__setitem__)
        return results[self.name]

    def rehearse(self) -> None:
        """Trains for one stretch."""
        over = threading.Event()
        job = Job.of(0, self.config, self.world, self.runs)
        train_jobs([job], on_stretch=over.set, stopped=over.is_set)

    def check(self, result: Arrays) -> None:
        runs = [row["run"] for row in outcomes(result)]
        if tuple(runs) != self.runs:
            raise ValueError(f"holds runs {runs}")


def _identity(world: Source) -> list[Any]:
    """All that makes a world or table another."""
    if isinstance(world, NamedTable):
        return [world.digest]
    digest = digest_of_own_tool(world)
    return [world.tool, world.text()] if digest is None else [digest, world.rows]


def plain(config: Config) -> dict[str, Any]:
    """The settings that decide what a run does, 0 and 0.0 being the same number.

    Settings of later versions are left out as long as they have no effect: initial states, if they
    are the map's own, and slip and policy_every, if they are 0.
    """
    idle = set() if config.starts else {"starts", "unseen", "starts_seed"}
    idle |= {name for name in ("slip", "policy_every") if not getattr(config, name)}
    defaults = {f.name: f.default for kind in (Config, *ALGORITHMS.values()) for f in fields(kind)}
    return {
        name: float(value) if isinstance(defaults[name], float) else value
        for name, value in config.as_dict().items()
        if name not in {"runs", *idle}
    }


def tasks_of(
    config: Config, world: Source | None = None, measures: tuple[RunMeasure, ...] = ()
) -> list[TrainingTask]:
    """The tasks that make up a configuration: its runs, a batch of lanes at a time.

    Args:
        config: the configuration.
        world: its world, if that is not to be read from where the configuration says.
        measures: measurements of each run.

    Raises:
        ValueError: the world or the tool does not exist.

    Example:
        >>> [task.runs for task in tasks_of(Config(world="yard", runs=7))]
        [(0, 1, 2, 3, 4), (5, 6)]
    """
    world = source_of(config) if world is None else world
    runs = tuple(range(config.runs))
    parts = [runs[first : first + LANES] for first in range(0, config.runs, LANES)]
    return [TrainingTask(config, world, part, measures) for part in parts]


def outcomes(result: Arrays) -> list[dict[str, Any]]:
    """The outcomes of the runs of a finished task, in their order.

    Returns:
        For each run `COLUMNS` ("converged_at" is `None` if it did not converge), its measurements
        (`None` where there is none, as for a run that diverged), and "curve": the mean return over
        each 100 episodes.
    """
    ends = np.cumsum(result["curve_lengths"])[:-1]
    measured = [name for name in result if name not in (*COLUMNS, *CURVE)]
    columns = [result[name].tolist() for name in (*COLUMNS, *measured)]
    rows = []
    for values, curve in zip(
        zip(*columns, strict=True), np.split(result["curve"], ends), strict=True
    ):
        row: dict[str, Any] = dict(zip((*COLUMNS, *measured), values, strict=True))
        row |= {name: None for name in measured if np.isnan(row[name])}
        row["converged_at"] = None if row["converged_at"] < 0 else row["converged_at"]
        rows.append(row | {"curve": curve.tolist()})
    return rows


def check(config: Config, world: Source) -> None:
    """Refuses what cannot be trained, before anything is.

    Raises:
        ValueError: the goal is unreachable, or the sensor does not exist.
    """
    Job.of(0, config.changed(horizon=min(config.horizon, 1)), world, ())


def train_tasks(
    tasks: Iterable[TrainingTask],
    done: Done,
    stopped: Stopped = lambda: 0,
    *,
    lanes: int | None = None,
) -> None:
    """Trains tasks in this process, side by side, as many as fill its batches of lanes.

    A run whose loss or parameters are not finite ends as it is; the others go on.

    Args:
        tasks: what to train.
        done: called with each finished task's name and result, at once.
        stopped: asked after every stretch whether to stop early.
        lanes: how many runs wide every batch is; see `train`.
    """
    jobs = _Jobs(tasks, done)
    again: Iterable[Job] = ()
    while True:
        try:
            train_jobs(
                itertools.chain(again, jobs.fresh),
                jobs.look,
                stopped=stopped,
                at_once=room(lanes),
                lanes=lanes,
            )
            return
        except NotFiniteError as error:
            jobs.end_diverged(error.job, error.run)
            again = jobs.in_play()


class _Jobs:
    """The jobs of tasks, from when they are begun until they are finished."""

    def __init__(self, tasks: Iterable[TrainingTask], done: Done):
        self._playing: dict[int, tuple[TrainingTask, Job]] = {}
        self._ended_at: dict[Record, float] = {}
        self._diverged: set[Record] = set()
        self._done = done
        self.fresh = self._begin(tasks)

    def _begin(self, tasks: Iterable[TrainingTask]) -> Iterator[Job]:
        for index, task in enumerate(tasks):
            job = Job.of(index, task.config, task.world, task.runs)
            self._playing[index] = task, job
            yield job

    def in_play(self) -> list[Job]:
        return [job for _, job in self._playing.values()]

    def end_diverged(self, job: Job, run: int) -> None:
        job.records[run].ended = True
        self._diverged.add(job.records[run])
        for index in list(self._playing):  # others of its batch may have ended just before
            self._finish_if_ended(index)

    def look(self, progress: Progress) -> None:
        self._finish_if_ended(progress.config)

    def _finish_if_ended(self, index: int) -> None:
        task, job = self._playing[index]
        for record in job.records:
            if record.ended:
                self._ended_at.setdefault(record, time.perf_counter())
        if all(record.ended for record in job.records):
            del self._playing[index]
            self._done(task.name, self._result(task, job))

    def _result(self, task: TrainingTask, job: Job) -> Arrays:
        rows = [
            self._outcome(run, record) for run, record in zip(task.runs, job.records, strict=True)
        ]
        curves = [_curve(record) for record in job.records]
        result = {name: np.array([row[name] for row in rows], COLUMNS[name]) for name in COLUMNS}
        result |= _measured(task, job, [row["finite"] for row in rows])
        result["curve"] = np.concatenate(curves)
        result["curve_lengths"] = np.array([len(curve) for curve in curves])
        return result

    def _outcome(self, run: int, record: Record) -> dict[str, Any]:
        returns = record.episodes()[:, 1]
        assert record.began is not None
        return {
            "run": run,
            "converged_at": -1 if record.converged_at is None else record.converged_at,
            "episodes_had": record.count,
            "steps_had": record.steps,
            "best_return": record.best_return,
            "final_return": returns[-BLOCK:].mean(dtype=float) if len(returns) else np.nan,
            "finite": record not in self._diverged,
            "seconds": self._ended_at.pop(record) - record.began,
        }


def _curve(record: Record) -> Float32[np.ndarray, "blocks"]:
    returns = record.episodes()[:, 1]
    blocks = returns[: len(returns) // BLOCK * BLOCK].reshape(-1, BLOCK)
    return blocks.mean(axis=1, dtype=float).astype(np.float32)


def _measured(task: TrainingTask, job: Job, finite: Sequence[bool]) -> dict[str, np.ndarray]:
    """Measurements of the runs that did not diverge, NaN for the others."""
    if not task.measures or not any(finite):
        return {}
    run = job.result()
    rows: list[dict[str, float | None]] = [{} for _ in finite]
    for index, row in enumerate(rows):
        for measure in task.measures if finite[index] else ():
            row |= measure(run, index)
    names = dict.fromkeys(name for row in rows for name in row)
    return {name: np.array([row.get(name) for row in rows], np.float64) for name in names}
