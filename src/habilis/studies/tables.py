"""Tables I and II: episodes to convergence, ours beside the paper's."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
import polars as pl
from scipy.stats import mannwhitneyu, rankdata, ttest_ind, ttest_ind_from_stats

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
    def median(self) -> float:
        """Of the runs, those given up above all others: infinite if half of them were."""
        return float(np.median(self.ranked))

    @property
    def ranked(self) -> np.ndarray:
        """float64[runs], episodes to convergence, infinite for a run that was given up."""
        at = self.run.converged_at
        return np.array([np.inf if n is None else n for n in at], float)

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
        complete: whether all our runs converged. If not, means are lower bounds, ratio and
            Welch's test say nothing, and ranks decide.
        rank_p: two-sided p-value of Mann and Whitney's test, for which it is enough to know that
            a run that was given up would have taken longer.
        faster_first: whether our runs of the first row come before those of the second, by
            their means, or by their ranks where runs were given up.
    """

    faster: str
    slower: str
    published_ratio: float
    ours_ratio: float
    published_p: float
    ours_p: float
    complete: bool
    rank_p: float
    faster_first: bool

    @property
    def p(self) -> float:
        """Of the test that decides."""
        return self.ours_p if self.complete else self.rank_p

    @property
    def outcome(self) -> Outcome:
        """Whether our runs show the paper's order, the opposite one, or neither (p = 0.05)."""
        if not self.p < 0.05:
            return Outcome.UNDECIDED
        return Outcome.HOLDS if self.faster_first else Outcome.OPPOSITE

    @property
    def verdict(self) -> str:
        """The outcome in plain words."""
        words = {
            Outcome.HOLDS: "the paper's order",
            Outcome.OPPOSITE: "the opposite order",
            Outcome.UNDECIDED: "undecided: not separated",
        }
        by = "" if self.complete else "by ranks, as runs were given up: "
        return f"{by}{words[self.outcome]} (p = {self.p:.2g})"


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
    complete = fast.all_converged and slow.all_converged
    below, rank_p = mann_whitney(fast.ranked, slow.ranked)
    return Comparison(
        faster=fast.row.label,
        slower=slow.row.label,
        published_ratio=fast.row.mean / slow.row.mean,
        ours_ratio=fast.ratio(slow),
        published_p=float(published.pvalue),
        ours_p=welch(fast.counts, slow.counts),
        complete=complete,
        rank_p=rank_p,
        faster_first=fast.mean < slow.mean if complete else below > 0.5,
    )


def mann_whitney(a: np.ndarray, b: np.ndarray) -> tuple[float, float]:
    """How often a value of the first is below one of the second (ties count half), and p.

    p is two-sided, by the normal approximation with ties and continuity corrected; 1 where all
    values are equal.
    """
    below = float((np.less.outer(a, b) + 0.5 * np.equal.outer(a, b)).mean())
    ranks = rankdata(np.concatenate([a, b]))
    if np.ptp(ranks) == 0:
        return below, 1.0
    test = mannwhitneyu(ranks[: len(a)], ranks[len(a) :], method="asymptotic")
    return below, float(test.pvalue)


def welch(a: np.ndarray, b: np.ndarray) -> float:
    """The two-sided p-value of Welch's t-test.

    1 where the test is not defined, which is with a single run, or with samples that do not
    vary: then there is nothing to tell chance by.
    """
    if min(len(a), len(b)) < 2 or np.ptp(a) == 0 or np.ptp(b) == 0:
        return 1.0
    test = ttest_ind(a, b, equal_var=False)
    return float(test.pvalue)  # pyright: ignore[reportAttributeAccessIssue]


def _ratio_is(result: Result, base: Result) -> str:
    """What the ratio of two means is where one of them, or both, are lower bounds."""
    if result is base or (result.all_converged and base.all_converged):
        return "exact"
    if base.all_converged:
        return "at least"
    return "at most" if result.all_converged else "unknown"


def table(experiment: Experiment, results: Sequence[Result]) -> pl.DataFrame:
    """A row for each of the paper's, with ours beside it; ratios are to the vanilla row.

    There is no median where half of the runs or more were given up.
    """
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
                "ours_median": result.median if np.isfinite(result.median) else None,
                "ours_ratio": result.ratio(base),
                "converged": result.converged,
                "runs": len(result.counts),
                "mean_is_lower_bound": not result.all_converged,
                "ratio_is": _ratio_is(result, base),
            }
        )
    return pl.DataFrame(rows, schema_overrides={"ours_median": pl.Float64})
