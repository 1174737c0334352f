"""Averages over runs, and how far they can be trusted.

As Agarwal et al. (2021, "Deep reinforcement learning at the edge of the statistical precipice")
define them: the interquartile mean, and percentile bootstrap intervals that draw runs anew.
"""

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from jaxtyping import Float

Statistic = Callable[[Float[np.ndarray, "runs *rest"]], Float[np.ndarray, "*rest"]]
"""Takes the first axis away."""

_AT_ONCE = 2**22  # numbers drawn anew together, so that memory stays small


def mean(scores: Float[np.ndarray, "runs *rest"]) -> Float[np.ndarray, "*rest"]:
    """The mean over the runs."""
    return np.mean(scores, axis=0)


def interquartile_mean(scores: Float[np.ndarray, "runs *rest"]) -> Float[np.ndarray, "*rest"]:
    """The mean of the middle half of the runs: a quarter, rounded down, is left out at each end.

    For one number over runs and tasks, give all scores as one axis.

    Example:
        >>> float(interquartile_mean(np.array([-500.0, -11.0, -12.0, -13.0])))
        -12.5
    """
    cut = len(scores) // 4
    middle = np.partition(scores, sorted({cut, len(scores) - cut - 1}), axis=0)
    return np.mean(middle[cut : len(scores) - cut], axis=0)


STATISTICS: dict[str, Statistic] = {"mean": mean, "iqm": interquartile_mean}
"""By their names on the command line."""


def bootstrap_interval(
    values: Float[np.ndarray, "runs *points"],
    statistic: Statistic = mean,
    confidence: float = 0.95,
    repeats: int = 2000,
    seed: int = 0,
) -> tuple[Float[np.ndarray, "*points"], Float[np.ndarray, "*points"]]:
    """Between what values a statistic of the runs is, point by point: a percentile bootstrap.

    The runs are drawn anew, with replacement, `repeats` times; a run that is drawn is drawn with
    all its points.

    Args:
        values: of independent runs.
        statistic: of the first axis.
        confidence: how much of the bootstrap distribution lies between the ends.
        repeats: how often the runs are drawn.
        seed: of these draws.

    Returns:
        The lower and the upper ends; both the statistic itself where there is one run only.
    """
    values = np.asarray(values, np.float64)
    return _interval([values], lambda drawn: statistic(drawn[0]), confidence, repeats, seed)


def stratified_interval(
    tasks: Sequence[Float[np.ndarray, "runs"]],
    statistic: Statistic = interquartile_mean,
    confidence: float = 0.95,
    repeats: int = 2000,
    seed: int = 0,
) -> tuple[float, float]:
    """Between what values a statistic of the scores of several tasks is, all pooled.

    As `bootstrap_interval`, the runs drawn within each task, so that every task keeps its share.

    Args:
        tasks: for each of them its runs' scores.
        statistic, confidence, repeats, seed: as there.
    """
    scores = [np.asarray(task, np.float64) for task in tasks]
    low, high = _interval(
        scores, lambda drawn: statistic(np.concatenate(drawn)), confidence, repeats, seed
    )
    return float(low), float(high)


def joint_interval(
    samples: Sequence[Float[np.ndarray, "runs"]],
    statistic: Callable[[list[np.ndarray]], np.ndarray],
    confidence: float = 0.95,
    repeats: int = 2000,
    seed: int = 0,
) -> tuple[float, float]:
    """Between what values a statistic of several samples is, each of them drawn anew by itself.

    Args:
        samples: of independent runs, such as those of several agents.
        statistic: of the drawn samples, float64[runs, draws] each; float64[draws].
        confidence, repeats, seed: as in `bootstrap_interval`.

    Example:
        >>> fast, slow = np.array([1.0, 1.2, 0.8]), np.array([2.0, 2.1, 1.9])
        >>> low, high = joint_interval([fast, slow], lambda drawn: mean(drawn[0]) / mean(drawn[1]))
        >>> bool(low < 0.5 < high < 1)
        True
    """
    low, high = _interval(samples, statistic, confidence, repeats, seed)
    return float(low), float(high)


def _interval(
    strata: Sequence[Float[np.ndarray, "runs *points"]],
    statistic: Callable[[list[np.ndarray]], np.ndarray],
    confidence: float,
    repeats: int,
    seed: int,
) -> tuple[np.ndarray, np.ndarray]:
    """The ends of a bootstrap distribution, runs drawn within each stratum."""
    if not all(len(stratum) for stratum in strata) or not strata:
        raise ValueError("an interval over no runs; give at least one")
    if not 0 < confidence < 1 or repeats < 1:
        raise ValueError(
            f"confidence is {confidence!r} and repeats {repeats!r}; give one between 0 and 1, and "
            "at least 1"
        )
    drawn = np.concatenate(list(_draws(strata, statistic, repeats, seed)))
    low, high = np.quantile(drawn, [(1 - confidence) / 2, (1 + confidence) / 2], axis=0)
    return low, high


def _draws(
    strata: Sequence[np.ndarray],
    statistic: Callable[[list[np.ndarray]], np.ndarray],
    repeats: int,
    seed: int,
) -> Iterator[np.ndarray]:
    random = np.random.default_rng(seed)
    chunk = max(1, _AT_ONCE // sum(stratum.size for stratum in strata))
    for start in range(0, repeats, chunk):
        count = min(chunk, repeats - start)
        yield statistic([s[random.integers(len(s), size=(len(s), count))] for s in strata])
