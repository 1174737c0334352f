"""A world as SVG text, for notebooks: sharp, a few kilobytes, and drawn without Matplotlib."""

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from zlib import crc32

from habilis.worlds.pictures.figures import Drawn, things_of
from habilis.worlds.pictures.shapes import SHAPES, Drawing
from habilis.worlds.world import World

_CELL, _ACROSS = 32, 640  # pixels: of a cell, and of a picture at most
_SMALL, _STRIP = 14, 132  # the same of a picture in a strip
_MOST = 12  # pictures of a strip
_LARGEST = 10_000  # cells of a map that is drawn unasked


def world_svg(world: World | Drawn, cell: int = _CELL, across: int = _ACROSS) -> str | None:
    """A world, in the state of its start cells, or a puzzle.

    Args:
        world: what to draw.
        cell: pixels a cell, at most.
        across: pixels of the picture, at most.

    Returns:
        The text of an SVG; the same world always has the same. `None` of a map that is too large
        to be drawn unasked.
    """
    if world.height * world.width > _LARGEST:
        return None
    shared: dict[str, str] = {}
    uses = _uses(world, shared)
    return _svg(world, f"<defs>{''.join(shared.values())}</defs>{uses}", cell, across)


def strip_html(states: Mapping[int, World | Drawn], captions: Sequence[str]) -> str | None:
    """States side by side, each with a line below it; the outlines that they share come once.

    Args:
        states: to draw, in order, by their places in what they are of.
        captions: one for each place.
    """
    if any(state.height * state.width > _LARGEST for state in states.values()):
        return None
    shared: dict[str, str] = {}
    parts, before = [], -1
    for place, state in states.items():
        if place > before + 1:
            parts.append('<div style="align-self:center">…</div>')
        picture = _svg(state, _uses(state, shared), _SMALL, _STRIP)
        parts.append(
            '<div style="text-align:center;font-size:12px">'
            f"{picture}<div>{escape(captions[place])}</div></div>"
        )
        before = place
    return (
        '<div style="display:flex;flex-wrap:wrap;gap:8px">'
        f'<svg xmlns="http://www.w3.org/2000/svg" width="0" height="0" style="position:absolute">'
        f"<defs>{''.join(shared.values())}</defs></svg>{''.join(parts)}</div>"
    )


def chosen_places(count: int) -> list[int]:
    """The places of the states that a strip shows: all, or the first and last of many."""
    if count <= _MOST:
        return list(range(count))
    half = _MOST // 2
    return [*range(half), *range(count - half, count)]


def _svg(world: World | Drawn, content: str, cell: int, across: int) -> str:
    rows, columns = world.height, world.width
    size = min(cell, across / max(rows, columns))
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {columns} {rows}" role="img" '
        f'width="{size * columns:g}" height="{size * rows:g}">'
        f"<title>{escape(world.name)}</title>{content}</svg>"
    )


def _uses(world: World | Drawn, shared: dict[str, str]) -> str:
    """The picture of a world as uses of outlines, which are added to `shared`."""
    parts = [_use(_background(world, shared), shared, 0, 0)]
    if not isinstance(world, World):
        return "".join([*parts, *(_use(_paths(one), shared, 0, 0) for one in world.drawings())])
    for (row, column), drawing in things_of(world, world.agent).items():
        parts.append(_use(_paths(drawing), shared, column, row))
    return "".join(parts)


def _use(content: str, shared: dict[str, str], column: int, row: int) -> str:
    # All pictures of a page share their ids; made of the content, an id means the same in each.
    name = f"habilis-{crc32(content.encode()):08x}"
    shared[name] = f'<g id="{name}">{content}</g>'
    return f'<use href="#{name}" x="{column}" y="{row}"/>'


def _background(world: World | Drawn, shared: dict[str, str]) -> str:
    rows, columns = world.height, world.width
    line, paper = SHAPES["floor"]
    across = "".join(f"M0 {row}h{columns}" for row in range(rows + 1))
    down = "".join(f"M{column} 0v{rows}" for column in range(columns + 1))
    width = 2 * paper.points[0][0]
    floor = (
        f'<path d="M0 0h{columns}v{rows}h{-columns}z" fill="{paper.fill}"/>'
        f'<path d="{across}{down}" stroke="{line.fill}" stroke-width="{width:g}"/>'
    )
    walls = [  # all of a shape before all of the next, as they overlap
        _use(_paths((shape,)), shared, column, row)
        for shape in SHAPES["wall"]
        for row, column in sorted(world.walls)
    ]
    return floor + "".join(walls)


def _paths(drawing: Drawing) -> str:
    return "".join(
        f'<path d="{_outline(shape.points)}" fill="{escape(shape.fill)}"/>' for shape in drawing
    )


def _outline(points: Iterable[tuple[float, float]]) -> str:
    """To a thousandth of a cell, however far from the corner of the map."""
    return "M" + "L".join(f"{round(x, 3):g} {round(y, 3):g}" for x, y in points) + "Z"
