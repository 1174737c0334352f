"""Searches: Optuna chooses the points."""

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import optuna
import polars as pl
from optuna.trial import TrialState

from habilis.files import writing
from habilis.sweeps import store
from habilis.sweeps.grids import finish, points_of, train_points
from habilis.sweeps.spec import OBJECTIVES, Range, Search, Spec, default_of, split
from habilis.sweeps.training import TrainingTask, train_tasks
from habilis.tasks.session import Session, opened
from habilis.tasks.task import Executor, OnProgress

_NAME, _SPEC, _TRIALS = "habilis", "search.json", "search.db"


def search(
    spec: Spec,
    out: str | Path,
    *,
    executor: Executor[TrainingTask] = train_tasks,
    resume: bool = False,
    on_progress: OnProgress | None = None,
) -> pl.DataFrame:
    """Searches for the configuration with the least of an objective, with Optuna's TPE.

    The specification alone decides which points are tried: a search that was interrupted goes on
    as it would have, and one with the same seed is the same search.

    Args:
        spec: with a `search`.
        out, executor, resume, on_progress: as in `sweep`. More `trials` than before are a reason
            to resume; other settings are another search.

    Returns:
        One row a run of each point that was tried, in their order; see `store.results`.

    Raises:
        ValueError, Interrupted: as `sweep`; the folder holds another search; or no point could be
            trained.
    """
    assert spec.search is not None
    folder, wanted = Path(out), spec.search
    with opened(folder, store.LAYOUT, executor, resume) as session:
        _check_same(spec, folder)
        with writing(folder):
            store.write_json(folder / _SPEC, _as_dict(spec))
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        storage = optuna.storages.RDBStorage(f"sqlite:///{(folder / _TRIALS).absolute()}")
        try:
            study = optuna.create_study(storage=storage, study_name=_NAME, load_if_exists=True)
            return _search(study, spec, wanted, session, on_progress)
        finally:
            storage.remove_session()
            storage.engine.dispose()


def best_point(frame: pl.DataFrame, minimise: str) -> int:
    """The number of the point with the least of an objective, the first of several."""
    values = {
        number: OBJECTIVES[minimise](runs)
        for (number,), runs in frame.partition_by("point", as_dict=True).items()
    }
    return int(min(values, key=lambda number: (values[number], number)))


def _search(
    study: optuna.Study,
    spec: Spec,
    wanted: Search,
    session: Session[TrainingTask],
    on_progress: OnProgress | None,
) -> pl.DataFrame:
    """Tries round after round.

    The points of a round are chosen before any of them is observed, so that they do not depend on
    what happens to finish first, and recorded when all of them are.
    """
    points: list[store.Point] = []
    refused = ""
    for first in range(0, wanted.trials, wanted.at_once):
        recorded = study.get_trials()
        size = min(wanted.at_once, wanted.trials - first)
        chosen = [trial.params for trial in recorded[first : first + size]]
        if len(chosen) < size:
            chosen = _choose(recorded[:first], wanted, size)
        places: list[int | None] = []
        for number, parameters in enumerate(chosen, start=first):
            try:
                points += points_of([spec.point(_values(parameters, wanted))])
                places.append(len(points) - 1)
            except ValueError as error:
                refused = str(error)
                places.append(None)
                if number >= len(recorded):
                    print(f"habilis: trial {number} is left out: {refused}", file=sys.stderr)
        train_points(points, session, on_progress)
        for number, place in enumerate(places, start=first):
            if number >= len(recorded):
                value = None
                if place is not None:
                    runs = store.table([points[place]], session.results)
                    value = OBJECTIVES[wanted.minimise](runs)
                study.add_trial(_trial(chosen[number - first], wanted, value))
    if not points:
        raise ValueError(f"no point of the search can be trained; the last one: {refused}")
    return finish(points, session)


def _choose(
    observed: Sequence[optuna.trial.FrozenTrial], wanted: Search, size: int
) -> list[dict[str, Any]]:
    """The parameters of the next round, a function of the observed trials alone."""
    sampler = optuna.samplers.TPESampler(seed=(wanted.seed + len(observed)) % 2**32)
    study = optuna.create_study(sampler=sampler)
    study.add_trials(observed)
    return [study.ask(_distributions(wanted)).params for _ in range(size)]


def _trial(
    parameters: Mapping[str, Any], wanted: Search, value: float | None
) -> optuna.trial.FrozenTrial:
    return optuna.trial.create_trial(
        state=TrialState.FAIL if value is None else TrialState.COMPLETE,
        params=dict(parameters),
        distributions=_distributions(wanted),
        value=value,
    )


def _distributions(wanted: Search) -> dict[str, Any]:
    return {names: _distribution(names, among) for names, among in wanted.space.items()}


def _distribution(names: str, among: Range | list[Any]) -> Any:
    if isinstance(among, list):
        # As text: a choice may be a list, which Optuna does not keep.
        return optuna.distributions.CategoricalDistribution([json.dumps(each) for each in among])
    if isinstance(default_of(names), int):
        return optuna.distributions.IntDistribution(int(among.low), int(among.high), among.log)
    return optuna.distributions.FloatDistribution(among.low, among.high, among.log)


def _values(parameters: Mapping[str, Any], wanted: Search) -> dict[str, Any]:
    """The settings that Optuna's parameters encode."""
    values: dict[str, Any] = {}
    for names, parameter in parameters.items():
        if isinstance(wanted.space[names], Range):
            values[names] = parameter
        else:
            one = json.loads(parameter)
            each = split(names)
            values |= dict(zip(each, one if len(each) > 1 else [one], strict=True))
    return values


def _check_same(spec: Spec, folder: Path) -> None:
    """Refuses to resume a folder with another search."""
    path = folder / _SPEC
    if not path.exists():
        return
    try:
        began = json.loads(path.read_text())
    except (OSError, ValueError) as error:
        raise ValueError(f"{path}: is damaged ({error}); search into a new folder") from None
    if began | {"trials": None} != json.loads(json.dumps(_as_dict(spec))) | {"trials": None}:
        raise ValueError(
            f"{folder}: was started with another search; give the same one (more trials are fine), "
            "or another folder"
        )


def _as_dict(spec: Spec) -> dict[str, Any]:
    assert spec.search is not None
    return asdict(spec.search) | {"config": spec.config}
