"""A stated number, measured in a scene."""

from math import inf, nan

import numpy as np

from habilis.studies.scenes import Scene
from habilis.studies.stated import Stated
from habilis.worlds.plans import solve


def measured(scene: Scene, stated: Stated) -> float:
    """The number that a statement is about, as it is in a scene; not rounded.

    Returns:
        Steps, a return, or bits. Infinitely many steps, and an infinitely low return, where the
        goal is out of reach; NaN where the scene has no such cells.
    """
    scene = scene.with_tool(stated.tool) if stated.tool else scene
    if stated.kind == "apart":
        other = scene.world.agent if stated.of == "agent" else scene.world.object
        return float(scene.distance(scene.tool_cell)[other])
    if stated.kind == "average":
        return _averaged(scene, stated)
    if stated.kind == "landscape":
        return _of_landscape(scene, stated)
    plan = solve(scene.mdp)
    if stated.kind == "steps":
        return inf if plan is None else plan.steps
    return -inf if plan is None else plan.best_return


def _averaged(scene: Scene, stated: Stated) -> float:
    bits = scene.average(stated.horizon, stated.sensor)
    if not stated.against:
        return bits
    other = scene.with_tool(stated.against)
    return bits - other.average(stated.horizon, stated.sensor)


def _of_landscape(scene: Scene, stated: Stated) -> float:
    places = scene.side_by_side if stated.placed else (scene.world.tool_cell, scene.world.object)
    if places is None:
        return nan
    values = scene.landscape(stated.horizon, stated.sensor, places).values
    if stated.against:
        other = scene.with_tool(stated.against)
        values = np.abs(values - other.landscape(stated.horizon, stated.sensor, places).values)
    everywhere = values[np.isfinite(values)]
    if stated.around:
        cells = {"tool": places[0], "object": places[1], "goal": scene.world.goal}
        cell = cells[stated.around]
        assert cell is not None, "lists that speak of a tool without one are refused"
        distance = scene.distance(cell)
        values = values[(distance <= stated.within) & (distance > stated.beyond)]
    values = values[np.isfinite(values)]
    if not len(values):
        return nan
    if stated.statistic == "rank":
        return float(np.mean(everywhere <= np.max(values)))
    statistic = {"most": np.max, "least": np.min, "mean": np.mean}[stated.statistic]
    return float(statistic(values))
