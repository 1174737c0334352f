"""All that the paper states about its worlds, recomputed: numbers, and statements in words."""

from math import inf, nan

import numpy as np

from habilis.studies.paper import corridor_statements, yard_statements
from habilis.studies.paper.findings import Number, Statement
from habilis.studies.paper.published import EXPERIMENTS
from habilis.studies.paper.targets import Target, load_targets
from habilis.studies.paper.worlds import CachedWorld, PaperWorlds, paper_worlds
from habilis.worlds.plans import solve
from habilis.worlds.world import load_world


def published_numbers() -> list[Number]:
    """All that are printed as numbers, in the worlds of the experiments, in the paper's order."""
    numbers = []
    for experiment in EXPERIMENTS:
        world, targets = CachedWorld(load_world(experiment.world)), load_targets(experiment.targets)
        printed = [target for target in targets.numbers if target.value is not None]
        numbers += [number_in(world, target) for target in printed]
    return numbers


def published_statements(worlds: PaperWorlds | None = None) -> list[Statement]:
    """Every statement that follows from the worlds alone, recomputed, in the paper's order.

    Args:
        worlds: those that they are about; by default those of the reproduction.
    """
    worlds = worlds or paper_worlds()
    return [check(worlds) for check in (*corridor_statements.CHECKS, *yard_statements.CHECKS)]


def number_in(world: CachedWorld, target: Target) -> Number:
    """A stated number beside its value in a world."""
    ours = measure(world, target)
    agrees = target.miss(ours) == 0
    return Number(target.section, target.text, target.published, ours, target.unit, agrees)


def measure(cached: CachedWorld, target: Target) -> float:
    """The number that a statement is about, as it is in a cached; not rounded.

    Returns:
        Steps, a return, or bits. Infinitely many steps, and an infinitely low return, where the
        goal is out of reach; NaN where the cached has no such cells.
    """
    cached = cached.with_tool(target.tool) if target.tool else cached
    if target.kind == "apart":
        other = cached.world.agent if target.of == "agent" else cached.world.object
        return float(cached.distance(cached.tool_cell)[other])
    if target.kind == "average":
        return _averaged(cached, target)
    if target.kind == "landscape":
        return _of_landscape(cached, target)
    plan = solve(cached.mdp)
    if target.kind == "steps":
        return inf if plan is None else plan.steps
    return -inf if plan is None else plan.best_return


def _averaged(cached: CachedWorld, target: Target) -> float:
    bits = cached.average(target.horizon, target.sensor)
    if not target.against:
        return bits
    other = cached.with_tool(target.against)
    return bits - other.average(target.horizon, target.sensor)


def _of_landscape(cached: CachedWorld, target: Target) -> float:
    places = cached.side_by_side if target.placed else (cached.world.tool_cell, cached.world.object)
    if places is None:
        return nan
    values = cached.landscape(target.horizon, target.sensor, places).values
    if target.against:
        other = cached.with_tool(target.against)
        values = np.abs(values - other.landscape(target.horizon, target.sensor, places).values)
    everywhere = values[np.isfinite(values)]
    if target.around:
        cells = {"tool": places[0], "object": places[1], "goal": cached.world.goal}
        cell = cells[target.around]
        assert cell is not None, "lists that speak of a tool without one are refused"
        distance = cached.distance(cell)
        values = values[(distance <= target.within) & (distance > target.beyond)]
    values = values[np.isfinite(values)]
    if not len(values):
        return nan
    if target.statistic == "rank":
        return float(np.mean(everywhere <= np.max(values)))
    statistic = {"most": np.max, "least": np.min, "mean": np.mean}[target.statistic]
    return float(statistic(values))
