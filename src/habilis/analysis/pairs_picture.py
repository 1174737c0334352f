"""The picture of every tool by every object."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from habilis.analysis.pairs import Pairs
from habilis.colours import COLOURS
from habilis.worlds.pictures.figures import new_figure
from habilis.worlds.pictures.heatmap import HEAT, inks, scale_of
from habilis.worlds.world import NO_TOOL

_CELL, _ROW, _PANEL, _LOWEST = 84, 46, 220, 220  # pixels: cells, panels
_LETTER, _KEY, _GAP, _AXIS, _HEAD, _FOOT = 8, 52, 18, 62, 56, 48  # pixels: around them
_MARKERS = "os^Dv<>"
_DASHES = ("-", "--", "-.")
_BARE, _DOTTED = "#5b6270", ":"


def pairs_figure(found: Pairs) -> Figure:
    """The matrix at the largest horizon, and the averages over horizons, a panel an object.

    Args:
        found: what `pairs` gave.

    Returns:
        The figure; `worlds.pictures.save_figure` writes it.
    """
    tools, objects = len(found.tools), len(found.objects)
    names = _LETTER * max(map(len, found.tools))
    cell = max(_CELL, _LETTER * max(map(len, found.objects)) + _GAP)
    high = max(_LOWEST, _ROW * tools)
    first = _GAP + names + cell * objects + _AXIS
    width = first + (_PANEL + _GAP) * objects + _KEY + names
    height = _HEAD + high + _FOOT
    figure = new_figure(width, height)

    def axes(left: int, across: int) -> Axes:  # in whole pixels: any layout engine rounds otherwise
        place = left / width, _FOOT / height, across / width, high / height
        return figure.add_axes(place)

    _draw_matrix(axes(_GAP + names, cell * objects), found)
    panels = [axes(first + (_PANEL + _GAP) * place, _PANEL) for place in range(objects)]
    for place, ax in enumerate(panels):
        _draw_curves(ax, found, place)
        ax.sharey(panels[0])
        ax.tick_params(labelleft=place == 0)
    panels[0].set_ylabel(f"{found.unit} on average")
    panels[-1].legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    figure.text(_GAP / width, 1 - 16 / height, found.title, fontsize=11, va="center")
    return figure


def _draw_matrix(ax: Axes, found: Pairs) -> None:
    """Values in cells, the lighter the more."""
    values = found.averages[-1]
    low, high = scale_of(values, vmin=0.0)
    heat = ax.pcolormesh(values, cmap=HEAT, vmin=low, vmax=high, edgecolors="white", linewidth=2)
    colours = inks(np.asarray(heat.to_rgba(values.ravel())))
    for (row, column), ink in zip(np.ndindex(values.shape), colours, strict=True):
        text = f"{values[row, column]:.2f}"
        ax.text(column + 0.5, row + 0.5, text, color=ink, ha="center", va="center_baseline")
    ax.set_xticks(np.arange(len(found.objects)) + 0.5, found.objects)
    ax.set_yticks(np.arange(len(found.tools)) + 0.5, found.tools)
    ax.tick_params(length=0)
    ax.invert_yaxis()
    ax.set_frame_on(False)
    ax.set_title(f"{found.unit} for h = {found.horizon}", fontsize=10)


def _draw_curves(ax: Axes, found: Pairs, place: int) -> None:
    """The averages over h of all tools for one object."""
    horizons = np.arange(1, found.horizon + 1)
    for row, tool in enumerate(found.tools):
        ax.plot(
            horizons,
            found.averages[:, row, place],
            _DOTTED if tool == NO_TOOL else _DASHES[row // len(COLOURS) % len(_DASHES)],
            color=_BARE if tool == NO_TOOL else COLOURS[row % len(COLOURS)],
            marker="" if tool == NO_TOOL else _MARKERS[row % len(_MARKERS)],
            markersize=6,
            markerfacecolor="none",  # where curves coincide, the marks of all are seen
            linewidth=1.4,
            label=tool,
        )
    ax.set_ylim(bottom=0)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.set_xlabel("h, actions")
    ax.set_title(found.objects[place], fontsize=10)
    ax.spines[["top", "right"]].set_visible(False)
