"""Films of plans."""

from typing import Any

import numpy as np
from jaxtyping import Float64, Int64

from habilis.estimators.simulators.scenes import Scene
from habilis.robots.pushing import PushingSimulator
from habilis.robots.scene import push_scene


def push_scenes(
    simulator: PushingSimulator,
    state: Float64[np.ndarray, "d"],
    plan: Int64[np.ndarray, "length"],
    goal: Any = None,
    every: int = 3,
) -> list[Scene]:
    """The scenes on the way of a plan, which `save_video` takes.

    Args:
        simulator: a deterministic one.
        state: where it begins.
        plan: indices of its actions.
        goal: float[2], of the puck, to be marked.
        every: how many of MuJoCo's steps lie between two scenes.

    Returns:
        Scenes in order, the first and the last state among them.

    Example:
        >>> from habilis.worlds.pictures import save_video
        >>> simulator = PushingSimulator("reach.xml", "hook")
        >>> start = simulator.placed([[0.2, 0.7]])[0]
        >>> scenes = push_scenes(simulator, start, np.array([1, 3]))
        >>> save_video(scenes, "plan.gif", milliseconds=60)  # doctest: +SKIP
    """
    aim = None if goal is None else np.asarray(goal, np.float64)
    scenes = [push_scene(simulator, state, aim)]
    for index in plan:
        action = simulator.actions[index]
        moving = simulator.motion(state, action)
        scenes += [push_scene(simulator, one, aim) for one in moving[every - 1 :: every]]
        state = simulator.step(state[None], action[None])[0]
    scenes.append(push_scene(simulator, state, aim))
    return scenes
