"""Axes that can be read: episodes and returns, on logarithmic scales, as numbers people write."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis, XAxis
from matplotlib.ticker import FixedLocator, LogLocator, NullFormatter, NullLocator

TICK_SIZE, LABEL_SIZE = 9, 10  # points

_RETURNS = -np.array([1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000], float)
_MANY_DECADES = 2.2  # beyond which 1, 10, 100, ... are ticks enough


def episodes_axis(axis: Axis, label: str, low: float, high: float) -> None:
    """A logarithmic axis of counts, with thousands separators; to be called after plotting.

    Args:
        axis: `ax.xaxis` or `ax.yaxis`.
        label: what is counted.
        low, high: the ends of the axis.

    Example:
        >>> from matplotlib.figure import Figure
        >>> ax = Figure().subplots()
        >>> episodes_axis(ax.xaxis, "episodes", 300, 40_000)
        >>> [tick.get_text() for tick in ax.get_xticklabels()][:3]
        ['500', '1,000', '2,000']
    """
    low, high = max(float(low), 1.0), max(float(high), 2.0)
    subs = (1, 2, 5) if np.log10(high / low) <= _MANY_DECADES else (1,)
    log_axis(axis, label, low, high, subs)
    axis.set_major_formatter(lambda value, _: f"{value:,.0f}")


def log_axis(
    axis: Axis, label: str, low: float, high: float, subs: tuple[float, ...] = (1, 2, 5)
) -> None:
    """A logarithmic axis whose ticks stand at some multiples of powers of ten, `subs`."""
    assert isinstance(axis.axes, Axes)
    if isinstance(axis, XAxis):
        axis.axes.set(xscale="log", xlim=(low, high))
    else:
        axis.axes.set(yscale="log", ylim=(low, high))
    decades = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
    ticks = [sub * 10.0**decade for decade in decades for sub in subs]
    axis.set_major_locator(FixedLocator([tick for tick in ticks if low <= tick <= high]))
    axis.set_minor_locator(LogLocator(subs="all"))
    axis.set_minor_formatter(NullFormatter())
    axis.set_major_formatter(lambda value, _: f"{value:,g}")
    axis.set_label_text(label, fontsize=LABEL_SIZE)
    axis.set_tick_params(labelsize=TICK_SIZE)


def returns_axis(ax: Axes, best: float, label: str = "mean return of an episode") -> None:
    """A vertical axis of returns, all of them negative: as far apart as their ratios are.

    Args:
        ax: the axes, on which the curves have been plotted.
        best: the best return, above which the axis ends.
        label: what is shown; none where it stands at the axes beside.
    """
    ax.set_yscale("symlog", linthresh=1)
    ax.set_ylim(top=0.75 * best)
    low, high = ax.get_ylim()
    ax.yaxis.set_major_locator(FixedLocator([t for t in _RETURNS if low <= t <= high]))
    ax.yaxis.set_minor_locator(NullLocator())
    ax.yaxis.set_major_formatter(lambda value, _: f"{value:,.0f}".replace("-", "−"))
    if label:
        ax.set_ylabel(f"{label} (reward −1 a step)", fontsize=LABEL_SIZE)
    ax.tick_params(axis="y", labelsize=TICK_SIZE)


def mark_best(ax: Axes, best: float) -> None:
    """A dotted line at the best return, named."""
    ax.axhline(best, color="#5b6270", linewidth=0.8, linestyle=":")
    ax.annotate(
        f"best: {best:,.0f}".replace("-", "−"),
        (0, best),
        xycoords=("axes fraction", "data"),
        xytext=(4, 3),
        textcoords="offset points",
        fontsize=TICK_SIZE,
        color="#5b6270",
    )
