"""When a run has converged: the paper's criterion."""

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

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
