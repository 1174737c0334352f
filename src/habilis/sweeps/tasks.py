"""The parts of a sweep: a task is a batch of lanes, some runs of one configuration."""

import hashlib
import itertools
import json
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float

from habilis.learning.algorithms import ALGORITHMS
from habilis.learning.batches import LANES, NotFiniteError, room, train_jobs
from habilis.learning.config import Config
from habilis.learning.jobs import Job, digest_of_own_tool
from habilis.learning.runs import Progress, Record
from habilis.worlds.world import World, load_world

BLOCK = 100
"""Episodes over which a learning curve, and the final return, are averaged."""


@dataclass(frozen=True)
class Task:
    """Some runs of one configuration, trained together, wherever that is.

    Attributes:
        config: the configuration.
        world: its world, so that whoever trains needs no map file.
        runs: their numbers.
    """

    config: Config
    world: World
    runs: tuple[int, ...]

    @cached_property
    def name(self) -> str:
        """What it is, in 32 hexadecimal digits: the same for the same settings, map and runs.

        What a tool of one's own does counts, and not where it is written.
        """
        digest = digest_of_own_tool(self.world)
        tool = [self.world.tool, self.world.text()] if digest is None else [digest, self.world.rows]
        what = [plain(self.config), *tool, self.runs]
        return hashlib.sha256(json.dumps(what, sort_keys=True).encode()).hexdigest()[:32]


@dataclass(frozen=True)
class Outcome:
    """What one run came to. All but `seconds` is the same whoever trains it, and beside whom.

    Attributes:
        run: its number.
        converged_at: episodes to convergence, `None` if it did not converge.
        episodes_had, steps_had: episodes and environment steps that it took.
        best_return: of a shortest plan in its world.
        final_return: mean return of its last 100 episodes; NaN if it had none.
        finite: whether its loss and parameters stayed so; it was given up if not.
        seconds: from its first step to its last, while others trained beside it.
        curve: float32[n], the mean return over each 100 episodes.
    """

    run: int
    converged_at: int | None
    episodes_had: int
    steps_had: int
    best_return: float
    final_return: float
    finite: bool
    seconds: float = field(compare=False)
    curve: Float[np.ndarray, "n"] = field(compare=False)


Outcomes = tuple[Outcome, ...]
Done = Callable[[Task, Outcomes], None]


def plain(config: Config) -> dict[str, Any]:
    """All that decides what a run of a configuration does; 0 and 0.0 are the same number.

    What came later is left out as long as it does nothing: where episodes begin, if that is where
    the map has everything, and slip, if there is none.
    """
    idle = set() if config.starts else {"starts", "unseen", "starts_seed"}
    idle |= set() if config.slip else {"slip"}
    defaults = {f.name: f.default for kind in (Config, *ALGORITHMS.values()) for f in fields(kind)}
    return {
        name: float(value) if isinstance(defaults[name], float) else value
        for name, value in config.as_dict().items()
        if name not in {"runs", *idle}
    }


def tasks_of(config: Config, world: World | None = None) -> list[Task]:
    """The tasks that make up a configuration: its runs, a batch of lanes at a time.

    Args:
        config: the configuration.
        world: its world, if that is not to be read from where the configuration says.

    Raises:
        ValueError: the world or the tool does not exist.

    Example:
        >>> [task.runs for task in tasks_of(Config(world="yard", runs=7))]
        [(0, 1, 2, 3, 4), (5, 6)]
    """
    world = load_world(config.world, config.tool) if world is None else world
    starts = range(0, config.runs, LANES)
    return [Task(config, world, tuple(range(config.runs)[at : at + LANES])) for at in starts]


def check(config: Config, world: World) -> None:
    """Refuses what cannot be trained, before anything is.

    Raises:
        ValueError: the goal is out of reach, or the sensor does not exist.
    """
    Job.of(0, config.changed(horizon=min(config.horizon, 1)), world, ())


def run_task(task: Task) -> Outcomes:
    """Trains the runs of one task, in a batch of lanes."""
    results: list[Outcomes] = []
    run_tasks([task], lambda _, outcomes: results.append(outcomes))
    return results[0]


def run_tasks(
    tasks: Iterable[Task], done: Done, stopped: Callable[[], object] = lambda: False
) -> None:
    """Trains tasks in this process, side by side, as many as fill its batches of lanes.

    A run whose loss or parameters are not finite is given up; it does not stop the others.

    Args:
        tasks: what to train.
        done: called with each task that is finished, as soon as it is.
        stopped: asked now and then whether to leave it at that.
    """
    jobs = _Jobs(tasks, done)
    again: Iterable[Job] = ()
    while True:
        try:
            at_once = room()
            train_jobs(
                itertools.chain(again, jobs.fresh), jobs.look, stopped=stopped, at_once=at_once
            )
            return
        except NotFiniteError as error:
            jobs.give_up(error.job, error.run)
            again = jobs.in_play()


class _Jobs:
    """The jobs of tasks, from when they are begun until they are finished."""

    def __init__(self, tasks: Iterable[Task], done: Done):
        self._playing: dict[int, tuple[Task, Job]] = {}
        self._ended_at: dict[Record, float] = {}
        self._not_finite: set[Record] = set()
        self._done = done
        self.fresh = self._begin(tasks)

    def _begin(self, tasks: Iterable[Task]) -> Iterator[Job]:
        for index, task in enumerate(tasks):
            job = Job.of(index, task.config, task.world, task.runs)
            self._playing[index] = task, job
            yield job

    def in_play(self) -> list[Job]:
        return [job for _, job in self._playing.values()]

    def give_up(self, job: Job, run: int) -> None:
        job.records[run].ended = True
        self._not_finite.add(job.records[run])
        for index in list(self._playing):  # others of its batch may have ended just before
            self._take_note(index)

    def look(self, progress: Progress) -> None:
        self._take_note(progress.config)

    def _take_note(self, index: int) -> None:
        task, job = self._playing[index]
        for record in job.records:
            if record.ended:
                self._ended_at.setdefault(record, time.perf_counter())
        if all(record.ended for record in job.records):
            del self._playing[index]
            self._done(task, tuple(map(self._outcome, task.runs, job.records)))

    def _outcome(self, run: int, record: Record) -> Outcome:
        returns = record.episodes()[:, 1]
        blocks = returns[: len(returns) // BLOCK * BLOCK].reshape(-1, BLOCK)
        assert record.began is not None
        return Outcome(
            run=run,
            converged_at=record.converged_at,
            episodes_had=record.count,
            steps_had=record.steps,
            best_return=record.best_return,
            final_return=float(returns[-BLOCK:].mean(dtype=float)) if len(returns) else np.nan,
            finite=record not in self._not_finite,
            seconds=self._ended_at.pop(record) - record.began,
            curve=blocks.mean(axis=1, dtype=float).astype(np.float32),
        )
