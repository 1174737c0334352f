"""The runs of a study, as tasks."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import polars as pl

from habilis.learning.config import Config
from habilis.learning.runs import Run
from habilis.studies.bonuses.study import Agent, Budget, Case, Study
from habilis.sweeps.training import COLUMNS, TrainingTask, outcomes, tasks_of
from habilis.tasks.session import Layout, Session
from habilis.tasks.task import Arrays, OnProgress

LAYOUT = Layout("studies", mark="runs", results="runs")
"""The folder of studies."""
TRIED_SEED = 1_000
"""The first seed of the runs by which weights are chosen."""


@dataclass(frozen=True, eq=False)
class Point:
    """Some runs of one agent in one case of a study."""

    study: Study
    case: Case
    agent: Agent
    config: Config

    @cached_property
    def tasks(self) -> list[TrainingTask]:
        return tasks_of(self.config, self.case.world, (episodes_of, self.study.measure_run))

    def rows(self, results: Mapping[str, Arrays]) -> list[dict[str, Any]]:
        """A row for each of its runs; see `trained`."""
        names = {"case": self.case.name, "agent": self.agent.name}
        names |= {"beta": self.config.beta, "seed": self.config.seed}
        rows = []
        for outcome in (row for task in self.tasks for row in outcomes(results[task.name])):
            row = {"run": outcome["run"], "converged_at": outcome["converged_at"]}
            row |= {"first_success": outcome.get("first_success")}
            row |= {"episodes": outcome["episodes_had"], "steps": outcome.get("steps")}
            known = (*row, *COLUMNS, "curve")
            row |= {name: value for name, value in outcome.items() if name not in known}
            rows.append(names | row | {"finite": outcome["finite"]})
        return rows


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
        return [Point(study, case, agent, config)]
    alone = [config.changed(runs=1, seed=k, starts_seed=k) for k in range(seed, seed + runs)]
    return [Point(study, case, agent, one) for one in alone]


def trained(
    points: Sequence[Point], session: Session[TrainingTask], on_progress: OnProgress | None = None
) -> pl.DataFrame:
    """The runs of some points, of which the finished ones are not trained again.

    Args:
        points: what to train.
        session: the folder of studies.
        on_progress: called first, and after each task.

    Returns:
        A row a run: "case", "agent", "beta", "seed", "run", "converged_at", "first_success" (in
        episodes, null where it never was), "episodes", "steps" (of these), the study's measures,
        and "finite": false for a run that diverged, which has no measures and counts as not
        converged.

    Raises:
        Interrupted: before all was there; what is finished is kept.
    """
    session.compute([task for point in points for task in point.tasks], on_progress)
    rows = [row for point in points for row in point.rows(session.results)]
    measures = {m.column: None for point in points for m in point.study.measures}
    every = dict.fromkeys(name for row in rows for name in row | measures)
    names = [*(name for name in every if name != "finite"), "finite"]
    counts = ("run", "converged_at", "first_success", "episodes", "steps")
    types: dict[Any, Any] = dict.fromkeys(measures, pl.Float64) | dict.fromkeys(counts, pl.Int64)
    columns = {name: [row.get(name) for row in rows] for name in names}
    return pl.DataFrame(columns, infer_schema_length=None).cast(types)


def episodes_of(run: Run, index: int) -> dict[str, float | None]:
    """The steps of a run's episodes, and how many these were up to its first success.

    "first_success" is `None` if it never reaches the goal: an episode that is cut off gets -1 for
    its last step too.
    """
    episodes = run.episodes.filter(run=index)
    reached = np.flatnonzero(episodes["return"].to_numpy() > -episodes["steps"].to_numpy())
    first = int(reached[0]) + 1 if len(reached) else None
    return {"first_success": first, "steps": int(episodes["steps"].sum())}
