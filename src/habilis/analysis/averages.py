"""Averages of empowerment, which compare tools."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Unpack

import numpy as np

from habilis.empowerment.api import Options, empowerment
from habilis.empowerment.old_keywords import takes_old_keywords
from habilis.mdp import TabularMDP
from habilis.progress import progress_bar
from habilis.worlds.table import tabulate
from habilis.worlds.tools import Tool
from habilis.worlds.world import NO_TOOL, World

NOTHING = 1e-9
"""The largest rounding error of an empowerment of zero."""


@takes_old_keywords
def average_empowerment(
    mdp: TabularMDP, horizon: int, sensor: str = "object", **options: Unpack[Options]
) -> float:
    """Mean empowerment over the states that compare tools, in bits.

    With a tool, these are all placements with the tool in hand; without one, all placements.
    Through the sensor "object" they are the paper's average tool's object empowerment and
    average agent's object empowerment (section III-B.3).

    Args:
        mdp: a world's table.
        horizon: h, in actions.
        sensor: as in `empowerment`.
        **options: `method`, `unit`, `executor` and `show_progress`, as in `empowerment`.

    Returns:
        Bits, or nats where these are asked for.

    Raises:
        ValueError: as in `empowerment`, or the tool can never be in hand.

    Example:
        >>> from habilis.worlds.world import load_world
        >>> mdp = tabulate(load_world("yard", tool="none"))
        >>> round(average_empowerment(mdp, horizon=3), 2)
        0.23
    """
    states = compared_states(mdp)
    return float(empowerment(mdp, horizon, sensor, states=states, **options).mean())


def compared_states(mdp: TabularMDP) -> np.ndarray:
    """bool[S]: the states over which averages go.

    Raises:
        ValueError: the tool can never be in hand.
    """
    if not any(name.partition(":")[0] == "tool" for name in mdp.factors):
        return np.ones(mdp.states, bool)
    if not mdp.flags["equipped"].any():
        raise ValueError("there is no room to hold the tool; leave two free cells side by side")
    return mdp.flags["equipped"]


def held(world: World) -> World:
    """The same world with no putting down: averages are of what a tool in hand is worth."""
    return replace(world, drop=False)


@takes_old_keywords
def compare(
    world: World,
    tools: Sequence[str | Tool | type],
    horizon: int,
    slip: float = 0.0,
    **options: Unpack[Options],
) -> dict[str, float]:
    """Average object empowerment of an agent with each tool in the same world, in bits.

    A tool that could be put down on the map is held here.

    Args:
        world: the map.
        tools: names of the map's own tools, which keep what the map says of them, or of others, or
            tools of one's own; "none" is the bare agent.
        horizon: h, in actions.
        slip: as in `tabulate`.
        **options: `method`, `unit`, `executor` and `show_progress`, as in `empowerment`.

    Returns:
        Bits by the tool's name (as in `World.tools` or `World.with_tool`): the average over all
        placements with the tool in hand or, for "none", over all placements.

    Raises:
        ValueError: no tools, an unknown one, two of one name, or a map that has no place for one.

    Example:
        >>> from habilis.worlds.world import load_world
        >>> averages = compare(load_world("yard"), ["picker", "none"], horizon=3)
        >>> {tool: round(bits, 2) for tool, bits in averages.items()}
        {'picker': 0.52, 'none': 0.23}
    """
    averages, armed = {}, with_each_tool(world, tools)
    show = options.get("show_progress", False)
    with progress_bar("tools", show) as report:
        for done, (name, other) in enumerate(armed.items()):
            report(done, len(armed))
            mdp = tabulate(held(other), slip, show_progress=show)
            averages[name] = average_empowerment(mdp, horizon, "object", **options)
    return averages


def ranking(averages: Mapping[str, float]) -> list[str]:
    """Tools in the order of their averages.

    Args:
        averages: by tool, as `compare` returns them.

    Returns:
        The names, from the most to the least empowering.
    """
    return sorted(averages, key=lambda tool: -averages[tool])


def with_each_tool(world: World, tools: Sequence[str | Tool | type] | None) -> dict[str, World]:
    """The world with each of some tools alone, by the tool's name.

    Args:
        world: the map.
        tools: names of the world's own tools, which stay as they are there, or of others, or tools
            of one's own; "none" is the bare agent. By default the world's own and "none".

    Raises:
        ValueError: no tools, an unknown one, two of one name, or a map that has no place for one.
    """
    own = {tool.name: tool for tool in world.tools}
    asked = [*own, NO_TOOL] if tools is None else tools
    if not asked:
        raise ValueError(f"no tools to compare; name some, such as picker,broom,{NO_TOOL}")
    found: dict[str, World] = {}
    given: list[str | Tool | type] = []
    for tool in asked:
        if tool in given:
            continue
        given.append(tool)
        there = own.get(tool) if isinstance(tool, str) else None
        armed = world.with_tool(tool if there is None else there)
        name = armed.tool if there is None else there.name
        if name in found:
            raise ValueError(f"two of the tools have one name, {name!r}; compare each alone")
        found[name] = armed
    return found
