"""Tables I and II: episodes to convergence, ours beside the paper's."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from habilis.learning.runs import Run
from habilis.statistics import welch, welch_of_moments
from habilis.studies.comparison import Comparison, Outcome, compare
from habilis.studies.pace.data import Learner, Pace
from habilis.studies.pace.ratios import Ratio, bound, ratio_over
from habilis.studies.paper.published import RUNS, Experiment, Row


@dataclass(frozen=True, eq=False)
class Result:
    """A row of a table, as it came out.

    A run that exceeds its budget counts with the episodes that it completed, fewer than it would
    have needed: the mean is then a lower bound.

    Attributes:
        row: the paper's.
        run: ours.
        counts: float64[runs], episodes to convergence, or those that the budget allowed.
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
    def map(self) -> str:
        """The name of the map, without the folder and suffix of its file."""
        return Path(self.run.world.name).stem

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
        """Over the runs: infinite if half of them exceeded their budget."""
        return float(np.median(self.ranked))

    @property
    def ranked(self) -> np.ndarray:
        """float64[runs], episodes to convergence, infinite for a run that exceeded its budget."""
        at = self.run.converged_at
        return np.array([np.inf if n is None else n for n in at], float)

    @property
    def deviation(self) -> float:
        """Sample standard deviation; 0 for a single run."""
        return float(self.counts.std(ddof=1)) if len(self.counts) > 1 else 0.0

    def ratio(self, to: "Result") -> float:
        """The mean episodes over those of another row."""
        return self.mean / to.mean


@dataclass(frozen=True)
class RowOrder:
    """The order of two rows of a table, published and ours.

    Attributes:
        faster, slower: labels of the row that is the faster and the slower one in the paper.
        published_ratio, ours_ratio: episodes of the first over episodes of the second.
        published_p: two-sided p-value of Welch's unequal-variances t-test, of the published means
            and deviations.
        ours_p: of the same test on our runs. It does not decide, and is meaningless where not all
            runs converged.
        complete: whether all our runs converged. If not, means are lower bounds, and the ratio is
            meaningless.
        ranks: our runs compared by ranks, which decides: for ranks it is enough to know that a run
            that exceeded its budget would have taken longer.
    """

    faster: str
    slower: str
    published_ratio: float
    ours_ratio: float
    published_p: float
    ours_p: float
    complete: bool
    ranks: Comparison

    @property
    def outcome(self) -> Outcome:
        """Whether our runs show the paper's order, the opposite one, or neither."""
        return self.ranks.outcome

    @property
    def verdict(self) -> str:
        """The outcome in plain words."""
        words = {
            Outcome.HOLDS: "the paper's order",
            Outcome.OPPOSITE: "the opposite order",
            Outcome.UNDECIDED: "undecided: not separated",
        }
        return f"{words[self.outcome]} (p = {self.ranks.p:.2g})"

    def as_dict(self) -> dict[str, Any]:
        """As plain values."""
        own = {name: value for name, value in vars(self).items() if name != "ranks"}
        ranks = {"superiority": self.ranks.superiority, "rank_p": self.ranks.p}
        return own | ranks | {"outcome": self.outcome, "verdict": self.verdict}


def row_orders(experiment: Experiment, results: Sequence[Result]) -> list[RowOrder]:
    """Every pair of rows, the paper's faster one first."""
    by_label = {result.row.label: result for result in results}
    rows = sorted(experiment.rows, key=lambda row: row.mean)
    pairs = [(fast, slow) for i, fast in enumerate(rows) for slow in rows[i + 1 :]]
    return [_order(by_label[fast.label], by_label[slow.label]) for fast, slow in pairs]


def _order(fast: Result, slow: Result) -> RowOrder:
    return RowOrder(
        faster=fast.row.label,
        slower=slow.row.label,
        published_ratio=fast.row.mean / slow.row.mean,
        ours_ratio=fast.ratio(slow),
        published_p=welch_of_moments(
            (fast.row.mean, fast.row.deviation, RUNS), (slow.row.mean, slow.row.deviation, RUNS)
        ),
        ours_p=welch(fast.counts, slow.counts),
        complete=fast.all_converged and slow.all_converged,
        ranks=compare(fast.ranked, slow.ranked),
    )


