"""Landscapes: a value for every cell that the agent can be in, all else fixed."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

import numpy as np
from jaxtyping import Float64
from numpy.typing import ArrayLike

from habilis.analysis.landscape_states import asked
from habilis.empowerment.api import Options, empowerment
from habilis.empowerment.sensors import Sensor
from habilis.files import save_whole, suffix_of
from habilis.mdp import TabularMDP
from habilis.worlds.moving import Where
from habilis.worlds.placements import object_factors, tool_factors
from habilis.worlds.world import World

if TYPE_CHECKING:
    import polars as pl
    from matplotlib.axes import Axes
    from matplotlib.collections import PolyCollection

_NOTEBOOK = 960  # pixels across, at most


@dataclass(frozen=True, eq=False)
class Landscape:
    """A value for every agent cell, tool and object fixed.

    Attributes:
        values: float64[rows, columns], in `unit`; NaN where the agent cannot be: walls, the cells
            of tool and object.
        world: the map, with tool and object where they were put.
        unit: "bits" or "nats".
        title: what was measured, as a picture says it.
    """

    values: Float64[np.ndarray, "rows columns"]
    world: World
    unit: str = "bits"
    title: str = ""

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
        """One row a cell: row, column, and the value, null where there is none."""
        import polars as pl

        row, column = np.indices(self.values.shape).reshape(2, -1)
        table = pl.DataFrame({"row": row, "column": column, self.unit: self.values.ravel()})
        return table.with_columns(pl.col(self.unit).fill_nan(None))

    def save(self, path: str | Path) -> None:
        """Writes the picture, or the values, by the file's suffix.

        Args:
            path: ends with .png, .svg or .pdf for the picture with its colour scale; with .csv,
                .parquet or .npz for the columns row, column and value; or with .npy for the
                values as they are, float64[rows, columns].

        Raises:
            ValueError: another suffix, or the table cannot be written; nothing is written.
        """
        from habilis.analysis.data_frames import TABLES, save_table, write_array
        from habilis.analysis.landscape_picture import draw_landscapes
        from habilis.worlds.pictures.figures import PICTURES, save_figure

        suffix = suffix_of(path, [*PICTURES, *TABLES])
        if suffix in PICTURES:
            save_figure(draw_landscapes({self.title: self}), path)
        elif suffix == ".npy":
            save_whole(path, lambda file: write_array(self.values, file))
        else:
            save_table(self.to_dataframe(), path)

    def _repr_png_(self) -> bytes:
        """The picture, for notebooks."""
        from io import BytesIO

        from habilis.analysis.landscape_picture import draw_landscapes

        cell = min(48, max(4, _NOTEBOOK // max(self.values.shape)))
        picture = BytesIO()
        draw_landscapes({self.title: self}, cell=cell).savefig(picture, format="png", dpi="figure")
        return picture.getvalue()


def landscape(
    world: World,
    horizon: int,
    sensor: Sensor = "state",
    actions: ArrayLike | None = None,
    *,
    slip: float = 0.0,
    tool: Where | None = None,
    object: Where | None = None,
    mdp: TabularMDP | None = None,
    ax: "Axes | None" = None,
    **options: Unpack[Options],
) -> Landscape:
    """Empowerment for every agent cell, all other things fixed.

    Args:
        world: the map.
        horizon, sensor, actions: as in `empowerment`.
        slip: as in `tabulate`.
        tool, object: their cells; by default those of the map. The agent next to the tool has it
            in hand; where the tool does not lie at its cell of the map, there are only such
            states. Of several, cells by names, as `tool={"rake": (2, 3)}`: these may lie anywhere,
            and the first beside the agent is in hand.
        mdp: the world's table, if it is at hand.
        ax: Matplotlib axes to draw it on at once (see `Landscape.draw`).
        **options: of `empowerment`, such as unit="nats".

    Returns:
        The values by cell, with the world and what was asked for.

    Raises:
        ValueError: as in `empowerment`; a tool's cell in a world without one, or no state has
            tool and object there.

    Example:
        >>> from habilis.worlds.world import load_world
        >>> found = landscape(load_world("corridor"), 1, "object")
        >>> found.values.shape, float(np.nanmax(found.values))
        ((10, 10), 1.0)
    """
    if tool is not None and not world.tools:
        raise ValueError(f"{world.name} has no tool here; leave out tool, or use with_tool")
    if mdp is not None and slip:
        raise ValueError("slip is given beside a table; give it to `tabulate`")
    if mdp is not None and (
        mdp.shape != (world.height, world.width)
        or (*tool_factors(world), *object_factors(world))
        != tuple(name for name in mdp.factors if ":" in name or name in ("tool", "object"))
    ):
        raise ValueError(f"{world.name}: the table is of another map; give what `tabulate` made")
    show = options.get("show_progress", False)
    shown, mdp, states = asked(world, horizon, sensor, slip, tool, object, mdp, show)
    values = np.full(world.height * world.width, np.nan)
    bits = empowerment(mdp, horizon, sensor, actions, states, **options)
    values[mdp.factor("agent")[states]] = bits
    bounds = "lower bounds on " if options.get("method") == "sampled" else ""
    sensed = f", sensor {sensor!r}" if isinstance(sensor, str) else ""
    found = Landscape(
        values=values.reshape(world.height, world.width),
        world=shown,
        unit=options.get("unit", "bits"),
        title=f"{bounds}{horizon}-step empowerment{sensed}",
    )
    if ax is not None:
        found.draw(ax)
    return found
