"""Whether one agent comes before another: one definition, for every report."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from jaxtyping import Float
from scipy.stats import mannwhitneyu, norm, rankdata

SIGNIFICANT = 0.05
"""p-values below it decide."""


class Outcome(StrEnum):
    """What runs say of a stated order: not significant is undecided, and no failure."""

    HOLDS = "holds"
    UNDECIDED = "undecided"
    OPPOSITE = "opposite"


@dataclass(frozen=True)
class Verdict:
    """What the runs of two agents say of a stated order.

    Attributes:
        superiority: how often a run of the agent that should come first did (ties count half).
        p: two-sided, of Mann and Whitney's test.
        sooner_converged, later_converged: how many runs of each came so far at all.
    """

    superiority: float
    p: float
    sooner_converged: int
    later_converged: int

    @property
    def outcome(self) -> Outcome:
        return outcome_of(self.superiority, self.p)


def outcome_of(superiority: float, p: float) -> Outcome:
    """The outcome of a comparison by ranks.

    Example:
        >>> [outcome_of(0.9, 0.01).value, outcome_of(0.1, 0.01).value, outcome_of(0.9, 0.06).value]
        ['holds', 'opposite', 'undecided']
    """
    if not p < SIGNIFICANT:
        return Outcome.UNDECIDED
    return Outcome.HOLDS if superiority > 0.5 else Outcome.OPPOSITE


def verdict_of(sooner: Float[np.ndarray, "n"], later: Float[np.ndarray, "m"]) -> Verdict:
    """Two agents' runs compared by ranks.

    Args:
        sooner, later: when each run came so far, of the agent that should come first and of the
            other; infinite for a run that did not, which is later than all that did.

    Example:
        >>> verdict_of(np.arange(5.0), np.arange(5.0, 10.0)).outcome.value
        'holds'
    """
    superiority, p = mann_whitney(sooner, later)
    return Verdict(superiority, p, int(np.isfinite(sooner).sum()), int(np.isfinite(later).sum()))


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


def verdict_over(pairs: Sequence[tuple[np.ndarray, np.ndarray]]) -> Verdict:
    """Two kinds of agents compared by ranks within each of several settings.

    The average over the settings of how often a run of the first comes before one of the second,
    and p by the sum of the settings' Mann-Whitney statistics, each divided by its number of pairs
    of runs (a van Elteren test). With one setting this is `verdict_of`.

    Args:
        pairs: the runs of both, as in `verdict_of`, in each setting; at least one.

    Example:
        >>> soon, late = np.arange(5.0), np.arange(5.0) + 2
        >>> verdict_of(soon, late).outcome.value, verdict_over([(soon, late)] * 5).outcome.value
        ('undecided', 'holds')
    """
    above, variance, weights = 0.0, 0.0, []
    for a, b in pairs:
        below, _ = mann_whitney(a, b)
        n, m, total = len(a), len(b), len(a) + len(b)
        ties = np.unique(np.concatenate([a, b]), return_counts=True)[1].astype(float)
        tied = (ties**3 - ties).sum() / (total * (total - 1))
        above += below - 0.5
        variance += (total + 1 - tied) / (12 * n * m)
        weights.append(1 / (n * m))
    off = max(abs(above) - 0.5 * min(weights), 0.0)
    p = min(1.0, 2 * norm.sf(off / np.sqrt(variance))) if variance > 0 else 1.0
    sides = (
        int(sum(np.isfinite(side).sum() for side in part)) for part in zip(*pairs, strict=True)
    )
    return Verdict(0.5 + above / len(pairs), float(p), *sides)


def tally(outcomes: Iterable[Outcome]) -> dict[str, int]:
    """How many statements hold, are undecided, and come out the other way round.

    Example:
        >>> tally([Outcome.HOLDS, Outcome.OPPOSITE, Outcome.HOLDS])
        {'holds': 2, 'undecided': 0, 'opposite': 1}
    """
    counts = Counter(outcomes)
    return {outcome.value: counts[outcome] for outcome in Outcome}


def in_words(counts: dict[str, int]) -> str:
    """A tally as it is printed.

    Example:
        >>> in_words({"holds": 8, "undecided": 4, "opposite": 1})
        'holds 8, undecided 4, opposite 1'
    """
    return ", ".join(f"{name} {count}" for name, count in counts.items())
