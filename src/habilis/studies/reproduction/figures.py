"""The figures of the report: the paper's, redrawn from our worlds and runs, and our own."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import polars as pl
from jaxtyping import Int
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import PercentFormatter

from habilis.analysis.landscape_values import draw_landscapes
from habilis.colours import COLOURS
from habilis.learning.curves import SMOOTHING
from habilis.learning.runs import Run
from habilis.studies.axes import (
    LABEL_SIZE,
    TICK_SIZE,
    episodes_axis,
    log_axis,
    mark_best,
    returns_axis,
)
from habilis.studies.pace.data import MEASURES
from habilis.studies.paper.curves import (
    Curves,
    attached_share,
    equipped_share,
    mean_curve,
    returns,
)
from habilis.studies.paper.tables import Result
from habilis.studies.paper.worlds import paper_worlds
from habilis.worlds.pictures.figures import draw_world
from habilis.worlds.rules import ACTIONS
from habilis.worlds.table import placement, tabulate
from habilis.worlds.world import World

_POINTS = 1000  # of a curve: more than there are pixels

_IN_LINE = """\
.......
.......
...A{tool}C.
.......
......G
"""
_BESIDE = """\
.......
....C..
...A{tool}..
.......
......G
"""


def figure_1() -> Figure:
    """The effects of moves and tool actions: a start state, and the state after each action."""
    rows = {
        "picker,\ncan beside it": _BESIDE.format(tool="P"),
        "picker,\ncan attached": _IN_LINE.format(tool="P"),
        "broom,\ncan beside it": _BESIDE.format(tool="B"),
        "broom,\ncan in line": _IN_LINE.format(tool="B"),
    }
    figure = Figure(
        figsize=(11, 4.5), dpi=96
    )  # as wide as the page, so that labels keep their size
    axes = figure.subplots(len(rows), 1 + len(ACTIONS))
    for row, (name, room) in zip(axes, rows.items(), strict=True):
        start = World.parse(room, name)
        _panel(row[0], start, framed=True)
        row[0].set_ylabel(name, fontsize=LABEL_SIZE)
        for action, ax in enumerate(row[1:]):
            _panel(ax, after(start, action), framed=False)
    for ax, title in zip(axes[0], ("start", *ACTIONS), strict=True):
        ax.set_title(title, fontsize=LABEL_SIZE)
    figure.subplots_adjust(left=0.06, right=0.995, top=0.94, bottom=0.01, wspace=0.06, hspace=0.06)
    return figure


def after(world: World, action: int) -> World:
    """The world one action later."""
    mdp = tabulate(world)
    return placement(world, mdp, mdp.next_state[mdp.start, action])


def _panel(ax: Axes, world: World, framed: bool) -> None:
    draw_world(ax, world)
    ax.set_frame_on(True)
    for spine in ax.spines.values():
        spine.set(color=COLOURS[0] if framed else "#c9ced6", linewidth=2.5 if framed else 0.8)


def figure_2(results: Sequence[Result]) -> Figure:
    """Share of the steps with the picker in hand, and of those with the can attached."""
    figure = Figure(figsize=(11, 4.2), dpi=96)
    left, right = figure.subplots(1, 2, sharey=True)
    _curves(left, results, equipped_share)
    left.set_title("picker equipped", fontsize=LABEL_SIZE)
    left.set(ylim=(0, 1.02))
    left.set_ylabel("share of an episode's steps", fontsize=LABEL_SIZE)
    left.yaxis.set_major_formatter(PercentFormatter(1))
    left.tick_params(axis="y", labelsize=TICK_SIZE)
    _curves(right, results, attached_share)
    right.set_title("can attached, of the steps with the picker equipped", fontsize=LABEL_SIZE)
    left.legend(frameon=False, fontsize=TICK_SIZE)
    figure.tight_layout()
    return figure


def returns_figure(results: Sequence[Result]) -> Figure:
    """Learning curves: mean extrinsic return by episode."""
    figure = Figure(figsize=(11, 4.2), dpi=96)
    ax = figure.subplots()
    _curves(ax, results, returns)
    best = {result.run.best_return for result in results}
    returns_axis(ax, max(best))
    for value in best:
        mark_best(ax, value)
    ax.legend(frameon=False, fontsize=TICK_SIZE, loc="lower right")
    figure.tight_layout()
    return figure


def _curves(ax: Axes, results: Sequence[Result], share: Callable[[Run], Curves]) -> None:
    last = SMOOTHING + 1
    for result, colour in zip(results, COLOURS, strict=False):
        values = mean_curve(share(result.run))
        last = max(last, len(values) + SMOOTHING)
        at = _spread(len(values))
        ax.plot(at + SMOOTHING, values[at], color=colour, label=result.row.label, lw=1.4)
    # Agents may differ tenfold in how long they take.
    episodes_axis(ax.xaxis, "episodes (moving average over 100)", SMOOTHING, last)
    ax.spines[["top", "right"]].set_visible(False)


def _spread(count: int) -> Int[np.ndarray, "points"]:
    """The places of at most `_POINTS` values that lie evenly on a logarithmic axis."""
    if not count:
        return np.arange(0)
    wanted = np.geomspace(SMOOTHING, SMOOTHING + count - 1, _POINTS) - SMOOTHING
    return np.unique(wanted.round().astype(int))


def figure_3() -> Figure:
    """1-step FOE, 5-step FOE and 6-step TOE in the first world."""
    cached = paper_worlds().corridor
    return draw_landscapes(
        {
            "(a) 1-step FOE": cached.landscape(1, "state"),
            "(b) 5-step FOE": cached.landscape(5, "state"),
            "(c) 6-step TOE": cached.landscape(6, "object"),
        },
        cell=40,
    )


def figure_4a() -> Figure:
    """1-step FOE with the can next to the broom."""
    broom = paper_worlds().yard.with_tool("broom")
    panels = {"(a) 1-step FOE, broom": broom.landscape(1, "state")}
    return draw_landscapes(panels, cell=40)


def figure_4b() -> Figure:
    """1-step TOE with the can next to the picker, and next to the broom: one colour scale."""
    worlds = {tool: paper_worlds().yard.with_tool(tool) for tool in ("picker", "broom")}
    return draw_landscapes(
        {
            f"(b) 1-step TOE, {tool}": cached.landscape(1, "object")
            for tool, cached in worlds.items()
        },
        cell=40,
    )


_MARKERS = {"ensemble": "o", "multiverse": "s", "fast default": "D"}
_EDGE = 1.25  # how far the axes of the slowness figure go beyond the marks, as a factor
_ROW_COLOURS = (COLOURS[0], COLOURS[2], COLOURS[1], COLOURS[3])


def slowness_figure(marks: pl.DataFrame) -> Figure:
    """The ratio of regularised to vanilla episodes by the vanilla agent's: a panel a measure.

    Args:
        marks: of `slowness.marks`.
    """
    figure = Figure(figsize=(11, 5), dpi=96)
    rows = marks["row"].unique(maintain_order=True).to_list()
    colours = dict(zip(rows, _ROW_COLOURS, strict=False))
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
