"""Estimated empowerment in the reward of environments without a table, such as robots."""

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
from gymnasium.utils import RecordConstructorArgs
from jaxtyping import Float64

from habilis.estimators.protocol import (
    Estimator,
    Fitted,
    SensorOfSimulator,
    Simulator,
    checked_simulator,
)
from habilis.rewards.shaping import EMPOWERMENT, EXTRINSIC, Bonus, regularised

StateOf = Callable[[Any], Any]


class EstimatedReward(gymnasium.Wrapper, RecordConstructorArgs):
    """`EmpowermentReward` with an estimator as its method: r + beta * M(s'), M estimated.

    The estimator is fitted once; what is amortised over states then costs next to nothing a step.
    `info` is that of `EmpowermentReward`.

    Example:
        >>> import gymnasium
        >>> import habilis as hb
        >>> env = gymnasium.make("InvertedPendulum-v5")
        >>> env = hb.EmpowermentReward(
        ...     env, 3, "hinge", beta=0.1, method=hb.Gaussian(power=1.0, noise=0.01)
        ... )
        >>> observation, info = env.reset(seed=0)
        >>> info["empowerment"] > 0
        True
    """

    changes_reward = True
    """For tables of what is around it (see `gymnasium_tables.verification`)."""

    def __init__(
        self,
        env: gymnasium.Env,
        horizon: int,
        sensor: SensorOfSimulator = "state",
        beta: float | None = None,
        *,
        method: Estimator,
        simulator: Simulator | None = None,
        state: StateOf | None = None,
        seed: int = 0,
        beta_schedule: str = "constant",
        beta_steps: int = 0,
        earned: str = "next",
        terminal_bonus: bool = True,
        extrinsic: bool = True,
        discount: float = 0.99,
    ):
        """
        Args:
            env: an environment.
            horizon, sensor, seed: of the estimator's fit.
            beta: the weight of empowerment, in reward a bit; it must be given.
            method: the estimator.
            simulator: of the environment; by default that of `gymnasium_simulator`, for MuJoCo's.
            state: a function of the unwrapped environment that returns float[d], its state as the
                simulator has it. It is needed with a simulator.
            beta_schedule, beta_steps, earned, terminal_bonus, extrinsic, discount: as in
                `EmpowermentReward`.

        Raises:
            ValueError: the environment is none of MuJoCo's and has no simulator, or as in the
                estimator and `EmpowermentReward`.
            TypeError: beta is left out.
        """
        RecordConstructorArgs.__init__(
            self,
            **{"horizon": horizon, "sensor": sensor, "beta": beta, "method": method},
            **{"simulator": simulator, "state": state, "seed": seed},
            **{"beta_schedule": beta_schedule, "beta_steps": beta_steps, "earned": earned},
            **{"terminal_bonus": terminal_bonus, "extrinsic": extrinsic, "discount": discount},
        )
        gymnasium.Wrapper.__init__(self, env)
        if beta is None:
            raise TypeError("beta is missing; give the weight of empowerment, as beta=0.1")
        bonus = Bonus(beta, beta_schedule, beta_steps, earned, terminal_bonus, extrinsic)
        self._numbers = bonus.numbers(discount)
        known, self._state_of = _simulated(env, simulator, state)
        self._fitted: Fitted = method.fit(known, horizon, sensor, seed=seed)
        self._before, self._taken = np.nan, 0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        observation, info = self.env.reset(seed=seed, options=options)
        self._before = self._bits()
        return observation, info | {EMPOWERMENT: self._before}

    def step(self, action: Any) -> tuple[Any, float, Any, Any, dict[str, Any]]:
        if np.isnan(self._before):
            raise gymnasium.error.ResetNeeded("call reset before step")
        observation, reward, terminated, truncated, info = self.env.step(action)
        reached = self._bits()
        ended = bool(terminated)
        numbers = self._numbers, float(reward), reached, self._before, ended, self._taken
        self._before, self._taken = reached, self._taken + 1
        added = {EXTRINSIC: reward, EMPOWERMENT: reached}
        return observation, float(regularised(*numbers)), terminated, truncated, info | added

    def _bits(self) -> float:
        """The estimate for the state that the environment is in."""
        state = np.asarray(self._state_of(self.env.unwrapped), np.float64)
        if state.ndim != 1:
            raise ValueError(f"state returns shape {state.shape}; let it return one vector")
        return float(self._fitted.bits(state[None])[0])


def _simulated(
    env: gymnasium.Env, simulator: Simulator | None, state: StateOf | None
) -> tuple[Simulator, StateOf]:
    """The simulator of an environment, and how its state is read."""
    if (simulator is None) != (state is None):
        has, lacks = ("state", "simulator") if simulator is None else ("simulator", "state")
        raise ValueError(f"{has} is given without {lacks}; give both, or neither")
    if simulator is not None and state is not None:
        return checked_simulator(simulator), state
    if not hasattr(env.unwrapped, "set_state"):
        raise ValueError(
            f"{type(env.unwrapped).__name__} is no MuJoCo environment; give simulator= and state=, "
            "or a method of tables such as hb.Exact()"
        )
    from habilis.estimators.simulators.gymnasium_mujoco import gymnasium_simulator

    return gymnasium_simulator(env), _of_mujoco


def _of_mujoco(inside: Any) -> Float64[np.ndarray, "d"]:
    """Positions and velocities."""
    return np.concatenate([inside.data.qpos, inside.data.qvel])
