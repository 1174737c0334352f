"""Regularised against vanilla agents, over an ensemble of learners and maps."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import polars as pl
from jaxtyping import Float

from habilis.statistics import joint_interval
from habilis.studies.comparison import Comparison, Outcome, compare, compare_within
from habilis.studies.pace.data import AgentRuns, Learner
from habilis.studies.paper.published import EXPERIMENTS, Experiment, Row


@dataclass(frozen=True)
class Ratio:
    """The episodes of one agent over those of another, over several learners.

    Attributes:
        middle: the geometric mean over the learners of the ratio of mean episodes.
        low, high: the ends of its 95 % bootstrap interval, each agent's runs resampled by
            themselves within each learner.
        learners: how many there are.
        converged, runs: of the first agent's, over all learners.
        vanilla_converged, vanilla_runs: of the second's.
        ranks: whether the first agent is the sooner one, by ranks within each learner. A ratio of
            means cannot decide where runs did not converge: a run of long episodes completes few
            of them within its budget.
    """

    middle: float
    low: float
    high: float
    learners: int
    converged: int
    runs: int
    vanilla_converged: int
    vanilla_runs: int
    ranks: Comparison

    @property
    def outcome(self) -> Outcome:
        return self.ranks.outcome

    @property
    def kind(self) -> str:
        """The meaning of the ratio, since some means are lower bounds (see `bound`)."""
        return bound(self.converged == self.runs, self.vanilla_converged == self.vanilla_runs)


def bound(complete: bool, vanilla_complete: bool) -> str:
    """The meaning of a ratio of mean episodes, by whether all runs of each side converged.

    Example:
        >>> [bound(True, True), bound(False, True), bound(True, False), bound(False, False)]
        ['exact', 'at least', 'at most', 'unknown']
    """
    if complete:
        return "exact" if vanilla_complete else "at most"
    return "at least" if vanilla_complete else "unknown"


def ratio_over(
    learners: Sequence[Learner],
    experiment: Experiment,
    row: Row,
    to: Row,
    measure: str = "convergence",
) -> Ratio | None:
    """The episodes of one row over those of another, over all learners that have both.

    In the ratio, a run that exceeded its budget counts with the episodes that it had; in the
    verdict, it is later than all others.

    Args:
        learners: such as the ensemble's.
        experiment: the table of both rows.
        row, to: whose episodes are divided by whose.
        measure: one of `data.MEASURES`.

    Returns:
        The ratio, or `None` where no learner has both rows.
    """
    both = [(one.agent(experiment, row), one.agent(experiment, to)) for one in learners]
    pairs = [(a, b) for a, b in both if a is not None and b is not None]
    if not pairs:
        return None
    samples = [agent.budgeted(measure) for pair in pairs for agent in pair]
    low, high = joint_interval(samples, _geometric_mean_ratio)
    return Ratio(
        middle=float(_geometric_mean_ratio(samples)),
        low=low,
        high=high,
        learners=len(pairs),
        **_came([a for a, _ in pairs], measure, ""),
        **_came([b for _, b in pairs], measure, "vanilla_"),
        ranks=compare_within([(a.counts[measure], b.counts[measure]) for a, b in pairs]),
    )


def one_by_one(learners: Sequence[Learner]) -> pl.DataFrame:
    """Every row of the tables by every learner.

    Returns:
        "learner", "row", "map", "mean" and "deviation" of the episodes to convergence (a run that
        did not converge counts with those it had), "converged", "runs"; and for rows with a bonus
        the "ratio" to the vanilla row and the "outcome" of the statement that they come first.
    """
    rows = [
        {"learner": learner.name, "row": row.label, "map": agent.map}
        | {"mean": float(had.mean()), "deviation": float(had.std(ddof=1)) if len(had) > 1 else 0.0}
        | {"converged": agent.came(), "runs": agent.runs}
        | _against(agent, None if row.vanilla else learner.agent(experiment, vanilla))
        for learner in learners
        for experiment in EXPERIMENTS
        for row in experiment.rows
        for vanilla in [next(v for v in experiment.rows if v.vanilla and v.tool == row.tool)]
        for agent in [learner.agent(experiment, row)]
        if agent is not None
        for had in [agent.budgeted()]
    ]
    kinds = dict.fromkeys(("learner", "row", "map"), pl.String)
    kinds |= dict.fromkeys(("mean", "deviation"), pl.Float64)
    kinds |= dict.fromkeys(("converged", "runs"), pl.Int64)
    return pl.DataFrame(rows, schema=kinds | {"ratio": pl.Float64, "outcome": pl.String})


def _against(agent: AgentRuns, vanilla: AgentRuns | None) -> dict[str, object]:
    if vanilla is None:
        return {"ratio": None, "outcome": None}
    sides = (one.counts["convergence"] for one in (agent, vanilla))
    ratio = float(agent.budgeted().mean() / vanilla.budgeted().mean())
    return {"ratio": ratio, "outcome": compare(*sides).outcome.value}


def _geometric_mean_ratio(samples: list[np.ndarray]) -> Float[np.ndarray, "*draws"]:
    """Of samples that alternate between numerators and denominators, runs first."""
    means = np.stack([np.mean(sample, axis=0) for sample in samples])
    return np.asarray(np.exp(np.mean(np.log(means[::2]) - np.log(means[1::2]), axis=0)))


def _came(agents: Sequence[AgentRuns], measure: str, prefix: str) -> dict[str, int]:
    return {
        f"{prefix}converged": sum(agent.came(measure) for agent in agents),
        f"{prefix}runs": sum(agent.runs for agent in agents),
    }
