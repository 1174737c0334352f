"""The things of a world as drawings: filled outlines in a unit cell, and nothing else.

A renderer needs one idea only, the filled polygon: curves are sampled finely enough for cells of
several hundred pixels, and thick lines are outlines too, so they grow with the cell. `SHAPES` is
plain data that any renderer can read (`figures.py` here, `Shape.path` for a page).

Coordinates are `(x, y)` in units of a cell: x from 0 at the left to 1, y from 0 at the top to 1.
"""

from dataclasses import dataclass, replace
from math import atan2, cos, pi, sin
from typing import Literal

Point = tuple[float, float]
Side = Literal["north", "east", "south", "west"]


@dataclass(frozen=True)
class Shape:
    """A filled outline.

    Attributes:
        points: its corners `(x, y)` in order, not closed (the last is not the first again).
        fill: colour, as "#rrggbb".
    """

    points: tuple[Point, ...]
    fill: str

    @property
    def path(self) -> str:
        """The outline as the `d` attribute of an SVG `path`."""
        return "M" + "L".join(f"{x:.4g} {y:.4g}" for x, y in self.points) + "Z"


Drawing = tuple[Shape, ...]
"""Shapes from the back to the front."""


def placed(drawing: Drawing, x: float, y: float, size: float = 1.0) -> Drawing:
    """The drawing scaled to `size` cells, the top left corner of its cell at `(x, y)`."""
    return tuple(
        replace(shape, points=tuple((x + size * px, y + size * py) for px, py in shape.points))
        for shape in drawing
    )


def facing(drawing: Drawing, side: Side) -> Drawing:
    """A tool's drawing turned about the middle of its cell, its working end towards `side`.

    Tools are drawn with the working end to the south. A tool in hand faces away from the agent:
    `side` is the side of the agent that it is on.
    """
    turns = ("south", "west", "north", "east").index(side)
    for _ in range(turns):
        drawing = tuple(
            replace(shape, points=tuple((1 - y, x) for x, y in shape.points)) for shape in drawing
        )
    return drawing


def _arc(x: float, y: float, rx: float, ry: float, start: float, stop: float) -> tuple[Point, ...]:
    """Points on an ellipse about `(x, y)`, angles in quarter turns: 0 east, 1 south, 2 west."""
    steps = max(1, round(abs(stop - start) * 10))
    angles = [(start + (stop - start) * step / steps) * pi / 2 for step in range(steps + 1)]
    return tuple((x + rx * cos(angle), y + ry * sin(angle)) for angle in angles)


def _ellipse(fill: str, x: float, y: float, rx: float, ry: float) -> Shape:
    return Shape(_arc(x, y, rx, ry, 0.0, 4.0)[:-1], fill)


def _circle(fill: str, x: float, y: float, radius: float) -> Shape:
    return _ellipse(fill, x, y, radius, radius)


def polygon(fill: str, *points: Point) -> Shape:
    return Shape(points, fill)


def box(fill: str, left: float, top: float, right: float, bottom: float, r: float) -> Shape:
    """A box with corners rounded by radius `r`."""
    corners = (
        _arc(right - r, bottom - r, r, r, 0.0, 1.0),
        _arc(left + r, bottom - r, r, r, 1.0, 2.0),
        _arc(left + r, top + r, r, r, 2.0, 3.0),
        _arc(right - r, top + r, r, r, 3.0, 4.0),
    )
    return Shape(sum(corners, ()), fill)


def bow(
    fill: str, x: float, y: float, radius: float, width: float, start: float, stop: float
) -> Shape:
    """A thick arc with round ends, clockwise from `start` to `stop` quarter turns."""
    half = width / 2
    outer, inner = radius + half, radius - half
    first, *_, last = _arc(x, y, radius, radius, start, stop)
    outline = (
        _arc(x, y, outer, outer, start, stop),
        _arc(*last, half, half, stop, stop + 2.0),
        _arc(x, y, inner, inner, stop, start),
        _arc(*first, half, half, start + 2.0, start + 4.0),
    )
    return Shape(sum(outline, ()), fill)


