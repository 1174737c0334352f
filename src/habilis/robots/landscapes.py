"""Pictures of a comparison: the landscape over the puck's position, and where which tool wins."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float64

from habilis.robots.comparison import ToolComparison
from habilis.robots.pushing import PushingSimulator
from habilis.robots.scene import ACROSS, Frame, still_shapes
from habilis.worlds.world import NO_TOOL

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_UNIT, _GAP, _HEAD, _KEY = 22, 14, 34, 92  # pixels: of a scene's unit, around it
_VERDICTS = ("#0072b2", "#d55e00", "#dfe3e8", "#f0e442")
_WORDS = ("better", "worse", "equal", "undecided")


def draw_comparison(found: ToolComparison, model: str | Path, than: str = NO_TOOL) -> "Figure":
    """Draws the landscapes over the puck's position, and below them verdicts against one tool.

    Args:
        found: what `compare_tools` returned.
        model: the model that it was given.
        than: the tool that the others are compared with; nothing is drawn below where it was not.

    Returns:
        A figure of its own, which `savefig` saves. Squares without a value are white: the puck
        touches something there.

    Example:
        >>> from habilis.robots import compare_tools
        >>> found = compare_tools("reach.xml", ["none", "hook"], horizon=2, side=2, seeds=1)
        >>> len(draw_comparison(found, "reach.xml").axes)
        5
    """
    from habilis.worlds.pictures.figures import new_figure
    from habilis.worlds.pictures.heatmap import HEAT

    simulators = [PushingSimulator(model, tool) for tool in found.tools]
    frame = Frame(simulators[0])
    wide, high = _UNIT * frame.width, _UNIT * frame.height
    bare = than in found.tools and len(found.tools) > 1
    rows = 2 if bare else 1
    width = _GAP + (wide + _GAP) * len(found.tools) + _KEY
    height = (high + _HEAD) * rows + _GAP
    figure = new_figure(width, height)

    def axes(column: int, row: int) -> "Axes":
        left, top = _GAP + (wide + _GAP) * column, _HEAD + (high + _HEAD) * row
        return figure.add_axes(
            (left / width, 1 - (top + high) / height, wide / width, high / height)
        )

    bits = found.bits.mean(axis=2)
    most = max(1.0, float(bits.max()))
    for column, (tool, simulator) in enumerate(zip(found.tools, simulators, strict=True)):
        ax = axes(column, 0)
        _draw(ax, found, simulator, frame, HEAT(bits[column] / most))
        ax.set_title(f"{tool}: {bits[column].mean():.2f} bits", fontsize=10)
        if bare and tool != than:
            judged = found.verdicts(tool, than)
            each = np.stack([judged.better, judged.worse, judged.equal, judged.undecided])
            colours = np.array([_rgba(one) for one in _VERDICTS])[each.argmax(axis=0)]
            below = axes(column, 1)
            _draw(below, found, simulator, frame, colours)
            share = f"better in {judged.better.mean():.0%}, worse in {judged.worse.mean():.0%}"
            below.set_title(f"against {than}: {share}", fontsize=8)
    _draw_scale(figure, most, (width - _KEY + 6) / width, 1 - (_HEAD + high) / height, high)
    if bare:
        _draw_key(figure, _GAP + (wide + _GAP) * found.tools.index(than), width, height, high)
    return figure


def _draw(
    ax: "Axes",
    found: ToolComparison,
    simulator: PushingSimulator,
    frame: Frame,
    colours: Float64[np.ndarray, "n rgba"],
) -> None:
    """The squares in their colours, and what stands still."""
    from matplotlib.collections import PolyCollection

    from habilis.worlds.pictures.figures import draw_shapes

    where = found.placements
    step = (where.high - where.low) / where.side
    outlines = []
    for square in where.squares:
        low = where.low + square * step
        corners = low + step * [(0, 0), (1, 0), (1, 1), (0, 1)]
        outlines.append([frame.point(corner) for corner in corners])
    ax.add_collection(
        PolyCollection(outlines, facecolors=colours, edgecolors="#ffffff", linewidths=0.4),
        autolim=False,
    )
    draw_shapes(ax, [still_shapes(simulator)])
    ax.set(xlim=(0, frame.width), ylim=(frame.height, 0), aspect="equal", xticks=[], yticks=[])
    ax.set_frame_on(False)


def _draw_scale(figure: "Figure", most: float, left: float, bottom: float, high: int) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    from habilis.worlds.pictures.heatmap import HEAT

    width, height = figure.get_size_inches() * figure.dpi
    place = figure.add_axes((left, bottom, 14 / width, high / height))
    bar = figure.colorbar(ScalarMappable(Normalize(0, most), HEAT), cax=place, label="bits")
    bar.outline.set_visible(False)
    if bar.solids is not None:
        bar.solids.set(rasterized=False, edgecolor="face")


def _draw_key(figure: "Figure", left: int, width: int, height: int, high: int) -> None:
    """The colours of verdicts, below the tool that others are compared with."""
    ax = figure.add_axes(
        (
            left / width,
            1 - (2 * (_HEAD + high)) / height,
            _UNIT * ACROSS / width,
            high / height,
        )
    )
    ax.set(xlim=(0, 10), ylim=(10, 0))
    ax.set_axis_off()
    for row, (word, colour) in enumerate(zip(_WORDS, _VERDICTS, strict=True)):
        ax.add_patch(_patch(1.0, 2.6 + 1.3 * row, colour))
        ax.text(2.4, 3.1 + 1.3 * row, word, fontsize=9, va="center")


def _patch(x: float, y: float, colour: str):
    from matplotlib.patches import Rectangle

    return Rectangle((x, y), 1.0, 1.0, facecolor=colour, edgecolor="#5b6270", linewidth=0.6)


def _rgba(colour: str) -> tuple[float, float, float, float]:
    from matplotlib.colors import to_rgba

    return to_rgba(colour)
