"""A table as a Gymnasium environment."""

from collections.abc import Mapping
from operator import index
from typing import Any

import gymnasium
import numpy as np
from jaxtyping import Int8, Shaped

from habilis.checks import is_probability
from habilis.envs.observations import Observation, ranks
from habilis.envs.registration import MAX_STEPS
from habilis.mdp import TabularMDP
from habilis.transitions import Transitions

ACTION_MASK = "action_mask"
"""The key of `info` with the available actions, where some are not available everywhere."""


class TableEnv(gymnasium.Env[np.ndarray, np.int64]):
    """A table, one step a look-up.

    Observation: as given, by default the value of each factor, counted from 0 among those that it
    has (`MultiDiscrete`). Action: `Discrete`, the table's. Reward and termination are the table's;
    an episode is cut off (truncated) after `max_steps`. Episodes begin in the table's start. `info`
    has the state's index as "state", and the state's values in the given columns.

    Where actions are not available everywhere, `info["action_mask"]`, int8[A], has a 1 for those
    that are, as `action_space.sample(mask=info["action_mask"])` takes it; a step with another is
    refused. Slip draws among the available ones. In a state without actions an episode terminates.

    Attributes:
        mdp: the table.
        slip: the probability that a random action replaces the chosen one.
        state: the index of the state that the environment is in.

    Example:
        >>> import habilis as hb
        >>> env = TableEnv(hb.tabulate(hb.load_world("yard")))
        >>> observation, info = env.reset(seed=0)
        >>> env.step(2)[1]
        -1.0
    """

    def __init__(
        self,
        mdp: TabularMDP,
        max_steps: int = MAX_STEPS,
        *,
        observation: Observation | None = None,
        columns: Mapping[str, Shaped[np.ndarray, "S"]] | None = None,
        slip: float = 0.0,
    ):
        """
        Args:
            mdp: the table; random outcomes are drawn from `np_random`.
            max_steps: the length of an episode, at most.
            observation: of states; by default the value of each factor.
            columns: by name, a value for every state.
            slip: the probability that an action drawn uniformly takes the place of the chosen one.

        Raises:
            ValueError: the table's start has no action, or a number is out of its range.
        """
        check_episode(mdp, max_steps, slip)
        shown = ranks(mdp) if observation is None else observation
        self.mdp, self._columns = mdp, dict(columns or {})
        self._look_up()
        self._show, self._actions = shown.show, mdp.action_count
        self._max_steps, self.slip = max_steps, slip
        self.state, self._steps = mdp.start, 0
        self.observation_space: Any = shown.space
        self.action_space: Any = gymnasium.spaces.Discrete(mdp.action_count)

    def _look_up(self) -> None:
        """Views, not lists: they give Python's own numbers as fast, and take no time to make."""
        self._transitions = transitions = Transitions.of(self.mdp)
        self._next_state, self._reward = transitions.next_state.data, transitions.reward.data
        self._random = transitions.outcomes > 1
        self._terminal = self.mdp.ends.data
        self._masks = action_masks(self.mdp)
        self._info_columns = [(name, column.data) for name, column in self._columns.items()]

    def __getstate__(self) -> dict[str, Any]:
        """For copies: views cannot be copied."""
        views = ("_transitions", "_next_state", "_reward", "_terminal", "_info_columns", "_masks")
        return {name: value for name, value in vars(self).items() if name not in views}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._look_up()

    @property
    def dynamics(self) -> TabularMDP:
        """The table with its slip."""
        return self.mdp.slippery(self.slip)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        super().reset(seed=seed)
        self.state, self._steps = self.mdp.start, 0
        return self._show(self.state), self._info()

    def step(self, action: Any) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        try:
            chosen = index(action)
        except TypeError:
            chosen = -1  # no whole number
        if not 0 <= chosen < self._actions:
            raise ValueError(f"action is {action!r}; use 0 to {self._actions - 1}")
        if self._masks is not None and not self._masks[self.state, chosen]:
            raise ValueError(unavailable(self._masks, self.state, chosen))
        if self.slip and self.np_random.random() < self.slip:
            chosen = self._any_action()
        transition = self.state * self._actions + chosen
        if self._random:
            transition = self._transitions.drawn(transition, self.np_random.random())
        self.state = state = self._next_state[transition]
        reward = self._reward[transition]
        self._steps += 1
        ended: Any = self._terminal[state]
        cut = not ended and self._steps >= self._max_steps
        return self._show(state), reward, ended, cut, self._info()

    def _any_action(self) -> int:
        """One drawn uniformly from those available."""
        if self._masks is None:
            return int(self.np_random.integers(self._actions))
        there = np.flatnonzero(self._masks[self.state])
        return int(there[self.np_random.integers(len(there))])

    def observe(self, state: int) -> np.ndarray:
        """The observation of a state.

        Args:
            state: its index.

        Returns:
            An observation, as `step` returns it.
        """
        return self._show(state)

    def _info(self) -> dict[str, Any]:
        state = self.state
        info: dict[str, Any] = {"state": state}
        for name, column in self._info_columns:
            info[name] = column[state]
        if self._masks is not None:
            info[ACTION_MASK] = self._masks[state].copy()
        return info


def check_episode(mdp: TabularMDP, max_steps: int, slip: float) -> None:
    """Raises ValueError: a start without actions, or a number out of its range."""
    if mdp.ends[mdp.start] and not mdp.terminal[mdp.start]:
        raise ValueError(f"no action is available in state {mdp.start}; give another start")
    if isinstance(max_steps, bool) or not isinstance(max_steps, int) or max_steps < 1:
        raise ValueError(f"max_steps is {max_steps!r}; give a whole number of at least 1")
    if not is_probability(slip):
        raise ValueError(f"slip is {slip!r}; give a probability from 0 to 1")


def action_masks(mdp: TabularMDP) -> Int8[np.ndarray, "S A"] | None:
    """1 where an action is available, 0 elsewhere; `None` where all are everywhere."""
    return None if mdp.always_available else mdp.available.astype(np.int8)


def unavailable(masks: Int8[np.ndarray, "S A"], state: int, action: int, where: str = "") -> str:
    """The message that an action is not available, and which are.

    Args:
        masks: of `action_masks`.
        state, action: the pair.
        where: further words on the place, as " of environment 3".
    """
    there = np.flatnonzero(masks[state])
    if not len(there):
        return f"no action is available in state {state}{where}: its episode has ended; reset it"
    return (
        f"action {action} is not available in state {state}{where}; "
        f"use one of {', '.join(map(str, there))}"
    )
