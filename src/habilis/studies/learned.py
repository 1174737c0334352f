"""What the paper states about its learning agents, held against ours."""

from collections.abc import Mapping, Sequence

import numpy as np

from habilis.studies.curves import attached_share, equipped_share
from habilis.studies.published import EXPERIMENTS
from habilis.studies.relations import Relation
from habilis.studies.tables import Result, comparisons

EARLY = 1_000
"""The "initial stage of learning" over which shares of Figure 2 are compared, in episodes."""

Results = Mapping[str, Sequence[Result]]
"""By the name of the experiment."""


def learned_relations(results: Results) -> list[Relation]:
    """The order of the tables' rows, and what Figure 2 is said to show."""
    orders = [
        Relation(
            "IV-B.1" if experiment.name == "table1" else "IV-C.1",
            f"{experiment.title}: “{c.faster}” converges before “{c.slower}”",
            c.holds,
            f"{c.verdict}; ratio {c.ours_ratio:.2f}, the paper's {c.published_ratio:.2f}",
        )
        for experiment in EXPERIMENTS
        for c in comparisons(experiment, results[experiment.name])
    ]
    return orders + _figure_2(results["table1"])


def _figure_2(first: Sequence[Result]) -> list[Relation]:
    vanilla, foe, toe = first
    equipped = {r.row.intrinsic: _early(equipped_share(r.run)) for r in (vanilla, foe, toe)}
    attached = {r.row.intrinsic: _early(attached_share(r.run)) for r in (vanilla, foe, toe)}
    return [
        _above("with the picker in hand", equipped, "state", "none", "FOE", "the vanilla agent"),
        _above("with the picker in hand", equipped, "object", "none", "TOE", "the vanilla agent"),
        _above("with the picker in hand", equipped, "state", "object", "FOE", "the TOE agent"),
        _above("with the can attached", attached, "state", "none", "FOE", "the vanilla agent"),
        _above("with the can attached", attached, "object", "none", "TOE", "the vanilla agent"),
        _above("with the can attached", attached, "state", "object", "FOE", "the TOE agent"),
    ]


def _early(share: np.ndarray) -> float:
    return float(share[:EARLY].mean())


def _above(
    what: str, shares: Mapping[str, float], more: str, less: str, agent: str, other: str
) -> Relation:
    return Relation(
        "IV-B.2",
        f"Figure 2: early on, the {agent} agent spends more of its time {what} than {other}",
        shares[more] > shares[less],
        f"{shares[more]:.1%} against {shares[less]:.1%} over the first {EARLY:,} episodes",
    )
