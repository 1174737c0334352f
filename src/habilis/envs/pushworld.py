"""Puzzles of PushWorld and Sokoban as Gymnasium environments, one at a time and many at once."""

from operator import index
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Discrete, MultiDiscrete
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from jaxtyping import Bool, Int64

from habilis.bridges.puzzles.pushworld import PushWorld
from habilis.bridges.puzzles.sokoban import puzzle_named
from habilis.envs.rendering import FRAMES_PER_SECOND, in_terminal
from habilis.envs.table import MAX_STEPS
from habilis.envs.vector import Stepped, autoreset_of, checked_actions, ended_error, final_info
from habilis.worlds.pictures.figures import frame

MODES = ("ansi", "rgb_array")


class PushWorldEnv(gymnasium.Env[Int64[np.ndarray, "bodies"], np.int64]):
    """A puzzle as a Gymnasium environment, of any size: no table is made of it.

    Observation: `MultiDiscrete`, the cell of each body's upper left corner, the agent's first, as
    `row * columns + column`. Actions: `Discrete(4)`, left, right, up, down. Reward: -1 a step, and
    0 for the one that solves the puzzle, which terminates the episode. `gymnasium.make` truncates
    it after 500 steps (`max_episode_steps`).

    Attributes:
        puzzle: the puzzle.
        state: a tuple of int, as `PushWorld` has it.

    Example:
        >>> import gymnasium
        >>> puzzle = PushWorld.parse("A M0 G0")
        >>> env = gymnasium.make("habilis/PushWorld-v0", puzzle=puzzle)
        >>> observation, info = env.reset(seed=0)
        >>> env.step(1)
        (array([1, 2]), 0.0, True, False, {})
    """

    metadata = {"render_modes": list(MODES), "render_fps": FRAMES_PER_SECOND}  # noqa: RUF012  # as Gymnasium has it

    def __init__(self, puzzle: PushWorld | str | Path, render_mode: str | None = None):
        """
        Args:
            puzzle: a puzzle, or the path of one (`.pwp`, `.xsb`, `levels.xsb#3`).
            render_mode: "ansi", "rgb_array", or `None`.

        Raises:
            ValueError: the file is no puzzle, or there is no such mode.
        """
        self.puzzle, self.render_mode = _puzzle(puzzle), _checked_mode(render_mode)
        self.state = self.puzzle.initial
        self.observation_space: Any = _space(self.puzzle)
        self.action_space: Any = Discrete(len(self.puzzle.actions))

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        super().reset(seed=seed)
        self.state = self.puzzle.initial
        return np.array(self.state), {}

    def step(self, action: Any) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        actions = len(self.puzzle.actions)
        try:
            chosen = index(action)
        except TypeError:
            chosen = -1  # no whole number
        if not 0 <= chosen < actions:
            raise ValueError(f"action is {action!r}; use 0 to {actions - 1}")
        self.state = self.puzzle.step(self.state, chosen)
        solved = self.puzzle.solved(self.state)
        return np.array(self.state), float(solved) - 1.0, solved, False, {}

    def render(self) -> Any:
        if self.render_mode is None:
            gymnasium.logger.warn('render() draws nothing: make it with render_mode="rgb_array"')
            return None
        return _rendered(self.puzzle, self.state, self.render_mode)


