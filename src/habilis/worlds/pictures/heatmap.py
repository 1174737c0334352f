"""A value for every cell of a map: heat maps that stay readable."""

from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float
from matplotlib import colormaps
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colorbar import Colorbar
from matplotlib.colors import ListedColormap
from matplotlib.text import Text

from habilis.worlds.pictures.figures import Drawn, draw_map, draw_shapes, repeated, things_of
from habilis.worlds.pictures.shapes import SHAPES, Drawing, placed
from habilis.worlds.world import Cell, World

# Readable by the colour-blind, and without its dark end, which would look like wall.
HEAT = ListedColormap(colormaps["viridis"](np.linspace(0.2, 1, 256)), name="heat")
SMALLEST = 7.0
"""The smallest text in points; a label that would be smaller is left out."""

_FONT = 0.32  # of a label, in cells
_HALFWAY = 0.179  # the luminance on which black and white contrast alike


def draw_heat(
    ax: Axes,
    world: World | Drawn,
    values: Float[np.ndarray, "rows columns"],
    *,
    vmin: float | None = None,
    vmax: float | None = None,
    labels: bool = True,
    title: str | None = None,
    agent: bool = False,
) -> PolyCollection:
    """Draws a value for every cell as a heat map, with the walls, the bin, the can and the tool.

    Args:
        ax: where to draw; its limits, aspect and frame are set to fit the world.
        world: the map, and where can and tool are; or a puzzle, whose bodies are behind the values.
        values: in any unit; NaN where there is none (walls, the cells of the can and the tool).
        vmin, vmax: the ends of the colour scale; by default those of the values.
        labels: whether to print the values where the cells are large enough: to one decimal, or
            two if they differ by less than 1.
        title: stands above the map, in a font that fits its width.
        agent: whether to draw the agent too; not in a landscape, whose values are over its cells.

    Returns:
        What a colour bar needs: `figure.colorbar(mappable)`.

    Raises:
        ValueError: the values do not have the map's shape.
    """
    if values.shape != (world.height, world.width):
        raise ValueError(
            f"{world.name}: the map has {world.height} rows and {world.width} columns, the values "
            f"{values.shape}; give one for every cell, NaN where there is none"
        )
    draw_map(ax, world, {})
    tile, things = SHAPES["floor"][-1], {}  # less the grid lines
    if isinstance(world, World):
        things = things_of(world, world.agent if agent else None)
    else:  # its bodies are behind the values, and as large as they are
        draw_shapes(ax, world.drawings(agent))
        (tile,) = placed(SHAPES["plate"], 0.12, 0.12, 0.76)
    valued = np.argwhere(np.isfinite(values))
    heat = repeated(ax, tile, valued.astype(float), cmap=HEAT)
    heat.set_array(values[tuple(valued.T)])
    heat.set_clim(*scale_of(values, vmin, vmax))
    ax.add_collection(heat, autolim=False)
    above = {cell: labels and bool(np.isfinite(values[cell])) for cell in things}
    draw_shapes(ax, [_small(cell, things[cell], above_label=above[cell]) for cell in things])
    if labels:
        ax.add_artist(_Labels(values, heat, set(things)))
    if title is not None:
        _set_title(ax, world, title)
    return heat


def scale_of(
    values: Float[np.ndarray, "*any"], vmin: float | None = None, vmax: float | None = None
) -> tuple[float, float]:
    """The two ends of a colour scale for some values, of which one or both may be given."""
    finite = values[np.isfinite(values)]
    low = (float(finite.min()) if finite.size else 0.0) if vmin is None else vmin
    high = (float(finite.max()) if finite.size else low) if vmax is None else vmax
    return low, high if high > low else low + 1


def draw_scale(heat: PolyCollection, label: str, **place) -> Colorbar:
    """Draws the colour scale of a heat map.

    Args:
        heat: what `draw_heat` returned.
        label: the unit.
        **place: as for Matplotlib's `figure.colorbar`: `cax=` the bar's own axes, or `ax=` the
            axes that it takes a part of.
    """
    assert heat.axes is not None
    bar = heat.axes.figure.colorbar(heat, label=label, **place)
    bar.outline.set_visible(False)
    if bar.solids is not None:
        bar.solids.set(rasterized=False, edgecolor="face")  # an SVG of areas, no image in it
    return bar


def _set_title(ax: Axes, world: World | Drawn, title: str) -> None:
    """A title as wide as the map, if the font can be made small enough."""
    text = ax.set_title(title)
    box = ax.get_window_extent()
    across = min(box.width, box.height * world.width / world.height) * 72 / ax.figure.dpi
    fitting = across / (0.55 * max(1, len(title)))  # letters are so wide on average
    text.set_fontsize(min(text.get_fontsize(), max(SMALLEST, fitting)))


class _Labels(Artist):
    """The values in their cells; the font follows the cells' size, whatever becomes of the axes."""

    def __init__(
        self, values: Float[np.ndarray, "rows columns"], heat: PolyCollection, below: set[Cell]
    ) -> None:
        super().__init__()
        self._values, self._heat, self._below = values, heat, below
        self.set(in_layout=False, zorder=3)  # never larger than the cells

    def draw(self, renderer: Any) -> None:
        """Sets the font to the size that a cell has now; too small to read, labels are left out."""
        assert self.axes is not None
        assert self.axes.figure is not None
        ends = self.axes.transData.transform([(0, 0), (1, 1)])
        points = np.abs(ends[1] - ends[0]).min() * 72 / self.axes.figure.dpi
        if _FONT * points < SMALLEST:
            return  # before there are any: they may be very many
        for text in self.texts:
            text.set_fontsize(_FONT * points)
            text.draw(renderer)

    @cached_property
    def texts(self) -> list[Text]:
        assert self.axes is not None
        cells = np.argwhere(np.isfinite(self._values))
        shown = self._values[tuple(cells.T)]
        decimals = 2 if shown.size and 1e-9 < np.ptp(shown) < 1 else 1
        colours = inks(self._heat.to_rgba(self._values[tuple(cells.T)]))
        texts = []
        for (row, column), ink in zip(cells.tolist(), colours, strict=True):
            middle = 0.82 if (row, column) in self._below else 0.5
            value = f"{self._values[row, column]:z.{decimals}f}"
            text = Text(column + 0.5, row + middle, value, color=ink)
            text.set(ha="center", va="center_baseline", transform=self.axes.transData)
            text.set(figure=self.axes.figure, clip_box=self.axes.bbox, clip_on=True)
            texts.append(text)
        return texts


def _small(cell: Cell, drawing: Drawing, *, above_label: bool) -> Drawing:
    """The drawing on a plate with space around it, or in the upper part of the cell."""
    row, column = cell
    left, top, size = (0.2, 0.05, 0.6) if above_label else (0.1, 0.1, 0.8)
    return placed(SHAPES["plate"] + drawing, column + left, row + top, size)


def inks(backgrounds: Float[np.ndarray, "n rgba"]) -> list[str]:
    """Black or white, whichever has the higher contrast (as WCAG 2 defines it)."""
    part = backgrounds[:, :3]
    linear = np.where(part <= 0.04045, part / 12.92, ((part + 0.055) / 1.055) ** 2.4)
    light = linear @ (0.2126, 0.7152, 0.0722)
    return np.where(light > _HALFWAY, "black", "white").tolist()
