"""Sweeps: many configurations, trained once each, whatever happens meanwhile."""

from collections.abc import Sequence
from pathlib import Path

import polars as pl

from habilis.files import writing
from habilis.learning.config import Config
from habilis.learning.sources import Source
from habilis.learning.training_problem import prepared
from habilis.sweeps import store
from habilis.sweeps.training import RunMeasure, TrainingTask, check, train_tasks
from habilis.tasks.session import Session, opened
from habilis.tasks.task import Executor, OnProgress


def sweep(
    configs: Sequence[Config],
    out: str | Path,
    *,
    executor: Executor[TrainingTask] = train_tasks,
    resume: bool = False,
    on_progress: OnProgress | None = None,
    measures: Sequence[RunMeasure] = (),
) -> pl.DataFrame:
    """Trains all runs of many configurations, and keeps each task as soon as it is finished.

    Args:
        configs: the points of the sweep.
        out: a new folder; see `store`.
        executor: where tasks run: in this process (`train_tasks`), in several (`processes`), or on
            a cluster (`on_ray`).
        resume: whether to go on in a folder that holds a sweep. What it has of these points is
            not trained again, whether or not it was begun with the same ones.
        on_progress: called whenever a task is finished.
        measures: functions of a `Run` and the index of one of its runs that return measurements
            by name: each becomes a column. They are called where a run is trained, as soon as it
            has ended.

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
    points, every = points_of(configs), tuple(measures)
    with opened(Path(out), store.LAYOUT, executor, resume) as session:
        train_points(points, session, on_progress, every)
        return finish(points, session, every)


def points_of(configs: Sequence[Config]) -> list[store.Point]:
    """Configurations with their worlds, checked.

    Raises:
        ValueError: there are none, or one cannot be trained; says which.
    """
    if not configs:
        raise ValueError("there is nothing to sweep over; give at least one configuration")
    points: list[store.Point] = []
    fine: set[tuple[Source, str]] = set()
    for number, config in enumerate(configs):
        try:
            config, world = prepared(config)
            if (world, config.intrinsic) not in fine:
                check(config, world)
                fine.add((world, config.intrinsic))
        except ValueError as error:
            raise ValueError(f"point {number}: {error}") from None
        points.append((config, world))
    return points


def train_points(
    points: Sequence[store.Point],
    session: Session[TrainingTask],
    on_progress: OnProgress | None,
    measures: tuple[RunMeasure, ...] = (),
) -> None:
    """Trains what is not finished yet of all points that there are so far.

    Raises:
        Interrupted: before all was finished.
    """
    with writing(session.folder):
        store.write_points(points, session.folder)
        store.remove_results(session.folder)
    session.compute(store.tasks_of_points(points, measures), on_progress)


def finish(
    points: Sequence[store.Point],
    session: Session[TrainingTask],
    measures: tuple[RunMeasure, ...] = (),
) -> pl.DataFrame:
    """Writes the results of all points, and returns them."""
    frame = store.table(points, session.results, measures)
    with writing(session.folder):
        store.write_results(frame, session.folder)
    return frame
