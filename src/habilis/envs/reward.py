"""Empowerment in the reward of any environment whose table can be had."""

from collections.abc import Sequence
from dataclasses import fields
from typing import Any

import gymnasium
import numpy as np
from gymnasium.utils import RecordConstructorArgs
from gymnasium.vector import AutoresetMode, SyncVectorEnv, VectorEnv, VectorWrapper
from jaxtyping import Float64, Int64

from habilis.empowerment.bonus import Bonus, regularised
from habilis.empowerment.keeping import kept_empowerment
from habilis.empowerment.sensors import Sensor
from habilis.envs.places import Measure, places_of, same_table
from habilis.envs.vector import Stepped, TableVectorEnv

EXTRINSIC, EMPOWERMENT = "extrinsic_reward", "empowerment"
"""What `info` says: the environment's own reward, and the bits of the state that was reached."""


class EmpowermentReward(gymnasium.Wrapper, RecordConstructorArgs):
    """Adds empowerment to the reward: r + beta * M(s'), s' the state that the step leads to.

    (Equation 1 of Rasheed, Polani and Catenacci Volpi 2023, M in bits.)

    For one environment, and for a vector environment, of which it makes a `VectorEmpowermentReward`
    with the same arguments: the worlds, Gymnasium's toy-text environments, and whatever
    `TabularMDP.from_gymnasium` can enumerate, small Minigrids among them; of these a new episode
    may have another layout, which is enumerated when it is met first. Values are computed once
    for a table, and then read from the disk.

    `info` has the environment's own reward as "extrinsic_reward", and as "empowerment" the bits of
    the state that was reached. `RecordEpisodeStatistics` around this counts the reward with the
    bonus, inside of it the one without.

    Example:
        >>> import gymnasium
        >>> env = gymnasium.make("FrozenLake-v1", is_slippery=False)
        >>> env = EmpowermentReward(env, horizon=2, sensor="state", beta=0.1)
        >>> observation, info = env.reset(seed=0)
        >>> observation, reward, *ends, info = env.step(2)
        >>> round(float(reward), 3), info["extrinsic_reward"], round(info["empowerment"], 2)
        (0.281, 0, 2.81)
    """

    def __new__(cls, env: Any = None, *args: Any, **kwargs: Any) -> Any:  # copies give no env
        if isinstance(env, VectorEnv):
            return VectorEmpowermentReward(env, *args, **kwargs)
        return super().__new__(cls)

    def __init__(
        self,
        env: gymnasium.Env,
        horizon: int,
        sensor: Sensor,
        beta: float,
        actions: Sequence[int] | None = None,
        *,
        beta_schedule: str = "constant",
        beta_steps: int = 0,
        earned: str = "next",
        terminal_bonus: bool = True,
        extrinsic: bool = True,
        discount: float = 0.99,
        max_states: int = 100_000,
    ):
        """
        Args:
            env: an environment, or a vector environment.
            horizon, sensor, actions: of the empowerment M, as in `habilis.empowerment`; or, as in
                "object:can + object:ball" and "object:can*object:ball", the sum or product of M
                through several sensors.
            beta: its weight, in reward a bit.
            beta_schedule: "constant", "linear" or "exponential".
            beta_steps: environment steps after which beta is 0 (linear) or has halved
                (exponential); those of all copies of a vector environment count.
            earned: whose M is added: the "next" state's, the "current" one's, or the "difference"
                discount * next - current, a potential, which leaves the best policy alone.
            terminal_bonus: whether entering a terminal state earns it too.
            extrinsic: whether the environment's reward is part of the reward at all.
            discount: of the agent that learns; for "difference".
            max_states: how many states an enumerated table may have.

        Raises:
            ValueError: the environment's table cannot be had, as in `TabularMDP.from_gymnasium`;
                or as in `habilis.empowerment`; or a setting is out of its range.
        """
        RecordConstructorArgs.__init__(
            self,
            **{"horizon": horizon, "sensor": sensor, "beta": beta, "actions": actions},
            **{"beta_schedule": beta_schedule, "beta_steps": beta_steps, "earned": earned},
            **{"terminal_bonus": terminal_bonus, "extrinsic": extrinsic},
            **{"discount": discount, "max_states": max_states},
        )
        gymnasium.Wrapper.__init__(self, env)
        bonus = Bonus(beta, beta_schedule, beta_steps, earned, terminal_bonus, extrinsic)
        self._numbers = bonus.numbers(discount)
        self._places = places_of(env, _measure(horizon, sensor, actions), max_states)
        self._taken, self._place = 0, -1

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        observation, info = self.env.reset(seed=seed, options=options)
        self._place = self._places.of(self.unwrapped)
        return observation, info | {EMPOWERMENT: float(self._places.values[self._place])}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        if self._place < 0:
            raise gymnasium.error.ResetNeeded("call reset before step")
        observation, reward, terminated, truncated, info = self.env.step(action)
        before, self._place = self._place, self._places.of(self.unwrapped)
        values = self._places.values
        worth = regularised(
            *(self._numbers, reward, values[self._place], values[before], terminated, self._taken)
        )
        self._taken += 1
        told = {EXTRINSIC: reward, EMPOWERMENT: float(values[self._place])}
        return observation, float(worth), terminated, truncated, info | told


