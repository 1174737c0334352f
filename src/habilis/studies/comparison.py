"""Comparisons of two agents: one definition of holds, undecided and opposite, for all reports."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from jaxtyping import Float

from habilis.reprs import short, unfailing
from habilis.statistics import mann_whitney, van_elteren

SIGNIFICANT = 0.05
"""p-values below it decide."""


class Outcome(StrEnum):
    """The verdict on a stated order: one that is not significant is undecided, not a failure."""

    HOLDS = "holds"
    UNDECIDED = "undecided"
    OPPOSITE = "opposite"


@dataclass(frozen=True)
class Comparison:
    """Two agents' runs, compared by ranks: does the first come before the second?

    Attributes:
        superiority: the probability that a run of the agent that should come first does (ties
            count half).
        p: two-sided, of Mann and Whitney's test.
        sooner_converged, later_converged: how many runs of each stayed within their budget.

    Example:
        >>> Comparison(0.9, 0.01, 5, 5).outcome.value, Comparison(0.9, 0.06, 5, 5).outcome.value
        ('holds', 'undecided')
    """

    superiority: float
    p: float
    sooner_converged: int
    later_converged: int

    @unfailing
    def __repr__(self) -> str:
        converged = f"{self.sooner_converged} and {self.later_converged} runs converged"
        odds = f"superiority {self.superiority:.2f}, p = {self.p:.2g}"
        return short("Comparison", self.outcome.value, odds, converged)

    @property
    def outcome(self) -> Outcome:
        if not self.p < SIGNIFICANT:
            return Outcome.UNDECIDED
        return Outcome.HOLDS if self.superiority > 0.5 else Outcome.OPPOSITE


def compare(sooner: Float[np.ndarray, "n"], later: Float[np.ndarray, "m"]) -> Comparison:
    """Two agents' runs compared by ranks.

    Args:
        sooner, later: the episodes (or steps) of each run, of the agent that should come first and
            of the other; infinite for a run that exceeded its budget: later than all others.

    Example:
        >>> compare(np.arange(5.0), np.arange(5.0, 10.0)).outcome.value
        'holds'
    """
    return Comparison(*mann_whitney(sooner, later), _finite(sooner), _finite(later))


def compare_within(pairs: Sequence[tuple[np.ndarray, np.ndarray]]) -> Comparison:
    """Two kinds of agents compared by ranks within each of several settings (van Elteren's test).

    Args:
        pairs: the runs of both, as in `compare`, in each setting; at least one.

    Example:
        >>> soon, late = np.arange(5.0), np.arange(5.0) + 2
        >>> compare(soon, late).outcome.value, compare_within([(soon, late)] * 5).outcome.value
        ('undecided', 'holds')
    """
    sides = (sum(map(_finite, side)) for side in zip(*pairs, strict=True))
    return Comparison(*van_elteren(pairs), *sides)


def _finite(runs: np.ndarray) -> int:
    return int(np.isfinite(runs).sum())


def tally(outcomes: Iterable[Outcome]) -> dict[str, int]:
    """The numbers of statements that hold, are undecided, and come out the other way round.

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
