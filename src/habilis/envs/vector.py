"""Many copies of a table at once as a Gymnasium vector environment: a step is a few look-ups."""

from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from jaxtyping import Bool, Int, Int8, Int64, Shaped

from habilis.envs.observations import Observation, ranks
from habilis.envs.table import (
    ACTION_MASK,
    MAX_STEPS,
    action_masks,
    check_episode,
    unavailable,
)
from habilis.mdp import TabularMDP
from habilis.probabilities import as_array
from habilis.transitions import Transitions

Stepped = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]


class TableVectorEnv(VectorEnv[np.ndarray, np.ndarray, np.ndarray]):
    """N environments on one table; each is a `TableEnv`.

    What happens after the last step of an episode goes by Gymnasium's autoreset modes:
    `NEXT_STEP`, the step that follows leaves its action aside, begins the next episode and has
    reward 0; `SAME_STEP`, the observation is already the next episode's first, and
    `info["final_obs"]` and `info["final_info"]` have the last; `DISABLED`, the caller resets with
    `options={"reset_mask": ...}`.

    Where actions are not available everywhere, `info["action_mask"]`, int8[N, A], has a 1 for those
    that are, as `action_space.sample(mask=tuple(info["action_mask"]))` takes it.

    Attributes:
        mdp: the table.
        state: int64[N], the states that the environments are in.

    Example:
        >>> import habilis as hb
        >>> envs = TableVectorEnv(hb.tabulate(hb.load_world("yard")), num_envs=3)
        >>> observations, info = envs.reset(seed=0)
        >>> envs.step(np.array([0, 1, 2]))[1]
        array([-1., -1., -1.])
    """

    def __init__(
        self,
        mdp: TabularMDP,
        num_envs: int,
        max_steps: int = MAX_STEPS,
        *,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        observation: Observation | None = None,
        columns: Mapping[str, Shaped[np.ndarray, "S"]] | None = None,
        slip: float = 0.0,
    ):
        """
        Args:
            mdp: the table.
            num_envs: N.
            max_steps: the length of an episode, at most.
            autoreset_mode: Gymnasium's, or its name: "NextStep", "SameStep", "Disabled".
            observation, columns, slip: as in `TableEnv`.

        Raises:
            ValueError: as in `TableEnv`, or there is no such mode.
        """
        check_episode(mdp, max_steps, slip)
        if isinstance(num_envs, bool) or not isinstance(num_envs, int) or num_envs < 1:
            raise ValueError(f"num_envs is {num_envs!r}; give a whole number of at least 1")
        shown = ranks(mdp) if observation is None else observation
        self.mdp, self.num_envs = mdp, num_envs
        self._mode = autoreset_of(autoreset_mode)
        self.metadata = self.metadata | {"autoreset_mode": self._mode}
        self._transitions = Transitions.of(mdp)
        self._terminal, self._masks = mdp.ends, action_masks(mdp)
        self._columns = dict(columns or {})
        self._show, self._actions = shown.show, mdp.action_count
        self._max_steps, self._slip = max_steps, slip
        self._everywhere = np.ones(num_envs, bool)
        self.single_observation_space: Any = shown.space
        self.single_action_space: Any = gymnasium.spaces.Discrete(mdp.action_count)
        self.observation_space: Any = batch_space(shown.space, num_envs)
        self.action_space: Any = batch_space(self.single_action_space, num_envs)
        self._restart(np.ones(num_envs, bool))

    @property
    def dynamics(self) -> TabularMDP:
        """The table with its slip."""
        return self.mdp.slippery(self._slip)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begins new episodes.

        Args:
            seed: of all the random numbers from here on; `None` goes on with those there are.
            options: `{"reset_mask": bool[N]}`: where to begin; everywhere if left out.

        Returns:
            Observations of all environments, N in front, and `info`.

        Raises:
            ValueError: the mask is not a bool for every environment.
        """
        super().reset(seed=seed)
        mask = (options or {}).get("reset_mask")
        if mask is None:
            self._restart(np.ones(self.num_envs, bool))
        elif (
            not isinstance(mask, np.ndarray) or mask.shape != (self.num_envs,) or mask.dtype != bool
        ):
            raise ValueError(f"reset_mask is {mask!r}; give an array of {self.num_envs} bools")
        else:
            self._restart(mask)
        return self._show(self.state), self._info()

    def step(self, actions: Any) -> Stepped:
        chosen = self._checked(actions)
        if self._mode is AutoresetMode.DISABLED and self._any:
            raise ended_error(self._ended)
        begins = self._ended if self._mode is AutoresetMode.NEXT_STEP and self._any else None
        transition = self.state * self._actions
        transition += chosen
        if self._transitions.outcomes > 1:
            draws = self.np_random.random(self.num_envs)
            transition = self._transitions.drawn(transition, draws)
        after = self._transitions.next_state.take(transition)
        rewards = self._transitions.reward.take(transition)
        self._steps += 1
        if begins is not None:  # these make no step: their next episode begins
            after[begins], rewards[begins], self._steps[begins] = self.mdp.start, 0.0, 0
        terminated = self._terminal.take(after)
        truncated = self._steps >= self._max_steps
        truncated &= ~terminated
        if begins is not None:
            terminated[begins] = truncated[begins] = False
        self.state = after.astype(np.int64)
        self._ended = terminated | truncated
        self._any = bool(self._ended.any())
        final: dict[str, Any] = {}
        if self._any and self._mode is AutoresetMode.SAME_STEP:
            final = self._final(self._ended)
            self._restart(self._ended)
        return self._show(self.state), rewards, terminated, truncated, self._info() | final

    def _checked(self, actions: Any) -> Int[np.ndarray, "N"]:
        """The actions, some of them replaced by random ones if there is slip."""
        chosen = checked_actions(actions, self.num_envs, self._actions)
        if self._masks is not None:
            chosen = self._available(chosen, self._masks)
        if self._slip:
            slips = self.np_random.random(self.num_envs) < self._slip
            return np.where(slips, self._any_actions(), chosen)
        return chosen

    def _available(
        self, chosen: Int[np.ndarray, "N"], masks: Int8[np.ndarray, "S A"]
    ) -> Int[np.ndarray, "N"]:
        """The actions, if they are available; those of ended episodes do not matter."""
        wrong = (masks[self.state, chosen] == 0) & ~self._ended
        if wrong.any():
            first = int(np.argmax(wrong))
            where = f" of environment {first}"
            raise ValueError(unavailable(masks, int(self.state[first]), int(chosen[first]), where))
        return chosen

    def _any_actions(self) -> Int64[np.ndarray, "N"]:
        """An action for each, drawn uniformly from those available."""
        if self._masks is None:
            return self.np_random.integers(self._actions, size=self.num_envs)
        there = self._masks[self.state]
        place = self.np_random.integers(np.maximum(there.sum(axis=1), 1))
        return (np.cumsum(there, axis=1) > place[:, None]).argmax(axis=1)

    def _restart(self, mask: Bool[np.ndarray, "N"]) -> None:
        if mask.all():
            self.state = np.full(self.num_envs, self.mdp.start, np.int64)
            self._steps = np.zeros(self.num_envs, np.int64)
            self._ended = np.zeros(self.num_envs, bool)
        else:
            self.state[mask], self._steps[mask], self._ended[mask] = self.mdp.start, 0, False
        self._any = bool(self._ended.any())

    def _info(self) -> dict[str, Any]:
        """Arrays of the values that one environment has, each beside the mask of environments."""
        info: dict[str, Any] = {"state": self.state.copy()}
        for name, column in self._columns.items():
            info[name] = column.take(self.state)
        if self._masks is not None:
            info[ACTION_MASK] = self._masks[self.state]
        info.update({f"_{name}": self._everywhere.copy() for name in tuple(info)})
        return info

    def _final(self, mask: Bool[np.ndarray, "N"]) -> dict[str, Any]:
        """The last observations and infos of episodes that end, in Gymnasium's format."""
        return final_info(mask, self._show(self.state[mask]), self._info())


