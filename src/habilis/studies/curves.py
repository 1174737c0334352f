"""What the runs of a configuration do from episode to episode, averaged over them."""

import numpy as np
import polars as pl
from jaxtyping import Float

from habilis.learning.convergence import moving_average
from habilis.learning.runs import Run

SMOOTHING = 100  # episodes


def equipped_share(run: Run) -> Float[np.ndarray, "episodes"]:
    """Share of an episode's steps with the tool in hand, averaged over the runs."""
    return _mean_over_runs(run, pl.col("equipped") / pl.col("steps"))


def attached_share(run: Run) -> Float[np.ndarray, "episodes"]:
    """Share of the steps with the tool in hand in which the object is attached to it.

    An episode in which the tool was never in hand counts as 0.
    """
    share = pl.when(pl.col("equipped") > 0).then(pl.col("attached") / pl.col("equipped"))
    return _mean_over_runs(run, share.otherwise(0.0))


def mean_return(run: Run) -> Float[np.ndarray, "episodes"]:
    """Extrinsic return, averaged over the runs."""
    return _mean_over_runs(run, pl.col("return"))


def smooth(values: Float[np.ndarray, "episodes"]) -> Float[np.ndarray, "fewer"]:
    """Moving average over `SMOOTHING` episodes."""
    return moving_average(values, SMOOTHING)


def _mean_over_runs(run: Run, value: pl.Expr) -> Float[np.ndarray, "episodes"]:
    """Mean over the runs by episode, as far as every run goes."""
    episodes = run.episodes.select("run", "episode", value.alias("value"))
    shortest = episodes.group_by("run").len()["len"].min()
    means = (
        episodes.filter(pl.col("episode") < shortest)
        .group_by("episode")
        .agg(pl.col("value").mean())
        .sort("episode")
    )
    return means["value"].to_numpy()
