"""The studies of learning to choose, from training to page."""

from collections.abc import Callable, Sequence
from pathlib import Path

import polars as pl

from habilis.studies.bonuses.choosing import STUDY as CHOOSING
from habilis.studies.bonuses.report import PAGE as PAGE
from habilis.studies.bonuses.report import Answer, write_report
from habilis.studies.bonuses.study import BETAS, FULL, QUICK, Agent, Budget, Case, Study
from habilis.studies.bonuses.training import LAYOUT, Point, points_of, trained
from habilis.studies.bonuses.two_goals import STUDY as TWO_GOALS
from habilis.studies.bonuses.unseen import STUDY as UNSEEN
from habilis.studies.bonuses.weights import choose
from habilis.sweeps.training import train_tasks
from habilis.tasks.session import opened
from habilis.tasks.task import OnProgress

STUDIES = {study.name: study for study in (CHOOSING, TWO_GOALS, UNSEEN)}

Weigh = Callable[[Case, Agent], float]


def run_studies(
    names: Sequence[str],
    out: str | Path,
    quick: bool = False,
    resume: bool = False,
    on_progress: OnProgress | None = None,
) -> list[Answer]:
    """Trains the agents of some studies, and writes the results.

    Args:
        names: of `STUDIES`; none: all.
        out: a new folder: `report.html`, and for each study a picture and two tables; in `runs`
            what has been trained.
        quick: whether to run a smoke test: so little training that the results are meaningless.
        resume: whether to continue in a folder of studies.
        on_progress: called whenever a task is finished.

    Returns:
        An answer a study.

    Raises:
        ValueError: no such study, or the folder cannot be used.
        Interrupted: by Ctrl-C or SIGTERM; what is finished is kept.
    """
    studies = [_named(name) for name in dict.fromkeys(names or STUDIES)]
    budget = QUICK if quick else FULL
    folder = Path(out)
    with opened(folder, LAYOUT, train_tasks, resume) as session:
        whole = [p for s in studies for p in (*_tried(s, budget), *_final(s, budget, _any))]
        total, before = sum(len(point.tasks) for point in whole), 0

        def train(points: Sequence[Point]) -> pl.DataFrame:
            nonlocal before
            frame = trained(points, session, report)
            before += sum(len(point.tasks) for point in points)
            return frame

        def report(done: int, _: int) -> None:
            if on_progress is not None:
                on_progress(before + done, total)

        answers = []
        for study in studies:
            weights = choose(train(_tried(study, budget)), study.measures[0])
            points = _final(study, budget, lambda c, a, w=weights: w.get((c.name, a.name), 0.0))
            answers.append(Answer.of(study, train(points)))
        write_report(answers, budget, folder)
        return answers


def _named(name: str) -> Study:
    if name not in STUDIES:
        raise ValueError(f"study {name!r} is unknown; use one of {', '.join(STUDIES)}")
    return STUDIES[name]


def _tried(study: Study, budget: Budget) -> list[Point]:
    return [
        point
        for case in study.cases
        for agent in study.agents
        if agent.has_bonus
        for beta in budget.betas
        for point in points_of(study, case, agent, beta, budget, tried=True)
    ]


def _final(study: Study, budget: Budget, weigh: Weigh) -> list[Point]:
    return [
        point
        for case in study.cases
        for agent in study.agents
        for point in points_of(study, case, agent, weigh(case, agent), budget)
    ]


def _any(case: Case, agent: Agent) -> float:
    """A weight, while that of each bonus is not chosen yet: there are as many points with any."""
    return BETAS[0]
