"""Pictures of a world: on Matplotlib axes, as files, as pixels, as coloured text.

A state is a `World` too, one with other start cells: `world.with_cells(agent=(1, 2))`.

In a plot the cell `(row, column)` covers x from `column` to `column + 1` and y from `row` to
`row + 1`, y pointing down. Everything is an area, so a picture is sharp at any size.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from io import StringIO
from itertools import groupby
from pathlib import Path
from typing import Any, Protocol, cast, get_args, runtime_checkable

import numpy as np
from jaxtyping import Float64, UInt8
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.transforms import AffineDeltaTransform
from rich.text import Text

from habilis.files import suffix_of, write_whole
from habilis.worlds.grid import STEPS
from habilis.worlds.map_text import AGENT, DOOR, FLOOR, GOAL, OBJECT, SECOND, TOOL, WALL
from habilis.worlds.pictures.shapes import (
    SHAPES,
    Drawing,
    Shape,
    Side,
    bin_with,
    facing,
    marked,
    of_kind,
    placed,
)
from habilis.worlds.tools import Tool, drawing_of
from habilis.worlds.world import Cell, World

_DPI = 96  # a web page's; and (n / 96) * 96 is exactly n in floating point: no pixel is lost
_CELL = 48  # pixels of a cell
_ACROSS = 4800  # pixels of a picture at most, unless someone asks for more
PICTURES = {  # by suffix: metadata that would make two files of one picture differ, removed
    ".png": {"Software": None},
    ".svg": {"Date": None},
    ".pdf": {"CreationDate": None},
}

_SIDES: dict[Cell, Side] = dict(zip(STEPS, get_args(Side), strict=True))

_STYLES = {  # by what a character stands for
    WALL: "#5b6270 on #5b6270",
    FLOOR: "dim",
    AGENT: "bold #ffffff on #0072b2",
    OBJECT: "bold #ffffff on #b34700",
    GOAL: "bold #ffffff on #007a59",
    TOOL: "bold #1f2430 on #f0c24b",
    SECOND: "bold #ffffff on #8f4a70",
    DOOR: "bold #ffffff on #7a4a20",
}


@runtime_checkable
class Drawn(Protocol):
    """A map with drawings of its own, which pictures take in the place of a world.

    Attributes:
        name: what messages call it.
        height, width: rows and columns of the map.
        walls: the wall cells.
    """

    @property
    def name(self) -> str: ...
    @property
    def height(self) -> int: ...
    @property
    def width(self) -> int: ...
    @property
    def walls(self) -> frozenset[Cell]: ...

    def drawings(self, agent: bool = True) -> list[Drawing]:
        """All but walls and floor, and the agent if need be, in the coordinates of the map."""
        ...

    def colored_text(self) -> Text:
        """The map in colours for a terminal: two characters a cell, one line a row."""
        ...


def draw_world(ax: Axes, world: World | Drawn, *, background: bool = True) -> None:
    """Draws a world in the state of its start cells.

    The tool in hand faces away from the agent. A can on its goal is in the bin; when something
    else is there, the bin is drawn small in its corner. Of several objects each has its picture on
    its bin, and of several of one kind each its colour.

    Args:
        ax: where to draw; its limits, aspect and frame are set to fit the world.
        world: what to draw.
        background: whether to draw the floor with its grid lines, or walls and things alone.
    """
    if isinstance(world, World):
        draw_map(ax, world, things_of(world, world.agent), background=background)
        return
    draw_map(ax, world, {}, background=background)
    draw_shapes(ax, world.drawings())


def draw_map(
    ax: Axes, world: World | Drawn, things: Mapping[Cell, Drawing], *, background: bool = True
) -> None:
    """Draws a map with any drawings in its cells (see `draw_world`)."""
    _fit(ax, world)
    if background:
        _draw_floor(ax, world)
    _draw_walls(ax, world)
    draw_shapes(ax, [_at(cell, drawing) for cell, drawing in things.items()])


def world_figure(world: World | Drawn, cell: int | None = None) -> Figure:
    """Draws a world.

    Args:
        world: the map, in any state; or a puzzle.
        cell: pixels per cell; by default 48, and fewer on maps of more than 100 cells across.

    Returns:
        A figure of `cell * width` by `cell * height` pixels.
    """
    cell = cell_size(max(world.width, world.height)) if cell is None else cell
    figure = new_figure(cell * world.width, cell * world.height)
    draw_world(figure.add_axes((0, 0, 1, 1)), world)
    return figure


def cell_size(across: int) -> int:
    """Pixels a cell, so that a map of so many cells across has a size that can be looked at."""
    return max(1, min(_CELL, _ACROSS // across))


def save_picture(world: World | Drawn, path: str | Path, cell: int | None = None) -> None:
    """Writes the picture of a world; the suffix says in which format.

    Args:
        world: what to draw, a world or a puzzle.
        path: ends with .png, .svg or .pdf.
        cell: pixels a cell; by default 48, and on maps of more than 100 cells across fewer.

    Raises:
        ValueError: another suffix; nothing is written.
    """
    suffix_of(path, PICTURES)
    save_figure(world_figure(world, cell), path)


def save_figure(figure: Figure, path: str | Path) -> None:
    """Writes a figure, the same figure always as the same bytes.

    Args:
        figure: any figure.
        path: ends with .png, .svg or .pdf.

    Raises:
        ValueError: another suffix; nothing is written.
    """
    suffix = suffix_of(path, PICTURES)
    how: Any = {"format": suffix[1:], "dpi": "figure", "metadata": PICTURES[suffix]}
    with rc_context({"svg.hashsalt": "habilis", "savefig.bbox": "standard"}):
        write_whole(path, lambda file: figure.savefig(file, **how))


def figure_svg(figure: Figure) -> str:
    """A figure as SVG text, the same figure always as the same."""
    file = StringIO()
    with rc_context({"svg.hashsalt": "habilis", "svg.fonttype": "none"}):
        figure.savefig(file, format="svg", metadata=PICTURES[".svg"])
    return file.getvalue()


def frame(world: World | Drawn, cell: int = 32) -> UInt8[np.ndarray, "height width 3"]:
    """The picture of a world as red, green and blue pixels, `cell` by `cell` of them a cell."""
    return _pixels(world_figure(world, cell))


def rendered(
    world: World, things: Mapping[Cell, Drawing], cell: int
) -> UInt8[np.ndarray, "height width 3"]:
    """A map with any drawings in its cells, as pixels."""
    figure = new_figure(cell * world.width, cell * world.height)
    draw_map(figure.add_axes((0, 0, 1, 1)), world, things)
    return _pixels(figure)


def _pixels(figure: Figure) -> UInt8[np.ndarray, "height width 3"]:
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()


def colored_text(world: World | Drawn) -> Text:
    """The map in colours for a terminal: two characters a cell, one line a row.

    The letters are those of the map's text; a G beside another letter is the goal under it. Of
    several tools the one in hand is underlined.
    """
    if not isinstance(world, World):
        return world.colored_text()
    marks = world.marks
    under = {mark.cell: mark for mark in marks if mark.role in (GOAL, DOOR)}
    above = {mark.cell: mark for mark in marks}
    held = world.in_hand
    in_hand = None if held < 0 or world.single else world.tools[held].cell
    rows = []
    for row in range(world.height):
        looks = []
        for column in range(world.width):
            cell = row, column
            there = above.get(cell)
            if there is None:
                plain = WALL if cell in world.walls else FLOOR
                looks.append((plain + " ", _STYLES[plain]))
                continue
            style = _STYLES[there.role]
            looks.append((there.character, f"{style} underline" if cell == in_hand else style))
            below = under.get(cell, there)
            hidden = below.role != there.role
            looks.append((below.character, _STYLES[below.role]) if hidden else (" ", style))
        text = Text()
        for style, run in groupby(looks, lambda look: look[1]):
            text.append("".join(part for part, _ in run), style)
        rows.append(text)
    return Text("\n").join(rows)


def new_figure(width: int, height: int) -> Figure:
    """An empty figure, its size in pixels."""
    return Figure(figsize=(width / _DPI, height / _DPI), dpi=_DPI)


def _fit(ax: Axes, world: World | Drawn) -> None:
    """One unit of the axes is a cell, and there is nothing around the map."""
    ax.set(xlim=(0, world.width), ylim=(world.height, 0), aspect="equal", xticks=[], yticks=[])
    ax.set_frame_on(False)


def _at(cell: Cell, drawing: Drawing) -> Drawing:
    row, column = cell
    return placed(drawing, float(column), float(row))


def draw_shapes(ax: Axes, drawings: Iterable[Drawing]) -> None:
    """Draws what is given in the coordinates of the axes."""
    shapes = [shape for drawing in drawings for shape in drawing]
    outlines = [shape.points for shape in shapes]
    colours = [shape.fill for shape in shapes]
    # Unsnapped: at few pixels a cell, snapping to whole pixels would swallow the grid lines.
    areas = PolyCollection(outlines, facecolors=colours, linewidths=0, snap=False)
    ax.add_collection(areas, autolim=False)


def _draw_floor(ax: Axes, world: World | Drawn) -> None:
    """Cells with their grid lines; each line is drawn across the whole map."""
    line, paper = SHAPES["floor"]
    half = paper.points[0][0]  # of a line's width
    right, bottom = float(world.width), float(world.height)

    def box(x0: float, y0: float, x1: float, y1: float, fill: str) -> Shape:
        x0, y0, x1, y1 = max(x0, 0.0), max(y0, 0.0), min(x1, right), min(y1, bottom)
        return Shape(((x0, y0), (x1, y0), (x1, y1), (x0, y1)), fill)

    down = [box(x - half, 0, x + half, bottom, line.fill) for x in range(world.width + 1)]
    across = [box(0, y - half, right, y + half, line.fill) for y in range(world.height + 1)]
    draw_shapes(ax, [(box(0, 0, right, bottom, paper.fill), *down, *across)])


def _draw_walls(ax: Axes, world: World | Drawn) -> None:
    cells = np.array(sorted(world.walls), float).reshape(-1, 2)
    for shape in SHAPES["wall"]:
        ax.add_collection(repeated(ax, shape, cells, facecolors=shape.fill), autolim=False)


def repeated(
    ax: Axes, shape: Shape, cells: Float64[np.ndarray, "n 2"], **looks: Any
) -> PolyCollection:
    """A shape in each of some cells (row, column), for axes: one outline, and where it is.

    However many cells there are, this is as quick to make as one, and its files stay small.
    """
    places = AffineDeltaTransform(cast("Any", ax.transData))
    outlines = [shape.points] if len(cells) else []  # Matplotlib 3.10 draws one without a place
    where: dict[str, Any] = {"offsets": cells[:, ::-1], "offset_transform": places}
    return PolyCollection(outlines, **where, linewidths=0, snap=False, **looks)


def things_of(world: World, agent: Cell | None) -> dict[Cell, Drawing]:
    """The things in the cells: bins, objects, tools, and the agent if it has a cell here."""
    things = dict(zip((thing.cell for thing in world.objects), object_drawings(world), strict=True))
    held = -1 if agent is None else world.in_hand
    for index, tool in enumerate(world.tools):
        things[tool.cell] = _tool(tool.rule, tool.cell, agent if index == held else None)
    if agent is not None:
        things[agent] = SHAPES["agent"]
    if world.second is not None:
        things[world.second] = SHAPES["second agent"]
    for door in world.doors:
        drawing = SHAPES["open door" if door.is_open else "door"]
        things[door.cell] = drawing + things.get(door.cell, ())
    for goal, its in bins(world).items():
        things[goal] = its.with_thing(things.get(goal))
    return things


def object_drawings(world: World) -> list[Drawing]:
    """How each of the objects looks."""
    kinds = [thing.kind for thing in world.objects]
    return [of_kind(kind, kinds[:place].count(kind)) for place, kind in enumerate(kinds)]


def tool_looks(rule: Tool) -> list[Drawing]:
    """How a tool looks: lying, then in hand to the north, east, south and west of the agent."""
    return [_tool(rule, (0, 0), None), *(_tool(rule, step, (0, 0)) for step in _SIDES)]


@dataclass(frozen=True)
class Bin:
    """The drawing of a goal.

    Attributes:
        own: the drawing of the object whose goal it is.
        labelled: whether that is on it.
    """

    own: Drawing
    labelled: bool

    def with_thing(self, thing: Drawing | None) -> Drawing:
        """The drawing in the goal's cell: with its object in it, or in a corner beside a thing."""
        if thing == self.own:
            return self._labelled(bin_with(self.own))
        empty = self._labelled(SHAPES["bin"])
        return empty if thing is None else thing + placed(empty, 0.56, 0.54, 0.44)

    def _labelled(self, drawing: Drawing) -> Drawing:
        return marked(drawing, self.own) if self.labelled else drawing


def bins(world: World) -> dict[Cell, Bin]:
    """The bins of a world by their cells."""
    drawings = zip(world.objects, object_drawings(world), strict=True)
    labelled = len(world.objects) > 1
    return {thing.goal: Bin(own, labelled) for thing, own in drawings if thing.goal is not None}


def _tool(tool: Tool, cell: Cell, agent: Cell | None) -> Drawing:
    """The tool facing away from the agent whose hand it is in, and as it is drawn otherwise."""
    drawing = drawing_of(tool)
    if agent is None:
        return drawing
    side = _SIDES.get((cell[0] - agent[0], cell[1] - agent[1]))
    return drawing if side is None else facing(drawing, side)
