"""How soon, from how far and how surely an agent has any influence on an object.

The measures are ours. An agent has influence within h actions where its h-step empowerment over
the object is above 0: where it has any choice of what becomes of it.
"""

from dataclasses import replace
from typing import Unpack

import numpy as np
from jaxtyping import Float64, Int64
from numpy.typing import ArrayLike

from habilis.analysis.averages import NOTHING, average_empowerment, compared_states, held
from habilis.empowerment.api import Options
from habilis.empowerment.horizons import empowerment_until_repeated
from habilis.empowerment.old_keywords import takes_old_keywords
from habilis.empowerment.sensors import Sensor
from habilis.mdp import TabularMDP
from habilis.worlds.table import tabulate
from habilis.worlds.world import World


@takes_old_keywords
def latency(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor = "object",
    actions: ArrayLike | None = None,
    states: ArrayLike | None = None,
    **options: Unpack[Options],
) -> Float64[np.ndarray, "n"]:
    """The least number of actions with which the agent has any influence.

    The measure is ours:

        L(s) = min {h : E_h(s) > 0}

    Args:
        mdp: the table.
        horizon: the largest h that is tried.
        sensor, actions, states: as in `empowerment`.
        **options: `method`, `unit`, `executor` and `show_progress`, as in `empowerment`.

    Returns:
        float64[n], infinity where no h up to the horizon has any.

    Raises:
        ValueError: as in `empowerment`.

    Example:
        >>> line = TabularMDP.deterministic([[1, 1], [2, 3], [2, 2], [3, 3]])
        >>> latency(line, 5, "state")
        array([ 2.,  1., inf, inf])
    """
    return first_above_nothing(
        empowerment_until_repeated(mdp, horizon, sensor, actions, states, **options)
    )


def first_above_nothing(bits: Float64[np.ndarray, "k n"]) -> Float64[np.ndarray, "n"]:
    """The first row that is above 0, infinity where none is."""
    some = bits > NOTHING
    return np.where(some.any(axis=0), some.argmax(axis=0), np.inf)


@takes_old_keywords
def influence_range(
    mdp: TabularMDP, horizon: int, sensor: str = "object", **options: Unpack[Options]
) -> int:
    """From how far the agent has any influence, in cells.

    The measure is ours:

        R = max {d(s) : L(s) <= h}

    where d(s) is the Manhattan distance between agent and object, and L(s) the `latency`. It is
    over the states that averages are over (see `average_empowerment`).

    Args:
        mdp: a world's table.
        horizon: h, in actions.
        sensor: the factor of the object.
        **options: `method`, `unit`, `executor` and `show_progress`, as in `empowerment`.

    Returns:
        Rows plus columns, 0 if there is no influence from anywhere.

    Raises:
        ValueError: as in `average_empowerment`, or the sensor has no cells.

    Example:
        >>> mdp = tabulate(World.parse("A..C.G").with_tool("none"))
        >>> influence_range(mdp, 1), influence_range(mdp, 3)
        (1, 3)
    """
    states = np.flatnonzero(compared_states(mdp))
    apart = distances(mdp, sensor, states)
    return furthest(apart, latency(mdp, horizon, sensor, states=states, **options))


def distances(
    mdp: TabularMDP, sensor: str, states: Int64[np.ndarray, "n"]
) -> Int64[np.ndarray, "n"]:
    """Manhattan distances between the agent and a thing."""
    if mdp.shape is None:
        raise ValueError("this MDP has no cells, and so no distances; give a world's table")
    ends = [
        np.stack(np.divmod(mdp.factor(name)[states], mdp.shape[1])) for name in ("agent", sensor)
    ]
    return np.abs(ends[0].astype(np.int64) - ends[1]).sum(axis=0)


def furthest(apart: Int64[np.ndarray, "n"], least: Float64[np.ndarray, "n"]) -> int:
    """The largest distance at which there is any influence, 0 if there is none."""
    return int(apart[np.isfinite(least)].max(initial=0))


@takes_old_keywords
def reliability(world: World, horizon: int, slip: float = 0.0, **options: Unpack[Options]) -> float:
    """How much of the object empowerment is left where actions or the tool may fail.

    The measure is ours: the average object empowerment with slip, both that of actions and that
    of the world's tool, over the average without either,

        r = mean E_h with slip / mean E_h without

    Args:
        world: the map, of one object and at most one tool.
        horizon: h, in actions.
        slip: as in `tabulate`.
        **options: `method`, `unit`, `executor` and `show_progress`, as in `empowerment`.

    Returns:
        1 where nothing fails; NaN where there is nothing to lose. Where actions slip it is at
        most 1; a tool that fails may leave a choice that it would have taken away.

    Raises:
        ValueError: as in `average_empowerment`.

    Example:
        >>> round(reliability(World.parse("A.C.G"), horizon=1, slip=0.2), 3)
        0.546
    """
    world = held(world)
    sure = average_empowerment(tabulate(certain(world)), horizon, **options)
    if not fails(world, slip):
        return share(sure, sure)
    return share(average_empowerment(tabulate(world, slip), horizon, **options), sure)


def certain(world: World) -> World:
    """The same world with tools that never fail."""
    return replace(world, tools=tuple(replace(tool, slip=0.0) for tool in world.tools))


def fails(world: World, slip: float) -> bool:
    """Whether some outcomes are random."""
    return bool(slip) or world.may_fail


def share(part: float, whole: float) -> float:
    """A part of a whole, NaN if there is no whole."""
    return part / whole if whole > NOTHING else float("nan")
