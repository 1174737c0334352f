"""Sweeps: many configurations, trained once each, whatever happens meanwhile."""

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol, runtime_checkable

import polars as pl

from habilis.files import check_folder, check_unused, writing
from habilis.interruption import Interrupted, locked, stop_signals
from habilis.learning.config import Config
from habilis.sweeps import store
from habilis.sweeps.tasks import Done, Outcomes, Task, check, run_tasks, tasks_of
from habilis.worlds.world import World, load_world

Stopped = Callable[[], int]
"""Whether to leave it at that: 0, or the signal that came."""
OnProgress = Callable[[int, int], None]
"""Told how many tasks are finished, and of how many."""


@runtime_checkable
class Executor(Protocol):
    """Trains tasks.

    Calls `done` in this process with each that is finished, and stops early where `stopped` says
    so.
    """

    def __call__(self, tasks: Sequence[Task], done: Done, stopped: Stopped, /) -> None: ...


def sweep(
    configs: Sequence[Config],
    out: str | Path,
    *,
    executor: Executor = run_tasks,
    resume: bool = False,
    on_progress: OnProgress | None = None,
) -> pl.DataFrame:
    """Trains all runs of many configurations, and keeps each task as soon as it is finished.

    Args:
        configs: the points of the sweep.
        out: a new folder; see `store`.
        executor: who trains: this process (`run_tasks`), `local.processes`, `cluster.on_ray`.
        resume: whether to go on in a folder that holds a sweep. What it has of these points is
            not trained again, whether or not it was begun with the same ones.
        on_progress: called whenever a task is finished.

    Returns:
        One row a run of each point; see `store.results`.

    Raises:
        ValueError: a world, tool or sensor does not exist, a goal is out of reach, there is
            nothing to train, or the folder cannot be used.
        Interrupted: by Ctrl-C or SIGTERM; what is finished is kept.

    Example:
        >>> from tempfile import mkdtemp
        >>> config = Config(world="yard", runs=2, episodes=20)
        >>> sweep([config, config.changed(discount=0.9)], f"{mkdtemp()}/sweep").height
        4
    """
    folder = Path(out)
    points = points_of(configs)
    with opened(folder, resume, executor, on_progress) as session:
        session.train(points)
        return session.finish(points)


def points_of(configs: Sequence[Config]) -> list[store.Point]:
    """Configurations with their worlds, looked over.

    Raises:
        ValueError: there are none, or one cannot be trained; says which.
    """
    if not configs:
        raise ValueError("there is nothing to sweep over; give at least one configuration")
    points: list[store.Point] = []
    fine: set[tuple[World, str]] = set()
    for number, config in enumerate(configs):
        try:
            world = load_world(config.world, config.tool)
            if (world, config.intrinsic) not in fine:
                check(config, world)
                fine.add((world, config.intrinsic))
        except ValueError as error:
            raise ValueError(f"point {number}: {error}") from None
        points.append((config, world))
    return points


@dataclass
class Session:
    """The one process at work in a sweep's folder."""

    folder: Path
    executor: Executor
    on_progress: OnProgress | None
    stopped: Stopped
    outcomes: dict[str, Outcomes] = field(default_factory=dict)

    def train(self, points: Sequence[store.Point]) -> None:
        """Trains what is not finished yet of all points that there are so far.

        Raises:
            Interrupted: before all was finished.
        """
        with writing(self.folder):
            store.write_points(points, self.folder)
            store.remove_results(self.folder)
        tasks = {task.name: task for point in points for task in tasks_of(*point)}
        unknown = [task for name, task in tasks.items() if name not in self.outcomes]
        found, told = store.read(unknown, self.folder)
        self.outcomes |= found
        for line in told:
            print(f"habilis: {line}", file=sys.stderr)

        def tell() -> None:
            if self.on_progress is not None:
                self.on_progress(sum(name in self.outcomes for name in tasks), len(tasks))

        def done(task: Task, outcomes: Outcomes) -> None:
            if task.name not in self.outcomes:
                with writing(self.folder):
                    store.write(task, outcomes, self.folder)
                self.outcomes[task.name] = outcomes
                tell()

        tell()
        missing = [task for name, task in tasks.items() if name not in self.outcomes]
        if missing and not self.stopped():
            self.executor(missing, done, self.stopped)
        left = sum(name not in self.outcomes for name in tasks)
        if left:
            raise Interrupted(
                f"stopped; {len(tasks) - left} of {len(tasks)} tasks are kept in {self.folder}: "
                "go on with --resume",
                int(self.stopped()),
            )

    def finish(self, points: Sequence[store.Point]) -> pl.DataFrame:
        """Writes the results."""
        frame = store.table(points, self.outcomes)
        with writing(self.folder):
            store.write_results(frame, self.folder)
        return frame


@contextmanager
def opened(
    folder: Path, resume: bool, executor: Executor, on_progress: OnProgress | None
) -> Iterator[Session]:
    """Makes or opens a sweep's folder, for this process alone.

    Raises:
        ValueError: it is in use, is no sweep's, or cannot be written.
    """
    check_place(folder, resume)
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
    with locked(folder), stop_signals() as stopped:
        yield Session(folder, executor, on_progress, stopped)


def check_place(folder: Path, resume: bool) -> None:
    """Refuses a folder that no sweep can be kept in, or gone on with, before any work is done.

    Raises:
        ValueError: it holds something else, or cannot be written.
    """
    there = resume and folder.is_dir() and any(folder.iterdir())
    check_folder(folder) if there else check_unused(folder)
    if there and not store.is_sweep(folder) and not _is_empty_but_for_lock(folder):
        raise ValueError(f"{folder}: holds no sweep to go on with; name another folder")


def _is_empty_but_for_lock(folder: Path) -> bool:
    """As a sweep leaves it that was killed at once."""
    return {path.name for path in folder.iterdir()} <= {"lock", store.TASKS}
