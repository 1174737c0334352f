"""Pictures of a hand, its tool and a puck, from above, without a renderer."""

from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float64

from habilis.estimators.simulators.mujoco import imported
from habilis.estimators.simulators.scenes import Scene, disc
from habilis.robots.tools import HAND, PUCK
from habilis.worlds.pictures.shapes import (
    BLUE,
    GREEN,
    INK,
    ORANGE,
    PAPER,
    SKY,
    Drawing,
    Shape,
    polygon,
    rod,
)

if TYPE_CHECKING:
    from habilis.robots.pushing import PushingSimulator

ACROSS = 10
"""How many units of a picture the longer side of the puck's range is."""

_MARGIN = 1  # units around it
_WOOD, _GLEAM = "#9c6430", "#f6cf80"


def push_scene(
    simulator: "PushingSimulator",
    state: Float64[np.ndarray, "d"],
    goal: Float64[np.ndarray, "2"] | None = None,
) -> Scene:
    """The picture of a state.

    Walls and the hand's own shape are dark and blue, the tool is brown, the puck orange. Spheres,
    cylinders, capsules and boxes are drawn; other geoms are not.

    Args:
        simulator: the world.
        state: one.
        goal: of the puck, marked by a ring.

    Returns:
        A scene, which `save_picture` and `save_video` take. A unit is a tenth of the longer side
        of where the puck may be.

    Example:
        >>> from habilis.robots import PushingSimulator
        >>> simulator = PushingSimulator("reach.xml", "stick")
        >>> push_scene(simulator, simulator.placed([[0.0, 0.8]])[0]).caption
        'stick, puck at (0.00, 0.80)'
    """
    frame = Frame(simulator)
    data = _data(simulator, state)
    shapes = list(_shapes(simulator, data, frame))
    if goal is not None:
        x, y = frame.point(goal)
        ring = disc(GREEN, x, y, 0.5), disc(PAPER, x, y, 0.42)
        shapes = [*ring, *shapes]
    where = state[simulator.puck]
    caption = f"{simulator.tool}, puck at ({where[0]:.2f}, {where[1]:.2f})"
    return Scene(f"{simulator.tool} and puck", frame.height, frame.width, tuple(shapes), caption)


def still_shapes(simulator: "PushingSimulator") -> Drawing:
    """The shapes of the first state but for the puck, in the units of a picture."""
    data = _data(simulator, simulator.initial)
    return tuple(_shapes(simulator, data, Frame(simulator), puck=False))


class Frame:
    """Where points of the world are in a picture: y points down there.

    Attributes:
        width, height: of the picture, in its units.
        scale: units for a unit of length.
    """

    def __init__(self, simulator: "PushingSimulator"):
        """
        Args:
            simulator: the world, whose puck's ranges are inside the picture.
        """
        corners = [(x, y) for x in (0, 1) for y in (0, 1)]
        size = simulator.high - simulator.low
        places = np.array(
            [
                bodies_at(simulator, state)[1][:2]
                for state in simulator.placed(simulator.low + np.array(corners) * size)
            ]
        )
        self.low, high = places.min(axis=0), places.max(axis=0)
        self.scale = ACROSS / float((high - self.low).max())
        across, up = (high - self.low) * self.scale + 2 * _MARGIN
        self.width, self.height = int(np.ceil(across - 1e-6)), int(np.ceil(up - 1e-6))

    def point(self, place: Any) -> tuple[float, float]:
        """Where a point of the world is."""
        x, y = (np.asarray(place, np.float64)[:2] - self.low) * self.scale + _MARGIN
        return float(x), float(self.height - y)


def bodies_at(
    simulator: "PushingSimulator", state: Float64[np.ndarray, "d"]
) -> Float64[np.ndarray, "2 3"]:
    """Where hand and puck are.

    Args:
        simulator: the world.
        state: one.

    Returns:
        The origins of their bodies.
    """
    data = _data(simulator, state)
    return np.stack([data.xpos[simulator.model.body(name).id] for name in (HAND, PUCK)])


def _data(simulator: "PushingSimulator", state: Float64[np.ndarray, "d"]) -> Any:
    mujoco = imported()
    data = mujoco.MjData(simulator.model)
    mujoco.mj_setState(simulator.model, data, state, mujoco.mjtState.mjSTATE_PHYSICS)
    mujoco.mj_kinematics(simulator.model, data)
    return data


def _shapes(
    simulator: "PushingSimulator", data: Any, frame: Frame, puck: bool = True
) -> list[Shape]:
    """Geoms from above: still ones, then tools, hands, and the puck."""
    model = simulator.model
    mujoco = imported()
    roots = {HAND: model.body(HAND).id, PUCK: model.body(PUCK).id}
    found: dict[str, list[Shape]] = {"still": [], "tool": [], HAND: [], PUCK: []}
    for index in range(model.ngeom):
        body = int(model.geom_bodyid[index])
        name = model.geom(index).name
        owner = _owner(model, body, roots)
        if owner == HAND and name and not name.startswith(HAND):
            owner = "tool"
        fill = {"still": INK, "tool": _WOOD, HAND: BLUE, PUCK: ORANGE}[owner]
        kind, size = int(model.geom_type[index]), model.geom_size[index] * frame.scale
        place, axes = data.geom_xpos[index], data.geom_xmat[index].reshape(3, 3)
        middle = frame.point(place)
        if kind in (mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_CYLINDER):
            found[owner].append(disc(fill, *middle, float(size[0])))
            gleam = {HAND: SKY, PUCK: _GLEAM}.get(owner)
            if gleam is not None:
                x, y = middle
                found[owner].append(
                    disc(gleam, x - 0.25 * size[0], y - 0.25 * size[0], 0.3 * float(size[0]))
                )
        elif kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
            along = axes[:, 2] * model.geom_size[index, 1]
            ends = frame.point(place - along), frame.point(place + along)
            found[owner].append(rod(fill, 2 * float(size[0]), *ends))
        elif kind == mujoco.mjtGeom.mjGEOM_BOX:
            across, up = (axes[:, side] * model.geom_size[index, side] for side in (0, 1))
            corners = (across + up, across - up, -across - up, up - across)
            found[owner].append(polygon(fill, *(frame.point(place + one) for one in corners)))
    order = ("still", "tool", HAND, PUCK) if puck else ("still", "tool", HAND)
    return [shape for name in order for shape in found[name]]


def _owner(model: Any, body: int, roots: dict[str, int]) -> str:
    """Which of the two a body is fixed to, or "still"."""
    while body:
        for name, root in roots.items():
            if body == root:
                return name
        body = int(model.body_parentid[body])
    return "still"
