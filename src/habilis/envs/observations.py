"""What an agent is shown of a state of a table."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np
from jaxtyping import Int

from habilis.mdp import TabularMDP
from habilis.worlds.world import World

KINDS = ("factors", "onehot", "grid", "rgb")
CELL = 16
"""Pixels a cell of "rgb"."""

Show = Callable[[Any], np.ndarray]
"""From a state, or an array of them, to what is shown; states are the leading axes."""


@dataclass(frozen=True)
class Observation:
    """What is shown of a state.

    Attributes:
        space: of one observation.
        show: makes them, arrays of the caller's own.
    """

    space: gymnasium.Space
    show: Show


def observation(kind: str, mdp: TabularMDP, world: World) -> Observation:
    """What a world shows.

    Args:
        kind: "factors", the cells of agent, tool (where there is one) and object, each
            `row * columns + column`, `MultiDiscrete`; "onehot", the same as zeros and ones, uint8
            `[things * cells]`; "grid", uint8 `[channels, rows, columns]` with a channel each for
            walls, goal, agent, tool (where there is one) and object; "rgb", a picture of 16 pixels
            a cell, uint8 `[16 * rows, 16 * columns, 3]`.
        mdp: the world's table.
        world: the map.

    Raises:
        ValueError: no such kind.
    """
    cells = np.stack([mdp.factors[name] for name in mdp.factors], axis=1)
    if kind == "factors":
        return _labels(cells, [world.height * world.width] * cells.shape[1])
    if kind == "onehot":
        size = world.height * world.width
        return _marks(cells, np.zeros((cells.shape[1] * size,), np.uint8), size)
    if kind == "grid":
        still = np.zeros((2 + cells.shape[1], world.height, world.width), np.uint8)
        for cell in world.walls:
            still[0][cell] = 1
        still[1][world.goal] = 1
        size = world.height * world.width
        return _marks(cells, still, size, first=2)
    if kind == "rgb":
        return _pictures(mdp, world)
    raise ValueError(f"observation {kind!r} is unknown; use one of {', '.join(KINDS)}")


def ranks(mdp: TabularMDP) -> Observation:
    """The value of each factor, counted from 0 among those that it has, `MultiDiscrete`.

    A table without factors shows the state's index.
    """
    factors = list(mdp.factors.values()) or [np.arange(mdp.states)]
    ranked = [np.unique(labels, return_inverse=True) for labels in factors]
    labels = np.stack([places for _, places in ranked], axis=1)
    return _labels(labels, [len(values) for values, _ in ranked])


def _labels(labels: Int[np.ndarray, "S factors"], sizes: list[int]) -> Observation:
    wide = labels.astype(np.int64)

    def show(state: Any) -> np.ndarray:
        return wide[state].copy() if isinstance(state, int) else wide.take(state, axis=0)

    return Observation(gymnasium.spaces.MultiDiscrete(sizes), show)


def _marks(
    cells: Int[np.ndarray, "S things"], still: np.ndarray, size: int, first: int = 0
) -> Observation:
    """Ones at the things' cells over what never changes, a block of `size` for each thing."""
    at = cells + size * np.arange(first, first + cells.shape[1])

    def show(state: Any) -> np.ndarray:
        places = at[state]
        shown = np.empty((*places.shape[:-1], still.size), np.uint8)
        shown[...] = still.reshape(-1)
        np.put_along_axis(shown, places, 1, axis=-1)
        return shown.reshape(*places.shape[:-1], *still.shape)

    return Observation(gymnasium.spaces.Box(0, 1, still.shape, np.uint8), show)


def _pictures(mdp: TabularMDP, world: World) -> Observation:
    show = frames(mdp, world, CELL)
    shape = (CELL * world.height, CELL * world.width, 3)
    return Observation(gymnasium.spaces.Box(0, 255, shape, np.uint8), show)


def frames(mdp: TabularMDP, world: World, cell: int) -> Show:
    """Pictures of states, uint8 `[cell * rows, cell * columns, 3]`, of several with N in front."""
    from habilis.worlds.tiles import Tiles

    tiles = Tiles.of(world, cell)

    def show(states: Any) -> np.ndarray:
        cells = {name: labels[np.atleast_1d(states)] for name, labels in mdp.factors.items()}
        pictures = tiles.frames(cells["agent"], cells.get("tool"), cells["object"])
        return pictures if np.ndim(states) else pictures[0]

    return show
