"""Curves of runs over episodes, and their means."""

import numpy as np
import polars as pl
from jaxtyping import Float

from habilis.learning.convergence import moving_average
from habilis.learning.curves import SMOOTHING, VALUES
from habilis.learning.runs import Run

Curves = Float[np.ndarray, "runs episodes"]
"""A value for each run and episode, as far as every run goes; NaN where there is none."""


def equipped_share(run: Run) -> Curves:
    """Share of an episode's steps with the tool in hand."""
    return _by_run(run, VALUES["equipped"])


def attached_share(run: Run) -> Curves:
    """Share of the steps with the tool in hand in which the object is attached to it.

    There is none in an episode in which the tool was never in hand.
    """
    return _by_run(run, VALUES["attached"])


def returns(run: Run) -> Curves:
    """Extrinsic return."""
    return _by_run(run, VALUES["return"])


def mean_curve(curves: Curves) -> Float[np.ndarray, "fewer"]:
    """Mean over the runs and over a moving window of `SMOOTHING` episodes.

    What is missing is left out; NaN where nothing is there.
    """
    there = np.isfinite(curves)
    sums = moving_average(np.where(there, curves, 0).sum(axis=0), SMOOTHING)
    counts = moving_average(there.sum(axis=0), SMOOTHING)
    return np.divide(sums, counts, out=np.full_like(sums, np.nan), where=counts > 0)


def _by_run(run: Run, value: pl.Expr) -> Curves:
    runs = run.episodes.select("run", value.alias("value")).partition_by("run")
    shortest = min(len(one) for one in runs)
    return np.stack([one["value"].to_numpy()[:shortest] for one in runs])