class PushWorldVectorEnv(VectorEnv[np.ndarray, np.ndarray, np.ndarray]):
    """N copies of a puzzle, stepped together; each is a `PushWorldEnv`.

    Gymnasium's autoreset modes are those of `TableVectorEnv`.

    Attributes:
        puzzle: the puzzle.
        state: int64[N, bodies].

    Example:
        >>> import gymnasium
        >>> puzzle = PushWorld.parse("A M0 G0")
        >>> envs = gymnasium.make_vec("habilis/PushWorld-v0", num_envs=2, puzzle=puzzle)
        >>> observations, info = envs.reset(seed=0)
        >>> envs.step(np.array([1, 0]))[1]
        array([ 0., -1.])
    """

    metadata = {"render_modes": list(MODES), "render_fps": FRAMES_PER_SECOND}  # noqa: RUF012  # as Gymnasium has it

    def __init__(
        self,
        num_envs: int,
        puzzle: PushWorld | str | Path,
        max_episode_steps: int = MAX_STEPS,
        render_mode: str | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
    ):
        """
        Args:
            num_envs: N.
            puzzle, render_mode: as in `PushWorldEnv`.
            max_episode_steps: the length of an episode, at most.
            autoreset_mode: Gymnasium's, or its name: "NextStep", "SameStep", "Disabled".

        Raises:
            ValueError: as in `PushWorldEnv`, or a number is out of its range.
        """
        for name, value in (("num_envs", num_envs), ("max_episode_steps", max_episode_steps)):
            if isinstance(value, bool) or not isinstance(value, int) or value < 1:
                raise ValueError(f"{name} is {value!r}; give a whole number of at least 1")
        self.puzzle, self.render_mode = _puzzle(puzzle), _checked_mode(render_mode)
        self.num_envs, self._most = num_envs, max_episode_steps
        self._mode = autoreset_of(autoreset_mode)
        self.metadata = self.metadata | {"autoreset_mode": self._mode}
        self.single_observation_space: Any = _space(self.puzzle)
        self.single_action_space: Any = Discrete(len(self.puzzle.actions))
        self.observation_space: Any = batch_space(self.single_observation_space, num_envs)
        self.action_space: Any = batch_space(self.single_action_space, num_envs)
        self._start = np.array(self.puzzle.initial)
        self.state = np.tile(self._start, (num_envs, 1))
        self._steps, self._ended = np.zeros(num_envs, np.int64), np.zeros(num_envs, bool)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begins new episodes.

        Args:
            seed: as Gymnasium has it; a puzzle draws no random numbers.
            options: `{"reset_mask": bool[N]}`: where to begin; everywhere if left out.

        Returns:
            Observations of all environments, N in front, and `info`.

        Raises:
            ValueError: the mask is not a bool for every environment.
        """
        super().reset(seed=seed)
        mask = (options or {}).get("reset_mask", np.ones(self.num_envs, bool))
        if getattr(mask, "shape", None) != (self.num_envs,) or mask.dtype != bool:
            raise ValueError(f"reset_mask is {mask!r}; give an array of {self.num_envs} bools")
        self._restart(mask)
        return self.state.copy(), {}

    def step(self, actions: Any) -> Stepped:
        chosen = checked_actions(actions, self.num_envs, len(self.puzzle.actions))
        if self._mode is AutoresetMode.DISABLED and self._ended.any():
            raise ended_error(self._ended)
        begins = self._ended & (self._mode is AutoresetMode.NEXT_STEP)
        self.state = self.puzzle.step_many(self.state, chosen)
        self._steps += 1
        terminated = self.puzzle.terminal_many(self.state)
        rewards = terminated - 1.0
        rewards[begins] = 0.0
        self._restart(begins)  # these make no step
        terminated &= ~begins
        truncated = (self._steps >= self._most) & ~terminated & ~begins
        self._ended = terminated | truncated
        info: dict[str, Any] = {}
        if self._mode is AutoresetMode.SAME_STEP and self._ended.any():
            info = final_info(self._ended, self.state[self._ended], {})
            self._restart(self._ended)
        return self.state.copy(), rewards, terminated, truncated, info

    def render(self) -> tuple[Any, ...] | None:
        if self.render_mode is None:
            gymnasium.logger.warn('render() draws nothing: make it with render_mode="rgb_array"')
            return None
        states = map(tuple, self.state.tolist())
        return tuple(_rendered(self.puzzle, state, self.render_mode) for state in states)

    def _restart(self, mask: Bool[np.ndarray, "N"]) -> None:
        self.state[mask], self._steps[mask] = self._start, 0
        self._ended = self._ended & ~mask


def _puzzle(given: PushWorld | str | Path) -> PushWorld:
    if isinstance(given, PushWorld):
        return given
    puzzle = puzzle_named(str(given)) if isinstance(given, str | Path) else None
    if puzzle is None:
        raise ValueError(f"puzzle is {given!r}; give a puzzle, or the path of a .pwp or .xsb file")
    return puzzle


def _checked_mode(mode: Any) -> str | None:
    if mode is not None and mode not in MODES:
        raise ValueError(f"render_mode {mode!r} is unknown; use one of {', '.join(MODES)}")
    return mode


def _space(puzzle: PushWorld) -> MultiDiscrete:
    return MultiDiscrete([puzzle.height * puzzle.width] * len(puzzle.bodies))


def _rendered(puzzle: PushWorld, state: tuple[int, ...], mode: str) -> Any:
    shown = puzzle.at(state)
    return in_terminal(shown.colored_text()) if mode == "ansi" else frame(shown)
