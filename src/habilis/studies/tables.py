"""Tables I and II: episodes to convergence, ours beside the paper's."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
import polars as pl
from scipy.stats import ttest_ind, ttest_ind_from_stats

from habilis.learning.runs import Run
from habilis.studies.published import RUNS, Experiment, Row


@dataclass(frozen=True, eq=False)
class Result:
    """A row of a table, as it came out.

    A run that was given up counts with the episodes that it had had by then, less than it would
    have needed: the mean is then a lower bound.

    Attributes:
        row: the paper's.
        run: ours.
        counts: float64[runs], episodes to convergence, or until the run was given up.
    """

    row: Row
    run: Run
    counts: np.ndarray

    @classmethod
    def of(cls, row: Row, run: Run) -> "Result":
        had = run.episodes.group_by("run").len().sort("run")["len"].to_list()
        counts = [n if at is None else at for at, n in zip(run.converged_at, had, strict=True)]
        return cls(row, run, np.array(counts, float))

    @property
    def converged(self) -> int:
        return sum(at is not None for at in self.run.converged_at)

    @property
    def all_converged(self) -> bool:
        return self.converged == len(self.counts)

    @property
    def mean(self) -> float:
        return float(self.counts.mean())

    @property
    def deviation(self) -> float:
        """Sample standard deviation; 0 for a single run."""
        return float(self.counts.std(ddof=1)) if len(self.counts) > 1 else 0.0

    def ratio(self, to: "Result") -> float:
        """How many times the episodes of another row."""
        return self.mean / to.mean


class Outcome(StrEnum):
    """What our runs say of an order of the paper's."""

    HOLDS = "holds"
    OPPOSITE = "opposite"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Comparison:
    """Two rows of a table held against each other.

    Attributes:
        faster, slower: labels of the row that is the faster and the slower one in the paper.
        published_ratio, ours_ratio: episodes of the first over episodes of the second.
        published_p, ours_p: two-sided p-values of Welch's unequal-variances t-test.
        faster_complete, slower_complete: whether all runs of the row converged. If not, our
            mean of it is a lower bound, and so is a p-value no p-value.
    """

    faster: str
    slower: str
    published_ratio: float
    ours_ratio: float
    published_p: float
    ours_p: float
    faster_complete: bool
    slower_complete: bool

    @property
    def outcome(self) -> Outcome:
        """Whether our runs show the paper's order, the opposite one, or neither.

        A row whose mean is a lower bound can only be the slower of two.
        """
        if not self.ours_p < 0.05:
            return Outcome.UNDECIDED
        if self.ours_ratio < 1:
            return Outcome.HOLDS if self.faster_complete else Outcome.UNDECIDED
        return Outcome.OPPOSITE if self.slower_complete else Outcome.UNDECIDED

    @property
    def verdict(self) -> str:
        """The outcome in plain words."""
        given_up = "" if self.faster_complete and self.slower_complete else "; runs were given up"
        if self.outcome is Outcome.HOLDS:
            return f"the paper's order (p = {self.ours_p:.2g}{given_up})"
        if self.outcome is Outcome.OPPOSITE:
            return f"the opposite order (p = {self.ours_p:.2g}{given_up})"
        if given_up:
            return "undecided: runs were given up"
        return f"undecided: not separated (p = {self.ours_p:.2g})"


def comparisons(experiment: Experiment, results: Sequence[Result]) -> list[Comparison]:
    """Every pair of rows, the paper's faster one first."""
    by_label = {result.row.label: result for result in results}
    rows = sorted(experiment.rows, key=lambda row: row.mean)
    pairs = [(fast, slow) for i, fast in enumerate(rows) for slow in rows[i + 1 :]]
    return [_compare(by_label[fast.label], by_label[slow.label]) for fast, slow in pairs]


def _compare(fast: Result, slow: Result) -> Comparison:
    published = ttest_ind_from_stats(
        *(fast.row.mean, fast.row.deviation, RUNS),
        *(slow.row.mean, slow.row.deviation, RUNS),
        equal_var=False,
    )
    return Comparison(
        faster=fast.row.label,
        slower=slow.row.label,
        published_ratio=fast.row.mean / slow.row.mean,
        ours_ratio=fast.ratio(slow),
        published_p=float(published.pvalue),
        ours_p=welch(fast.counts, slow.counts),
        faster_complete=fast.all_converged,
        slower_complete=slow.all_converged,
    )


def welch(a: np.ndarray, b: np.ndarray) -> float:
    """The two-sided p-value of Welch's t-test.

    1 where the test is not defined, which is with a single run, or with samples that do not
    vary: then there is nothing to tell chance by.
    """
    if min(len(a), len(b)) < 2 or np.ptp(a) == 0 or np.ptp(b) == 0:
        return 1.0
    test = ttest_ind(a, b, equal_var=False)
    return float(test.pvalue)  # pyright: ignore[reportAttributeAccessIssue]


def table(experiment: Experiment, results: Sequence[Result]) -> pl.DataFrame:
    """A row for each of the paper's, with ours beside it; ratios are to the vanilla row."""
    vanilla = {result.row.tool: result for result in results if result.row.vanilla}
    rows = []
    for result in results:
        row, base = result.row, vanilla[result.row.tool]
        rows.append(
            {
                "approach": row.label,
                "published_mean": row.mean,
                "published_std": row.deviation,
                "published_ratio": row.mean / base.row.mean,
                "ours_mean": result.mean,
                "ours_std": result.deviation,
                "ours_ratio": result.ratio(base),
                "converged": result.converged,
                "runs": len(result.counts),
                "mean_is_lower_bound": not result.all_converged,
            }
        )
    return pl.DataFrame(rows)
