"""The paper's statements about its learning agents, and the verdicts of our runs on them."""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float

from habilis.studies.comparison import compare
from habilis.studies.pace.data import Learner
from habilis.studies.pace.ratios import Ratio, ratio_over
from habilis.studies.paper.curves import Curves, attached_share, equipped_share
from habilis.studies.paper.findings import AgentStatement
from habilis.studies.paper.published import EXPERIMENTS, Experiment
from habilis.studies.paper.tables import Result, RowOrder, row_orders

EARLY = 1_000
"""The "initial stage of learning" over which shares of Figure 2 are compared, in episodes."""

STATED = (
    ("A2C with 6-step TOE", "A2C with 5-step FOE"),
    ("A2C with 5-step FOE", "A2C"),
    ("A2C with 6-step TOE", "A2C"),
    ("A2C with 3-step TOE (picker)", "A2C (picker)"),
    ("A2C with 3-step TOE (broom)", "A2C (broom)"),
    ("A2C (picker)", "A2C (broom)"),
    ("A2C with 3-step TOE (picker)", "A2C with 3-step TOE (broom)"),
)
"""The pairs of rows that the text speaks of, the faster one first."""

Results = Mapping[str, Sequence[Result]]
"""By the name of the experiment."""


def agent_statements(results: Results, ensemble: Sequence[Learner] = ()) -> list[AgentStatement]:
    """The stated orders of the tables' rows, and what Figure 2 is said to show.

    Args:
        results: of the reproduction's learner, by the experiment's name.
        ensemble: other learners, by which the orders are judged, too.
    """
    orders = [
        AgentStatement(
            "IV-B.1" if experiment.name == "table1" else "IV-C.1",
            f"{experiment.title}: “{c.faster}” converges before “{c.slower}”",
            c.outcome,
            f"{c.verdict}; {f'ratio {c.ours_ratio:.2f}, ' if c.complete else ''}"
            f"the paper's ratio {c.published_ratio:.2f} (p = {c.published_p:.2g})"
            f"{_in_words(over)}",
            None if over is None else over.outcome,
        )
        for experiment in EXPERIMENTS
        for c in row_orders(experiment, results[experiment.name])
        if (c.faster, c.slower) in STATED
        for over in [_over(ensemble, experiment, c)]
    ]
    return orders + _figure_2(results["table1"])


def _over(ensemble: Sequence[Learner], experiment: Experiment, order: RowOrder) -> Ratio | None:
    rows = {row.label: row for row in experiment.rows}
    return ratio_over(ensemble, experiment, rows[order.faster], rows[order.slower])


def _in_words(ratio: Ratio | None) -> str:
    if ratio is None:
        return ""
    interval = f"{ratio.middle:.2f} [{ratio.low:.2f}, {ratio.high:.2f}]"
    return f"; in the ensemble {interval}: {ratio.outcome.value}"


def _figure_2(first: Sequence[Result]) -> list[AgentStatement]:
    agents = {"none": "vanilla", "state": "FOE", "object": "TOE"}
    shares = {
        "with the picker equipped": {r.row.intrinsic: equipped_share(r.run) for r in first},
        "with the can attached (of those with the picker equipped)": {
            r.row.intrinsic: attached_share(r.run) for r in first
        },
    }
    pairs = (("state", "none"), ("object", "none"), ("state", "object"))
    return [
        _above(
            f"Figure 2: early on, the {agents[more]} agent spends a larger share of its steps "
            f"{what} than the {agents[less]} agent",
            share[more],
            share[less],
        )
        for what, share in shares.items()
        for more, less in pairs
    ]


def _above(text: str, more: Curves, less: Float[np.ndarray, "others fewer"]) -> AgentStatement:
    """Whether one agent's early share is above another's, by the ranks of the runs."""
    a, b = _early(more), _early(less)
    ranks = compare(-a, -b)
    episodes = min(EARLY, more.shape[1], less.shape[1])
    found = f"{a.mean():.1%} against {b.mean():.1%} over the first {episodes:,} episodes"
    return AgentStatement("IV-B.2", text, ranks.outcome, f"{found} (p = {ranks.p:.2g})")


def _early(curves: Curves) -> Float[np.ndarray, "runs"]:
    """Each run's mean over its first episodes; 0 if there is nothing to average."""
    early = curves[:, :EARLY]
    there = np.isfinite(early)
    sums = np.where(there, early, 0).sum(axis=1)
    return sums / np.maximum(there.sum(axis=1), 1)
