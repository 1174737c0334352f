"""The paper's figures, redrawn from our worlds and runs."""

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from habilis.empowerment.landscape_picture import draw_landscapes
from habilis.learning.curves import SMOOTHING
from habilis.learning.runs import Run
from habilis.studies.curves import (
    Curves,
    attached_share,
    equipped_share,
    mean_curve,
    returns,
)
from habilis.studies.scenes import pair
from habilis.studies.tables import Result
from habilis.worlds.pictures import draw_world
from habilis.worlds.rules import ACTIONS
from habilis.worlds.table import placement, tabulate
from habilis.worlds.world import World

# Colour-blind-safe (Okabe and Ito).
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7")

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
    """What tool actions and moves do: a start state, and the state after each action."""
    rows = {
        "picker, can beside it": _BESIDE.format(tool="P"),
        "picker, can attached": _IN_LINE.format(tool="P"),
        "broom, can beside it": _BESIDE.format(tool="B"),
        "broom, can in line": _IN_LINE.format(tool="B"),
    }
    figure = Figure(figsize=(15, 6), dpi=96)
    axes = figure.subplots(len(rows), 1 + len(ACTIONS))
    for row, (name, room) in zip(axes, rows.items(), strict=True):
        start = World.parse(room, name)
        _panel(row[0], start, "start", framed=True)
        row[0].set_ylabel(name, fontsize=9)
        for action, ax in enumerate(row[1:]):
            _panel(ax, after(start, action), ACTIONS[action], framed=False)
    figure.tight_layout()
    return figure


def after(world: World, action: int) -> World:
    """The world one action later."""
    mdp = tabulate(world)
    return placement(world, mdp, mdp.next_state[mdp.start, action])


def _panel(ax: Axes, world: World, title: str, framed: bool) -> None:
    draw_world(ax, world)
    ax.set_title(title, fontsize=9)
    ax.set_frame_on(True)
    for spine in ax.spines.values():
        spine.set(color="#0072b2" if framed else "#c9ced6", linewidth=2.5 if framed else 0.8)


def figure_2(results: Sequence[Result]) -> Figure:
    """Share of the steps with the picker in hand, and of those with the can attached."""
    figure = Figure(figsize=(11, 4.2), dpi=96)
    left, right = figure.subplots(1, 2, sharey=True)
    _curves(left, results, equipped_share)
    left.set(title="picker equipped", ylabel="share of an episode's steps", ylim=(0, 1.02))
    _curves(right, results, attached_share)
    right.set(title="can attached, of the steps with the picker equipped")
    left.legend(frameon=False)
    figure.tight_layout()
    return figure


def returns_figure(results: Sequence[Result]) -> Figure:
    """Learning curves: mean extrinsic return by episode."""
    figure = Figure(figsize=(11, 4.2), dpi=96)
    ax = figure.subplots()
    _curves(ax, results, returns)
    best = {result.run.best_return for result in results}
    for value in best:
        ax.axhline(value, color="#5b6270", linewidth=0.8, linestyle=":")
    ax.set(ylabel="mean return (dotted: best)", yscale="symlog")
    ax.set_ylim(top=0.75 * max(best))
    ax.legend(frameon=False)
    figure.tight_layout()
    return figure


def _curves(ax: Axes, results: Sequence[Result], share: Callable[[Run], Curves]) -> None:
    for result, colour in zip(results, COLOURS, strict=False):
        values = mean_curve(share(result.run))
        episodes = np.arange(len(values)) + SMOOTHING
        ax.plot(episodes, values, color=colour, label=result.row.label, lw=1.4)
    # Agents may differ tenfold in how long they take.
    ax.set(xlabel="episode (moving average over 100)", xscale="log")
    ax.spines[["top", "right"]].set_visible(False)


def figure_3() -> Figure:
    """1-step FOE, 5-step FOE and 6-step TOE in the first world."""
    scene = pair().corridor
    return draw_landscapes(
        {
            "(a) 1-step FOE": scene.landscape(1, "state"),
            "(b) 5-step FOE": scene.landscape(5, "state"),
            "(c) 6-step TOE": scene.landscape(6, "object"),
        },
        cell=40,
    )


def figure_4a() -> Figure:
    """1-step FOE with the can next to the broom."""
    broom = pair().yard.with_tool("broom")
    panels = {"(a) 1-step FOE, broom": broom.landscape(1, "state")}
    return draw_landscapes(panels, cell=40)


def figure_4b(tool: str) -> Figure:
    """1-step TOE with the can next to a tool."""
    scene = pair().yard.with_tool(tool)
    panels = {f"(b) 1-step TOE, {tool}": scene.landscape(1, "object")}
    return draw_landscapes(panels, cell=40)
