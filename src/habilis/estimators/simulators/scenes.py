"""Pictures of the states of simulators, in the way of worlds: one unit of length is one cell."""

from dataclasses import dataclass
from math import cos, sin
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float64

from habilis.worlds.pictures.shapes import (
    BLUE,
    INK,
    ORANGE,
    RED,
    SILVER,
    SKY,
    STEEL,
    Drawing,
    Point,
    Shape,
    bow,
    box,
    polygon,
    rod,
)

if TYPE_CHECKING:
    from rich.text import Text

State = Float64[np.ndarray, "d"]


@dataclass(frozen=True)
class Scene:
    """A state to draw: `save_picture`, `save_video` and notebooks take it as they take a world.

    Attributes:
        name: of the simulator.
        height, width: of the picture, in units of length.
        shapes: what is drawn, from back to front, y pointing down.
        caption: the state in words.
    """

    name: str
    height: int
    width: int
    shapes: Drawing
    caption: str

    @property
    def walls(self) -> frozenset[tuple[int, int]]:
        """None: a scene draws its own."""
        return frozenset()

    def drawings(self, agent: bool = True) -> list[Drawing]:
        """All shapes.

        Args:
            agent: has no part in it.

        Returns:
            One drawing.
        """
        return [self.shapes]

    def colored_text(self) -> "Text":
        """The caption, for terminals."""
        from rich.text import Text

        return Text(self.caption)


def disc(fill: str, x: float, y: float, radius: float) -> Shape:
    """A filled circle."""
    turns = np.linspace(0, 2 * np.pi, 41)[:-1]
    return polygon(fill, *((x + radius * cos(turn), y + radius * sin(turn)) for turn in turns))


def arrow(start: Point, along: Point) -> Drawing:
    """A velocity as an arrow; nothing where it is too small to be seen."""
    length = float(np.hypot(*along))
    if length < 0.1:
        return ()
    (x, y), (u, v) = start, (along[0] / length, along[1] / length)
    tip = x + along[0], y + along[1]
    neck = tip[0] - 0.16 * u, tip[1] - 0.16 * v
    return (
        rod(RED, 0.05, start, neck),
        polygon(
            RED, tip, (neck[0] - 0.1 * v, neck[1] + 0.1 * u), (neck[0] + 0.1 * v, neck[1] - 0.1 * u)
        ),
    )


def pendulum(state: State, length: float, name: str) -> Scene:
    """A rod with a mass at its end, angle 0 upright, and an arc for the velocity."""
    angle, velocity = float(state[0]), float(state[1])
    across = max(3, int(np.ceil(2 * length + 0.6)))
    middle = across / 2
    end = middle + length * sin(angle), middle - length * cos(angle)
    shapes: Drawing = (
        disc(SILVER, middle, middle, 0.2),
        rod(STEEL, 0.12, (middle, middle), end),
        disc(INK, middle, middle, 0.09),
        disc(ORANGE, *end, 0.18),
    )
    turn = float(np.clip(velocity / 8, -1, 1))  # quarter turns
    if abs(turn) > 0.05:
        first = angle / (np.pi / 2) - 1  # of `bow`: 0 east, clockwise
        ends = sorted((first, first + turn))
        shapes += (bow(RED, middle, middle, 0.45, 0.06, *ends),)
    caption = f"angle {angle:.2f} rad, velocity {velocity:.2f} rad/s"
    return Scene(name, across, across, shapes, caption)


def cart_pole(state: State, half_length: float, limit: float, name: str) -> Scene:
    """A cart on a track with a pole, angle 0 upright."""
    x, velocity, angle, turning = (float(one) for one in state)
    across, height = int(2 * np.ceil(limit + 0.6)), 3
    middle, track = across / 2, 2.2
    foot = middle + x, track - 0.3
    tip = foot[0] + 2 * half_length * sin(angle), foot[1] - 2 * half_length * cos(angle)
    shapes: Drawing = (
        box(STEEL, middle - limit, track + 0.14, middle + limit, track + 0.2, 0.0),
        *(
            box(
                INK,
                middle + side * limit - 0.04,
                track - 0.1,
                middle + side * limit + 0.04,
                track + 0.2,
                0.02,
            )
            for side in (-1, 1)
        ),
        *(disc(INK, foot[0] + side * 0.25, track + 0.06, 0.09) for side in (-1, 1)),
        box(BLUE, foot[0] - 0.42, track - 0.3, foot[0] + 0.42, track, 0.06),
        *arrow((foot[0], track - 0.15), (0.4 * velocity, 0.0)),
        rod(ORANGE, 0.12, foot, tip),
        disc(INK, *foot, 0.07),
    )
    caption = f"cart {x:.2f} m, {velocity:.2f} m/s, pole {angle:.2f} rad, {turning:.2f} rad/s"
    return Scene(name, height, across, shapes, caption)


def double_integrator(state: State, limit: float, name: str) -> Scene:
    """A cart on a line, and an arrow for its velocity."""
    x, velocity = float(state[0]), float(state[1])
    across = int(2 * np.ceil(limit + 0.5))
    middle = across / 2
    shapes: Drawing = (
        box(STEEL, 0.0, 1.24, float(across), 1.3, 0.0),
        box(INK, middle - 0.02, 1.18, middle + 0.02, 1.36, 0.0),
        *(disc(INK, middle + x + side * 0.22, 1.16, 0.08) for side in (-1, 1)),
        box(BLUE, middle + x - 0.36, 0.75, middle + x + 0.36, 1.1, 0.06),
        *arrow((middle + x, 0.6), (velocity, 0.0)),
    )
    caption = f"position {x:.2f} m, velocity {velocity:.2f} m/s"
    return Scene(name, 2, across, shapes, caption)


def ball_in_box(state: State, size: float, radius: float, name: str) -> Scene:
    """A ball between four walls, seen from above, and an arrow for its velocity; y points up."""
    x, y, u, v = (float(one) for one in state)
    across = int(np.ceil(size)) + 1
    edge = (across - size) / 2
    far = across - edge
    walls = (
        (0.0, 0.0, across, edge),
        (0.0, far, across, across),
        (0.0, 0.0, edge, across),
        (far, 0.0, across, across),
    )
    place = edge + x, far - y
    shapes: Drawing = (
        *(box(INK, *wall, 0.0) for wall in walls),
        disc(SKY, *place, radius),
        disc("#bfe3f7", place[0] - 0.3 * radius, place[1] - 0.3 * radius, 0.25 * radius),
        *arrow(place, (0.5 * u, -0.5 * v)),
    )
    caption = f"ball at ({x:.2f}, {y:.2f}) m, velocity ({u:.2f}, {v:.2f}) m/s"
    return Scene(name, across, across, shapes, caption)
