"""Landscapes: empowerment, or any measure, for every cell of the agent, all else fixed."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
from jaxtyping import Float64, Int64, Num
from numpy.typing import ArrayLike

from habilis.analysis.landscape_states import PlainMap, asked, asked_of_model, asked_of_puzzle
from habilis.analysis.landscape_values import Landscape
from habilis.bridges.puzzles.pushworld import PushWorld
from habilis.empowerment.api import Options
from habilis.empowerment.kinds import (
    EFFECTIVE,
    GOAL_DIRECTED,
    OPEN_LOOP,
    WHOLE,
    checked_kind,
    named,
    of_kind,
)
from habilis.empowerment.methods import Exact, bounds_of
from habilis.empowerment.old_keywords import takes_old_keywords
from habilis.empowerment.players import played_by
from habilis.empowerment.sensors import Sensor, is_noisy
from habilis.mdp import TabularMDP
from habilis.models.explore import AnyModel
from habilis.worlds.placements import Factors
from habilis.worlds.table import tabulate
from habilis.worlds.things import Where
from habilis.worlds.world import World

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Measure = Callable[[TabularMDP, np.ndarray], ArrayLike]
"""A function of a table and int64[n], its states, that returns float[n]."""


@takes_old_keywords
def landscape(
    model: AnyModel,
    horizon: int,
    sensor: Sensor = "state",
    actions: ArrayLike | None = None,
    *,
    kind: str = OPEN_LOOP,
    discount: float | None = None,
    slack: int | None = None,
    slip: float = 0.0,
    tool: Where | None = None,
    object: Where | None = None,
    mdp: TabularMDP | None = None,
    player: str | None = None,
    others: Any = None,
    ax: "Axes | None" = None,
    **options: Unpack[Options],
) -> Landscape:
    """Empowerment for every agent cell, all other things fixed.

    Args:
        model: a map, or a puzzle, of which the agent's cell is that of its corner; no more of them
            is explored than the horizon reaches. Or any other model or table whose factor "agent"
            is a cell: the states are those that differ from its first state in that factor alone.
            A map with two agents is one of these.
        horizon, sensor, actions: as in `empowerment`.
        kind: "open-loop"; "effective", under the uniform policy, which has a discount and no
            horizon; "closed-loop"; or "goal-directed", towards the terminal states. Of a method
            effective and closed-loop empowerment use the tolerance alone, not its limits.
        discount: of effective empowerment.
        slack: of goal-directed empowerment; 0 by default.
        slip: as in `tabulate`.
        tool, object: their cells; by default those of the map. The agent next to the tool has it
            in hand; where the tool does not lie at its cell of the map, there are only such
            states. Of several, cells by names, as `tool={"rake": (2, 3)}`: these may lie anywhere,
            and the first beside the agent is in hand. Of a puzzle, `object={"m1": (2, 3)}`.
        mdp: the world's table, if it is at hand.
        player, others: as in `empowerment`, of a map with two agents or a table of several players.
            The cells are those of "agent", whichever player it is.
        ax: Matplotlib axes to draw it on at once (see `Landscape.draw`).
        **options: `method`, `unit`, `executor` and `show_progress`, as in `empowerment`.

    Returns:
        The values by cell, with the world and what was asked for.

    Raises:
        ValueError: as in `empowerment`; a tool's cell in a world without one, or no state has
            tool and object there.

    Example:
        >>> from habilis.worlds.world import load_world
        >>> found = landscape(load_world("corridor"), 1, "object")
        >>> found.values.shape, float(np.nanmax(found.values))
        ((10, 10), 1.0)
    """
    checked_kind(kind, discount, slack)
    reach, show = None if kind in WHOLE else horizon, options.get("show_progress", False)
    shown, mdp, states = _asked(model, reach, kind, sensor, slip, tool, object, mdp, show)
    mdp, against = played_by(mdp, player, others, isinstance(model, TabularMDP))
    bits, gap = of_kind(
        kind, mdp, horizon, sensor, actions, states, discount, slack, options, against
    )
    method = options.get("method", Exact())
    counted = kind != EFFECTIVE and isinstance(method, Exact)
    counted &= not mdp.is_stochastic and not is_noisy(sensor)
    whose = "" if player is None else f" of {player}"
    sensed = f", sensor {sensor!r}" if isinstance(sensor, str) else ""
    found = Landscape(
        values=_on_map(shown, mdp, states, bits),
        world=shown,
        unit=options.get("unit", "bits"),
        title=f"{bounds_of(method)}{named(kind, horizon, discount)}{whose}{sensed}",
        kind=kind,
        discount=discount,
        slack=(slack or 0) if kind == GOAL_DIRECTED else None,
        gap=None if counted else _on_map(shown, mdp, states, gap),
    )
    if ax is not None:
        found.draw(ax)
    return found


def landscape_of(
    model: AnyModel,
    measure: Measure,
    *,
    unit: str = "bits",
    title: str = "",
    slip: float = 0.0,
    tool: Where | None = None,
    object: Where | None = None,
    mdp: TabularMDP | None = None,
    ax: "Axes | None" = None,
) -> Landscape:
    """Any measure of states for every agent cell, all other things fixed.

    So every kind of empowerment has a landscape: within a budget, of one of several players, under
    a trained policy; and so has any other quantity of states.

    Args:
        model: as in `landscape`, but of a puzzle give the table that `explore` makes.
        measure: a function of the whole table and of int64[n], the states asked about, that
            returns float[n].
        unit: of the values.
        title: what was measured, as a picture says it.
        slip, tool, object, mdp, ax: as in `landscape`.

    Returns:
        The values by cell.

    Raises:
        ValueError: as in `landscape`; or the measure does not return one number a state.

    Example:
        >>> from habilis.worlds.world import load_world
        >>> from habilis.empowerment import empowerment
        >>> def careful(mdp, states):
        ...     cost = np.tile([1, 1, 1, 1, 5, 5, 5, 5], (mdp.states, 1))  # to move the tool
        ...     return empowerment(mdp, 3, "object", states=states, cost=cost, budget=4)
        >>> landscape_of(load_world("corridor"), careful).values.shape
        (10, 10)
    """
    shown, mdp, states = _asked(model, None, "measure", "state", slip, tool, object, mdp, False)
    found = np.asarray(measure(mdp, states))
    if found.shape != states.shape or found.dtype.kind not in "biuf":
        raise ValueError(
            f"measure returns shape {found.shape} and type {found.dtype}; let it return one number "
            f"for each of the {len(states)} states"
        )
    landscape = Landscape(_on_map(shown, mdp, states, found), shown, unit, title)
    if ax is not None:
        landscape.draw(ax)
    return landscape


def _asked(
    model: AnyModel,
    horizon: int | None,
    kind: str,
    sensor: Sensor,
    slip: float,
    tool: Where | None,
    object: Where | None,
    mdp: TabularMDP | None,
    show: bool,
) -> "tuple[World | PushWorld | PlainMap, TabularMDP, Int64[np.ndarray, 'n']]":
    """A map, its table, the whole one without a horizon, and the states of the agent's cells."""
    if isinstance(model, World) and model.second is None:
        _check_table(model, slip, tool, mdp)
        if horizon is None and mdp is None:
            mdp = tabulate(model, slip, show_progress=show)
        return asked(model, horizon or 0, sensor, slip, tool, object, mdp, show)
    if isinstance(model, PushWorld):
        if tool is not None or mdp is not None:
            raise ValueError(f"{model.name} is a puzzle; leave out tool and mdp")
        if horizon is None:
            raise ValueError(
                f"{model.name} is a puzzle, of which {kind!r} would need every state; explore it, "
                "and give the table"
            )
        shown, table, states = asked_of_puzzle(model, horizon, object, show)
        return shown, table.slippery(slip), states
    if tool is not None or object is not None or mdp is not None:
        what = "a map with two agents" if isinstance(model, World) else "not a map"
        raise ValueError(f"{type(model).__name__} is {what}; leave out tool, object and mdp")
    shown, table, states = asked_of_model(model, show)
    return shown, table.slippery(slip), states


def _on_map(
    shown: World | PushWorld | PlainMap,
    mdp: TabularMDP,
    states: Int64[np.ndarray, "n"],
    found: Num[np.ndarray, "n"],
) -> Float64[np.ndarray, "rows columns"]:
    """Values of states where their agent is."""
    values = np.full(shown.height * shown.width, np.nan)
    values[mdp.factor("agent")[states]] = found
    return values.reshape(shown.height, shown.width)


def _check_table(world: World, slip: float, tool: Where | None, mdp: TabularMDP | None) -> None:
    """Refuses a tool's cell in a world without one, and a table of another map.

    Raises:
        ValueError: it is so.
    """
    if tool is not None and not world.tools:
        raise ValueError(f"{world.name} has no tool here; leave out tool, or use with_tool")
    if mdp is not None and slip:
        raise ValueError("slip is given beside a table; give it to `tabulate`")
    if mdp is not None and (
        mdp.shape != (world.height, world.width)
        or Factors.of(world).things
        != tuple(name for name in mdp.factors if ":" in name or name in ("tool", "object"))
    ):
        raise ValueError(f"{world.name}: the table is of another map; give what `tabulate` made")
