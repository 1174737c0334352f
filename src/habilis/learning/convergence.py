"""When a run has converged: the paper's criterion."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Float64
from numpy.typing import ArrayLike

from habilis.compiled import compiled

SHORT_WINDOW, LONG_WINDOW = 100, 2000  # episodes
MARGIN = 0.9  # in units of return


def moving_average(values: ArrayLike, window: int) -> Float[np.ndarray, "n"]:
    """Means of each `window` consecutive values; empty if there are fewer.

    Returns:
        float64[max(0, len(values) - window + 1)].
    """
    values = np.asarray(values, np.float64)
    if len(values) < window:
        return np.empty(0)
    sums = np.concatenate([[0.0], np.cumsum(values)])
    return (sums[window:] - sums[:-window]) / window


def episodes_to_convergence(
    returns: ArrayLike,
    best_return: float,
    windows: tuple[int, int] = (SHORT_WINDOW, LONG_WINDOW),
) -> int | None:
    """How many episodes it took until the double moving average came close to the best return.

    The moving average (window 2000) of the moving average (window 100) of the extrinsic episode
    return is within 0.9 of the best return (paper, section IV-B.1).

    Args:
        returns: of a run's episodes, first to last, undiscounted and extrinsic.
        best_return: of a shortest plan.
        windows: the two windows, in episodes.

    Returns:
        The number of episodes run when the criterion first held; `None` if it never did.
    """
    short, long = windows
    smooth = moving_average(moving_average(returns, short), long)
    close = np.flatnonzero(smooth >= best_return - MARGIN)
    return int(close[0]) + short + long - 1 if len(close) else None


@dataclass(frozen=True, eq=False)
class Averages:
    """The double moving average after some episodes, which goes on when there are more.

    What it says is `episodes_to_convergence` of all episodes, bit for bit, but each episode is
    looked at once.

    Attributes:
        episodes: how many there have been.
        sums: float64[short], the last prefix sums of the returns, that of n at n modulo short.
        smooth_sums: float64[long], of their moving averages.

    Example:
        >>> averages, at = Averages.of(windows=(2, 3)).after([-5.0, -1.0, -1.0], best_return=-1)
        >>> at is None
        True
        >>> averages.after([-1.0, -1.0, -1.0], best_return=-1)[1]
        4
    """

    episodes: int
    sums: Float64[np.ndarray, "short"]
    smooth_sums: Float64[np.ndarray, "long"]

    @classmethod
    def of(cls, windows: tuple[int, int] = (SHORT_WINDOW, LONG_WINDOW)) -> "Averages":
        """Before the first episode."""
        return cls(0, np.zeros(windows[0]), np.zeros(windows[1]))

    def after(
        self, returns: ArrayLike, best_return: float, margin: float = MARGIN
    ) -> tuple["Averages", int | None]:
        """Goes on with more episodes. It may run in several threads at once.

        Args:
            returns: of the episodes that followed, undiscounted and extrinsic.
            best_return: of a shortest plan.
            margin: how far below it is close enough.

        Returns:
            The averages after all of them, and the number of episodes run, earlier ones included,
            when the criterion first held among the new ones; `None` if it did not.
        """
        values = np.ascontiguousarray(returns, np.float64)
        sums, smooth_sums = self.sums.copy(), self.smooth_sums.copy()
        at = _follow(values, self.episodes, sums, smooth_sums, best_return - margin)
        return Averages(self.episodes + len(values), sums, smooth_sums), at or None


@compiled()
def _follow(
    returns: np.ndarray, before: int, sums: np.ndarray, smooth_sums: np.ndarray, enough: float
) -> int:
    """Goes on with the sums; the number of episodes when it first was enough, or 0."""
    short, long = len(sums), len(smooth_sums)
    found = 0
    for i in range(len(returns)):
        count = before + i + 1
        total = sums[(count - 1) % short] + returns[i]
        first = sums[count % short]
        sums[count % short] = total
        if count < short:
            continue
        smooths = count - short + 1
        smooth_total = smooth_sums[(smooths - 1) % long] + (total - first) / short
        smooth_first = smooth_sums[smooths % long]
        smooth_sums[smooths % long] = smooth_total
        if found == 0 and smooths >= long and (smooth_total - smooth_first) / long >= enough:
            found = count
    return found
