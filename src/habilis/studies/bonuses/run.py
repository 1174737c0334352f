"""The studies of learning to choose, from training to page."""

from collections.abc import Callable, Sequence
from pathlib import Path

import polars as pl

from habilis.files import check_folder, check_unused, writing
from habilis.interruption import locked, stop_signals
from habilis.studies.bonuses.choosing import STUDY as CHOOSING
from habilis.studies.bonuses.report import PAGE as PAGE
from habilis.studies.bonuses.report import Answer, write_report
from habilis.studies.bonuses.study import BETAS, FULL, QUICK, Agent, Budget, Case, Study
from habilis.studies.bonuses.training import RUNS, Point, points_of, trained
from habilis.studies.bonuses.two_goals import STUDY as TWO_GOALS
from habilis.studies.bonuses.unseen import STUDY as UNSEEN
from habilis.studies.bonuses.weights import choose

STUDIES = {study.name: study for study in (CHOOSING, TWO_GOALS, UNSEEN)}

OnProgress = Callable[[int, int], None]
"""Told how many parts are there, and of how many."""
Weigh = Callable[[Case, Agent], float]


def run_studies(
    names: Sequence[str],
    out: str | Path,
    quick: bool = False,
    resume: bool = False,
    on_progress: OnProgress | None = None,
) -> list[Answer]:
    """Trains the agents of some studies, and writes what they came to.

    Args:
        names: of `STUDIES`; none: all.
        out: a new folder: `report.html`, and for each study a picture and two tables; in `runs`
            what has been trained.
        quick: whether to train too little to say anything, to see that it works.
        resume: whether to go on in a folder of studies.
        on_progress: called whenever a part is there.

    Returns:
        An answer a study.

    Raises:
        ValueError: no such study, or the folder cannot be used.
        Interrupted: by Ctrl-C or SIGTERM; what is finished is kept.
    """
    studies = [_named(name) for name in dict.fromkeys(names or STUDIES)]
    budget = QUICK if quick else FULL
    folder = Path(out)
    _open(folder, resume)
    with locked(folder), stop_signals() as stopped:
        total = sum(len(_tried(s, budget)) + len(_final(s, budget, _any)) for s in studies)
        done = 0

        def tell() -> None:
            nonlocal done
            done += 1
            if on_progress is not None:
                on_progress(done, total)

        def train(study: Study, points: Sequence[Point]) -> pl.DataFrame:
            return trained(points, study.tell, folder, stopped, tell)

        answers = []
        for study in studies:
            weights = choose(train(study, _tried(study, budget)), study.measures[0])
            points = _final(study, budget, lambda c, a, w=weights: w.get((c.name, a.name), 0.0))
            answers.append(Answer.of(study, train(study, points)))
        write_report(answers, budget, folder)
        return answers


def _named(name: str) -> Study:
    if name not in STUDIES:
        raise ValueError(f"no study {name!r}; name one of {', '.join(STUDIES)}")
    return STUDIES[name]


def _open(folder: Path, resume: bool) -> None:
    there = resume and folder.is_dir() and any(folder.iterdir())
    check_folder(folder) if there else check_unused(folder)
    if there and not (folder / RUNS).is_dir():
        raise ValueError(f"{folder}: holds no studies to go on with; name another folder")
    with writing(folder):
        (folder / RUNS).mkdir(parents=True, exist_ok=True)


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
