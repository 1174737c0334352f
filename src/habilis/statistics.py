"""Statistics of runs: averages with bootstrap intervals, rank tests, Welch's test, corrections.

The interquartile mean and the percentile bootstrap, which resamples runs, are those of Agarwal et
al. (2021, "Deep reinforcement learning at the edge of the statistical precipice"). A run that does
not reach its goal within the budget is infinite here: later than all others.
"""

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from jaxtyping import Float
from scipy.stats import (
    mannwhitneyu,
    norm,
    rankdata,
    ttest_ind,
    ttest_ind_from_stats,
)

Statistic = Callable[[Float[np.ndarray, "runs *rest"]], Float[np.ndarray, "*rest"]]
"""Takes the first axis away."""

_AT_ONCE = 2**22  # numbers resampled together, so that memory stays small
_INFINITE = 1e30  # stands for infinity, since quantiles between infinities are undefined


def mean(scores: Float[np.ndarray, "runs *rest"]) -> Float[np.ndarray, "*rest"]:
    """The mean over the runs."""
    return np.asarray(np.mean(scores, axis=0))


def interquartile_mean(scores: Float[np.ndarray, "runs *rest"]) -> Float[np.ndarray, "*rest"]:
    """The mean of the middle half of the runs: a quarter, rounded down, is left out at each end.

    For one number over runs and tasks, give all scores as one axis.

    Example:
        >>> float(interquartile_mean(np.array([-500.0, -11.0, -12.0, -13.0])))
        -12.5
    """
    cut = len(scores) // 4
    middle = np.partition(scores, sorted({cut, len(scores) - cut - 1}), axis=0)
    return np.asarray(np.mean(middle[cut : len(scores) - cut], axis=0))


STATISTICS: dict[str, Statistic] = {"mean": mean, "iqm": interquartile_mean}
"""By their names on the command line."""


