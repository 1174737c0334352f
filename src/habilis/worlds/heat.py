"""A value for every cell of a map: heat maps that stay readable."""

import numpy as np
from jaxtyping import Float
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.collections import PolyCollection
from matplotlib.colorbar import Colorbar
from matplotlib.colors import ListedColormap
from matplotlib.text import Text

from habilis.worlds.pictures import draw_map, draw_shapes, things_of
from habilis.worlds.shapes import SHAPES, Drawing, placed
from habilis.worlds.world import Cell, World

# Readable by the colour-blind, and without its dark end, which would look like wall.
HEAT = ListedColormap(colormaps["viridis"](np.linspace(0.2, 1, 256)), name="heat")
SMALLEST = 7.0
"""The smallest text in points; a label that would be smaller is left out."""

_HALFWAY = 0.179  # the luminance on which black and white contrast alike


def draw_heat(
    ax: Axes,
    world: World,
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
        world: the map, and where can and tool are.
        values: in any unit; NaN where there is none (walls, the cells of the can and the tool).
        vmin, vmax: the ends of the colour scale; by default those of the values.
        labels: whether to print the values, to one decimal, where the cells are large enough.
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
    valued = [(int(row), int(column)) for row, column in np.argwhere(np.isfinite(values))]
    heat = PolyCollection(
        [_placed(cell, SHAPES["floor"])[-1].points for cell in valued],  # less their grid lines
        cmap=HEAT,
        linewidths=0,
        snap=False,
    )
    heat.set_array(np.array([values[cell] for cell in valued]))
    heat.set_clim(*scale_of(values, vmin, vmax))
    ax.add_collection(heat, autolim=False)
    labelled = valued if labels else []
    things = things_of(world, world.agent if agent else None)
    draw_shapes(ax, [_small(cell, things[cell], above_label=cell in labelled) for cell in things])
    for cell in labelled:
        ink = _ink(np.array(HEAT(heat.norm(values[cell]))))
        ax.add_artist(_Label(cell, values[cell], ink, below=cell in things))
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


def _set_title(ax: Axes, world: World, title: str) -> None:
    """A title as wide as the map, if the font can be made small enough."""
    text = ax.set_title(title)
    box = ax.get_window_extent()
    across = min(box.width, box.height * world.width / world.height) * 72 / ax.figure.dpi
    fitting = across / (0.55 * max(1, len(title)))  # letters are so wide on average
    text.set_fontsize(min(text.get_fontsize(), max(SMALLEST, fitting)))


class _Label(Text):
    """A value in its cell; the font follows the cell's size, whatever becomes of the axes."""

    def __init__(self, cell: Cell, value: float, ink: str, *, below: bool) -> None:
        row, column = cell
        middle, self._part = (0.82, 0.28) if below else (0.5, 0.32)
        super().__init__(column + 0.5, row + middle, f"{value:z.1f}", color=ink)
        self.set(ha="center", va="center_baseline", in_layout=False)  # never larger than its cell

    def draw(self, renderer: RendererBase) -> None:
        """Sets the font to the size that the cell has now; too small to read, it is left out."""
        if self.axes is None or self.figure is None:
            return
        ends = self.axes.transData.transform([(0, 0), (1, 1)])
        points = self._part * np.abs(ends[1] - ends[0]).min() * 72 / self.figure.dpi
        if points < SMALLEST:
            return
        if points != self.get_fontsize():
            self.set_fontsize(points)
        super().draw(renderer)


def _placed(cell: Cell, drawing: Drawing) -> Drawing:
    row, column = cell
    return placed(drawing, float(column), float(row))


def _small(cell: Cell, drawing: Drawing, *, above_label: bool) -> Drawing:
    """The drawing on a plate with space around it, or in the upper part of the cell."""
    row, column = cell
    left, top, size = (0.2, 0.05, 0.6) if above_label else (0.1, 0.1, 0.8)
    return placed(SHAPES["plate"] + drawing, column + left, row + top, size)


def _ink(background: Float[np.ndarray, "rgba"]) -> str:
    """Black or white, whichever has the higher contrast (as WCAG 2 defines it)."""
    part = background[:3]
    linear = np.where(part <= 0.04045, part / 12.92, ((part + 0.055) / 1.055) ** 2.4)
    return "black" if linear @ (0.2126, 0.7152, 0.0722) > _HALFWAY else "white"
