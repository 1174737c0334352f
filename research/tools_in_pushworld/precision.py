"""How often the movable that a rule names is one that the solution uses."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import polars as pl
from jaxtyping import Float64

from habilis.statistics import bootstrap_interval, mean
from research.tools_in_pushworld.cases import asks

CASE = ("level", "puzzle", "target")
LOSSES = ("lost_fixed", "lost_removed", "fixed_first", "removed_first")
"""Columns of `losses.csv`: means over states of the solution, and in its first state alone."""
BASELINES = ("chance", "nearest", "nearest_along", "largest")
RULES = (*LOSSES, *BASELINES)


def named_right(scores: Sequence[float], used: Sequence[bool]) -> float:
    """How likely the one of largest score is a used one, where equal ones are drawn from.

    Example:
        >>> named_right([1.0, 2.0, 2.0], [True, True, False])
        0.5
    """
    best = np.isclose(scores, max(scores), rtol=0, atol=1e-6)
    return float(np.asarray(used, np.float64)[best].mean())


def verdicts(cases: pl.DataFrame, losses: pl.DataFrame) -> pl.DataFrame:
    """For each case and horizon how likely each rule names a used movable.

    Args:
        cases, losses: the tables `cases.csv` and `losses.csv`. Cases in which the solution uses
            none of the other movables, or all of them, are left out.

    Returns:
        `level`, `puzzle`, `target`, `horizon`; for each rule of `RULES` a number from 0 to 1;
        `answers_...`, for each loss, whether some movable has a positive one.
    """
    rows = []
    joined = losses.join(cases, on=[*CASE, "object"], how="inner", maintain_order="left")
    for key, group in joined.group_by([*CASE, "horizon"], maintain_order=True):
        if asks(group.to_dicts()):
            row = dict(zip((*CASE, "horizon"), key, strict=True))
            rows.append(row | _verdict(group, (group["steps_through"] > 0).to_list()))
    return pl.DataFrame(rows)


def _verdict(group: pl.DataFrame, used: Sequence[bool]) -> dict[str, Any]:
    scores = {name: group[name].to_list() for name in LOSSES}
    scores |= {"chance": [0.0] * len(used), "largest": group["cells"].to_list()}
    scores |= {"nearest": (-group["distance"]).to_list()}
    scores |= {"nearest_along": (-group["distance_along"]).to_list()}
    right = {name: named_right(scores[name], used) for name in RULES}
    return right | {f"answers_{name}": max(scores[name]) > 1e-6 for name in LOSSES}


def by_puzzle(found: pl.DataFrame) -> dict[str, Float64[np.ndarray, "puzzles"]]:
    """For each rule the mean over the cases of each puzzle, so that each puzzle counts once."""
    grouped = found.group_by("level", "puzzle", maintain_order=True).agg(pl.col(RULES).mean())
    return {rule: grouped[rule].to_numpy() for rule in RULES}


def precision(found: pl.DataFrame) -> pl.DataFrame:
    """The precision of each rule at each horizon, with 95 % intervals over puzzles.

    Args:
        found: as `verdicts` returns it.

    Returns:
        `horizon`, `rule`, `among` ("all" cases, or those where the loss "answers": some movable
        has a positive one), `puzzles`, `cases`, `precision`, `low`, `high`, and the mean difference
        from each of `BASELINES` on the same cases, with its interval: `over_chance`,
        `over_chance_low`, ...
    """
    rows = []
    for (horizon,), group in found.group_by(["horizon"], maintain_order=True):
        for rule in RULES:
            about = {"horizon": horizon, "rule": rule}
            rows.append(about | {"among": "all"} | _precision(group, rule))
            if rule in LOSSES:
                part = group.filter(pl.col(f"answers_{rule}"))
                rows.append(about | {"among": "answers"} | _precision(part, rule))
    return pl.DataFrame(rows, infer_schema_length=None)


def _precision(found: pl.DataFrame, rule: str) -> dict[str, Any]:
    if found.is_empty():
        return {"puzzles": 0, "cases": 0}
    values = by_puzzle(found)
    row: dict[str, Any] = {"puzzles": len(values[rule]), "cases": len(found)}
    row |= _interval("precision", values[rule])
    for other in BASELINES:
        row |= _interval(f"over_{other}", values[rule] - values[other])
    return row


def _interval(name: str, values: Float64[np.ndarray, "puzzles"]) -> dict[str, float]:
    low, high = bootstrap_interval(values)
    ends = ("low", "high") if name == "precision" else (f"{name}_low", f"{name}_high")
    numbers = (float(mean(values)), float(low), float(high))
    return {column: round(n, 4) + 0.0 for column, n in zip((name, *ends), numbers, strict=True)}
