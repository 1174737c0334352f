"""A landscape: a value for every cell that the agent can be in; its table and its pictures."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float64

from habilis.analysis.landscape_states import PlainMap
from habilis.bridges.puzzles.pushworld import PushWorld
from habilis.empowerment.kinds import OPEN_LOOP
from habilis.files import save_whole, suffix_of
from habilis.reprs import counted, quietly, short, unfailing
from habilis.worlds.world import World

if TYPE_CHECKING:
    import polars as pl
    from matplotlib.axes import Axes
    from matplotlib.collections import PolyCollection
    from matplotlib.figure import Figure

_NOTEBOOK = 960  # pixels across, at most
_GAP, _HEAD, _BAR, _BAR_LABEL = 24, 36, 16, 64  # pixels


@dataclass(frozen=True, eq=False)
class Landscape:
    """A value for every agent cell, tool and object fixed.

    Attributes:
        values: float64[rows, columns], in `unit`; NaN where the agent cannot be: walls, the cells
            of tool and object.
        world: the map, with tool and object where they were put; or the puzzle.
        unit: "bits" or "nats".
        title: what was measured, as a picture says it.
        kind: of empowerment, as in `landscape`.
        discount: of effective empowerment.
        slack: of goal-directed empowerment.
        gap: float64[rows, columns], by how much the true values may differ at most, in `unit`;
            `None` where values are counts, without noise.
    """

    values: Float64[np.ndarray, "rows columns"]
    world: World | PushWorld | PlainMap
    unit: str = "bits"
    title: str = ""
    kind: str = OPEN_LOOP
    discount: float | None = None
    slack: int | None = None
    gap: Float64[np.ndarray, "rows columns"] | None = None

    def draw(
        self,
        ax: "Axes | None" = None,
        vmin: float | None = None,
        vmax: float | None = None,
        labels: bool = True,
        title: str | None = None,
    ) -> "PolyCollection":
        """Draws it as a heat map with the walls, the goal, the object and the tool.

        Args:
            ax: any Matplotlib axes; by default pyplot's current ones.
            vmin, vmax: the ends of the colour scale; by default those of the values.
            labels: whether to print the values. They grow and shrink with the axes, and are left
                out while they would be too small to read.
            title: stands above the map; by default what was measured, "" for nothing.

        Returns:
            What a colour bar needs: `figure.colorbar(mappable, ax=ax, label=landscape.unit)`.
        """
        from habilis.worlds.pictures.heatmap import draw_heat

        if ax is None:
            from matplotlib import pyplot

            ax = pyplot.gca()
        title = self.title if title is None else title
        return draw_heat(
            ax, self.world, self.values, vmin=vmin, vmax=vmax, labels=labels, title=title
        )

    def to_dataframe(self) -> "pl.DataFrame":
        """One row a cell: row, column, and the value, null where there is none.

        Besides, where they apply: the gap; and of a kind other than open loop its name, its
        discount and its slack.
        """
        import polars as pl

        row, column = np.indices(self.values.shape).reshape(2, -1)
        measured = {self.unit: self.values} | ({} if self.gap is None else {"gap": self.gap})
        columns = {name: values.ravel() for name, values in measured.items()}
        table = pl.DataFrame({"row": row, "column": column, **columns})
        settings = {name: pl.lit(value) for name, value in self.settings.items()}
        return table.with_columns(pl.col(*columns).fill_nan(None), **settings)

    @property
    def settings(self) -> dict[str, str | float | int]:
        """The kind and its settings, by name; of open loop, nothing."""
        if self.kind == OPEN_LOOP:
            return {}
        given = {"kind": self.kind, "discount": self.discount, "slack": self.slack}
        return {name: value for name, value in given.items() if value is not None}

    def save(self, path: str | Path) -> None:
        """Writes the picture, or the values, by the file's suffix.

        Args:
            path: ends with .png, .svg or .pdf for the picture with its colour scale; with .csv,
                .parquet or .npz for the columns of `to_dataframe`; or with .npy for the values as
                they are, float64[rows, columns].

        Raises:
            ValueError: another suffix, or the table cannot be written; nothing is written.
        """
        from habilis.analysis.data_frames import TABLES, save_table, write_array
        from habilis.worlds.pictures.figures import PICTURES, save_figure

        suffix = suffix_of(path, [*PICTURES, *TABLES])
        if suffix in PICTURES:
            save_figure(draw_landscapes({self.title: self}), path)
        elif suffix == ".npy":
            save_whole(path, lambda file: write_array(self.values, file))
        else:
            save_table(self.to_dataframe(), path)

    @unfailing
    def __repr__(self) -> str:
        there = self.values[np.isfinite(self.values)]
        most = f" to {there.max():.2f}" if there.size else ""
        least = f"{there.min():.2f}" if there.size else "no"
        where = f"{least}{most} {self.unit} in {counted(there.size, 'cell')}"
        return short("Landscape", self.world.name, self.title, where)

    @quietly
    def _repr_png_(self) -> bytes:
        """The picture, for notebooks."""
        from io import BytesIO

        cell = min(48, max(4, _NOTEBOOK // max(self.values.shape)))
        picture = BytesIO()
        draw_landscapes({self.title: self}, cell=cell).savefig(picture, format="png", dpi="figure")
        return picture.getvalue()


def draw_landscapes(
    landscapes: Mapping[str, Landscape],
    axes: "Axes | Iterable[Any] | None" = None,
    *,
    cell: int | None = None,
    labels: bool = True,
) -> "Figure":
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
        >>> from habilis import landscape, load_world
        >>> world = load_world("corridor")
        >>> panels = {f"{h} steps": landscape(world, h, "object") for h in (1, 3)}
        >>> [ax.get_title() for ax in draw_landscapes(panels).axes]
        ['1 steps', '3 steps', '']
    """
    from matplotlib.axes import Axes

    from habilis.worlds.pictures.figures import cell_size
    from habilis.worlds.pictures.heatmap import draw_scale, scale_of

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


def _as_high_as(places: "list[Axes]", bar: "Axes") -> None:
    """Maps have square cells, and so are lower than their axes may be."""
    from matplotlib.transforms import Bbox

    for ax in places:
        ax.apply_aspect()
    maps = Bbox.union([ax.get_position() for ax in places])
    bar.set_position((bar.get_position().x0, maps.y0, bar.get_position().width, maps.height))


def _new_axes(landscapes: list[Landscape], cell: int) -> "tuple[list[Axes], Axes]":
    """One for each in a row, tops aligned, and those of the bar."""
    from habilis.worlds.pictures.figures import new_figure

    sizes = [(cell * found.world.width, cell * found.world.height) for found in landscapes]
    tallest = max(height for _, height in sizes)
    width = _GAP + sum(across + _GAP for across, _ in sizes) + _BAR + _BAR_LABEL
    height = _HEAD + tallest + _GAP
    figure = new_figure(width, height)

    def axes(left: int, across: int, down: int) -> "Axes":
        bottom = _GAP + tallest - down
        return figure.add_axes((left / width, bottom / height, across / width, down / height))

    places, left = [], _GAP
    for across, down in sizes:
        places.append(axes(left, across, down))
        left += across + _GAP
    return places, axes(left, _BAR, tallest)
