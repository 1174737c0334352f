"""Steps about a scene, each short enough to wait for.

Steps are functions of plain values, so that any worker can run any of them; each worker caches what
they share (a scene's table).
"""

import random
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache, wraps
from typing import Any

import numpy as np

from habilis.analysis.averages import NOTHING, compared_states
from habilis.analysis.futures import futures
from habilis.empowerment.api import empowerment
from habilis.empowerment.arguments import chosen_actions
from habilis.empowerment.closed_loop import possible_observations
from habilis.empowerment.kinds import of_kind
from habilis.empowerment.limits import Limits, TooMuchError, too_much
from habilis.empowerment.methods import Exact
from habilis.empowerment.sensors import observation_probabilities
from habilis.empowerment.tabular.beliefs import TooManyBeliefsError
from habilis.empowerment.tabular.column_generation import certified
from habilis.empowerment.tabular.cost import check_effort, most_entries
from habilis.empowerment.tabular.open_loop import Problem, problem_of
from habilis.mdp import TabularMDP
from habilis.models.limits import TooManyStatesError
from habilis.probabilities import shape_of
from habilis.studio.films import film
from habilis.studio.limits import (
    BOARD_STATES,
    DRAWN,
    FEWEST,
    GIB,
    NUMBERS,
    OBSERVATIONS,
    SECONDS,
)
from habilis.studio.pairs import pair
from habilis.studio.protocol import scenes as protocol
from habilis.studio.random_placements import random_placements
from habilis.studio.scenes import ELSEWHERE, AnyScene, Scene, Where
from habilis.transitions import Transitions
from habilis.worlds.table import tabulate
from habilis.worlds.world import Cell, World

Answer = dict[str, Any]

_LIMITS = Limits(GIB, SECONDS)
_METHOD = Exact(threads=1, max_gib=GIB, max_seconds=SECONDS)
_TOLERANCE = 1e-6  # bits
_KEPT = 4  # tables of scenes
_MANY, _EXACT = 100, 5.0  # cells, seconds: beyond, an average over a stochastic table is estimated


def landscape(scene: AnyScene) -> Answer:
    """Empowerment for every agent cell, all else where the map or board has it.

    Only what h actions from there can touch is tabulated: on a small map as quick as looking up
    in a table of all placements, on a large one hundreds of times quicker.
    """
    agents = scene.agents
    bits, gap = _bits(scene, list(agents.values())) if agents else np.empty((2, 0))
    return {"bits": bits.tolist(), "gap": gap.tolist(), "cells": list(agents)}


def cells(scene: AnyScene) -> Answer:
    """The cells of a landscape."""
    return {"cells": list(scene.agents)}


def stretch(scene: AnyScene, first: int, end: int) -> Answer:
    """Empowerment for some of the agent's cells, of a stochastic table, which takes long."""
    if scene.measured.is_closed:
        mdp, states = _watched(scene)
        bits, gap = _of(scene, mdp, states[first:end])
        return {"bits": bits.tolist(), "gap": gap.tolist()}
    problem, states = _everywhere(scene)
    return {"bits": _each(problem, states[first:end])}


def sampled(scene: Scene, tool: str, first: int, end: int) -> Answer:
    """Object empowerment in some of `DRAWN` placements with a tool, or none, in hand."""
    problem, states = _anywhere(scene.with_tool(tool))
    return {"bits": _each(problem, states[first:end])}


def average(scene: Scene, tool: str) -> Answer:
    """The average with a tool, or none; `None` if the exact one takes too long."""
    of_tool = scene.with_tool(tool)
    if of_tool.is_stochastic and len(of_tool.world.agent_cells) > _MANY:
        return {"bits": None}
    mdp = tabulate(of_tool.world, scene.slip)
    states = np.flatnonzero(compared_states(mdp))
    method = replace(_METHOD, max_seconds=_EXACT) if of_tool.is_stochastic else _METHOD
    try:
        bits = empowerment(mdp, scene.horizon, "object", states=states, method=method)
    except TooMuchError:
        return {"bits": None}
    return {"bits": float(bits.mean()), "some": bool(bits.max() > NOTHING)}


