"""A plan that brings the puck to a goal, found by a search."""

from typing import Any

import numpy as np
from jaxtyping import Float64, Int64

from habilis.empowerment.arguments import at_least_one
from habilis.robots.pushing import PushingSimulator


def push_plan(
    simulator: PushingSimulator,
    state: Float64[np.ndarray, "d"],
    goal: Any,
    horizon: int = 20,
    *,
    sequences: int = 2000,
    seed: int = 0,
) -> Int64[np.ndarray, "length"]:
    """A shortest sequence of actions that is found to bring the puck into the goal's cell.

    The search goes forward action by action from all states reached so far that differ by more
    than half a cell from those before; if these are more than `sequences`, from some drawn at
    random.

    Args:
        simulator: a deterministic one.
        state: where it begins.
        goal: float[2], of the puck's joints; its cell is the square of side `simulator.resolution`
            around it.
        horizon: how many actions at most.
        sequences: how many states to go on from, from 1 up.
        seed: of the draws.

    Returns:
        Indices of `simulator.actions`.

    Raises:
        ValueError: the simulator is stochastic, or no such sequence is found.

    Example:
        >>> simulator = PushingSimulator("reach.xml", "stick")
        >>> start = simulator.placed([[0.0, 0.7]])[0]
        >>> push_plan(simulator, start, [0.0, 0.8])  # twice away from the robot
        array([3, 3])
    """
    if simulator.is_stochastic:
        raise ValueError("the simulator is noisy: no plan is sure; make one without noise")
    horizon, most = at_least_one("horizon", horizon), at_least_one("sequences", sequences)
    aim = np.asarray(goal, np.float64)
    generator = np.random.default_rng(seed)
    count, grain = len(simulator.actions), simulator.resolution / 2
    level, seen = state[None], {tuple(np.rint(state / grain))}
    parents: list[np.ndarray] = []
    for _ in range(horizon):
        starts = np.repeat(level, count, axis=0)
        reached = simulator.step(starts, np.tile(simulator.actions, (len(level), 1)))
        there = np.abs(reached[:, simulator.puck] - aim).max(axis=1) <= simulator.resolution / 2
        if there.any():
            return _traced([*parents, np.flatnonzero(there)[:1]], count)
        new = []
        for index, key in enumerate(map(tuple, np.rint(reached / grain))):
            if key not in seen:
                seen.add(key)
                new.append(index)
        if not new:
            break
        kept = np.array(new)
        if len(kept) > most:
            kept = np.sort(generator.choice(kept, most, replace=False))
        parents.append(kept)
        level = reached[kept]
    raise ValueError(
        f"no sequence of {horizon} actions is found that brings the puck to {aim.tolist()} with "
        f"{simulator.tool}; give a longer horizon, more sequences or another tool"
    )


def _traced(parents: list[np.ndarray], count: int) -> Int64[np.ndarray, "length"]:
    """The actions that lead to the first of the last level."""
    actions, place = [], 0
    for kept in reversed(parents):
        index = int(kept[place])
        actions.append(index % count)
        place = index // count
    return np.array(actions[::-1], np.int64)