class VectorEmpowermentReward(VectorWrapper):
    """`EmpowermentReward` of a vector environment.

    `info` has "extrinsic_reward" and "empowerment" as arrays. Where an episode ends and the next
    one begins in the same step, both speak of the state in which it ended. A step that only begins
    an episode (autoreset mode "NextStep") has reward 0 and no bonus.
    """

    def __init__(
        self,
        env: VectorEnv,
        horizon: int,
        sensor: Sensor,
        beta: float,
        actions: Sequence[int] | None = None,
        *,
        discount: float = 0.99,
        max_states: int = 100_000,
        **settings: Any,
    ):
        """
        Args:
            env: one of ours, or a `SyncVectorEnv` of environments of which tables can be had.
            horizon, sensor, beta, actions, discount, max_states, settings: as in
                `EmpowermentReward`.

        Raises:
            ValueError: as there, or the environments are not in this process.
            TypeError: there is no such setting.
        """
        super().__init__(env)
        known = {f.name for f in fields(Bonus)}
        for name in settings:
            if name not in known:
                raise TypeError(f"setting {name!r} is unknown; use some of {', '.join(known)}")
        self._numbers = Bonus(beta=beta, **settings).numbers(discount)
        measure = _measure(horizon, sensor, actions)
        self._states = _states_of(env.unwrapped, measure, max_states)
        self._mode = env.metadata.get("autoreset_mode", AutoresetMode.NEXT_STEP)
        self._taken = 0
        self._before = np.empty(0, np.int64)
        self._ended = np.zeros(self.num_envs, bool)

    def reset(
        self,
        *,
        seed: int | list[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Any, dict[str, Any]]:
        mask = (options or {}).get("reset_mask")
        # A copy: wrappers take the mask out of what they are given, and others need it still.
        given: Any = seed
        observations, info = self.env.reset(seed=given, options=options and dict(options))
        self._ended = self._ended & (False if mask is None else ~mask)
        self._before = self._states.now()
        return observations, info | self._told({EMPOWERMENT: self._states.values[self._before]})

    def step(self, actions: Any) -> Stepped:
        if not len(self._before):
            raise gymnasium.error.ResetNeeded("call reset before step")
        observations, rewards, terminated, truncated, info = self.env.step(actions)
        now, ended = self._states.now(), terminated | truncated
        reached = now
        if self._mode is AutoresetMode.SAME_STEP and ended.any():
            reached = self._states.last(self._before, actions, now, ended, info)
        values = self._states.values
        worth = regularised(
            *(self._numbers, rewards, values[reached], values[self._before], terminated),
            self._taken,
        )
        if self._mode is AutoresetMode.NEXT_STEP:
            worth = np.where(self._ended, rewards, worth)
        self._taken += self.num_envs
        self._before, self._ended = now, ended
        told = {EXTRINSIC: rewards.copy(), EMPOWERMENT: values[reached]}
        return observations, worth, terminated, truncated, info | self._told(told)

    def _told(self, told: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """With what Gymnasium's vector infos have beside each array: for whom it is told."""
        return told | {f"_{name}": np.ones(self.num_envs, bool) for name in told}


class _OwnStates:
    """Of our vector environment, which says where its copies are."""

    def __init__(self, env: TableVectorEnv, measure: Measure):
        self._env, self.values = env, measure(env.dynamics)

    def now(self) -> Int64[np.ndarray, "N"]:
        return self._env.state

    def last(self, before: Any, actions: Any, now: Any, ended: Any, info: dict[str, Any]) -> Any:
        return np.where(ended, info["final_info"]["state"], now)


class _ManyStates:
    """Of a `SyncVectorEnv`, whose environments are asked one by one."""

    def __init__(self, envs: list[gymnasium.Env], measure: Measure, max_states: int):
        for number, env in enumerate(envs[1:], start=1):
            if not same_table(envs[0], env):
                raise ValueError(
                    f"environment {number} is another than environment 0; wrap each environment "
                    "in EmpowermentReward before it is vectorised"
                )
        self._envs = [env.unwrapped for env in envs]
        self._places = places_of(envs[0], measure, max_states)

    @property
    def values(self) -> Float64[np.ndarray, "S"]:
        return self._places.values

    def now(self) -> Int64[np.ndarray, "N"]:
        return np.array([self._places.of(env) for env in self._envs])

    def last(self, before: Any, actions: Any, now: Any, ended: Any, info: dict[str, Any]) -> Any:
        reached, states = now.copy(), info.get("final_info", {}).get("state")
        for i in np.flatnonzero(ended):
            # Only ours have "state"; others may have what is no array, such as statistics.
            of_one = {} if states is None else {"state": states[i]}
            reached[i] = self._places.last(
                int(before[i]), int(actions[i]), info["final_obs"][i], of_one
            )
        return reached


def _states_of(env: Any, measure: Measure, max_states: int) -> _OwnStates | _ManyStates:
    if isinstance(env, TableVectorEnv):
        return _OwnStates(env, measure)
    if isinstance(env, SyncVectorEnv):
        return _ManyStates(list(env.envs), measure, max_states)
    raise ValueError(
        f"the states of a {type(env).__name__} cannot be seen from here; wrap each environment "
        "in EmpowermentReward before it is vectorised"
    )


def _measure(horizon: int, sensor: Sensor, actions: Sequence[int] | None) -> Measure:
    return lambda mdp: kept_empowerment(mdp, horizon, sensor, actions)