def choices(scene: AnyScene, agent: Cell) -> Answer:
    """The futures that the agent can reach from a cell."""
    agents = scene.agents
    if agent not in agents:
        raise ValueError(f"the agent cannot be in {agent}; give a cell that has a value")
    mdp, states = _around(scene, [agents[agent]])
    sensor = scene.sensed(mdp)
    method = Exact(max_gib=GIB)
    found = futures(mdp, int(states[0]), scene.horizon, sensor, scene.action_indices, method=method)
    labels, place = np.unique(scene.seen_in(mdp, found.observations), return_inverse=True)
    seen = np.bincount(place, found.seen, len(labels))
    here = labels != ELSEWHERE
    rows, columns = np.divmod(labels[here], scene.width)
    return {
        "bits": found.empowerment,
        "gap": found.gap,
        "things": [
            list(thing)
            for thing in zip(rows.tolist(), columns.tolist(), seen[here].tolist(), strict=True)
        ],
        "elsewhere": float(seen[~here].sum()),
        "count": len(found.observations),
    }


def plan(scene: AnyScene, at: protocol.Placement | None = None) -> Answer:
    """A shortest plan from a placement, by default the first, with its placements."""
    found = scene.plan(at)
    if found is None:
        return {"steps": None, "return": None, "actions": None, "placements": None}
    way, placements = found
    return {
        "steps": way.steps,
        "return": way.best_return,
        "actions": list(way.actions),
        "placements": placements,
    }


def step(scene: AnyScene, at: protocol.Placement, action: int | None) -> Answer:
    """The effect of an action in a placement, and the bits of the placement reached.

    Args:
        scene: the world, and what is measured.
        at: the placement.
        action: its index; `None` stays.
    """
    mdp, states = scene.around([scene.where(at)], 1)
    state, reward, ended = int(states[0]), None, bool(mdp.terminal[states[0]])
    if action is not None:
        if not 0 <= action < mdp.action_count:
            raise ValueError(f"action is {action}; use indices from 0 to {mdp.action_count - 1}")
        if random.random() < scene.slip:
            action = random.randrange(mdp.action_count)
        transitions = Transitions.of(mdp)
        made = transitions.drawn(state * mdp.action_count + action, random.random())
        state, reward = int(transitions.next_state[made]), float(transitions.reward[made])
        ended = bool(mdp.terminal[state])
    now = scene.placed(mdp, state)
    return {
        "placement": now,
        "bits": _bits_of(scene, scene.where(now)),
        "equipped": _flag(mdp, "equipped", state),
        "attached": _flag(mdp, "attached", state),
        "reward": reward,
        "ended": ended,
    }


def _flag(mdp: TabularMDP, name: str, state: int) -> bool:
    return name in mdp.flags and bool(mdp.flags[name][state])


def _around(scene: AnyScene, places: list[Where]) -> tuple[TabularMDP, np.ndarray]:
    """The table reachable from some states with h actions, and their indices in it."""
    mdp, states = scene.around(places, scene.horizon)
    return mdp.slippery(scene.slip), states


def _bits(scene: AnyScene, places: list[Where]) -> tuple[np.ndarray, np.ndarray]:
    """Values and their gaps."""
    if not scene.measured.needs_whole:
        return _of(scene, *_around(scene, places))
    mdp, states = scene.whole(places)
    mdp = mdp.slippery(scene.slip)
    _check_numbers(scene, mdp)
    return _of(scene, mdp, states)


