"""What the runs of a study say: a table with intervals, comparisons, a sentence."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import polars as pl
from jaxtyping import Float

from habilis.learning.intervals import bootstrap_interval
from habilis.studies.bonuses.study import Measure, Study
from habilis.studies.comparison import Outcome, mann_whitney, outcome_of
from research.multiverse.study import iqm


def values_of(runs: pl.DataFrame, measure: Measure) -> Float[np.ndarray, "runs"]:
    """A measure of each run; infinite where it counts episodes and a run did not get there."""
    values = runs[measure.column].cast(pl.Float64)
    return values.fill_null(np.inf if measure.counts else 0.0).to_numpy()


def summary(study: Study, runs: pl.DataFrame) -> pl.DataFrame:
    """The table of a study.

    Args:
        study: whose table.
        runs: a row a run, as `training.trained` has them.

    Returns:
        A row for each case and agent: "case", "agent", "beta", "runs", "converged" (how many of
        them), and for each measure three columns named for its own: the middle, "_low", "_high".
        Of counts the middle is the interquartile mean, null where too many runs did not come so
        far; of shares the mean. The ends are those of the 95 % bootstrap interval.
    """
    rows = []
    for case in study.cases:
        for agent in study.agents:
            part = runs.filter(case=case.name, agent=agent.name)
            row: dict[str, Any] = {"case": case.name, "agent": agent.name}
            row |= {"beta": part["beta"][0], "runs": len(part)}
            row["converged"] = part["converged_at"].count()
            for measure in study.measures:
                names = (measure.column, f"{measure.column}_low", f"{measure.column}_high")
                row |= dict(zip(names, interval(values_of(part, measure), measure), strict=True))
            rows.append(row)
    spread = {
        measure.column + end: pl.Float64
        for measure in study.measures
        for end in ("", "_low", "_high")
    }
    return pl.DataFrame(rows, schema_overrides=spread, infer_schema_length=None)


def interval(
    values: Float[np.ndarray, "runs"], measure: Measure
) -> tuple[float | None, float | None, float | None]:
    """The middle of some runs and its 95 % interval; null where infinite."""
    if measure.counts:
        return iqm(values)
    low, high = bootstrap_interval(values)
    return float(values.mean()), float(low), float(high)


@dataclass(frozen=True)
class Comparison:
    """Two agents held against each other in one case.

    Attributes:
        case, agent, other: which.
        superiority: how often a run of the agent was better than one of the other (ties: half).
        p: two-sided, Mann and Whitney's, after Holm's correction over the pairs of the case.
    """

    case: str
    agent: str
    other: str
    superiority: float
    p: float

    @property
    def outcome(self) -> Outcome:
        """Whether the agent is the better one, the other is, or nobody can say."""
        return outcome_of(self.superiority, self.p)


def comparisons(study: Study, runs: pl.DataFrame) -> list[Comparison]:
    """The pairs of a study, held against each other in each case by the measure that decides."""
    found = []
    for case in study.cases:
        of_agent = {
            agent.name: values_of(runs.filter(case=case.name, agent=agent.name), study.measures[0])
            for agent in study.agents
        }
        tests = [mann_whitney(of_agent[one], of_agent[other]) for one, other in study.pairs]
        corrected = holm([p for _, p in tests])
        for (one, other), (below, _), p in zip(study.pairs, tests, corrected, strict=True):
            better = below if study.measures[0].counts else 1 - below
            found.append(Comparison(case.name, one, other, better, p))
    return found


def holm(p: Sequence[float]) -> list[float]:
    """p-values of several tests, corrected so that one in twenty sets of them is wrong anywhere.

    Example:
        >>> holm([0.01, 0.04, 0.03])
        [0.03, 0.06, 0.06]
    """
    corrected, largest = [1.0] * len(p), 0.0
    for rank, place in enumerate(sorted(range(len(p)), key=p.__getitem__)):
        largest = max(largest, (len(p) - rank) * p[place])
        corrected[place] = min(1.0, largest)
    return corrected


def sentences(study: Study, compared: Sequence[Comparison]) -> list[str]:
    """The outcome in words: a sentence for each case and agent whose pairs there are."""
    better, worse = ("sooner", "later") if study.measures[0].counts else ("higher", "lower")
    words = {
        Outcome.HOLDS: f"{better} than",
        Outcome.OPPOSITE: f"{worse} than",
        Outcome.UNDECIDED: "not to be told from",
    }
    told = []
    for case in study.cases:
        for agent in dict.fromkeys(one for one, _ in study.pairs):
            parts = []
            for outcome, phrase in words.items():
                others = [
                    f"{c.other} (p = {c.p:.2g})"
                    for c in compared
                    if (c.case, c.agent, c.outcome) == (case.name, agent, outcome)
                ]
                if others:
                    parts.append(f"{phrase} {', '.join(others)}")
            told.append(
                f"{case.name}: by {study.measures[0].title}, {agent} is {'; '.join(parts)}."
            )
    return told


def divergences(runs: pl.DataFrame) -> list[str]:
    """A sentence for each case and agent of which runs diverged."""
    found = []
    for (case, agent), part in runs.group_by("case", "agent", maintain_order=True):
        count = int((~part["finite"]).sum())
        if count:
            one = "it counts as a run that never converges"
            several = "they count as runs that never converge"
            found.append(
                f"{case}, {agent}: {count} of {len(part)} runs diverged (a loss or parameters "
                f"became infinite or NaN); {one if count == 1 else several}."
            )
    return found
