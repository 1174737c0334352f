"""Pictures of every run, and of the intervals over them."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import polars as pl
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator

from habilis.colours import COLOURS
from habilis.studies.bonuses.study import CONVERGENCE, FIRST_SUCCESS, Measure

CAPTION = (
    "Every run (small dots; on the right those that exceeded their budget), their interquartile "
    "mean with its 95 % bootstrap interval (an arrow: unbounded; no large dot: too few runs "
    "finished for a mean)."
)
_RUN, _MIDDLE, _NEVER = "#8a93a3", COLOURS[0], COLOURS[1]
_TICKS = [digit * 10**power for power in range(8) for digit in (1, 2, 5)]


def episodes_figure(
    table: pl.DataFrame,
    runs: pl.DataFrame,
    measures: Sequence[Measure] = (FIRST_SUCCESS, CONVERGENCE),
) -> Figure:
    """The episodes that each agent takes: a row of panels per measure, a column per case.

    Args:
        table: of `analysis.summary`.
        runs: a row a run, as `training.trained` has them.
        measures: that count episodes.
    """
    cases = table["case"].unique(maintain_order=True).to_list()
    agents = table["agent"].unique(maintain_order=True).to_list()
    size = 2.6 + 4.2 * len(cases), (0.7 + 0.3 * len(agents)) * len(measures)
    figure = Figure(figsize=size, dpi=96)
    axes = figure.subplots(len(measures), len(cases), sharex="row", sharey=True, squeeze=False)
    for row, measure in zip(axes, measures, strict=True):
        least, never = _ends(table, runs, measure)
        for ax, case in zip(row, cases, strict=True):
            _panel(ax, table.filter(case=case), runs.filter(case=case), measure, never)
            _scale(ax, least, never)
            ax.set_title(f"{case}: {measure.title}", fontsize=9)
        row[0].set_yticks(range(len(agents)), agents, fontsize=8)
    axes[0, 0].invert_yaxis()
    figure.tight_layout()
    return figure


def shares_panel(ax: Axes, table: pl.DataFrame, runs: pl.DataFrame, measure: Measure) -> None:
    """One panel of a measure that is a share, a row an agent.

    Args:
        ax: where to.
        table, runs: of one case, as in `episodes_figure`.
        measure: the share.
    """
    for place, row in enumerate(table.iter_rows(named=True)):
        x = runs.filter(agent=row["agent"])[measure.column].to_numpy()
        ax.scatter(x, _spread(place, len(x)), s=7, c=_RUN, linewidths=0)
        _interval(ax, place, *_middle(row, measure))
    ax.set(xlim=(-0.02, 1.02))
    ax.tick_params(axis="x", labelsize=8)
    _bare(ax)


def _spread(place: int, count: int) -> Float[np.ndarray, "count"]:
    """Heights of an agent's runs around its own."""
    return place + 0.26 * np.linspace(-1, 1, count)


def _middle(row: dict[str, Any], measure: Measure) -> tuple[Any, Any, Any]:
    """The middle of an agent's runs and the ends of its interval; null where there is none."""
    middle, low, high = (row[measure.column + end] for end in ("", "_low", "_high"))
    return middle, low, high


def _interval(ax: Axes, place: int, middle: float, low: float, high: float) -> None:
    ax.plot([low, high], [place, place], color=_MIDDLE, linewidth=3, alpha=0.45)
    ax.plot(middle, place, "o", color=_MIDDLE, markersize=6)


def _bare(ax: Axes) -> None:
    ax.spines[["top", "right", "left"]].set_visible(False)
    ax.tick_params(axis="y", length=0)


def _ends(table: pl.DataFrame, runs: pl.DataFrame, measure: Measure) -> tuple[float, float]:
    """The start of an axis, and the place on it of runs that exceeded their budget."""
    columns = [runs[measure.column], *(table[measure.column + end] for end in ("_low", "_high"))]
    there = [value for column in columns for value in column.drop_nulls().to_list()]
    return (min(there), 2.0 * max(there)) if there else (1.0, 10.0)


def _panel(
    ax: Axes, table: pl.DataFrame, runs: pl.DataFrame, measure: Measure, never: float
) -> None:
    for place, row in enumerate(table.iter_rows(named=True)):
        values = runs.filter(agent=row["agent"])[measure.column]
        x = values.cast(pl.Float64).fill_null(never).to_numpy()
        colours = np.where(x < never, _RUN, _NEVER).tolist()
        ax.scatter(x, _spread(place, len(x)), s=7, c=colours, linewidths=0)
        middle, low, high = _middle(row, measure)
        if middle is not None:
            end = 0.7 * never if high is None else high
            _interval(ax, place, middle, low, end)
            if high is None:
                ax.plot(end, place, ">", color=_MIDDLE, markersize=5, alpha=0.6)
    ax.axvline(never / 1.3, color="#c9ced6", linewidth=0.8, linestyle=":")


def _scale(ax: Axes, least: float, never: float) -> None:
    """A logarithmic axis with "never" at its end."""
    shown = [tick for tick in _TICKS if 0.8 * least <= tick < 0.7 * never]
    if len(shown) > 6:
        shown = [tick for tick in shown if str(tick)[0] == "1"]
    ax.set(xscale="log", xlim=(0.8 * least, 1.35 * never))
    ax.xaxis.set_major_locator(FixedLocator([*shown, never]))
    ax.xaxis.set_minor_locator(NullLocator())
    ax.set_xticklabels([*(f"{tick:,}" for tick in shown), "never"], fontsize=8)
    _bare(ax)