def _of(scene: AnyScene, mdp: TabularMDP, states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values of the scene's kind of empowerment in a table, and their gaps."""
    of = scene.measured
    if of.is_to_goals and not mdp.is_stochastic and not mdp.terminal.any():
        return np.zeros(len(states)), np.zeros(len(states))  # the goal is out of reach
    asked = mdp, scene.horizon, scene.sensed(mdp), scene.action_indices, states
    return of_kind(of.kind, *asked, of.discount, of.slack, {"method": _METHOD})


def _bits_of(scene: AnyScene, place: Where) -> float:
    """The value of one state."""
    if not scene.measured.needs_whole:
        return float(_bits(scene, [place])[0][0])
    mdp, bits = _of_all(scene)
    asked, states = scene.around([place], 0)
    same = np.ones(mdp.states, bool)
    for name in mdp.factors:
        same &= mdp.factor(name) == asked.factor(name)[states[0]]
    if same.sum() == 1:
        return float(bits[same][0])
    return float(_bits(scene, [place])[0][0])  # nothing leads there from the landscape's states


@lru_cache(_KEPT)
def _of_all(scene: AnyScene) -> tuple[TabularMDP, np.ndarray]:
    """All that can be reached from the landscape's states, and its values: a game asks often."""
    mdp, _ = scene.whole(list(scene.agents.values()))
    mdp = mdp.slippery(scene.slip)
    _check_numbers(scene, mdp)
    return mdp, _of(scene, mdp, np.arange(mdp.states))[0]


def _check_numbers(scene: AnyScene, mdp: TabularMDP) -> None:
    """Refuses effective empowerment of more observations and states than a page waits for.

    Raises:
        ValueError: it is so.
    """
    if not scene.measured.is_effective:
        return
    seen = shape_of(observation_probabilities(mdp, scene.sensed(mdp)))[1]
    if seen * mdp.states > NUMBERS:
        raise ValueError(
            f"effective empowerment of {seen:,} observations in {mdp.states:,} states takes too "
            "long here; observe a single thing, or make the map smaller"
        )


@lru_cache(_KEPT)
def _watched(scene: AnyScene) -> tuple[TabularMDP, np.ndarray]:
    """The table of closed-loop empowerment with random outcomes, and the landscape's states.

    Raises:
        ValueError: so many observations are possible that it takes too long.
    """
    mdp, states = _around(scene, list(scene.agents.values()))
    sensor, used = scene.sensed(mdp), chosen_actions(mdp, scene.action_indices)
    most = max(possible_observations(mdp, scene.horizon, sensor, states, used), default=0)
    if most > OBSERVATIONS:
        raise ValueError(
            f"with feedback and random outcomes, {scene.horizon} steps ahead take too long here: "
            f"{most} observations are possible from a cell, and the limit is {OBSERVATIONS}; look "
            "fewer steps ahead, or observe a single thing"
        )
    return mdp, states


@lru_cache(_KEPT)
def _everywhere(scene: AnyScene) -> tuple[Problem, np.ndarray]:
    """The problem shared by the agent's cells in a stochastic table.

    Raises:
        TooMuchError: it takes too long.
    """
    problem, states = _uncertain(scene, list(scene.agents.values()))
    check_effort(problem, states, 1, _LIMITS)
    return problem, states


@lru_cache(_KEPT)
def _anywhere(scene: Scene) -> tuple[Problem, np.ndarray]:
    """The problem shared by random placements in a stochastic table.

    Raises:
        TooMuchError: even a few take too long.
    """
    problem, states = _uncertain(scene, random_placements(scene.world, DRAWN))
    check_effort(problem, states[:FEWEST], 1, _LIMITS)
    return problem, states


def _uncertain(scene: AnyScene, places: list[Where]) -> tuple[Problem, np.ndarray]:
    mdp, states = _around(scene, places)
    used, most = chosen_actions(mdp, scene.action_indices), most_entries(_LIMITS, 1)
    return problem_of(mdp, scene.horizon, scene.sensed(mdp), used, _TOLERANCE, most), states


def _each(problem: Problem, states: np.ndarray) -> list[float]:
    try:
        return [certified(problem, int(state))[0] for state in states]
    except TooManyBeliefsError as error:
        raise too_much(problem.horizon, error.horizon, _LIMITS) from None


def _in_words(one: Callable[..., Answer]) -> Callable[..., Answer]:
    """Reports in the page's terms that something takes too long."""

    @wraps(one)
    def step(*given: Any, **named: Any) -> Answer:
        try:
            return one(*given, **named)
        except TooManyStatesError:
            raise ValueError(
                f"more than {BOARD_STATES:,} states are within the horizon; look fewer steps ahead"
            ) from None
        except TooMuchError as error:
            fewer = f"up to {error.fitting} do not" if error.fitting > 0 else "have no slip"
            raise ValueError(
                f"with slip, {error.horizon} steps ahead take too long here; {fewer}"
            ) from None

    return step


_ALL = (landscape, cells, pair, stretch, sampled, average, choices, plan, step, film)
STEPS: dict[str, Callable[..., Answer]] = {one.__name__: _in_words(one) for one in _ALL}
"""The steps that a worker can run, by name."""


def prepare(background: bool) -> None:
    """Loads or compiles what steps need, so that the first one is as fast as the others.

    Args:
        background: whether the worker runs long steps.
    """
    world = World.parse("AP..\n.C.G\n....\n....")
    for sensor in ("object", "state"):
        landscape(Scene(world, sensor, horizon=2))
        choices(Scene(world, sensor, horizon=2, slip=0.1 if background else 0.0), (0, 0))
