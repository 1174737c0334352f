"""The results of a study: a table with intervals, contrasts of agents, sentences."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import polars as pl
from jaxtyping import Float

from habilis.statistics import bootstrap_interval, holm, interquartile_interval
from habilis.studies.bonuses.study import Measure, Study
from habilis.studies.comparison import Comparison, Outcome, compare


def values_of(runs: pl.DataFrame, measure: Measure) -> Float[np.ndarray, "runs"]:
    """A measure of each run; infinite where it counts episodes and a run exceeded its budget."""
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
        Of counts the middle is the interquartile mean, null where too many runs exceeded their
        budget; of shares the mean. The ends are those of the 95 % bootstrap interval.
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
        return interquartile_interval(values)
    low, high = bootstrap_interval(values)
    return float(values.mean()), float(low), float(high)


@dataclass(frozen=True)
class Contrast:
    """Two agents compared in one case.

    Attributes:
        case, agent, other: which.
        ranks: how often a run of the agent was better than one of the other, and p after Holm's
            correction over the pairs of the case.
    """

    case: str
    agent: str
    other: str
    ranks: Comparison

    @property
    def outcome(self) -> Outcome:
        """Whether the agent is the better one, the other is, or neither can be shown."""
        return self.ranks.outcome

    def as_dict(self) -> dict[str, Any]:
        """For machines."""
        names = {"case": self.case, "agent": self.agent, "other": self.other}
        ranks = {"superiority": self.ranks.superiority, "p": self.ranks.p}
        return names | ranks | {"outcome": self.outcome.value}


def contrasts(study: Study, runs: pl.DataFrame) -> list[Contrast]:
    """The pairs of a study, compared in each case by the measure that decides."""
    found = []
    for case in study.cases:
        of_agent = {
            agent.name: values_of(runs.filter(case=case.name, agent=agent.name), study.measures[0])
            for agent in study.agents
        }
        tests = [compare(of_agent[one], of_agent[other]) for one, other in study.pairs]
        corrected = holm([test.p for test in tests])
        for (one, other), test, p in zip(study.pairs, tests, corrected, strict=True):
            below = test.superiority
            better = below if study.measures[0].counts else 1 - below  # of shares the larger
            ranks = replace(test, superiority=better, p=p)
            found.append(Contrast(case.name, one, other, ranks))
    return found


def sentences(study: Study, compared: Sequence[Contrast]) -> list[str]:
    """The outcome in words: a sentence for each case and agent whose pairs there are."""
    better, worse = ("sooner", "later") if study.measures[0].counts else ("higher", "lower")
    words = {
        Outcome.HOLDS: f"{better} than",
        Outcome.OPPOSITE: f"{worse} than",
        Outcome.UNDECIDED: "not distinguishable from",
    }
    lines = []
    for case in study.cases:
        for agent in dict.fromkeys(one for one, _ in study.pairs):
            parts = []
            for outcome, phrase in words.items():
                others = [
                    f"{c.other} (p = {c.ranks.p:.2g})"
                    for c in compared
                    if (c.case, c.agent, c.outcome) == (case.name, agent, outcome)
                ]
                if others:
                    parts.append(f"{phrase} {', '.join(others)}")
            lines.append(
                f"{case.name}: by {study.measures[0].title}, {agent} is {'; '.join(parts)}."
            )
    return lines


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
