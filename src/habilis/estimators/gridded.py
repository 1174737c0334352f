"""Values on a grid of states, interpolated between: slow estimates at the cost of a look-up."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from jaxtyping import Float64, Int64
from numpy.typing import ArrayLike

from habilis.estimators.protocol import (
    Estimator,
    Fitted,
    Kind,
    SensorOfSimulator,
    Simulator,
    Target,
    checked_estimator,
    checked_states,
)


@dataclass(frozen=True, eq=False)
class Gridded:
    """Estimates that are interpolated linearly between the points of a grid.

    Attributes:
        axes: of each component of the state, the values of the grid in increasing order. A
            component with one value only has no influence.
        values: float64[m_1, ..., m_d], in bits.
        periods: for each component its period, as 2 pi of an angle; 0 where it has none. A
            component with a period is wrapped into the axis, which spans a whole period.
        kind: "approximation".
        target: of what was tabulated.
    """

    axes: tuple[Float64[np.ndarray, "_"], ...]
    values: Float64[np.ndarray, "*grid"]
    periods: tuple[float, ...]
    kind: Kind = "approximation"
    target: Target = "capacity"
    _corners: Int64[np.ndarray, "corners"] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        corners = np.zeros(1, np.int64)
        for length, stride in zip(self.values.shape, _strides(self.values), strict=True):
            if length > 1:
                corners = np.concatenate([corners, corners + stride])
        object.__setattr__(self, "_corners", corners)

    def bits(self, states: ArrayLike) -> Float64[np.ndarray, "n"]:
        """The interpolated estimates; outside the grid those at its edge.

        Args:
            states: float[n, d].

        Returns:
            float64[n].

        Raises:
            ValueError: states are of another length.
        """
        given = checked_states(states)
        if given.shape[1] != len(self.axes):
            raise ValueError(
                f"states have {given.shape[1]} components, the grid {len(self.axes)}; give as many"
            )
        first, shares = np.zeros(len(given), np.int64), []
        strides = _strides(self.values)
        for index, (axis, period, stride) in enumerate(
            zip(self.axes, self.periods, strides, strict=True)
        ):
            if len(axis) == 1:
                continue
            asked = given[:, index]
            if period:
                asked = axis[0] + (asked - axis[0]) % period
            left = axis.searchsorted(asked, "right").clip(1, len(axis) - 1) - 1
            share = (asked - axis[left]) / (axis[left + 1] - axis[left])
            shares.append(share.clip(0.0, 1.0)[:, None])
            first += left * stride
        found = self.values.ravel()[first[:, None] + self._corners]
        for share in reversed(shares):
            half = found.shape[1] // 2
            found = found[:, :half] * (1 - share) + found[:, half:] * share
        return found[:, 0]


@dataclass(frozen=True, eq=False)
class OnGrid:
    """An estimator that is tabulated on a grid of states, for rewards: a step costs a look-up.

    Attributes:
        method: the estimator.
        axes, periods: as in `on_grid`.

    Example:
        >>> from habilis.estimators import Counting
        >>> from habilis.estimators.simulators import double_integrator
        >>> axes = np.linspace(-3, 3, 7), [0.0]
        >>> fitted = OnGrid(Counting(0.1), axes).fit(double_integrator(), 2, seed=0)
        >>> fitted.kind, fitted.bits([[0.1, 0.0], [0.2, 5.0]]).shape
        ('approximation', (2,))
    """

    method: Estimator
    axes: Sequence[Any]
    periods: Sequence[float] | None = None

    def fit(
        self,
        simulator: Simulator,
        horizon: int,
        sensor: SensorOfSimulator = "state",
        *,
        seed: int = 0,
    ) -> Gridded:
        """Estimates at all points of the grid.

        Args:
            simulator, horizon, sensor, seed: as in the method.

        Returns:
            Interpolated estimates on request.

        Raises:
            ValueError: as in the method and in `on_grid`.
        """
        method = checked_estimator(self.method)
        return on_grid(method.fit(simulator, horizon, sensor, seed=seed), self.axes, self.periods)


def on_grid(fitted: Fitted, axes: Sequence[Any], periods: Sequence[float] | None = None) -> Gridded:
    """Tabulates an estimator.

    Args:
        fitted: the estimator.
        axes: of each component of the state, the values of the grid in increasing order; one value
            where the component has no influence or never changes.
        periods: for each component its period, 0 where it has none; by default none has one.

    Returns:
        Estimates that cost a look-up each, with an interface like `fitted`'s.

    Raises:
        ValueError: axes are none, or one with a period does not span it.

    Example:
        >>> from habilis.estimators import Gaussian
        >>> from habilis.estimators.simulators import pendulum
        >>> fitted = Gaussian(power=1, noise=0.1).fit(pendulum(), 5)
        >>> axes = np.linspace(-np.pi, np.pi, 9), np.linspace(-8, 8, 5)
        >>> table = on_grid(fitted, axes, [2 * np.pi, 0])
        >>> np.allclose(table.bits([[2 * np.pi, 0.0]]), fitted.bits([[0.0, 0.0]]))
        True
    """
    values = [np.asarray(axis, np.float64) for axis in axes]
    cycles = [0.0] * len(values) if periods is None else [float(period) for period in periods]
    if not values or len(cycles) != len(values):
        raise ValueError(f"{len(values)} axes and {len(cycles)} periods; give one of each for each")
    for index, (axis, period) in enumerate(zip(values, cycles, strict=True)):
        if axis.ndim != 1 or not len(axis) or not (np.diff(axis) > 0).all():
            raise ValueError(f"axes[{index}] does not increase; give values in order")
        if period and abs(axis[-1] - axis[0] - period) > 1e-9 * period:
            raise ValueError(
                f"axes[{index}] goes from {axis[0]:g} to {axis[-1]:g}; let it span its period, "
                f"{period:g}"
            )
    states = np.stack(np.meshgrid(*values, indexing="ij"), axis=-1).reshape(-1, len(values))
    bits = fitted.bits(states).reshape([len(axis) for axis in values])
    return Gridded(tuple(values), bits, tuple(cycles), target=fitted.target)


def _strides(values: Float64[np.ndarray, "*grid"]) -> list[int]:
    """How far apart neighbours along each axis are in the flat array."""
    return [int(np.prod(values.shape[index + 1 :])) for index in range(values.ndim)]
