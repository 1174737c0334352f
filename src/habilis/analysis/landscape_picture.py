"""Landscapes side by side, with one colour scale."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from habilis.analysis.landscape import Landscape
from habilis.worlds.pictures.figures import cell_size, new_figure
from habilis.worlds.pictures.heatmap import draw_scale, scale_of

_GAP, _HEAD, _BAR, _BAR_LABEL = 24, 36, 16, 64  # pixels


def draw_landscapes(
    landscapes: Mapping[str, Landscape],
    axes: Axes | Iterable[Any] | None = None,
    *,
    cell: int | None = None,
    labels: bool = True,
) -> Figure:
    """Landscapes side by side, with one colour scale, and one bar for it.

    Args:
        landscapes: by their titles.
        axes: one for each, such as `plt.subplots(1, 3)` makes; the bar takes a part of them. By
            default those of a new figure, in one row.
        cell: pixels a cell in a new figure; by default 48, and on maps of more than 100 cells
            across fewer.
        labels: whether to print the values (see `Landscape.draw`).

    Returns:
        The figure, which `savefig` saves.

    Raises:
        ValueError: no landscapes, another number of axes, or values in several units.

    Example:
        >>> from habilis.analysis.landscape import landscape
        >>> from habilis.worlds.world import load_world
        >>> world = load_world("corridor")
        >>> panels = {f"{h} steps": landscape(world, h, "object") for h in (1, 3)}
        >>> [ax.get_title() for ax in draw_landscapes(panels).axes]
        ['1 steps', '3 steps', '']
    """
    panels = list(landscapes.items())
    units = {landscape.unit for landscape in landscapes.values()}
    if not panels:
        raise ValueError("no landscapes to draw; give at least one")
    if len(units) > 1:
        raise ValueError(f"one colour scale for {' and '.join(sorted(units))}; give one unit")
    vmin, vmax = scale_of(np.concatenate([found.values.ravel() for _, found in panels]))
    if axes is None:
        across = max(max(found.values.shape) for _, found in panels)
        cell = cell_size(across) if cell is None else cell
        places, bar = _new_axes([found for _, found in panels], cell)
        place = {"cax": bar}
    else:
        places = [axes] if isinstance(axes, Axes) else list(np.ravel(np.asarray([*axes], object)))
        place = {"ax": places}
        if len(places) != len(panels):
            raise ValueError(
                f"{len(panels)} landscapes on {len(places)} axes; give one axes for each"
            )
    heats = [
        found.draw(ax, vmin, vmax, labels, title)
        for ax, (title, found) in zip(places, panels, strict=True)
    ]
    bar = draw_scale(heats[0], units.pop(), **place)
    figure = places[0].get_figure(root=True)
    assert figure is not None, "axes are on a figure"
    if axes is not None and figure.get_layout_engine() is None:
        _as_high_as(places, bar.ax)
    return figure


def _as_high_as(places: list[Axes], bar: Axes) -> None:
    """Maps have square cells, and so are lower than their axes may be."""
    for ax in places:
        ax.apply_aspect()
    maps = Bbox.union([ax.get_position() for ax in places])
    bar.set_position((bar.get_position().x0, maps.y0, bar.get_position().width, maps.height))


def _new_axes(landscapes: list[Landscape], cell: int) -> tuple[list[Axes], Axes]:
    """One for each in a row, tops aligned, and those of the bar."""
    sizes = [(cell * found.world.width, cell * found.world.height) for found in landscapes]
    tallest = max(height for _, height in sizes)
    width = _GAP + sum(across + _GAP for across, _ in sizes) + _BAR + _BAR_LABEL
    height = _HEAD + tallest + _GAP
    figure = new_figure(width, height)

    def axes(left: int, across: int, down: int) -> Axes:
        bottom = _GAP + tallest - down
        return figure.add_axes((left / width, bottom / height, across / width, down / height))

    places, left = [], _GAP
    for across, down in sizes:
        places.append(axes(left, across, down))
        left += across + _GAP
    return places, axes(left, _BAR, tallest)
