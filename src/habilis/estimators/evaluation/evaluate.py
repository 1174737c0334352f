"""Estimators compared with the truth: bias, error, order of the states, and what they cost."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import chain, product
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float64

from habilis.empowerment.arguments import at_least_one, whole_number
from habilis.estimators.evaluation.case import Case, suite
from habilis.estimators.evaluation.estimates import (
    REFUSALS,
    Contestant,
    Estimates,
    estimated,
    refused,
)
from habilis.estimators.protocol import is_estimator
from habilis.progress import progress_bar
from habilis.statistics import bootstrap_interval, spearman
from habilis.tasks.task import Executor, results_of

if TYPE_CHECKING:
    import polars as pl

    from habilis.estimators.evaluation.tasks import EstimateTask

MEASURES = ("bias", "rmse", "rank")

_ALIKE = 1e-5  # bits: values that are closer have the same rank


def evaluate(
    estimators: Contestant | Mapping[str, Contestant],
    cases: Iterable[Case] | None = None,
    seeds: int | Sequence[int] = 3,
    *,
    executor: Executor[Any] | None = None,
    show_progress: bool = False,
) -> "pl.DataFrame":
    """How far estimators are from known empowerment.

    Only like is compared with like: an estimator of effective empowerment is not compared with a
    capacity, nor the other way round.

    Args:
        estimators: one, or several by their names. In the place of one, a function of a case that
            returns one, where settings depend on the case.
        cases: by default `suite()`.
        seeds: how many, from 0 up, or which. Each is a fit.
        executor: runs each seed of an estimator and a case as a task elsewhere, as in
            `empowerment`.
        show_progress: whether to draw a progress bar on standard error.

    Returns:
        A Polars data frame with a row for each estimator and case. The columns "estimator", "case",
        "target" (of the case), "kind" (of the estimator) and "seeds" say of what. "bias" is the
        mean of estimate minus truth over states, in bits; "rmse" the root of the mean square;
        "rank" Spearman's rank correlation with the truth over states, null where the truth is the
        same everywhere. Each is the mean over seeds, with the ends of its 95 % bootstrap interval
        over seeds, as in "bias_low" and "bias_high". "seconds" are those of a fit with the values
        of all states, compilation included, and "steps" those of the simulator, as in
        `habilis.estimators.simulators.Metered`. "reason" says why there are no numbers.

    Raises:
        ValueError: an estimator without `fit`, or no seeds.

    Example:
        >>> from habilis.estimators import Counting
        >>> table = evaluate(Counting(), suite(["maze"]), seeds=1)
        >>> table.select("estimator", "bias", "rank", "reason").rows()
        [('Counting', 0.0, 1.0, None)]
    """
    import polars as pl

    named = estimators if isinstance(estimators, Mapping) else {_name(estimators): estimators}
    for name, one in named.items():
        if isinstance(one, type) or not (is_estimator(one) or callable(one)):
            raise ValueError(f"estimator {name!r} has no method fit; give one, as hb.Counting()")
    given = range(at_least_one("seeds", seeds)) if isinstance(seeds, int) else seeds
    numbers = [whole_number("seed", seed) for seed in given]
    if not numbers:
        raise ValueError("seeds is empty; give at least one")
    asked = suite() if cases is None else list(cases)
    rows = []
    if executor is not None:
        rows = _rows_of_tasks(named, asked, numbers, executor, show_progress)
        return pl.DataFrame(rows, schema=_schema())
    with progress_bar("estimators", show_progress) as report:
        for name, one in named.items():
            for case in asked:
                report(len(rows), len(named) * len(asked))
                found = _until_refused(estimated(one, case, seed) for seed in numbers)
                rows.append({"estimator": name} | _row(case, found, len(numbers)))
    return pl.DataFrame(rows, schema=_schema())


def _rows_of_tasks(
    named: Mapping[str, Contestant],
    cases: Sequence[Case],
    seeds: Sequence[int],
    executor: Executor[Any],
    show_progress: bool,
) -> list[dict[str, Any]]:
    """The rows, by tasks; the same, but for the seconds."""
    from habilis.estimators.evaluation.tasks import tasks_of

    tasks: dict[tuple[str, str], list[EstimateTask]] = {}
    refusals: dict[tuple[str, str], Estimates] = {}
    for case in cases:  # those of one case in a row, so that a process has it only once
        for name, one in named.items():
            try:
                tasks[name, case.name] = tasks_of(name, one, case, seeds)
            except REFUSALS as error:
                refusals[name, case.name] = refused(error)
    with progress_bar("tasks", show_progress, time_left=True) as report:
        results = results_of([*chain(*tasks.values())], executor, report)
    rows = []
    for name, case in product(named, cases):
        pair = name, case.name
        found = [Estimates.of_arrays(results[task.name]) for task in tasks.get(pair, [])]
        found = _until_refused([refusals[pair]] if pair in refusals else found)
        rows.append({"estimator": name} | _row(case, found, len(seeds)))
    return rows


def _until_refused(found: Iterable[Estimates]) -> list[Estimates]:
    """The estimates up to the first refusal, after which no other seed is tried."""
    those: list[Estimates] = []
    for one in found:
        those.append(one)
        if one.reason:
            break
    return those


def _schema() -> dict[str, Any]:
    import polars as pl

    words = dict.fromkeys(("estimator", "case", "target", "kind"), pl.String)
    ends = [f"{name}{end}" for name in MEASURES for end in ("", "_low", "_high")]
    numbers = dict.fromkeys([*ends, "seconds"], pl.Float64)
    return words | {"seeds": pl.Int64} | numbers | {"steps": pl.Int64, "reason": pl.String}


def _name(estimator: Contestant) -> str:
    return getattr(estimator, "__name__", type(estimator).__name__)


def _row(case: Case, found: Sequence[Estimates], seeds: int) -> dict[str, Any]:
    row: dict[str, Any] = {"case": case.name, "target": case.target, "seeds": seeds}
    if found[-1].reason:
        return row | {"reason": found[-1].reason}
    row["kind"] = found[0].kind
    row["seconds"] = float(np.mean([one.seconds for one in found]))
    row["steps"] = round(float(np.mean([one.steps for one in found])))
    bits = np.stack([one.bits for one in found if one.bits is not None])
    for name, values in _measures(bits, case).items():
        low, high = bootstrap_interval(values)
        row |= {name: float(values.mean()), f"{name}_low": float(low), f"{name}_high": float(high)}
    return row


def _measures(bits: Float64[np.ndarray, "seeds n"], case: Case) -> dict[str, np.ndarray]:
    off = bits - case.bits
    found = {"bias": off.mean(axis=1), "rmse": np.sqrt((off**2).mean(axis=1))}
    truth = np.broadcast_to(np.rint(case.bits / _ALIKE), bits.shape)
    if np.ptp(truth) > 0:
        found["rank"] = spearman(np.rint(bits / _ALIKE), truth)
    return found
