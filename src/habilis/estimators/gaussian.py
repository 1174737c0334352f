"""The capacity of the linear response to actions, through Gaussian noise and under a power."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64
from numpy.typing import ArrayLike

from habilis.empowerment.arguments import positive, whole_number
from habilis.estimators.actions import ActionBox, action_size, check_size, checked_actions
from habilis.estimators.linear_response import Response, linear_response
from habilis.estimators.noise import covariance_of, whitened
from habilis.estimators.protocol import (
    Kind,
    SensorOfSimulator,
    Simulator,
    Target,
    checked_simulator,
    checked_states,
    in_jax,
    is_finite,
    is_linear,
    is_stochastic,
)
from habilis.estimators.sensors import reading

_AT_ONCE = 256  # states that are differentiated together
_CLOSED = 1e-300  # a gain that is none


@dataclass(frozen=True)
class Gaussian:
    """The capacity of the channel that a world is to small changes of the next h actions.

    The response of the sensor is linearised about nominal actions; process noise, linearised too,
    is added to the sensor's noise. With G the Jacobian for (a_1 ... a_h), N the covariance of all
    noise, and s_i the singular values of N^(-1/2) G,

        E = max of 1/2 sum log2(1 + s_i^2 p_i)   over p_i >= 0, sum p_i <= power

    (Salge, Glackin and Polani 2013), by water-filling. This is the capacity of a linear system with
    Gaussian noise whose actions are bounded by E ||(a_1 ... a_h)||^2 <= power in all. Other bounds,
    such as an `ActionBox`, have no part in it.

    Attributes:
        power: of the h actions together, about the nominal ones, above 0.
        noise: of the sensor: a standard deviation, one for each of its p components, or a
            covariance float[p, p].
        nominal: the actions about which the response is linearised: a number, float[k] or
            float[h, k].
        difference: of central finite differences, for simulators that are not functions of JAX.

    Raises:
        ValueError: a setting is out of its range.

    Example:
        >>> from habilis.estimators.simulators import linear_system
        >>> drift = linear_system([[1.0]], [[1.0]])  # s' = s + a: after 3 steps s + a_1 + a_2 + a_3
        >>> Gaussian(power=1, noise=1).fit(drift, 3).bits([[0.0]])  # 1/2 log2(1 + 3)
        array([1.])
    """

    power: float
    noise: Any
    nominal: Any = 0.0
    difference: float = 1e-4

    def __post_init__(self) -> None:
        for name in ("power", "difference"):
            value = positive(name, getattr(self, name))
            if value == np.inf:
                raise ValueError(f"{name} is infinite; give a finite number")
            object.__setattr__(self, name, value)
        covariance_of(self.noise)

    def fit(
        self,
        simulator: Simulator,
        horizon: int,
        sensor: SensorOfSimulator = "state",
        *,
        seed: int = 0,
    ) -> "FittedGaussian":
        """Prepares the derivatives; nothing is learned.

        Args:
            simulator: one whose step can be differentiated; if it is stochastic, with `noise` and
                `transition`.
            horizon: h, how many actions.
            sensor: see `habilis.estimators.sensors`.
            seed: has no part in it.

        Returns:
            Values on request. Their kind is "exact" if the simulator says that it is linear and the
            sensor is no function; "approximation" otherwise.

        Raises:
            ValueError: the simulator cannot be differentiated, or an argument is none of its kind.
        """
        horizon = whole_number("horizon", horizon)
        if is_finite(checked_simulator(simulator)):
            raise ValueError(
                "the simulator's states are labels, which have no derivative; use hb.Exact, "
                "hb.Counting or hb.MonteCarlo"
            )
        noise = 0
        if is_stochastic(simulator):
            noise = int(getattr(simulator, "noise", 0))
            if not noise or not hasattr(simulator, "transition"):
                raise ValueError(
                    "the simulator is stochastic, but does not say how: give it `noise` and "
                    "`transition`, or is_stochastic = False if its steps draw nothing"
                )
        actions = checked_actions(simulator.actions)
        size = action_size(actions)
        check_size(2 * horizon * (size + noise), horizon, size + noise)
        nominal = _nominal(self.nominal, horizon, size)
        if not in_jax(simulator):
            _check_inside(actions, nominal, self.difference)
        shown = reading(simulator, sensor)
        response = linear_response(simulator, shown, nominal, noise, self.difference)
        kind: Kind = "exact" if is_linear(simulator, sensor) else "approximation"
        return FittedGaussian(response, horizon, self.power, self.noise, kind)


@dataclass(frozen=True, eq=False)
class GaussianChannels:
    """Parallel channels with Gaussian noise, and how the power is divided between them.

    Attributes:
        bits: float64[n], the capacity of each state.
        residual: float64[n], how many bits another division of the power could add at most, from
            the conditions of Karush, Kuhn and Tucker: 0 but for rounding.
        gains: float64[n, r], s_i^2, in decreasing order.
        powers: float64[n, r], p_i.
    """

    bits: Float64[np.ndarray, "n"]
    residual: Float64[np.ndarray, "n"]
    gains: Float64[np.ndarray, "n r"]
    powers: Float64[np.ndarray, "n r"]


@dataclass(frozen=True, eq=False)
class FittedGaussian:
    """`Gaussian` of one simulator, horizon and sensor.

    Attributes:
        response: the derivatives of the sensor.
        horizon: h.
        power: of the h actions together.
        noise: of the sensor.
        kind: "exact" or "approximation".
        target: "capacity".
    """

    response: Response
    horizon: int
    power: float
    noise: Any
    kind: Kind
    target: Target = "capacity"

    def bits(self, states: ArrayLike) -> Float64[np.ndarray, "n"]:
        """The capacities at states.

        Args:
            states: float[n, d].

        Returns:
            float64[n].

        Raises:
            ValueError: the total noise is singular, or a derivative is not finite.
        """
        return self.channels(states).bits

    def channels(self, states: ArrayLike) -> GaussianChannels:
        """The channels that the world is at states, with the certificate of each capacity.

        Args:
            states: float[n, d].

        Returns:
            Gains, powers, bits and their residual.

        Raises:
            ValueError: as in `bits`.
        """
        given = checked_states(states)
        if not self.horizon or not len(given):
            none = np.zeros((len(given), 0))
            return GaussianChannels(np.zeros(len(given)), np.zeros(len(given)), none, none)
        gains = np.concatenate(
            [
                self._gains(given[first : first + _AT_ONCE])
                for first in range(0, len(given), _AT_ONCE)
            ]
        )
        return water_filling(gains, self.power)

    def _gains(self, states: Float64[np.ndarray, "n d"]) -> Float64[np.ndarray, "n r"]:
        by_action, by_noise = self.response(states)
        for jacobian in (by_action, by_noise):
            if not np.isfinite(jacobian).all():
                raise ValueError(
                    "a derivative of the sensor is not finite; give a shorter horizon, or states "
                    "and nominal actions where the simulator is smooth"
                )
        own = covariance_of(self.noise, by_action.shape[1])
        covariance = own + by_noise @ by_noise.swapaxes(1, 2)
        return np.linalg.svd(whitened(covariance, by_action), compute_uv=False) ** 2


def water_filling(gains: Float64[np.ndarray, "n r"], power: float) -> GaussianChannels:
    """The division of a power between parallel channels that carries the most (Cover and Thomas).

    Args:
        gains: in decreasing order in each row.
        power: above 0.

    Returns:
        Powers `max(0, level - 1 / gain)`, bits, and their residual.
    """
    open_ = gains > _CLOSED
    costs = np.divide(1, gains, out=np.zeros_like(gains), where=open_)
    used = np.arange(1, gains.shape[1] + 1)
    levels = (power + np.cumsum(costs, axis=1)) / used
    count = np.maximum(((levels > costs) & open_).sum(axis=1), 1)
    level = levels[np.arange(len(gains)), count - 1][:, None]
    powers = np.where(used <= count[:, None], np.maximum(level - costs, 0.0), 0.0)
    powers = np.where(open_[:, :1], powers, power / gains.shape[1])
    bits = np.log1p(gains * powers).sum(axis=1) / (2 * np.log(2))
    # The capacity is concave in the powers: it lies below its tangent, on the whole simplex.
    slopes = gains / (2 * np.log(2) * (1 + gains * powers))
    residual = power * slopes.max(axis=1) - (slopes * powers).sum(axis=1)
    return GaussianChannels(bits, np.maximum(residual, 0.0), gains, powers)


def _nominal(given: Any, horizon: int, size: int) -> Float64[np.ndarray, "h k"]:
    actions = np.asarray(given)
    fits = actions.ndim <= 2 and actions.dtype.kind in "iuf" and np.isfinite(actions).all()
    try:
        if not fits:
            raise ValueError
        return np.broadcast_to(actions.astype(np.float64), (horizon, size)).copy()
    except ValueError:
        raise ValueError(
            f"nominal is {str(given)[:60]}; give a number, {size} for each component of an action, "
            f"or [{horizon}, {size}]"
        ) from None


def _check_inside(
    actions: "Float64[np.ndarray, 'm k'] | ActionBox",
    nominal: Float64[np.ndarray, "h k"],
    difference: float,
) -> None:
    """Refuses differences across the edge of the actions, beyond which nothing changes."""
    if not isinstance(actions, ActionBox):
        return
    inside = (nominal - difference >= actions.low) & (nominal + difference <= actions.high)
    if not inside.all():
        raise ValueError(
            "nominal is on the edge of the actions or beyond, where finite differences are not "
            "derivatives; give actions well inside"
        )
