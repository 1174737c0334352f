"""Empowerment in the reward of any environment that can be tabulated."""

from collections.abc import Sequence
from dataclasses import fields
from functools import partial
from inspect import signature
from typing import Any, no_type_check

import gymnasium
import numpy as np
from gymnasium.utils import RecordConstructorArgs
from gymnasium.vector import AutoresetMode, SyncVectorEnv, VectorEnv, VectorWrapper
from jaxtyping import Float64, Int64
from numpy.typing import ArrayLike

from habilis.bridges.gymnasium.snapshots import Identity, StateFunctions
from habilis.empowerment.methods import Exact, Method
from habilis.empowerment.sensors import Sensor
from habilis.envs.tabulated_states import (
    Measure,
    Position,
    TabulatedStates,
    same_table,
    tabulated_states,
)
from habilis.envs.vector import TableVectorEnv
from habilis.estimators.protocol import is_estimator
from habilis.mdp import TabularMDP
from habilis.rewards.measures import Policy, measured, under_policy
from habilis.rewards.shaping import EMPOWERMENT, EXTRINSIC, Bonus, regularised

_EXACT = Exact()


class EmpowermentReward(gymnasium.Wrapper, RecordConstructorArgs):
    """Adds empowerment to the reward: r + beta * M(s'), s' the state that the step leads to.

    (Equation 1 of Rasheed, Polani and Catenacci Volpi 2023, M in bits.)

    For one environment, and for a vector environment, of which it makes a `VectorEmpowermentReward`
    with the same arguments: the worlds, Gymnasium's toy-text environments, and whatever
    `TabularMDP.from_gymnasium` can enumerate, small Minigrids among them; of these a new episode
    may have another layout, which is enumerated when it first appears. Values are computed once
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

    changes_reward = True
    """For tables of what is around it (see `gymnasium_tables.verification`)."""

    def __new__(cls, env: Any = None, *args: Any, **kwargs: Any) -> Any:  # copies give no env
        if is_estimator(kwargs.get("method")):
            return _estimated(env, args, kwargs)
        if isinstance(env, VectorEnv):
            return VectorEmpowermentReward(env, *args, **kwargs)
        return super().__new__(cls)

    def __init__(
        self,
        env: gymnasium.Env,
        horizon: int,
        sensor: Sensor = "state",
        beta: float | None = None,
        actions: ArrayLike | None = None,
        *,
        method: Method = _EXACT,
        beta_schedule: str = "constant",
        beta_steps: int = 0,
        earned: str = "next",
        terminal_bonus: bool = True,
        extrinsic: bool = True,
        discount: float = 0.99,
        max_states: int = 100_000,
        ignore: Sequence[str] = (),
        state: StateFunctions | None = None,
    ):
        """
        Args:
            env: an environment, or a vector environment.
            horizon, sensor, actions: of the empowerment M, as in `habilis.empowerment`; sums and
                products of several sensors, as "object:can + object:ball", are sensors too, and so
                are other kinds of empowerment: "goal-directed:object", "closed-loop:object", and
                "effective:object" with horizon 0, with `discount` under the uniform policy, or
                one that `follow` is given.
            beta: its weight, in reward a bit; it must be given.
            method: how M is found, as in `habilis.empowerment`. With an estimator, such as
                `hb.Gaussian`, this makes an `EstimatedReward`, which needs no table: of Gymnasium's
                MuJoCo environments, or with `simulator=` and `state=`, of any other.
            beta_schedule: "constant", "linear" or "exponential".
            beta_steps: environment steps after which beta is 0 (linear) or has halved
                (exponential); those of all copies of a vector environment count.
            earned: whose M is added: the "next" state's, the "current" one's, or the "difference"
                discount * next - current, a potential, which leaves the best policy alone.
            terminal_bonus: whether entering a terminal state earns it too.
            extrinsic: whether the environment's reward is part of the reward at all.
            discount: of the agent that learns; for "difference".
            max_states: how many states an enumerated table may have.
            ignore, state: what the state of an enumerated environment is, as in
                `TabularMDP.from_gymnasium`.

        Raises:
            ValueError: the environment has no table, as in `TabularMDP.from_gymnasium`; or as in
                `habilis.empowerment`; or a setting is out of its range. `step` raises it where
                a step differs from the table's.
            TypeError: beta is left out.
        """
        chosen: dict[str, Any] = {} if method == _EXACT else {"method": method}
        RecordConstructorArgs.__init__(
            self,
            **chosen,
            **{"horizon": horizon, "sensor": sensor, "beta": beta, "actions": actions},
            **{"beta_schedule": beta_schedule, "beta_steps": beta_steps, "earned": earned},
            **{"terminal_bonus": terminal_bonus, "extrinsic": extrinsic},
            **{"discount": discount, "max_states": max_states, "ignore": ignore, "state": state},
        )
        gymnasium.Wrapper.__init__(self, env)
        weight = _given(beta)
        bonus = Bonus(weight, beta_schedule, beta_steps, earned, terminal_bonus, extrinsic)
        self._numbers = bonus.numbers(discount)
        measure = partial(_measured, horizon, sensor, discount, actions, method)
        self._states = tabulated_states(env, measure, max_states, Identity(None, ignore, state))
        self._position, self._taken = Position(env, self._states), 0
        self._under = partial(_measured_under, sensor, discount, method)

    def follow(self, policy: Policy) -> None:
        """Computes effective empowerment anew, under the agent's policy.

        To be called every so many updates; until then the policy is uniform.

        Args:
            policy: float[S, A], in the order of states of `TabularMDP.from_gymnasium`; or a
                function from a table to that array, which environments with several layouts need.

        Raises:
            ValueError: the sensor is no effective empowerment, or the policy is none.
        """
        self._states.measure(partial(self._under, policy))

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        observation, info = self.env.reset(seed=seed, options=options)
        self._position.begin(observation)
        return observation, info | {EMPOWERMENT: float(self._states.values[self._position.state])}

    def step(self, action: Any) -> tuple[Any, float, Any, Any, dict[str, Any]]:
        if self._position.state < 0:
            raise gymnasium.error.ResetNeeded("call reset before step")
        observation, reward, terminated, truncated, info = self.env.step(action)
        before = self._position.state
        self._position.step(action, observation, terminated, truncated)
        values, here = self._states.values, self._position.state
        total = regularised(
            *(self._numbers, reward, values[here], values[before], terminated, self._taken)
        )
        self._taken += 1
        added = {EXTRINSIC: reward, EMPOWERMENT: float(values[here])}
        return observation, float(total), terminated, truncated, info | added


def _estimated(env: Any, args: tuple[Any, ...], settings: dict[str, Any]) -> Any:
    from habilis.envs.estimated_reward import EstimatedReward

    if isinstance(env, VectorEnv):
        raise ValueError(
            "an estimator is for single environments; wrap each in EmpowermentReward before it is "
            "vectorised"
        )
    names = [*signature(EmpowermentReward.__init__).parameters][2:]
    given = dict(zip(names, args, strict=False)) | settings
    foreign = [name for name in ("actions", "max_states", "ignore") if name in given]
    if foreign:
        raise ValueError(
            f"{foreign[0]} is for tables, and the method is an estimator; leave it out"
        )
    return EstimatedReward(env, **given)


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
        sensor: Sensor = "state",
        beta: float | None = None,
        actions: ArrayLike | None = None,
        *,
        method: Method = _EXACT,
        discount: float = 0.99,
        max_states: int = 100_000,
        ignore: Sequence[str] = (),
        state: StateFunctions | None = None,
        **settings: Any,
    ):
        """
        Args:
            env: one of ours, or a `SyncVectorEnv` of environments that can be tabulated.
            horizon, sensor, beta, actions, method, discount, max_states, ignore, state, settings:
                as in `EmpowermentReward`.

        Raises:
            ValueError: as there, or the environments are not in this process.
            TypeError: there is no such setting, or beta is left out.
        """
        super().__init__(env)
        known = {f.name for f in fields(Bonus)}
        for name in settings:
            if name not in known:
                raise TypeError(f"setting {name!r} is unknown; use some of {', '.join(known)}")
        self._numbers = Bonus(beta=_given(beta), **settings).numbers(discount)
        measure = partial(_measured, horizon, sensor, discount, actions, method)
        identity = Identity(None, ignore, state)
        self._states = _states_of(env.unwrapped, measure, max_states, identity)
        self._under = partial(_measured_under, sensor, discount, method)
        self._bonus = self._constant_bonus()
        self._mode = env.metadata.get("autoreset_mode", AutoresetMode.NEXT_STEP)
        self._taken = 0
        self._before = np.empty(0, np.int64)
        self._everywhere = np.ones(self.num_envs, bool)
        self._ended, self._any = np.zeros(self.num_envs, bool), False

    def follow(self, policy: Policy) -> None:
        """Computes effective empowerment anew, under the agent's policy.

        Args:
            policy: as in `EmpowermentReward.follow`.

        Raises:
            ValueError: as there.
        """
        self._states.measure(partial(self._under, policy))
        self._bonus = self._constant_bonus()

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
        self._any = bool(self._ended.any())
        self._before = self._states.now()
        return observations, info | self._masked({EMPOWERMENT: self._states.values[self._before]})

    def step(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        if not len(self._before):
            raise gymnasium.error.ResetNeeded("call reset before step")
        observations, rewards, terminated, truncated, info = self.env.step(actions)
        now, ended = self._states.now(), terminated | truncated
        reached, any_ended = now, bool(ended.any())
        if self._mode is AutoresetMode.SAME_STEP and any_ended:
            reached = self._states.last(now, ended, info)
        bits = self._states.values.take(reached)
        if self._bonus is None:
            of_current = self._states.values.take(self._before)
            total = regularised(self._numbers, rewards, bits, of_current, terminated, self._taken)
        else:
            total = self._bonus.take(reached)
            total += rewards
        if self._mode is AutoresetMode.NEXT_STEP and self._any:
            np.copyto(total, rewards, where=self._ended)
        self._taken += self.num_envs
        self._before, self._ended, self._any = now, ended, any_ended
        added = {EXTRINSIC: rewards.copy(), EMPOWERMENT: bits}
        return observations, total, terminated, truncated, info | self._masked(added)

    def _constant_bonus(self) -> Float64[np.ndarray, "S"] | None:
        """The bonus of a step to each state, where nothing else decides on it: one look-up."""
        n = self._numbers
        constant = n["beta_falls"] == n["beta_halves"] == n["of_current"] == 0
        simple = constant and n["of_terminal"] == n["extrinsic"] == 1
        if not simple or not isinstance(self._states, _OwnStates):
            return None
        values = self._states.values
        return regularised(n, 0.0, values, np.zeros_like(values), False, 0)

    def _masked(self, columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """With the mask of environments that Gymnasium's vector infos have beside each array."""
        return columns | {f"_{name}": self._everywhere.copy() for name in columns}