def rod(fill: str, width: float, start: Point, end: Point) -> Shape:
    """A thick line with round ends."""
    (x0, y0), (x1, y1) = start, end
    along = atan2(y1 - y0, x1 - x0) / (pi / 2)
    half = width / 2
    caps = (
        _arc(x1, y1, half, half, along - 1.0, along + 1.0),
        _arc(x0, y0, half, half, along + 1.0, along + 3.0),
    )
    return Shape(sum(caps, ()), fill)


INK, WHITE, PAPER = "#1f2430", "#ffffff", "#f6f7f8"
# The main colours are Okabe and Ito's, which are distinguishable for every kind of colour vision.
ORANGE, GREEN, BLUE, RED = "#e69f00", "#009e73", "#0072b2", "#d55e00"
VIOLET = "#cc79a7"
LEAF, STRAW, YELLOW = "#00684c", "#c08414", "#f0c24b"
SILVER, STEEL = "#cfd6de", "#8a94a3"
SKY, WOOD = "#56b4e9", "#c98a4b"
_GLEAM_OF_CAN, _GLEAM_OF_BALL = "#ef8a4a", "#bfe3f7"

_FLOOR: Drawing = (
    polygon("#d2d6db", (0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)),
    polygon(PAPER, (0.013, 0.013), (0.987, 0.013), (0.987, 0.987), (0.013, 0.987)),
)
_PLATE: Drawing = (box(PAPER, 0.0, 0.0, 1.0, 1.0, 0.2),)
_WALL: Drawing = (
    # A little more than the cell, so that no light shows between neighbours.
    polygon("#1b1e24", (-0.01, -0.01), (1.01, -0.01), (1.01, 1.01), (-0.01, 1.01)),
    box("#2b2f38", 0.06, 0.06, 0.94, 0.94, 0.08),
)
_AGENT: Drawing = (
    box(INK, 0.475, 0.1, 0.525, 0.24, 0.02),  # antenna
    _circle(ORANGE, 0.5, 0.1, 0.065),
    box(INK, 0.1, 0.31, 0.9, 0.46, 0.06),  # ears
    box(INK, 0.31, 0.84, 0.46, 0.96, 0.05),  # feet
    box(INK, 0.54, 0.84, 0.69, 0.96, 0.05),
    box(STEEL, 0.17, 0.64, 0.3, 0.83, 0.06),  # arms
    box(STEEL, 0.7, 0.64, 0.83, 0.83, 0.06),
    box("#005f96", 0.27, 0.55, 0.73, 0.9, 0.1),  # body
    _circle(YELLOW, 0.5, 0.755, 0.055),
    box(BLUE, 0.16, 0.19, 0.84, 0.62, 0.15),  # head
    box("#eaf5fc", 0.23, 0.27, 0.77, 0.55, 0.11),  # face
    _ellipse(INK, 0.375, 0.385, 0.055, 0.07),  # eyes
    _ellipse(INK, 0.625, 0.385, 0.055, 0.07),
    _circle(WHITE, 0.39, 0.36, 0.02),
    _circle(WHITE, 0.64, 0.36, 0.02),
    bow(INK, 0.5, 0.415, 0.07, 0.032, 0.3, 1.7),  # smile
)
_PICKER: Drawing = (
    bow(STEEL, 0.5, 0.14, 0.15, 0.05, 0.1, 1.0),  # trigger
    rod(STEEL, 0.085, (0.5, 0.1), (0.5, 0.6)),  # shaft
    rod(ORANGE, 0.13, (0.5, 0.09), (0.75, 0.13)),  # grip
    bow(INK, 0.5, 0.76, 0.19, 0.08, -0.9, 0.55),  # jaws
    bow(INK, 0.5, 0.76, 0.19, 0.08, 1.45, 2.9),
    _circle(ORANGE, 0.623, 0.904, 0.064),  # their pads
    _circle(ORANGE, 0.377, 0.904, 0.064),
    _circle(INK, 0.5, 0.58, 0.095),  # hinge
    _circle(SILVER, 0.5, 0.58, 0.04),
)
_BROOM: Drawing = (
    box("#9c6430", 0.46, 0.02, 0.54, 0.55, 0.04),  # stick
    polygon(
        YELLOW, (0.37, 0.57), (0.63, 0.57), (0.75, 0.72), (0.83, 0.95), (0.17, 0.95), (0.25, 0.72)
    ),
    polygon(STRAW, (0.28, 0.95), (0.325, 0.8), (0.345, 0.95)),  # gaps between the bristles
    polygon(STRAW, (0.465, 0.95), (0.5, 0.77), (0.535, 0.95)),
    polygon(STRAW, (0.655, 0.95), (0.675, 0.8), (0.72, 0.95)),
    polygon(STRAW, (0.27, 0.695), (0.298, 0.66), (0.702, 0.66), (0.73, 0.695)),  # stitching
    box(RED, 0.35, 0.48, 0.65, 0.61, 0.05),  # collar
)
_RAKE: Drawing = (
    box("#9c6430", 0.46, 0.02, 0.54, 0.66, 0.04),  # handle
    box(INK, 0.14, 0.64, 0.86, 0.74, 0.04),  # bar
    *(rod(INK, 0.07, (x, 0.72), (x, 0.92)) for x in (0.18, 0.34, 0.5, 0.66, 0.82)),  # teeth
)
_STICK: Drawing = (
    rod("#9c6430", 0.13, (0.5, 0.12), (0.5, 0.84)),
    rod("#c98a4b", 0.035, (0.475, 0.2), (0.475, 0.62)),
    _circle("#9c6430", 0.5, 0.12, 0.1),  # knob
    box(INK, 0.4, 0.78, 0.6, 0.97, 0.06),  # foot
    box(RED, 0.41, 0.68, 0.59, 0.76, 0.03),  # ring above it
)
_MAGNET: Drawing = (  # a horseshoe, open to the south
    bow(RED, 0.5, 0.38, 0.23, 0.2, 2.0, 4.0),
    box(RED, 0.17, 0.36, 0.37, 0.68, 0.0),
    box(RED, 0.63, 0.36, 0.83, 0.68, 0.0),
    box(STEEL, 0.17, 0.68, 0.37, 0.93, 0.0),  # poles
    box(STEEL, 0.63, 0.68, 0.83, 0.93, 0.0),
    box(INK, 0.17, 0.66, 0.37, 0.71, 0.0),
    box(INK, 0.63, 0.66, 0.83, 0.71, 0.0),
)
_BALL: Drawing = (
    _circle(SKY, 0.5, 0.52, 0.35),
    bow(INK, 0.12, 0.52, 0.3, 0.045, -0.78, 0.78),  # seams
    bow(INK, 0.88, 0.52, 0.3, 0.045, 1.22, 2.78),
    _circle(_GLEAM_OF_BALL, 0.5, 0.31, 0.075),  # gleam
)
_CRATE: Drawing = (
    box("#7a4a20", 0.11, 0.13, 0.89, 0.91, 0.03),  # frame
    box(WOOD, 0.2, 0.22, 0.8, 0.82, 0.0),
    box("#7a4a20", 0.2, 0.41, 0.8, 0.44, 0.0),  # gaps between the boards
    box("#7a4a20", 0.2, 0.61, 0.8, 0.64, 0.0),
    rod("#7a4a20", 0.1, (0.25, 0.27), (0.75, 0.77)),  # brace
)
_TOOL: Drawing = (  # a spanner, for tools that say nothing of how they look
    bow(INK, 0.5, 0.17, 0.095, 0.07, 0.0, 4.0),  # ring
    polygon(VIOLET, (0.44, 0.27), (0.56, 0.27), (0.58, 0.6), (0.42, 0.6)),  # handle
    box("#8f4a70", 0.475, 0.31, 0.525, 0.54, 0.025),
    bow(INK, 0.5, 0.76, 0.155, 0.15, 1.55, 4.45),  # jaws
)
_CAN: Drawing = (
    _ellipse(STEEL, 0.5, 0.855, 0.19, 0.07),  # foot
    polygon(STEEL, (0.29, 0.22), (0.35, 0.13), (0.65, 0.13), (0.71, 0.22)),  # shoulder
    box(RED, 0.27, 0.2, 0.73, 0.86, 0.06),
    polygon("#fbe3d0", (0.27, 0.61), (0.27, 0.49), (0.73, 0.39), (0.73, 0.51)),  # band
    box(_GLEAM_OF_CAN, 0.33, 0.27, 0.38, 0.42, 0.025),  # gleam
    _ellipse(SILVER, 0.5, 0.14, 0.17, 0.055),  # top
    _ellipse(INK, 0.5, 0.14, 0.055, 0.02),
)
_TUB: Drawing = (
    polygon(
        GREEN, (0.23, 0.32), (0.77, 0.32), (0.71, 0.9), (0.66, 0.95), (0.34, 0.95), (0.29, 0.9)
    ),
    rod(LEAF, 0.05, (0.37, 0.46), (0.395, 0.82)),
    rod(LEAF, 0.05, (0.5, 0.46), (0.5, 0.82)),
    rod(LEAF, 0.05, (0.63, 0.46), (0.605, 0.82)),
)
_BIN: Drawing = (
    *_TUB,
    bow(LEAF, 0.5, 0.21, 0.085, 0.045, 2.0, 4.0),  # handle
    box(LEAF, 0.16, 0.22, 0.84, 0.34, 0.05),  # lid
)


