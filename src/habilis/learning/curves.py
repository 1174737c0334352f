"""Learning curves: what runs do from episode to episode, and on average over them."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import polars as pl
from jaxtyping import Float, Int

from habilis.learning.runs import Run
from habilis.reprs import short, unfailing
from habilis.statistics import STATISTICS, bootstrap_interval

SMOOTHING = 100  # episodes
POINTS = 500  # of a curve

VALUES = {
    "return": pl.col("return"),
    "length": pl.col("steps"),
    "equipped": pl.col("equipped") / pl.col("steps"),
    "attached": pl.col("attached") / pl.col("equipped"),
}
"""The measures of an episode: its extrinsic return, its steps, the share of them with the tool in
hand, and the share of these with the object attached to it (none if it was never in hand)."""


@dataclass(frozen=True, eq=False)
class Curve:
    """A statistic of the runs of one configuration, with its interval.

    Attributes:
        value: which of `VALUES`.
        unit: what `x` counts, "episodes" or "steps" (of the environment).
        statistic: "mean" or "iqm", the mean of the middle half.
        runs: how many there are.
        carried: how many of them are carried on at their last value where the curve ends.
        x: float64[points].
        middle, low, high: float64[points], the statistic and its 95 % bootstrap interval.
    """

    value: str
    unit: str
    statistic: str
    runs: int
    carried: int
    x: Float[np.ndarray, "points"]
    middle: Float[np.ndarray, "points"]
    low: Float[np.ndarray, "points"]
    high: Float[np.ndarray, "points"]

    @unfailing
    def __repr__(self) -> str:
        return short("Curve", self.text())

    def as_dict(self) -> dict[str, Any]:
        """Runs, and the points as lists."""
        points = {name: getattr(self, name).tolist() for name in ("x", "low", "high")}
        counts = {"runs": self.runs, "carried_on": self.carried}
        return counts | points | {self.statistic: self.middle.tolist()}

    def text(self) -> str:
        """Where the curve ends, in words."""
        over = f"over {self.runs} run{'s' if self.runs > 1 else ''}"
        return (
            f"{self.statistic} {self.value} {self.middle[-1]:.4g} "
            f"[{self.low[-1]:.4g}, {self.high[-1]:.4g}] {over} after {self.x[-1]:,.0f} {self.unit}"
        )


def learning_curve(
    run: Run, value: str = "return", unit: str = "episodes", statistic: str = "mean"
) -> Curve:
    """The average learning curve of one configuration's runs.

    A run's value at some point is the mean over its last 100 episodes there; curves begin where all
    runs have as many, or, while some are younger, where all have one. A run that has *converged*
    was ended because there was nothing left to learn: it is carried on at its last value, or else
    the average would be over ever fewer runs, and jump whenever one leaves. Of a run that was given
    up, or has not ended, nobody knows how it would have gone on: the curve ends where the first of
    these does. So at every point it is over all runs.

    Args:
        run: what training gave, to its end or so far.
        value: which of `VALUES`.
        unit: what goes to the right: episodes, or steps of the environment in ended episodes.
        statistic: over the runs: "mean" or "iqm".

    Returns:
        The curve, with a 95 % bootstrap interval at each point.

    Raises:
        ValueError: the value is not there in this world, or a run has not ended an episode yet.
    """
    missing = set(VALUES[value].meta.root_names()) - set(run.episodes.columns)
    if missing:
        raise ValueError(f"{run.world.name}: episodes have no {min(missing)!r}; plot another value")
    episodes = run.episodes.select("run", "steps", value=VALUES[value].cast(pl.Float64))
    places, smooth = [], []
    for k in range(run.config.runs):
        part = episodes.filter(run=k)
        values = held(smoothed(part["value"].to_numpy(), SMOOTHING))
        steps = part["steps"].cast(pl.Int64).cum_sum().to_numpy()
        there = np.isfinite(values)
        places.append((steps if unit == "steps" else np.arange(len(part)) + 1)[there])
        smooth.append(values[there])
    open_ended = [
        at[-1] if len(at) else 0
        for at, end in zip(places, run.converged_at, strict=True)
        if end is None
    ]
    last = min(open_ended, default=max(at[-1] if len(at) else 0 for at in places))
    for k, at in sorted(enumerate(places), key=lambda place: len(place[1])):
        if not len(at) or at[0] > last:
            raise ValueError(
                f"{run.world.name}: run {k} has no {value} to plot yet; train on, or plot another "
                "value"
            )
    full = max(at[min(SMOOTHING, len(at)) - 1] for at in places)
    first = full if full <= last else max(at[0] for at in places)
    x = np.unique(np.linspace(first, last, POINTS).round())
    table = np.stack(
        [values[at_or_before(at, x)] for at, values in zip(places, smooth, strict=True)]
    )
    function = STATISTICS[statistic]
    low, high = bootstrap_interval(table, function)
    return Curve(
        *(value, unit, statistic, len(places), int(sum(at[-1] < last for at in places))),
        *(x, function(table), low, high),
    )


def smoothed(values: Float[np.ndarray, "n"], window: int) -> Float[np.ndarray, "n"]:
    """Mean of the last `window` values, fewer at the start; what is NaN is left out."""
    there = np.isfinite(values)
    sums, counts = (
        np.concatenate([[0.0], np.cumsum(part)]) for part in (np.where(there, values, 0), there)
    )
    end = np.arange(1, len(values) + 1)
    start = np.maximum(end - window, 0)
    count = counts[end] - counts[start]
    total = sums[end] - sums[start]
    return np.divide(total, count, out=np.full(len(values), np.nan), where=count > 0)


def held(values: Float[np.ndarray, "n"]) -> Float[np.ndarray, "n"]:
    """With the last value there was in place of NaN; NaN before the first."""
    latest = np.maximum.accumulate(np.where(np.isfinite(values), np.arange(len(values)), 0))
    return values[latest] if len(values) else values


def at_or_before(places: Int[np.ndarray, "n"], x: Float[np.ndarray, "m"]) -> Int[np.ndarray, "m"]:
    """The index of the last place that is at most each x, of which none is below the first."""
    return np.searchsorted(places, x, side="right") - 1
