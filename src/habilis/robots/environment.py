"""Pushing the puck to a goal, as a Gymnasium environment with a sparse reward."""

from typing import Any

import gymnasium
import numpy as np
from jaxtyping import Float32, Float64
from numpy.typing import ArrayLike

from habilis.checks import is_number
from habilis.empowerment.arguments import at_least_one, positive
from habilis.robots.pushing import PushingSimulator

MAX_STEPS = 50
"""The length of an episode, at most, unless another is given."""


class PushingEnv(gymnasium.Env[np.ndarray, np.int64]):
    """The hand brings the puck to a goal; nothing else is rewarded.

    Observation: the simulator's state, float32[d]. Action: `Discrete`, the simulator's. The reward
    is 0 for the action that brings the puck's centre to within `radius` of the goal, which ends the
    episode, and -1 for every other; an episode is cut off (truncated) after `max_steps`. `info` has
    "is_success", whether the puck is at the goal.

    Attributes:
        simulator: of the hand, its tool and the puck.
        state: float64[d], the state that the environment is in.

    Example:
        >>> hand = PushingSimulator("reach.xml", "stick")
        >>> env = PushingEnv(hand, goal=[0.0, 0.8], positions=[[0.0, 0.7]])
        >>> observation, info = env.reset(seed=0)
        >>> env.step(3)[1], env.step(3)[1:3]  # north, twice
        (-1.0, (0.0, True))
    """

    def __init__(
        self,
        simulator: PushingSimulator,
        goal: ArrayLike,
        positions: ArrayLike,
        *,
        radius: float = 0.06,
        max_steps: int = MAX_STEPS,
    ):
        """
        Args:
            simulator: of one tool.
            goal: float[2], of the puck's joints.
            positions: float[n, 2], where the puck may begin, drawn uniformly; as those of
                `puck_placements`, in which it touches nothing.
            radius: of the goal, above 0.
            max_steps: the length of an episode, at most.

        Raises:
            ValueError: goal or positions are none, or a number is out of its range.
        """
        self.simulator = simulator
        self._goal = _vectors("goal", goal, 1)
        self._positions = _vectors("positions", positions, 2)
        if not len(self._positions):
            raise ValueError("positions is empty; give where the puck may begin")
        if not is_number(radius):
            raise ValueError(f"radius is {radius!r}; give a number above 0")
        self._radius = positive("radius", radius)
        self._max_steps = at_least_one("max_steps", max_steps)
        size = len(simulator.initial)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (size,), np.float32)
        self.action_space = gymnasium.spaces.Discrete(len(simulator.actions))
        self.state = simulator.initial
        self._left = 0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Float32[np.ndarray, "d"], dict[str, Any]]:
        super().reset(seed=seed)
        place = self._positions[self.np_random.integers(len(self._positions))]
        self.state, self._left = self.simulator.placed(place[None])[0], self._max_steps
        return self.state.astype(np.float32), {"is_success": self._there()}

    def step(
        self, action: Any
    ) -> tuple[Float32[np.ndarray, "d"], float, bool, bool, dict[str, Any]]:
        if not self._left:
            raise gymnasium.error.ResetNeeded("call reset before step")
        if not self.action_space.contains(action):
            last = len(self.simulator.actions) - 1
            raise ValueError(f"action is {action!r}; give one from 0 to {last}")
        controls = self.simulator.actions[int(action)]
        self.state = self.simulator.step(
            self.state[None], controls[None], self.np_random if self.simulator.noise else None
        )[0]
        there = self._there()
        self._left = 0 if there else self._left - 1
        ended = there, not there and not self._left
        return self.state.astype(np.float32), 0.0 if there else -1.0, *ended, {"is_success": there}

    def _there(self) -> bool:
        """Whether the puck is at the goal."""
        return bool(np.hypot(*(self.state[self.simulator.puck] - self._goal)) <= self._radius)


def _vectors(name: str, given: ArrayLike, dimensions: int) -> Float64[np.ndarray, "*n 2"]:
    found = np.asarray(given)
    wanted = "float[2]" if dimensions == 1 else "float[n, 2]"
    good = found.dtype.kind in "iuf" and found.ndim == dimensions and found.shape[-1] == 2
    if not good or not np.isfinite(found).all():
        raise ValueError(
            f"{name} has shape {found.shape}; give {wanted}, numbers of the puck's joints"
        )
    return found.astype(np.float64)