def _ratio_is(result: Result, base: Result) -> str:
    """The meaning of the ratio of two means, of which either may be a lower bound."""
    return "exact" if result is base else bound(result.all_converged, base.all_converged)


def table(
    experiment: Experiment, results: Sequence[Result], pace: Pace | None = None
) -> pl.DataFrame:
    """A row for each of the paper's, with ours beside it; ratios are to the vanilla row.

    The median is null where half of the runs or more exceeded their budget. Outcomes are of the
    statement that a row with a bonus comes before the vanilla one.

    Args:
        experiment: which table.
        results: its rows, by the learner of the reproduction.
        pace: what else was trained: the same with 30 runs ("thirty_..."), and the ratio over an
            ensemble of learners and maps with its 95 % interval ("ensemble_..."); null without.
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
                "outcome": None if row.vanilla else _order(result, base).outcome.value,
            }
            | _thirty(None if pace is None else pace.thirty, experiment, row, base.row)
            | _ensemble(() if pace is None else pace.ensemble, experiment, row, base.row)
        )
    return pl.DataFrame(rows, schema_overrides=_MAY_BE_NULL)


_MAY_BE_NULL: dict[str, type[pl.DataType]] = {
    "ours_median": pl.Float64,
    "outcome": pl.String,
    **dict.fromkeys(("thirty_mean", "thirty_std", "thirty_ratio"), pl.Float64),
    **dict.fromkeys(("thirty_converged", "thirty_runs"), pl.Int64),
    "thirty_outcome": pl.String,
    **dict.fromkeys(("ensemble_ratio", "ensemble_low", "ensemble_high"), pl.Float64),
    "ensemble_ratio_is": pl.String,
    **dict.fromkeys(("ensemble_pairs", "ensemble_converged", "ensemble_runs"), pl.Int64),
    **dict.fromkeys(("ensemble_vanilla_converged", "ensemble_vanilla_runs"), pl.Int64),
    **dict.fromkeys(("ensemble_superiority", "ensemble_p"), pl.Float64),
    "ensemble_outcome": pl.String,
}


def _thirty(
    learner: Learner | None, experiment: Experiment, row: Row, vanilla: Row
) -> dict[str, Any]:
    """The columns of more runs by the same learner."""
    none = {name: None for name in _MAY_BE_NULL if name.startswith("thirty_")}
    agent = None if learner is None else learner.agent(experiment, row)
    base = None if learner is None else learner.agent(experiment, vanilla)
    if agent is None:
        return none
    had = agent.budgeted()
    found = none | {
        "thirty_mean": float(had.mean()),
        "thirty_std": float(had.std(ddof=1)) if len(had) > 1 else 0.0,
        "thirty_converged": agent.came(),
        "thirty_runs": agent.runs,
    }
    if base is None:
        return found
    found["thirty_ratio"] = float(had.mean() / base.budgeted().mean())
    if row != vanilla:
        sides = (one.counts["convergence"] for one in (agent, base))
        found["thirty_outcome"] = compare(*sides).outcome.value
    return found


def _ensemble(
    learners: Sequence[Learner], experiment: Experiment, row: Row, vanilla: Row
) -> dict[str, Any]:
    """The columns of the ensemble."""
    none = {name: None for name in _MAY_BE_NULL if name.startswith("ensemble_")}
    found: Ratio | None = ratio_over(learners, experiment, row, vanilla)
    if found is None or row == vanilla:
        return none
    return {
        "ensemble_ratio": found.middle,
        "ensemble_low": found.low,
        "ensemble_high": found.high,
        "ensemble_ratio_is": found.kind,
        "ensemble_pairs": found.learners,
        "ensemble_converged": found.converged,
        "ensemble_runs": found.runs,
        "ensemble_vanilla_converged": found.vanilla_converged,
        "ensemble_vanilla_runs": found.vanilla_runs,
        "ensemble_superiority": found.ranks.superiority,
        "ensemble_p": found.ranks.p,
        "ensemble_outcome": found.outcome.value,
    }
