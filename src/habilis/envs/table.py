"""A table as a Gymnasium environment."""

from typing import Any

import gymnasium
import numpy as np

from habilis.mdp import TabularMDP


class TableEnv(gymnasium.Env[np.ndarray, np.int64]):
    """A deterministic table, one step a look-up.

    Observation: the value of each factor, counted from 0 among those that it has (`MultiDiscrete`).
    Action: `Discrete`, the table's. Reward and termination are the table's; an episode is cut off
    (truncated) after `max_steps`. Episodes begin in the table's start.

    Example:
        >>> import habilis as hb
        >>> env = TableEnv(hb.tabulate(hb.load_world("yard")))
        >>> observation, info = env.reset(seed=0)
        >>> env.step(2)[1]
        -1.0
    """

    def __init__(self, mdp: TabularMDP, max_steps: int = 500):
        """
        Args:
            mdp: a deterministic table.
            max_steps: the length of an episode, at most.
        """
        factors = list(mdp.factors.values()) or [np.arange(mdp.states)]
        ranked = [np.unique(labels, return_inverse=True) for labels in factors]
        self._observations = np.stack([places for _, places in ranked], axis=1).astype(np.int64)
        self._next_state = mdp.next_state.tolist()
        self._reward = mdp.reward.astype(float).tolist()
        self._terminal = mdp.terminal.tolist()
        self._start, self._max_steps = mdp.start, max_steps
        self._state, self._steps = mdp.start, 0
        self.observation_space: Any = gymnasium.spaces.MultiDiscrete(
            [len(values) for values, _ in ranked]
        )
        self.action_space: Any = gymnasium.spaces.Discrete(mdp.next_state.shape[1])

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        super().reset(seed=seed)
        self._state, self._steps = self._start, 0
        return self._observations[self._state].copy(), {"state": self._state}

    def step(self, action: Any) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        reward = self._reward[self._state][action]
        self._state = state = self._next_state[self._state][action]
        self._steps += 1
        terminated = self._terminal[state]
        truncated = not terminated and self._steps >= self._max_steps
        return self._observations[state].copy(), reward, terminated, truncated, {"state": state}