def ended_error(ended: Bool[np.ndarray, "N"]) -> ValueError:
    """The error of a step after an episode's end, where the caller has to reset."""
    return ValueError(
        f"the episode of environment {int(np.argmax(ended))} has ended; "
        'reset it first, with options={"reset_mask": ...}'
    )


def checked_actions(actions: Any, num_envs: int, count: int) -> Int[np.ndarray, "N"]:
    """The actions of a step.

    Raises:
        ValueError: they are not one of `count` for each environment.
    """
    chosen = as_array("actions", actions)
    if chosen.shape != (num_envs,) or chosen.dtype.kind not in "iu":
        raise ValueError(
            f"actions have shape {chosen.shape} and type {chosen.dtype}; "
            f"give {num_envs} whole numbers"
        )
    # As unsigned numbers negative ones are large: one comparison for both ends.
    if chosen.view(chosen.dtype.str.replace("i", "u")).max() >= count:
        wrong = int(np.argmax((chosen < 0) | (chosen >= count)))
        raise ValueError(
            f"action {chosen[wrong]} of environment {wrong} is unknown; use 0 to {count - 1}"
        )
    return chosen


def final_info(
    mask: Bool[np.ndarray, "N"], observations: Shaped[np.ndarray, "n *shape"], info: dict[str, Any]
) -> dict[str, Any]:
    """The last observations and infos of the n episodes that end, in Gymnasium's format."""
    last = np.full(len(mask), None, dtype=object)
    for number, shown in zip(np.flatnonzero(mask), observations, strict=True):
        last[number] = shown
    for value in info.values():  # the masks among them
        value[~mask] = 0
    return {
        "final_obs": last,
        "_final_obs": mask.copy(),
        "final_info": info,
        "_final_info": mask.copy(),
    }


def autoreset_of(given: AutoresetMode | str) -> AutoresetMode:
    try:
        return AutoresetMode(given)
    except ValueError:
        known = ", ".join(mode.value for mode in AutoresetMode)
        raise ValueError(f"autoreset_mode {given!r} is unknown; use one of {known}") from None
