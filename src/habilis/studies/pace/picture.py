"""The picture of the second question: does empowerment help slow learners more than fast ones?"""

from typing import Any

import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from habilis.studies.axes import LABEL_SIZE, TICK_SIZE, episodes_axis, log_axis
from habilis.studies.pace.data import MEASURES

_COLOURS = ("#0072b2", "#009e73", "#d55e00", "#cc79a7")  # Okabe and Ito
_MARKERS = {"ensemble": "o", "multiverse": "s", "fast default": "D"}
_EDGE = 1.25  # how far the axes go beyond the marks, as a factor


def slowness_figure(marks: pl.DataFrame) -> Figure:
    """The ratio of regularised to vanilla episodes by the vanilla agent's: a panel a measure.

    Args:
        marks: of `slowness.marks`.
    """
    figure = Figure(figsize=(11, 5), dpi=96)
    rows = marks["row"].unique(maintain_order=True).to_list()
    colours = dict(zip(rows, _COLOURS, strict=False))
    low, high = _ends(marks["ratio"])
    for ax, measure in zip(figure.subplots(1, len(MEASURES)), MEASURES, strict=True):
        part = marks.filter(measure=measure)
        for one in part.iter_rows(named=True):
            colour = colours[one["row"]]
            ax.plot(
                *(one["vanilla"], one["ratio"], _MARKERS[one["source"]]),
                markerfacecolor=colour if one["complete"] else "white",
                markeredgecolor=colour,
                markeredgewidth=1.4,
                markersize=7,
                alpha=0.9,
            )
        _frame(ax, part, measure, min(low, 0.5), max(high, 2.0))
    handles = [Line2D([], [], color=c, marker="o", ls="", label=row) for row, c in colours.items()]
    handles += [
        Line2D([], [], color="#5b6270", marker=marker, ls="", label=source)
        for source, marker in _MARKERS.items()
        if source in marks["source"]
    ]
    hollow: dict[str, Any] = {
        "color": "#5b6270",
        "markerfacecolor": "white",
        "marker": "o",
        "ls": "",
    }
    handles.append(Line2D([], [], **hollow, label="some runs exceeded their budget"))
    figure.tight_layout(rect=(0, 0.13, 1, 1))
    figure.legend(handles=handles, loc="lower center", ncols=4, frameon=False, fontsize=TICK_SIZE)
    return figure


def _frame(ax: Axes, part: pl.DataFrame, measure: str, low: float, high: float) -> None:
    episodes_axis(ax.xaxis, f"vanilla agent: episodes to {measure}", *_ends(part["vanilla"]))
    many = np.log10(high / low) > 2.2
    log_axis(ax.yaxis, "regularised / vanilla", low, high, (1,) if many else (1, 2, 5))
    ax.axhline(1, color="#5b6270", linewidth=1)
    looks: dict[str, Any] = {"fontsize": TICK_SIZE, "color": "#5b6270", "va": "bottom"}
    ax.text(
        0.98, 0.02, "below the line the bonus helps", ha="right", transform=ax.transAxes, **looks
    )
    ax.set_title(measure, fontsize=LABEL_SIZE)
    ax.spines[["top", "right"]].set_visible(False)


def _ends(values: pl.Series) -> tuple[float, float]:
    """The ends of an axis that holds all values; any where there are none."""
    found = values.to_numpy()
    if not len(found):
        return 1_000.0, 100_000.0
    return float(found.min()) / _EDGE, float(found.max()) * _EDGE