def bin_with(thing: Drawing) -> Drawing:
    """The bin with a thing in it, of which the top is seen."""
    return (
        rod(LEAF, 0.09, (0.8, 0.33), (0.93, 0.07)),  # lid, swung open
        *placed(thing, 0.12, -0.05, 0.74),
        *_TUB,
        box(LEAF, 0.18, 0.3, 0.82, 0.38, 0.04),  # rim
    )


def marked(drawing: Drawing, thing: Drawing) -> Drawing:
    """A bin with the picture of a thing on it: whose bin it is."""
    return (*drawing, *placed((*_LABEL, *thing), 0.305, 0.47, 0.39))


_LABEL: Drawing = (box(PAPER, 0.02, 0.0, 0.98, 1.02, 0.16),)
# The colours that distinguish things of one kind, and their highlights.
_MAIN = {"can": (RED, _GLEAM_OF_CAN), "ball": (SKY, _GLEAM_OF_BALL), "crate": (WOOD, "")}
_OTHER_COLOURS = (
    (BLUE, "#5aa9d6"),
    (YELLOW, "#fae5ac"),
    (VIOLET, "#ebc6da"),
    (INK, "#6b7280"),
)


def of_kind(kind: str, before: int) -> Drawing:
    """An object's drawing: the first of a kind in its colour, further ones in others.

    Args:
        kind: of the object, as in `SHAPES`.
        before: how many of the kind come before it.
    """
    drawing = SHAPES[kind]
    if not before:
        return drawing
    other = _OTHER_COLOURS[(before - 1) % len(_OTHER_COLOURS)]
    recoloured = dict(zip(_MAIN[kind], other, strict=True))
    return tuple(replace(one, fill=recoloured.get(one.fill, one.fill)) for one in drawing)