class _OwnStates:
    """The states of our vector environment, which has their indices."""

    def __init__(self, env: TableVectorEnv, measure: Measure):
        self._env, self.values = env, measure(env.dynamics)

    def now(self) -> Int64[np.ndarray, "N"]:
        return self._env.state

    def last(self, now: Any, ended: Any, info: dict[str, Any]) -> Any:
        return np.where(ended, info["final_info"]["state"], now)

    def measure(self, measure: Measure) -> None:
        self.values = measure(self._env.dynamics)


class _Followed(gymnasium.Wrapper):
    """Follows where one of many environments is, also in episodes that end within a step."""

    def __init__(self, env: gymnasium.Env, states: TabulatedStates):
        super().__init__(env)
        self.position = Position(env, states)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        observation, info = self.env.reset(seed=seed, options=options)
        self.position.begin(observation)
        return observation, info

    def step(self, action: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        returned = self.env.step(action)
        observation, _, terminated, truncated, _ = returned
        self.position.step(action, observation, terminated, truncated)
        return returned


class _ManyStates:
    """The states of a `SyncVectorEnv`, each of whose environments is followed."""

    def __init__(
        self, vector: SyncVectorEnv, measure: Measure, max_states: int, identity: Identity
    ):
        envs: list[Any] = vector.envs
        for number, env in enumerate(envs[1:], start=1):
            if not same_table(envs[0], env):
                raise ValueError(
                    f"environment {number} differs from environment 0; wrap each environment "
                    "in EmpowermentReward before it is vectorised"
                )
        self._states = tabulated_states(envs[0], measure, max_states, identity)
        self._followed = [_Followed(env, self._states) for env in envs]
        envs[:] = self._followed

    @property
    def values(self) -> Float64[np.ndarray, "S"]:
        return self._states.values

    def now(self) -> Int64[np.ndarray, "N"]:
        return np.array([env.position.state for env in self._followed])

    def last(self, now: Any, ended: Any, info: dict[str, Any]) -> Any:
        return np.where(ended, [env.position.reached for env in self._followed], now)

    def measure(self, measure: Measure) -> None:
        self._states.measure(measure)


def _states_of(
    env: Any, measure: Measure, max_states: int, identity: Identity
) -> _OwnStates | _ManyStates:
    if isinstance(env, TableVectorEnv):
        return _OwnStates(env, measure)
    if isinstance(env, SyncVectorEnv):
        return _ManyStates(env, measure, max_states, identity)
    raise ValueError(
        f"the states of a {type(env).__name__} cannot be accessed from this process; wrap each "
        "environment "
        "in EmpowermentReward before it is vectorised"
    )


@no_type_check  # environments contain it, and what the tests' checks put around it cannot be copied
def _measured(
    horizon: int,
    sensor: Sensor,
    discount: float,
    actions: ArrayLike | None,
    method: Method,
    mdp: TabularMDP,
) -> Float64[np.ndarray, "S"]:
    return measured(mdp, horizon, sensor, discount, actions, method)


@no_type_check
def _measured_under(
    sensor: Sensor, discount: float, method: Method, policy: Policy, mdp: TabularMDP
) -> Float64[np.ndarray, "S"]:
    return under_policy(mdp, sensor, discount, policy, method.tolerance)


def _given(beta: float | None) -> float:
    if beta is None:
        raise TypeError("beta is missing; give the weight of empowerment, as beta=0.1")
    return beta
