"""Where the puck is put: one definition for averages, landscapes and comparisons."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int64

from habilis.empowerment.arguments import at_least_one, whole_number
from habilis.estimators.simulators.mujoco import imported
from habilis.robots.pushing import PushingSimulator
from habilis.robots.tools import PUCK

_TRIES = 20  # draws in a square before it is left out


@dataclass(frozen=True, eq=False)
class Placements:
    """Positions of the puck, all else as the model begins.

    The ranges of the puck's joints are divided into `side * side` squares. In each one position is
    drawn uniformly, until the puck touches nothing there, whichever tool is in the hand; a square
    in which twenty draws find none is left out. So each placement is free with every tool, and an
    average over placements is one over the free part of the table.

    Attributes:
        positions: float64[n, 2], of the puck's joints.
        squares: int64[n, 2], column and row of the square of each, from the low ends.
        side: how many squares there are along each joint.
        low, high: float64[2], the ranges.
    """

    positions: Float64[np.ndarray, "n 2"]
    squares: Int64[np.ndarray, "n 2"]
    side: int
    low: Float64[np.ndarray, "2"]
    high: Float64[np.ndarray, "2"]


def puck_placements(
    simulators: Sequence[PushingSimulator], side: int = 8, seed: int = 0
) -> Placements:
    """Draws placements that are free in all of some simulators.

    Args:
        simulators: of one model, one for each tool.
        side: how many squares along each of the puck's joints, from 1 up.
        seed: of the draws, from 0 up.

    Returns:
        At most `side * side` placements.

    Raises:
        ValueError: none is free, or an argument is out of its range.

    Example:
        >>> tools = [PushingSimulator("reach.xml", tool) for tool in ("none", "hook")]
        >>> len(puck_placements(tools, side=4).positions)
        16
    """
    side, seed = at_least_one("side", side), whole_number("seed", seed)
    generator = np.random.default_rng(seed)
    low, high = simulators[0].low, simulators[0].high
    squares = np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 2)
    drawn = generator.random((_TRIES, len(squares), 2))
    tried = low + (squares + drawn) / side * (high - low)
    free = np.ones((_TRIES, len(squares)), bool)
    for simulator in simulators:
        free &= _free(simulator, tried.reshape(-1, 2)).reshape(free.shape)
    found = free.any(axis=0)
    if not found.any():
        raise ValueError(
            "the puck touches something wherever it is put; widen the ranges of its joints"
        )
    first = free.argmax(axis=0)
    positions = tried[first, np.arange(len(squares))]
    return Placements(positions[found], squares[found], side, low, high)


def _free(
    simulator: PushingSimulator, positions: Float64[np.ndarray, "n 2"]
) -> Bool[np.ndarray, "n"]:
    """Whether the puck touches nothing at positions."""
    mujoco, model = imported(), simulator.model
    data, puck = mujoco.MjData(model), model.body(PUCK).id
    found = np.zeros(len(positions), bool)
    for index, state in enumerate(simulator.placed(positions)):
        mujoco.mj_setState(model, data, state, mujoco.mjtState.mjSTATE_PHYSICS)
        mujoco.mj_forward(model, data)
        contacts = data.contact
        bodies = model.geom_bodyid[np.asarray(contacts.geom).reshape(-1, 2)]
        touching = (bodies == puck).any(axis=1) & (np.asarray(contacts.dist) < 0)
        found[index] = not touching.any()
    return found
