"""The picture of every tool by every object."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from habilis.colours import COLOURS
from habilis.empowerment.pairs import Pairs
from habilis.worlds.heat import HEAT, inks, scale_of
from habilis.worlds.pictures import new_figure
from habilis.worlds.world import NO_TOOL

_CELL, _ROW, _PANEL, _LEAST = 84, 46, 250, 330  # pixels: width and height of cells, panels, all
_NAMES, _AROUND = 100, 110  # beside and around the cells
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
    widths = [_NAMES + _CELL * objects, *([_PANEL] * objects)]
    height = max(_LEAST, _ROW * tools + _AROUND)
    figure = new_figure(sum(widths) + _AROUND, height)
    figure.set_layout_engine("constrained", w_pad=0.08)
    axes = np.atleast_1d(figure.subplots(1, 1 + objects, width_ratios=widths))
    _draw_matrix(axes[0], found)
    for place, ax in enumerate(axes[1:]):
        _draw_curves(ax, found, place)
        ax.sharey(axes[1])
        ax.set_ylabel(f"{found.unit} on average" if place == 0 else "")
        ax.tick_params(labelleft=place == 0)
    figure.legend(*axes[1].get_legend_handles_labels(), loc="outside right center", frameon=False)
    figure.suptitle(found.title, fontsize=11)
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
