"""The weight of each bonus: chosen for each case, in the same way for all."""

import polars as pl

from habilis.studies.bonuses.study import Measure


def choose(tried: pl.DataFrame, measure: Measure) -> dict[tuple[str, str], float]:
    """The weight with which an agent did best in runs made for that alone.

    Where episodes are counted, the weight with which most runs stay within their budget; among
    these, the one with the fewest episodes on average; where no run does, the one with the
    earliest first success. Of equals the smallest.

    Args:
        tried: a row a run, as `training.trained` has them, of several weights.
        measure: the one that decides in the study.

    Returns:
        By case and agent.
    """
    best: dict[tuple[str, str], tuple[tuple[float, ...], float]] = {}
    for (case, agent, beta), runs in tried.group_by("case", "agent", "beta", maintain_order=True):
        key, weight = (str(case), str(agent)), float(str(beta))
        found = (_loss(runs, measure), weight)
        best[key] = min(best.get(key, found), found)
    return {key: weight for key, (_, weight) in best.items()}


def _loss(runs: pl.DataFrame, measure: Measure) -> tuple[float, ...]:
    values = runs[measure.column]
    if not measure.counts:
        return (-_mean(values, 0.0),)
    first = runs["first_success"]
    return tuple(
        part
        for column in (values, first)
        for part in (-float(column.count()), _mean(column, float("inf")))
    )


def _mean(values: pl.Series, without: float) -> float:
    mean = values.cast(pl.Float64).mean()
    return float(mean) if isinstance(mean, float) else without
