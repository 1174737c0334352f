"""Estimators held against the truth: bias, error, order of the states, and what they cost."""

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from jaxtyping import Float64

from habilis.empowerment.arguments import at_least_one, whole_number
from habilis.estimators.evaluation.case import Case, suite
from habilis.estimators.protocol import Estimator, is_estimator
from habilis.estimators.simulators.metered import Metered
from habilis.extras import MissingExtraError
from habilis.progress import progress_bar
from habilis.statistics import bootstrap_interval, spearman

if TYPE_CHECKING:
    import polars as pl

Contestant = Estimator | Callable[[Case], Estimator]
"""An estimator, or a function that sets one up for a case."""

MEASURES = ("bias", "rmse", "rank")

_ALIKE = 1e-5  # bits: values that are closer have the same rank


class _Found(NamedTuple):
    kind: str
    bits: Float64[np.ndarray, "n"]
    seconds: float
    steps: int


def evaluate(
    estimators: Contestant | Mapping[str, Contestant],
    cases: Iterable[Case] | None = None,
    seeds: int | Sequence[int] = 3,
    *,
    show_progress: bool = False,
) -> "pl.DataFrame":
    """How far estimators are from known empowerment.

    Only like is compared with like: an estimator of effective empowerment is not held against a
    capacity, nor the other way round.

    Args:
        estimators: one, or several by their names. In the place of one, a function of a case that
            returns one, where settings depend on the case.
        cases: by default `suite()`.
        seeds: how many, from 0 up, or which. Each is a fit.
        show_progress: whether to draw a progress bar on standard error.

    Returns:
        A Polars data frame with a row for each estimator and case. The columns "estimator", "case",
        "target" (of the case), "kind" (of the estimator) and "seeds" say of what. "bias" is the
        mean of estimate minus truth over states, in bits; "rmse" the root of the mean square;
        "rank" Spearman's rank correlation with the truth over states, null where the truth is the
        same everywhere. Each is the mean over seeds, with the ends of its 95 % bootstrap interval
        over seeds, as in "bias_low" and "bias_high". "seconds" are those of a fit with the values
        of all states, compilation included, and "steps" those of the simulator, through
        `habilis.estimators.rollouts`. "reason" says why there are no numbers.

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
    with progress_bar("estimators", show_progress) as report:
        for name, one in named.items():
            for case in asked:
                report(len(rows), len(named) * len(asked))
                rows.append({"estimator": name} | _row(one, case, numbers))
    return pl.DataFrame(rows, schema=_schema())


def _schema() -> dict[str, Any]:
    import polars as pl

    words = dict.fromkeys(("estimator", "case", "target", "kind"), pl.String)
    ends = [f"{name}{end}" for name in MEASURES for end in ("", "_low", "_high")]
    numbers = dict.fromkeys([*ends, "seconds"], pl.Float64)
    return words | {"seeds": pl.Int64} | numbers | {"steps": pl.Int64, "reason": pl.String}


def _name(estimator: Contestant) -> str:
    return getattr(estimator, "__name__", type(estimator).__name__)


def _row(contestant: Contestant, case: Case, seeds: list[int]) -> dict[str, Any]:
    row: dict[str, Any] = {"case": case.name, "target": case.target, "seeds": len(seeds)}
    try:
        found = [_estimated(contestant, case, seed) for seed in seeds]
    except (ValueError, MissingExtraError, FloatingPointError) as error:
        return row | {"reason": str(error).partition("\n")[0]}
    row["kind"] = found[0].kind
    row["seconds"] = float(np.mean([one.seconds for one in found]))
    row["steps"] = round(float(np.mean([one.steps for one in found])))
    for name, values in _measures(np.stack([one.bits for one in found]), case).items():
        low, high = bootstrap_interval(values)
        row |= {name: float(values.mean()), f"{name}_low": float(low), f"{name}_high": float(high)}
    return row


def _estimated(contestant: Contestant, case: Case, seed: int) -> _Found:
    """The estimates of one seed."""
    estimator: Any = contestant if is_estimator(contestant) else contestant(case)  # pyright: ignore[reportCallIssue]
    metered = Metered(case.simulator)
    start = time.perf_counter()
    fitted = estimator.fit(metered, case.horizon, case.sensor, seed=seed)
    if fitted.target != case.target:
        names = {"capacity": "the capacity", "effective": "effective empowerment"}
        raise ValueError(f"estimates {names[fitted.target]}, the case is {names[case.target]}")
    bits = np.asarray(fitted.bits(case.states), np.float64)
    seconds = time.perf_counter() - start
    if bits.shape != case.bits.shape:
        raise ValueError(f"gives bits of shape {bits.shape} for {len(case.states)} states")
    if not np.isfinite(bits).all():
        raise ValueError("gives bits that are not finite")
    return _Found(fitted.kind, bits, seconds, metered.steps)


def _measures(bits: Float64[np.ndarray, "seeds n"], case: Case) -> dict[str, np.ndarray]:
    off = bits - case.bits
    found = {"bias": off.mean(axis=1), "rmse": np.sqrt((off**2).mean(axis=1))}
    truth = np.broadcast_to(np.rint(case.bits / _ALIKE), bits.shape)
    if np.ptp(truth) > 0:
        found["rank"] = spearman(np.rint(bits / _ALIKE), truth)
    return found
