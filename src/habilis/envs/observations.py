"""Observations of the states of a table."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np
from jaxtyping import Int64, UInt8

from habilis.mdp import HELD, TabularMDP
from habilis.worlds.placements import Factors
from habilis.worlds.rules import NONE
from habilis.worlds.world import World

if TYPE_CHECKING:
    from habilis.worlds.pictures.tiles import Tiles

KINDS = ("factors", "onehot", "grid", "rgb")
CELL = 16
"""Pixels a cell of "rgb"."""

Show = Callable[[Any], np.ndarray]
"""From a state, or an array of them, to observations; states are the leading axes."""


@dataclass(frozen=True)
class Observation:
    """Observations of states.

    Attributes:
        space: of one observation.
        show: makes them, arrays of the caller's own.
    """

    space: gymnasium.Space
    show: Show


def observation(kind: str, mdp: TabularMDP, world: World) -> Observation:
    """Observations of a world.

    Args:
        kind: "factors", the cells of agent, tool (where there is one) and object, each
            `row * columns + column`, `MultiDiscrete`; "onehot", the same as zeros and ones, uint8
            `[things * cells]`; "grid", uint8 `[channels, rows, columns]` with a channel each for
            walls, goal, agent, tool (where there is one) and object; "rgb", a picture of 16 pixels
            a cell, uint8 `[16 * rows, 16 * columns, 3]`.

            Of several things "factors" has all cells in the order of `mdp.factors`, then which
            tool is in hand, 0 for none, 1 for the first, and, where tools can be put down, in the
            same way which was and has not been left since. "grid" has a channel for each object's
            goal, for each thing, and one each for the cell of the tool in hand and of the one that
            was put down.
        mdp: the world's table.
        world: the map.

    Raises:
        ValueError: no such kind.
    """
    labels = cells(mdp, world)
    if kind == "factors":
        return _labels(labels)
    if kind == "onehot":
        return _marks(one_hot(labels))
    if kind == "grid":
        return _marks(grid(labels, world))
    if kind == "rgb":
        return _pictures(mdp, world)
    raise ValueError(f"observation {kind!r} is unknown; use one of {', '.join(KINDS)}")


def ranks(mdp: TabularMDP) -> Observation:
    """The value of each factor, counted from 0 among those that it has, `MultiDiscrete`.

    A table without factors shows the state's index.
    """
    return _labels(ranked(mdp))


@dataclass(frozen=True)
class Labels:
    """A number for each thing in each state.

    Attributes:
        of: int64[S, things].
        sizes: how many numbers there are for each thing.
    """

    of: Int64[np.ndarray, "S things"]
    sizes: list[int]


@dataclass(frozen=True)
class Marks:
    """Ones over a constant background.

    Attributes:
        at: int64[S, things], where a state has its ones, `still` laid flat.
        still: uint8, zeros and ones.
    """

    at: Int64[np.ndarray, "S things"]
    still: UInt8[np.ndarray, "*shape"]


def cells(mdp: TabularMDP, world: World) -> Labels:
    """The cells of a world's things, and of several what is in hand, from 0 for nothing."""
    hands = 1 + len(world.tools)
    sizes = [world.height * world.width if mdp.is_cell(name) else hands for name in mdp.factors]
    each = [mdp.factors[name] - (0 if mdp.is_cell(name) else NONE) for name in mdp.factors]
    return Labels(np.stack(each, axis=1).astype(np.int64), sizes)


def ranked(mdp: TabularMDP) -> Labels:
    """The factors of any table, each counted from 0 among the values that it has."""
    factors = list(mdp.factors.values()) or [np.arange(mdp.states)]
    found = [np.unique(labels, return_inverse=True) for labels in factors]
    each = np.stack([places for _, places in found], axis=1)
    return Labels(each.astype(np.int64), [len(values) for values, _ in found])


def one_hot(labels: Labels) -> Marks:
    """A block of zeros for each thing, and a one in it."""
    firsts = np.cumsum([0, *labels.sizes])
    return Marks(labels.of + firsts[:-1], np.zeros((firsts[-1],), np.uint8))


def grid(labels: Labels, world: World) -> Marks:
    """A channel each for walls, every goal, every thing, and what is or was in hand."""
    goals = [thing.goal for thing in world.objects if thing.goal is not None]
    below = 1 + len(goals)
    still = np.zeros((below + labels.of.shape[1], world.height, world.width), np.uint8)
    for cell in world.walls:
        still[0][cell] = 1
    for channel, goal in enumerate(goals, start=1):
        still[channel][goal] = 1
    firsts = world.height * world.width * np.arange(below, len(still))
    at = labels.of + firsts
    things = 1 + len(world.tools) + len(world.objects)
    tools = labels.of[:, 1 : 1 + len(world.tools)]
    for column in range(things, at.shape[1]):
        which = labels.of[:, column] - 1
        its = np.take_along_axis(tools, np.maximum(which, 0)[:, None], axis=1)[:, 0]
        # Where no tool is, there is a one less: the agent's again.
        at[:, column] = np.where(which < 0, at[:, 0], its + firsts[column])
    return Marks(at, still)


def _labels(labels: Labels) -> Observation:
    return Observation(gymnasium.spaces.MultiDiscrete(labels.sizes), partial(_labelled, labels.of))


def _marks(marks: Marks) -> Observation:
    space = gymnasium.spaces.Box(0, 1, marks.still.shape, np.uint8)
    return Observation(space, partial(_marked, marks.at, marks.still))


def _pictures(mdp: TabularMDP, world: World) -> Observation:
    show = frames(mdp, world, CELL)
    shape = (CELL * world.height, CELL * world.width, 3)
    return Observation(gymnasium.spaces.Box(0, 255, shape, np.uint8), show)


def frames(mdp: TabularMDP, world: World, cell: int) -> Show:
    """Pictures of states, uint8 `[cell * rows, cell * columns, 3]`, of several with N in front."""
    from habilis.worlds.pictures.tiles import Tiles

    of = Factors.of(world)
    names = ["agent"], of.tools, of.objects, [HELD] * (HELD in mdp.factors)
    each = [tuple(mdp.factors[name] for name in group) for group in names]
    return partial(_pictured, Tiles.of(world, cell), each)


# Functions inside others could not be pickled, and environments are.


def _labelled(of: Int64[np.ndarray, "S things"], state: Any) -> np.ndarray:
    return of[state].copy() if isinstance(state, int) else of.take(state, axis=0)


def _marked(
    at: Int64[np.ndarray, "S things"], still: UInt8[np.ndarray, "*shape"], state: Any
) -> np.ndarray:
    places = at[state]
    shown = np.empty((*places.shape[:-1], still.size), np.uint8)
    shown[...] = still.reshape(-1)
    np.put_along_axis(shown, places, 1, axis=-1)
    return shown.reshape(*places.shape[:-1], *still.shape)


def _pictured(tiles: "Tiles", factors: Sequence[tuple[np.ndarray, ...]], states: Any) -> np.ndarray:
    which = np.atleast_1d(states)
    (agent,), tools, objects, held = ([of[which] for of in group] for group in factors)
    pictures = tiles.laid(agent, tools, objects, held[0] if held else None)
    return pictures if np.ndim(states) else pictures[0]
