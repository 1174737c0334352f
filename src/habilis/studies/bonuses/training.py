"""The runs of a study: trained side by side, each kept as soon as it is there."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from habilis.files import write_whole, writing
from habilis.interruption import Interrupted
from habilis.learning.batches import room, train_jobs
from habilis.learning.config import Config
from habilis.learning.jobs import Job
from habilis.learning.runs import Run
from habilis.studies.bonuses.study import Agent, Budget, Case, Study, Tell
from habilis.sweeps.tasks import Task

RUNS = "runs"
"""The folder of what is kept, in a folder of studies."""
TRIED_SEED = 1_000
"""Where the seeds begin of the runs by which weights are chosen."""

OnPoint = Callable[[], None]


@dataclass(frozen=True, eq=False)
class Point:
    """Some runs of one agent in one case."""

    case: Case
    agent: Agent
    config: Config

    @cached_property
    def name(self) -> str:
        """The same for the same settings, map and runs."""
        return Task(self.config, self.case.world, tuple(range(self.config.runs))).name


def points_of(
    study: Study, case: Case, agent: Agent, beta: float, budget: Budget, tried: bool = False
) -> list[Point]:
    """The runs of one agent in one case.

    Where episodes begin in random placements, every run has placements of its own.

    Args:
        study, case, agent: whose they are.
        beta: weight of the agent's bonus, if it has one.
        budget: how many runs there are, and how long they are at most.
        tried: whether they are those by which the weight is chosen.
    """
    seed, runs = (TRIED_SEED, budget.tried) if tried else (0, budget.runs)
    weight = {"beta": beta} if agent.has_bonus else {}
    steps = min(study.steps, budget.most)
    config = agent.config.changed(world=case.world.name, **case.settings, **weight)
    config = config.changed(steps=steps, episodes=steps, runs=runs, seed=seed)
    if not config.starts:
        return [Point(case, agent, config)]
    alone = [config.changed(runs=1, seed=k, starts_seed=k) for k in range(seed, seed + runs)]
    return [Point(case, agent, one) for one in alone]


def trained(
    points: Sequence[Point],
    tell: Tell,
    folder: Path,
    stopped: Callable[[], int],
    on_point: OnPoint,
) -> pl.DataFrame:
    """What the runs of some points came to, those in the folder as they are there.

    Args:
        points: what to train.
        tell: the study's.
        folder: of the studies.
        stopped: asked now and then whether to leave it at that: 0, or the signal that came.
        on_point: called whenever a point is there.

    Returns:
        A row a run: "case", "agent", "beta", "seed", "run", "converged_at", "first_success" (in
        episodes, null where it never was), "episodes", "steps", and what `tell` says.

    Raises:
        Interrupted: before all was there; what is finished is kept.
    """
    kept = {point.name: frame for point in points if (frame := _kept(point, folder)) is not None}
    for _ in kept:
        on_point()

    def done(point: Point, run: Run) -> None:
        kept[point.name] = _rows(run, tell)
        with writing(folder):
            write_whole(_path(point, folder), kept[point.name].write_parquet)
        on_point()

    missing = [point for point in points if point.name not in kept]
    if missing and not stopped():
        _train(missing, done, stopped)
    left = sum(point.name not in kept for point in points)
    if left:
        raise Interrupted(
            f"stopped; what is finished is kept in {folder}: go on with --resume", int(stopped())
        )
    frames = [_named(point, kept[point.name]) for point in points]
    return pl.concat(frames, how="vertical_relaxed")


def _train(
    points: Sequence[Point], done: Callable[[Point, Run], None], stopped: Callable[[], int]
) -> None:
    playing: dict[int, tuple[Point, Job]] = {}

    def jobs() -> Iterator[Job]:
        for number, point in enumerate(points):
            job = Job.of(number, point.config, point.case.world)
            playing[number] = point, job
            yield job

    def look(progress: Any) -> None:
        if progress.ended == progress.runs:
            point, job = playing.pop(progress.config)
            done(point, job.result())

    train_jobs(jobs(), look, stopped=stopped, at_once=room())


def _named(point: Point, rows: pl.DataFrame) -> pl.DataFrame:
    config = point.config
    names = {"case": point.case.name, "agent": point.agent.name, "beta": config.beta}
    columns = [pl.lit(value).alias(name) for name, value in (names | {"seed": config.seed}).items()]
    return rows.select(*columns, pl.all())


def _rows(run: Run, tell: Tell) -> pl.DataFrame:
    rows = []
    for index, at in enumerate(run.converged_at):
        episodes = run.episodes.filter(run=index)
        rows.append(
            {"run": index, "converged_at": at, "first_success": first_success(episodes)}
            | {"episodes": len(episodes), "steps": int(episodes["steps"].sum())}
            | dict(tell(run, index))
        )
    whole = {"converged_at": pl.Int64, "first_success": pl.Int64}
    return pl.DataFrame(rows, schema_overrides=whole, infer_schema_length=None)


def first_success(episodes: pl.DataFrame) -> int | None:
    """After how many episodes the goal is reached for the first time; `None` if it never is.

    Args:
        episodes: of one run, in order; one that is cut off gets -1 for its last step too.
    """
    reached = np.flatnonzero(episodes["return"].to_numpy() > -episodes["steps"].to_numpy())
    return int(reached[0]) + 1 if len(reached) else None


def _path(point: Point, folder: Path) -> Path:
    return folder / RUNS / f"{point.name}.parquet"


def _kept(point: Point, folder: Path) -> pl.DataFrame | None:
    """What is in the folder of a point; nothing if that is damaged."""
    try:
        return pl.read_parquet(_path(point, folder))
    except (OSError, pl.exceptions.PolarsError):
        return None
