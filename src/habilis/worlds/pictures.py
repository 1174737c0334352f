"""Pictures of a world: on Matplotlib axes, as files, as pixels, as coloured text.

A state is a `World` too, one with other start cells: `replace(world, agent=(1, 2))`.

In a plot the cell `(row, column)` covers x from `column` to `column + 1` and y from `row` to
`row + 1`, y pointing down. Everything is an area, so a picture is sharp at any size.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from pathlib import Path

import numpy as np
from jaxtyping import Float, UInt8
from matplotlib import colormaps, rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from PIL import Image
from rich.text import Text

from habilis.worlds.shapes import SHAPES, Drawing, Side, facing, placed
from habilis.worlds.tools import TOOLS
from habilis.worlds.world import AGENT, FLOOR, GOAL, NO_TOOL, OBJECT, WALL, Cell, World

_DPI = 96  # a web page's; and (n / 96) * 96 is exactly n in floating point: no pixel is lost
_METADATA = {  # what would tell apart two files of one picture, left out
    ".png": {"Software": None},
    ".svg": {"Date": None},
    ".pdf": {"CreationDate": None},
}
_LAST_FRAME = 6  # how many times longer a film stays on its last frame

_SIDES: dict[Cell, Side] = {(-1, 0): "north", (0, 1): "east", (1, 0): "south", (0, -1): "west"}

# Without its dark end, which would look like wall.
_HEAT = ListedColormap(colormaps["viridis"](np.linspace(0.2, 1, 256)), name="heat")
_HALFWAY = 0.179  # the luminance on which black and white contrast alike

_STYLES = {
    WALL: "#5b6270 on #5b6270",
    FLOOR: "dim",
    AGENT: "bold #ffffff on #0072b2",
    OBJECT: "bold #ffffff on #b34700",
    GOAL: "bold #ffffff on #007a59",
    **{tool.character: "bold #1f2430 on #f0c24b" for tool in TOOLS.values()},
}


def draw_world(ax: Axes, world: World, *, background: bool = True) -> None:
    """Draws a world in the state of its start cells.

    A tool beside the agent is in hand and faces away from it. A can on the goal is in the bin;
    when something else is there, the bin is drawn small in its corner.

    Args:
        ax: where to draw; its limits, aspect and frame are set to fit the world.
        world: what to draw.
        background: whether to draw the floor with its grid lines, or walls and things alone.
    """
    _draw_map(ax, world, _things(world, world.agent), background=background)


def _draw_map(
    ax: Axes, world: World, things: Mapping[Cell, Drawing], *, background: bool = True
) -> None:
    _fit(ax, world)
    if background:
        _draw_floor(ax, world)
    _draw_walls(ax, world)
    _draw(ax, [_at(cell, drawing) for cell, drawing in things.items()])


def world_figure(world: World, cell: int = 48) -> Figure:
    """The picture of a world as a figure of `cell * width` by `cell * height` pixels."""
    figure = _figure(cell * world.width, cell * world.height)
    draw_world(figure.add_axes((0, 0, 1, 1)), world)
    return figure


def save_picture(world: World, path: str | Path, cell: int = 48) -> None:
    """Writes the picture of a world; the suffix says in which format.

    Args:
        world: what to draw.
        path: ends with .png, .svg or .pdf.
        cell: pixels a cell.

    Raises:
        ValueError: another suffix; nothing is written.
    """
    save_figure(world_figure(world, cell), path)


def save_figure(figure: Figure, path: str | Path) -> None:
    """Writes a figure, the same figure always as the same bytes.

    Args:
        figure: any figure.
        path: ends with .png, .svg or .pdf.

    Raises:
        ValueError: another suffix; nothing is written.
    """
    suffix = _suffix(path, _METADATA)
    with rc_context({"svg.hashsalt": "habilis", "savefig.bbox": "standard"}):
        figure.savefig(path, format=suffix[1:], dpi="figure", metadata=_METADATA[suffix])


def frame(world: World, cell: int = 32) -> UInt8[np.ndarray, "height width 3"]:
    """The picture of a world as red, green and blue pixels, `cell` by `cell` of them a cell."""
    return rendered(world, _things(world, world.agent), cell)


def rendered(
    world: World, things: Mapping[Cell, Drawing], cell: int
) -> UInt8[np.ndarray, "height width 3"]:
    """A map with any drawings in its cells, as pixels."""
    figure = _figure(cell * world.width, cell * world.height)
    _draw_map(figure.add_axes((0, 0, 1, 1)), world, things)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()


def save_gif(
    worlds: Sequence[World], path: str | Path, cell: int = 32, milliseconds: int = 250
) -> None:
    """Writes states of one world as a film that repeats, after a rest on the last of them.

    Args:
        worlds: the states in order; equal neighbours share a frame that stays on for both.
        path: ends with .gif.
        cell: pixels a cell.
        milliseconds: how long a state stays on.

    Raises:
        ValueError: another suffix, or no states; nothing is written.
    """
    _suffix(path, [".gif"])
    if not worlds:
        raise ValueError(f"{path}: a film of no states; give at least one")
    frames = [frame(world, cell) for world in worlds]
    # One palette, so that still things do not flicker; the ends have all the colours there are.
    ends = Image.fromarray(np.concatenate([frames[0], frames[-1]]))
    palette = ends.quantize(method=Image.Quantize.FASTOCTREE)
    first, *rest = (
        Image.fromarray(pixels).quantize(palette=palette, dither=Image.Dither.NONE)
        for pixels in frames
    )
    durations = [milliseconds] * len(rest) + [_LAST_FRAME * milliseconds]
    first.save(path, format="GIF", save_all=True, append_images=rest, duration=durations, loop=0)


def draw_landscape(
    ax: Axes,
    world: World,
    values: Float[np.ndarray, "rows columns"],
    *,
    vmin: float | None = None,
    vmax: float | None = None,
    labels: bool = True,
    title: str | None = None,
    agent: bool = False,
) -> ScalarMappable:
    """Draws a value for every cell as a heat map, with the walls, the bin, the can and the tool.

    Args:
        ax: where to draw, in its final size (the labels' font is chosen to fit it).
        world: the map, and where can and tool are.
        values: in bits; NaN where there is none (walls, the cells of the can and the tool).
        vmin, vmax: the ends of the colour scale; by default those of the values.
        labels: whether to print the values, to one decimal.
        title: stands above the map.
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
    _fit(ax, world)
    _draw_floor(ax, world)
    _draw_walls(ax, world)
    valued = [(int(row), int(column)) for row, column in np.argwhere(np.isfinite(values))]
    heat = PolyCollection(
        [_at(cell, SHAPES["floor"])[-1].points for cell in valued],  # less their grid lines
        cmap=_HEAT,
        linewidths=0,
        snap=False,
    )
    heat.set_array(np.array([values[cell] for cell in valued]))
    heat.set_clim(vmin, vmax)
    heat.autoscale_None()
    ax.add_collection(heat, autolim=False)
    labelled = valued if labels else []
    things = _things(world, world.agent if agent else None)
    _draw(ax, [_small_at(cell, things[cell], above_label=cell in labelled) for cell in things])
    size = _cell_points(ax, world)
    for cell in labelled:
        row, column = cell
        middle, part = (0.81, 0.22) if cell in things else (0.5, 0.32)
        ax.text(
            column + 0.5,
            row + middle,
            f"{values[cell]:z.1f}",
            fontsize=part * size,
            color=_ink(np.array(_HEAT(heat.norm(values[cell])))),
            ha="center",
            va="center_baseline",
        )
    if title is not None:
        ax.set_title(title)
    return heat


def landscape_figure(
    world: World,
    panels: Mapping[str, Float[np.ndarray, "rows columns"]],
    cell: int = 48,
    unit: str = "bits",
) -> Figure:
    """Landscapes side by side, with one colour scale and a bar for it.

    Args:
        world: the map, and where can and tool are.
        panels: the values of each landscape (see `draw_landscape`) by its title.
        cell: pixels a cell.
        unit: stands at the colour scale.

    Raises:
        ValueError: there are no panels, or values do not have the map's shape.
    """
    if not panels:
        raise ValueError(f"{world.name}: a figure of no landscapes; give at least one")
    finite = np.concatenate([values[np.isfinite(values)] for values in panels.values()])
    vmin = float(finite.min()) if finite.size else 0.0
    vmax = float(finite.max()) if np.unique(finite).size > 1 else vmin + 1  # a scale needs two ends
    gap, head, bar_width, bar_label = 24, 36, 16, 64  # pixels
    map_width, map_height = cell * world.width, cell * world.height
    width = gap + len(panels) * (map_width + gap) + bar_width + bar_label
    height = head + map_height + gap
    figure = _figure(width, height)

    def column(left: int, across: int) -> Axes:
        box = (left / width, gap / height, across / width, map_height / height)
        return figure.add_axes(box)

    heats = []
    for number, (name, values) in enumerate(panels.items()):
        ax = column(gap + number * (map_width + gap), map_width)
        heats.append(draw_landscape(ax, world, values, vmin=vmin, vmax=vmax, title=name))
    bar_ax = column(width - bar_label - bar_width, bar_width)
    draw_scale(figure, heats[0], bar_ax, unit)
    return figure


def draw_scale(figure: Figure, heat: ScalarMappable, ax: Axes, label: str) -> None:
    """Draws the colour scale of a landscape."""
    bar = figure.colorbar(heat, cax=ax, label=label)
    bar.outline.set_visible(False)
    if bar.solids is not None:
        bar.solids.set(rasterized=False, edgecolor="face")  # an SVG of areas, no image in it


def colored_text(world: World) -> Text:
    """The map in colours for a terminal: two characters a cell, one line a row.

    The letters are those of the map's text; a G beside another letter is the goal under it.
    """
    rows = []
    for row, line in enumerate(world.text().splitlines()):
        text = Text()
        for column, character in enumerate(line):
            beside = GOAL if (row, column) == world.goal and character != GOAL else " "
            text.append(character, _STYLES[character])
            text.append(beside, _STYLES[character if beside == " " else beside])
        rows.append(text)
    return Text("\n").join(rows)


def _suffix(path: str | Path, known: Iterable[str]) -> str:
    suffix = Path(path).suffix.lower()
    if suffix not in known:
        raise ValueError(
            f"{path}: unknown picture suffix {suffix!r}; let the name end with {', '.join(known)}"
        )
    return suffix


def _figure(width: int, height: int) -> Figure:
    """An empty figure, its size in pixels."""
    return Figure(figsize=(width / _DPI, height / _DPI), dpi=_DPI)


def _fit(ax: Axes, world: World) -> None:
    """One unit of the axes is a cell, and there is nothing around the map."""
    ax.set(xlim=(0, world.width), ylim=(world.height, 0), aspect="equal", xticks=[], yticks=[])
    ax.set_frame_on(False)


def _at(cell: Cell, drawing: Drawing) -> Drawing:
    row, column = cell
    return placed(drawing, float(column), float(row))


def _small_at(cell: Cell, drawing: Drawing, *, above_label: bool) -> Drawing:
    """The drawing on a plate with space around it, or in the upper part of the cell."""
    row, column = cell
    left, top, size = (0.2, 0.05, 0.6) if above_label else (0.1, 0.1, 0.8)
    return placed(SHAPES["plate"] + drawing, column + left, row + top, size)


def _draw(ax: Axes, drawings: Iterable[Drawing]) -> None:
    shapes = [shape for drawing in drawings for shape in drawing]
    outlines = [shape.points for shape in shapes]
    colours = [shape.fill for shape in shapes]
    # Unsnapped: at few pixels a cell, snapping to whole pixels would swallow the grid lines.
    areas = PolyCollection(outlines, facecolors=colours, linewidths=0, snap=False)
    ax.add_collection(areas, autolim=False)


def _draw_floor(ax: Axes, world: World) -> None:
    cells = product(range(world.height), range(world.width))
    _draw(ax, [_at(cell, SHAPES["floor"]) for cell in cells])


def _draw_walls(ax: Axes, world: World) -> None:
    _draw(ax, [_at(cell, SHAPES["wall"]) for cell in sorted(world.walls)])


def _cell_points(ax: Axes, world: World) -> float:
    """The size of a cell in typographic points."""
    box = ax.get_window_extent()
    return min(box.width / world.width, box.height / world.height) * 72 / ax.figure.dpi


def _ink(background: Float[np.ndarray, "rgba"]) -> str:
    """Black or white, whichever has the higher contrast (as WCAG 2 defines it)."""
    part = background[:3]
    linear = np.where(part <= 0.04045, part / 12.92, ((part + 0.055) / 1.055) ** 2.4)
    return "black" if linear @ (0.2126, 0.7152, 0.0722) > _HALFWAY else "white"


def _things(world: World, agent: Cell | None) -> dict[Cell, Drawing]:
    """What stands in the cells: bin, can, tool, and the agent if it has a cell here."""
    things = {world.object: SHAPES["can"]}
    if world.tool != NO_TOOL and world.tool_cell is not None:
        things[world.tool_cell] = _tool(world.tool, world.tool_cell, agent)
    if agent is not None:
        things[agent] = SHAPES["agent"]
    things[world.goal] = on_goal(things.get(world.goal))
    return things


def looks(world: World) -> dict[str, Drawing]:
    """How things can look in a cell of the world: "agent", "can", and with a tool "tool".

    The tool in hand looks otherwise on each side of the agent: "north", "east", "south", "west".
    """
    things = {"agent": SHAPES["agent"], "can": SHAPES["can"]}
    if world.tool != NO_TOOL:
        things["tool"] = _tool(world.tool, (0, 0), None)
        things |= {side: _tool(world.tool, step, (0, 0)) for step, side in _SIDES.items()}
    return things


def on_goal(thing: Drawing | None) -> Drawing:
    """What is seen in the goal cell: the bin, with the can in it, or in a corner beside a thing."""
    if thing is None:
        return SHAPES["bin"]
    if thing == SHAPES["can"]:
        return SHAPES["full bin"]
    return thing + placed(SHAPES["bin"], 0.56, 0.54, 0.44)


def _tool(name: str, cell: Cell, agent: Cell | None) -> Drawing:
    """The tool facing away from the agent when it is in hand, and as it is drawn otherwise."""
    if agent is None:
        return SHAPES[name]
    side = _SIDES.get((cell[0] - agent[0], cell[1] - agent[1]))
    return SHAPES[name] if side is None else facing(SHAPES[name], side)
