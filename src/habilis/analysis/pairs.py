"""Which tool for which object: every pair of them, alone in the same world."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

import numpy as np
from jaxtyping import Float64, Int64

from habilis.analysis.averages import compared_states, held, with_each_tool
from habilis.analysis.influence import (
    certain,
    distances,
    fails,
    first_above_nothing,
    furthest,
    share,
)
from habilis.colours import COLOURS
from habilis.empowerment.api import Options
from habilis.empowerment.arguments import at_least_one, per_bit
from habilis.empowerment.horizons import empowerment_by_horizon
from habilis.empowerment.methods import Exact, bounds_of
from habilis.empowerment.old_keywords import takes_old_keywords
from habilis.files import save_whole, suffix_of
from habilis.progress import progress_bar
from habilis.reprs import quietly, short, unfailing
from habilis.worlds.table import tabulate
from habilis.worlds.tools import Tool
from habilis.worlds.world import NO_TOOL, World

if TYPE_CHECKING:
    import polars as pl
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Table = Float64[np.ndarray, "tools objects"]

_CELL, _ROW, _PANEL, _LOWEST = 84, 46, 220, 220  # pixels: cells, panels
_LETTER, _KEY, _GAP, _AXIS, _HEAD, _FOOT = 8, 52, 18, 62, 56, 48  # pixels: around them
_MARKERS = "os^Dv<>"
_DASHES = ("-", "--", "-.")
_BARE, _DOTTED = "#5b6270", ":"


@dataclass(frozen=True, eq=False)
class Pairs:
    """Average object empowerment with each tool over each object, and further measures.

    A pair is the world with that tool and that object alone. Its averages, and all that is said
    of it here, go over all placements with the tool in hand or, for "none", over all placements.

    Attributes:
        tools: names of the T rows; "none" is the bare agent.
        objects: names of the O columns.
        averages: float64[H, T, O], the average object empowerment for h = 1, 2, ... H.
        range: int64[T, O], from how many cells away there is any influence within H actions; 0
            where there is none.
        latency: float64[T, O], the least number of actions with which there is any, from where it
            takes fewest; infinity where none up to H has any.
        median_latency: float64[T, O], the median over placements of that number.
        persistence: float64[T, O], the average over placements of what can be reached again and
            again, nothing failing.
        reliability: float64[T, O], the average with slip over the average without, at H; 1 where
            nothing fails, NaN where there is nothing to lose.
        unit: "bits" or "nats".
        title: what was measured, as a picture says it.
    """

    tools: tuple[str, ...]
    objects: tuple[str, ...]
    averages: Float64[np.ndarray, "horizons tools objects"]
    range: Int64[np.ndarray, "tools objects"]
    latency: Table
    median_latency: Table
    persistence: Table
    reliability: Table
    unit: str = "bits"
    title: str = ""

    @property
    def horizon(self) -> int:
        """H, the largest number of actions."""
        return len(self.averages)

    def draw(self) -> "Figure":
        """Draws the matrix at H, and beside it the averages over h, a panel for each object.

        Returns:
            A figure of its own, which `savefig` saves.
        """
        from habilis.worlds.pictures.figures import new_figure

        tools, objects = len(self.tools), len(self.objects)
        names = _LETTER * max(map(len, self.tools))
        cell = max(_CELL, _LETTER * max(map(len, self.objects)) + _GAP)
        high = max(_LOWEST, _ROW * tools)
        first = _GAP + names + cell * objects + _AXIS
        width = first + (_PANEL + _GAP) * objects + _KEY + names
        height = _HEAD + high + _FOOT
        figure = new_figure(width, height)

        def axes(
            left: int, across: int
        ) -> "Axes":  # in whole pixels: any layout engine rounds otherwise
            place = left / width, _FOOT / height, across / width, high / height
            return figure.add_axes(place)

        _draw_matrix(axes(_GAP + names, cell * objects), self)
        panels = [axes(first + (_PANEL + _GAP) * place, _PANEL) for place in range(objects)]
        for place, ax in enumerate(panels):
            _draw_curves(ax, self, place)
            ax.sharey(panels[0])
            ax.tick_params(labelleft=place == 0)
        panels[0].set_ylabel(f"{self.unit} on average")
        panels[-1].legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
        figure.text(_GAP / width, 1 - 16 / height, self.title, fontsize=11, va="center")
        return figure

    def to_dataframe(self) -> "pl.DataFrame":
        """One row for each tool, object and h, with the average and what else is said of the pair.

        Returns:
            A Polars data frame; null where there is no value, be it infinity or NaN.
        """
        import polars as pl

        tool, object, horizon = np.indices(self.averages.transpose(1, 2, 0).shape).reshape(3, -1)
        columns = {
            "tool": np.array(self.tools)[tool],
            "object": np.array(self.objects)[object],
            "horizon": horizon + 1,
            self.unit: self.averages[horizon, tool, object],
        }
        columns |= {name: getattr(self, name)[tool, object] for name in MEASURES}
        kinds = pl.selectors.float()
        return pl.DataFrame(columns).with_columns(
            pl.when(kinds.is_finite()).then(kinds).otherwise(None)
        )

    def save(self, path: str | Path) -> None:
        """Writes the picture, or the values, by the file's suffix.

        Args:
            path: ends with .png, .svg or .pdf for the picture; with .csv, .parquet or .npz for
                the columns of `to_dataframe`; or with .npy for the averages as they are,
                float64[H, T, O].

        Raises:
            ValueError: another suffix, or the table cannot be written; nothing is written.
        """
        from habilis.analysis.data_frames import TABLES, save_table, write_array
        from habilis.worlds.pictures.figures import PICTURES, save_figure

        suffix = suffix_of(path, [*PICTURES, *TABLES])
        if suffix in PICTURES:
            save_figure(self.draw(), path)
        elif suffix == ".npy":
            save_whole(path, lambda file: write_array(self.averages, file))
        else:
            save_table(self.to_dataframe(), path)

    @unfailing
    def __repr__(self) -> str:
        first = max(map(len, self.tools))
        widths = [max(len(name), len("0.00")) + 2 for name in self.objects]
        rows = [("", self.objects)]
        for tool, values in zip(self.tools, self.averages[-1], strict=True):
            rows.append((tool, tuple(f"{value:.2f}" for value in values)))
        lines = [
            f"{name:<{first}}" + "".join(f"{c:>{w}}" for c, w in zip(cells, widths, strict=True))
            for name, cells in rows
        ]
        title = short("Pairs", self.title, f"{self.unit} for h = {self.horizon}")
        return "\n".join([title, *lines])

    @quietly
    def _repr_png_(self) -> bytes:
        """The picture, for notebooks."""
        from io import BytesIO

        picture = BytesIO()
        self.draw().savefig(picture, format="png", dpi="figure")
        return picture.getvalue()


MEASURES = ("range", "latency", "median_latency", "persistence", "reliability")
"""The measures of a pair besides its averages, by attribute name."""


@takes_old_keywords
def pairs(
    world: World,
    horizon: int,
    tools: Sequence[str | Tool | type] | None = None,
    objects: Sequence[str] | None = None,
    slip: float = 0.0,
    **options: Unpack[Options],
) -> Pairs:
    r"""Average object empowerment of an agent with each tool over each object, and how it comes.

    Of each pair, which is the world with that tool and that object alone, it also has range,
    latency, persistence and reliability; see `influence_range`, `latency`, `persistence` and
    `reliability` for what they are. A tool that could be put down on the map is held here.

    Args:
        world: the map.
        horizon: H, the largest number of actions, from 1 up.
        tools: names of the world's tools, or of others, or tools of one's own; "none" is the bare
            agent. By default the world's own and "none".
        objects: names of the world's objects; by default all.
        slip: as in `tabulate`; tools that may fail do so besides.
        **options: `method`, `unit`, `executor` and `show_progress`, as in `empowerment`.

    Returns:
        The values of all pairs.

    Raises:
        ValueError: no tools or objects, an unknown one, two of one name, a map that has no place
            for one, or as in `empowerment`.

    Example:
        >>> room = World.parse("D = ball\nG = goal of C\nA.P.\n..C.\n.D..\n...G")
        >>> found = pairs(room, horizon=2)
        >>> found.tools, found.objects
        (('picker', 'none'), ('can', 'ball'))
        >>> found.averages[-1].round(2)
        array([[0.81, 0.79],
               [0.41, 0.37]])
    """
    horizon = at_least_one("horizon", horizon)
    rows = with_each_tool(world, tools)
    columns = tuple(dict.fromkeys(_object_names(world) if objects is None else objects))
    if not columns:
        raise ValueError(f"no objects; name some of {', '.join(_object_names(world))}")
    alone = {
        (tool, object): held(armed.with_object(object))
        for tool, armed in rows.items()
        for object in columns
    }
    measured: dict[object, _Pair] = {}
    with progress_bar("pairs", options.get("show_progress", False)) as report:
        for done, pair in enumerate(alone.values()):
            report(done, len(alone))
            if (key := _dynamics(pair)) not in measured:
                measured[key] = _measured(pair, horizon, slip, options)
    bounds = bounds_of(options.get("method", Exact()))
    found = [[measured[_dynamics(alone[tool, object])] for object in columns] for tool in rows]
    values = {
        name: np.array([[getattr(one, name) for one in row] for row in found]) for name in MEASURES
    }
    return Pairs(
        tools=tuple(rows),
        objects=columns,
        averages=np.array([[one.averages for one in row] for row in found]).transpose(2, 0, 1),
        **values,
        unit=options.get("unit", "bits"),
        title=f"{world.name}: {bounds}average object empowerment",
    )


@dataclass(frozen=True)
class _Pair:
    """The results for one pair; see `Pairs`."""

    averages: Float64[np.ndarray, "horizons"]
    range: int
    latency: float
    median_latency: float
    persistence: float
    reliability: float


def _measured(pair: World, horizon: int, slip: float, options: Options) -> _Pair:
    from habilis.empowerment.tabular.persistence import persistence  # compiles

    show = options.get("show_progress", False)
    mdp = tabulate(certain(pair), show_progress=show)
    states = np.flatnonzero(compared_states(mdp))
    sure = bits = empowerment_by_horizon(mdp, horizon, "object", states=states, **options)
    if fails(pair, slip):  # the same states, and so in the same places
        noisy = tabulate(pair, slip, show_progress=show)
        bits = empowerment_by_horizon(noisy, horizon, "object", states=states, **options)
    least = first_above_nothing(bits)
    averages = bits.mean(axis=1)
    lasting = persistence(mdp, "object", states=states, show_progress=show).mean()
    return _Pair(
        averages=averages[1:],
        range=furthest(distances(mdp, "object", states), least),
        latency=float(least.min()),
        median_latency=float(np.median(least)),
        persistence=float(lasting * per_bit(options.get("unit", "bits"))),
        reliability=share(averages[-1], sure[-1].mean()),
    )


def _dynamics(pair: World) -> object:
    """The data that a pair's measures depend on: all placements, not the start."""
    tools = tuple((id(tool.rule), tool.slip, tool.reading) for tool in pair.tools)
    return tools, pair.objects[0].kind


def _object_names(world: World) -> list[str]:
    return [thing.name for thing in world.objects]


def _draw_matrix(ax: "Axes", found: Pairs) -> None:
    """Values in cells, the lighter the more."""
    from habilis.worlds.pictures.heatmap import HEAT, inks, scale_of

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


def _draw_curves(ax: "Axes", found: Pairs, place: int) -> None:
    """The averages over h of all tools for one object."""
    from matplotlib.ticker import MaxNLocator

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