_SECOND_AGENT: Drawing = tuple(
    replace(one, fill={BLUE: VIOLET, "#005f96": "#8f4a70", ORANGE: GREEN}.get(one.fill, one.fill))
    for one in _AGENT
)
_OPEN_DOOR: Drawing = (  # its posts
    box("#7a4a20", 0.0, 0.0, 0.12, 1.0, 0.02),
    box("#7a4a20", 0.88, 0.0, 1.0, 1.0, 0.02),
)
_DOOR: Drawing = (
    box(WOOD, 0.06, 0.04, 0.94, 0.96, 0.02),
    box("#7a4a20", 0.2, 0.14, 0.8, 0.45, 0.03),  # panels
    box("#7a4a20", 0.2, 0.55, 0.8, 0.86, 0.03),
    *_OPEN_DOOR,
    _circle(YELLOW, 0.78, 0.5, 0.055),  # knob
)

SHAPES: dict[str, Drawing] = {
    "floor": _FLOOR,
    "plate": _PLATE,
    "wall": _WALL,
    "agent": _AGENT,
    "second agent": _SECOND_AGENT,
    "door": _DOOR,
    "open door": _OPEN_DOOR,
    "picker": _PICKER,
    "broom": _BROOM,
    "rake": _RAKE,
    "stick": _STICK,
    "magnet": _MAGNET,
    "tool": _TOOL,
    "can": _CAN,
    "ball": _BALL,
    "crate": _CRATE,
    "bin": _BIN,
    "full bin": bin_with(_CAN),
}
"""The drawing of each thing by its name; "tool" is one that does not say how it looks."""