def bootstrap_interval(
    values: Float[np.ndarray, "runs *points"],
    statistic: Statistic = mean,
    confidence: float = 0.95,
    repeats: int = 2000,
    seed: int = 0,
) -> tuple[Float[np.ndarray, "*rest"], Float[np.ndarray, "*rest"]]:
    """The percentile bootstrap interval of a statistic of the runs, point by point.

    The runs are resampled, with replacement, `repeats` times, each with all its points.

    Args:
        values: of independent runs.
        statistic: of the first axis.
        confidence: how much of the bootstrap distribution lies between the ends.
        repeats: how often the runs are resampled.
        seed: of the resampling.

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
    """The bootstrap interval of a statistic of the scores of several tasks, pooled.

    As `bootstrap_interval`, with runs resampled within each task, so that it keeps its share.

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
    """The bootstrap interval of a statistic of several samples, each of them resampled by itself.

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
    return np.asarray(low), np.asarray(high)


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


Interval = tuple[float | None, float | None, float | None]
"""A mean and the ends of its interval, each `None` where it is infinite."""


def interquartile_interval(counts: Float[np.ndarray, "runs"]) -> Interval:
    """The interquartile mean of counts, and its 95 % bootstrap interval.

    Args:
        counts: infinite for a run that exceeded its budget; such runs are in the upper quarter, or
            there is no mean.

    Example:
        >>> interquartile_interval(np.array([1.0, 2.0, 3.0, np.inf]))[0]
        2.5
    """
    low, high = bootstrap_interval(_large(counts), interquartile_mean)
    middle = float(interquartile_mean(counts))
    return _finite(middle), _finite(float(low)), _finite(float(high))


def pooled_interquartile_interval(tasks: Sequence[Float[np.ndarray, "_"]]) -> Interval:
    """The interquartile mean of the scores of several tasks, and its stratified interval.

    Args:
        tasks: for each of them its runs' scores, infinite as in `interquartile_interval`; a task
            without a finite score leaves no mean.
    """
    if not all(np.isfinite(task).any() for task in tasks):
        return None, None, None
    middle = float(interquartile_mean(np.concatenate(tasks)))
    low, high = stratified_interval([_large(task) for task in tasks])
    return _finite(middle), _finite(low), _finite(high)


def _large(values: Float[np.ndarray, "runs"]) -> Float[np.ndarray, "runs"]:
    return np.where(np.isfinite(values), values, _INFINITE)


def _finite(value: float) -> float | None:
    return value if value < _INFINITE * 1e-6 else None


def superiority_interval(
    a: Float[np.ndarray, "n"], b: Float[np.ndarray, "m"], repeats: int = 2000, seed: int = 0
) -> tuple[float, float]:
    """The 95 % bootstrap interval of P(a < b), ties counting half (rliable's improvement).

    Args:
        a, b: two samples, each resampled by itself.
        repeats: how often they are resampled.
        seed: of the resampling.
    """
    random = np.random.default_rng(seed)
    first = a[random.integers(len(a), size=(repeats, len(a)))]
    second = b[random.integers(len(b), size=(repeats, len(b)))]
    below = (first[:, :, None] < second[:, None]) + 0.5 * (first[:, :, None] == second[:, None])
    low, high = np.quantile(below.mean(axis=(1, 2)), [0.025, 0.975])
    return float(low), float(high)


def mann_whitney(a: Float[np.ndarray, "n"], b: Float[np.ndarray, "m"]) -> tuple[float, float]:
    """The share of pairs in which a value of `a` is below one of `b` (ties count half), and p.

    p is two-sided, by the normal approximation with ties and continuity corrected; 1 where all
    values are equal.
    """
    below = float((np.less.outer(a, b) + 0.5 * np.equal.outer(a, b)).mean())
    ranks = rankdata(np.concatenate([a, b]))
    if np.ptp(ranks) == 0:
        return below, 1.0
    test = mannwhitneyu(ranks[: len(a)], ranks[len(a) :], method="asymptotic")
    return below, float(test.pvalue)


def van_elteren(pairs: Sequence[tuple[np.ndarray, np.ndarray]]) -> tuple[float, float]:
    """Mann and Whitney's test stratified over several pairs of samples.

    Args:
        pairs: samples `a` and `b` as in `mann_whitney`, in each stratum; at least one.

    Returns:
        The mean over the strata of the share of pairs in which `a` is below `b`, and p by the sum
        of the strata's Mann-Whitney statistics, each divided by its number of pairs. With one
        stratum both are those of `mann_whitney`.
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
    return 0.5 + above / len(pairs), float(p)


def welch(a: Float[np.ndarray, "n"], b: Float[np.ndarray, "m"]) -> float:
    """The two-sided p-value of Welch's unequal-variances t-test.

    1 where the test is undefined: with a single run, or with samples that do not vary.
    """
    if min(len(a), len(b)) < 2 or np.ptp(a) == 0 or np.ptp(b) == 0:
        return 1.0
    test = ttest_ind(a, b, equal_var=False)
    return float(test.pvalue)  # pyright: ignore[reportAttributeAccessIssue]


def welch_of_moments(a: tuple[float, float, int], b: tuple[float, float, int]) -> float:
    """The same test of samples of which mean, standard deviation and size are known."""
    return float(ttest_ind_from_stats(*a, *b, equal_var=False).pvalue)


def holm(p: Sequence[float]) -> list[float]:
    """Holm's correction: p-values of several tests that bound the error of all of them together.

    Example:
        >>> holm([0.01, 0.04, 0.03])
        [0.03, 0.06, 0.06]
    """
    corrected, largest = [1.0] * len(p), 0.0
    for rank, place in enumerate(sorted(range(len(p)), key=p.__getitem__)):
        largest = max(largest, (len(p) - rank) * p[place])
        corrected[place] = min(1.0, largest)
    return corrected


def spearman(
    x: Float[np.ndarray, "rows n"], y: Float[np.ndarray, "rows n"]
) -> Float[np.ndarray, "rows"]:
    """Spearman's rank correlation of each row of `x` with that of `y`; 0 where one is constant."""
    a, b = (rankdata(part, axis=1) for part in (x, y))
    a, b = (part - part.mean(axis=1, keepdims=True) for part in (a, b))
    scale = np.sqrt((a**2).sum(axis=1) * (b**2).sum(axis=1))
    return np.divide((a * b).sum(axis=1), scale, out=np.zeros(len(x)), where=scale > 0)
