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
from habilis.empowerment.limits import Limits, TooMuchError, too_much
from habilis.empowerment.methods import Exact
from habilis.empowerment.tabular.beliefs import TooManyBeliefsError
from habilis.empowerment.tabular.cost import check_effort, most_entries
from habilis.empowerment.tabular.open_loop import Problem, exact, problem_of
from habilis.mdp import TabularMDP
from habilis.studio.limits import DRAWN, FEWEST, GIB, SECONDS
from habilis.studio.placements import placed
from habilis.studio.protocol import scenes as protocol
from habilis.studio.random_placements import random_placements
from habilis.studio.scenes import ELSEWHERE, Scene
from habilis.transitions import Transitions
from habilis.worlds.placements import Placement
from habilis.worlds.plans import check_certain, solve
from habilis.worlds.reach import TooManyPlacementsError, reachable
from habilis.worlds.table import tabulate
from habilis.worlds.world import Cell, World

Answer = dict[str, Any]
Cells = list[list[int]]

_LIMITS = Limits(GIB, SECONDS)
_METHOD = Exact(threads=1, max_gib=GIB, max_seconds=SECONDS)
_TOLERANCE = 1e-6  # bits
_KEPT = 4  # tables of scenes
_MOST = 3_000_000  # placements that the search for a plan visits
_MANY, _EXACT = 100, 5.0  # cells, seconds: beyond, an average over a stochastic table is estimated


def landscape(scene: Scene) -> Answer:
    """Empowerment for every agent cell, tool and object where the map has them.

    Only what h actions from there can touch is tabulated: on a small map as quick as looking up
    in a table of all placements, on a large one hundreds of times quicker.
    """
    places = scene.world.agent_cells
    bits = np.empty(0) if not places else _bits(scene, [_at(scene, place) for place in places])
    return {"bits": bits.tolist()}


def stretch(scene: Scene, first: int, end: int) -> Answer:
    """Empowerment for some of the agent's cells, of a stochastic table, which takes long."""
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


def choices(scene: Scene, agent: Cell) -> Answer:
    """The futures that the agent can reach from a cell."""
    mdp, states = _around(scene, [_at(scene, agent)])
    state, sensor = int(states[0]), scene.sensed(mdp)
    found = futures(
        mdp, state, scene.horizon, sensor, scene.action_indices, method=Exact(max_gib=GIB)
    )
    seen, labels = found.seen, found.observations
    if scene.sensor == "state":
        labels, place = np.unique(mdp.factor(scene.seen)[labels], return_inverse=True)
        seen = np.bincount(place, seen, len(labels))
    here = labels != ELSEWHERE
    rows, columns = np.divmod(labels[here], scene.world.width)
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


def plan(scene: Scene, at: protocol.Placement | None = None) -> Answer:
    """A shortest plan from a placement, by default the map's, with its placements."""
    world = check_certain(scene.world)
    if world.single:
        mdp = tabulate(world)
        start = mdp.start if at is None else state_of(world, mdp, scene.named(at))
    else:
        mdp, start = _within_reach(world, scene.placement if at is None else scene.named(at))
    found = solve(mdp, start)
    if found is None:
        return {"steps": None, "return": None, "actions": None, "placements": None}
    return {
        "steps": found.steps,
        "return": found.best_return,
        "actions": list(found.actions),
        "placements": [placed(world, scene.listed, mdp, state) for state in found.states],
    }


def step(scene: Scene, at: protocol.Placement, action: int | None) -> Answer:
    """The effect of an action in a placement, and the bits of the placement reached.

    Args:
        scene: the world, and what is measured.
        at: the placement.
        action: its index; `None` stays.
    """
    world = scene.world
    mdp, states = reachable(world, scene.named(at), 1)
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
    now = placed(world, scene.listed, mdp, state)
    return {
        "placement": now,
        "bits": float(_bits(scene, [scene.named(now)])[0]),
        "equipped": bool(mdp.flags["equipped"][state]),
        "attached": bool(mdp.flags["attached"][state]),
        "reward": reward,
        "ended": ended,
    }


def _within_reach(world: World, at: Placement) -> tuple[TabularMDP, int]:
    """The table reachable from a placement, and the placement's state."""
    try:
        mdp, states = reachable(world, at, None, _MOST)
    except TooManyPlacementsError:
        raise ValueError(
            f"more than {_MOST:,} placements can be reached; remove things, or make the map smaller"
        ) from None
    return mdp, int(states[0])


def state_of(world: World, mdp: TabularMDP, at: Placement) -> int:
    """The state of a placement in a table of its world.

    Raises:
        ValueError: it is no placement, or the table has none such.
    """
    asked, states = reachable(world, at, 0)
    same = np.ones(mdp.states, bool)
    for name in mdp.factors:
        same &= mdp.factor(name) == asked.factor(name)[states[0]]
    if not same.any():
        raise ValueError("that cannot be reached from where episodes start; put things elsewhere")
    return int(np.flatnonzero(same)[0])


def _at(scene: Scene, agent: Cell) -> Placement:
    return {**scene.placement, "agent": agent}


def _around(scene: Scene, places: list[Placement]) -> tuple[TabularMDP, np.ndarray]:
    """The table reachable from some placements with h actions, and their states."""
    mdp, states = reachable(scene.world, places, scene.horizon)
    return mdp.slippery(scene.slip), states


def _bits(scene: Scene, places: list[Placement]) -> np.ndarray:
    mdp, states = _around(scene, places)
    return empowerment(
        mdp, scene.horizon, scene.sensed(mdp), scene.action_indices, states, method=_METHOD
    )


@lru_cache(_KEPT)
def _everywhere(scene: Scene) -> tuple[Problem, np.ndarray]:
    """The problem shared by the agent's cells in a stochastic table.

    Raises:
        TooMuchError: it takes too long.
    """
    problem, states = _uncertain(scene, [_at(scene, place) for place in scene.world.agent_cells])
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


def _uncertain(scene: Scene, places: list[Placement]) -> tuple[Problem, np.ndarray]:
    mdp, states = _around(scene, places)
    used, most = chosen_actions(mdp, scene.action_indices), most_entries(_LIMITS, 1)
    return problem_of(mdp, scene.horizon, scene.sensed(mdp), used, _TOLERANCE, most), states


def _each(problem: Problem, states: np.ndarray) -> list[float]:
    try:
        return [exact(problem, int(state))[1].bits for state in states]
    except TooManyBeliefsError as error:
        raise too_much(problem.horizon, error.horizon, _LIMITS) from None


def _in_words(one: Callable[..., Answer]) -> Callable[..., Answer]:
    """Reports in the page's terms that something takes too long."""

    @wraps(one)
    def step(*given: Any, **named: Any) -> Answer:
        try:
            return one(*given, **named)
        except TooMuchError as error:
            fewer = f"up to {error.fitting} do not" if error.fitting > 0 else "have no slip"
            raise ValueError(
                f"with slip, {error.horizon} steps ahead take too long here; {fewer}"
            ) from None

    return step


_ALL = (landscape, stretch, sampled, average, choices, plan, step)
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
