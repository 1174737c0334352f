"""Values on a grid of states, interpolated between: slow estimates at the cost of a look-up."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64
from numpy.typing import ArrayLike

from habilis.estimators.protocol import Fitted, Kind, Target, checked_states


@dataclass(frozen=True, eq=False)
class Gridded:
    """Estimates that are interpolated linearly between the points of a grid.

    Attributes:
        axes: of each component of the state, the values of the grid in increasing order.
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

    def bits(self, states: ArrayLike) -> Float64[np.ndarray, "n"]:
        """The interpolated estimates; outside the grid those at its edge.

        Args:
            states: float[n, d].

        Returns:
            float64[n].

        Raises:
            ValueError: states are of another length.
        """
        from scipy.interpolate import RegularGridInterpolator

        given = checked_states(states).copy()
        if given.shape[1] != len(self.axes):
            raise ValueError(
                f"states have {given.shape[1]} components, the grid {len(self.axes)}; give as many"
            )
        for index, (axis, period) in enumerate(zip(self.axes, self.periods, strict=True)):
            if period:
                given[:, index] = axis[0] + (given[:, index] - axis[0]) % period
            given[:, index] = np.clip(given[:, index], axis[0], axis[-1])
        return np.asarray(RegularGridInterpolator(self.axes, self.values)(given), np.float64)


def on_grid(fitted: Fitted, axes: Sequence[Any], periods: Sequence[float] | None = None) -> Gridded:
    """Tabulates an estimator.

    Args:
        fitted: the estimator.
        axes: of each component of the state, the values of the grid in increasing order, at least
            two.
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
        if axis.ndim != 1 or len(axis) < 2 or not (np.diff(axis) > 0).all():
            raise ValueError(f"axes[{index}] does not increase; give at least two values in order")
        if period and abs(axis[-1] - axis[0] - period) > 1e-9 * period:
            raise ValueError(
                f"axes[{index}] goes from {axis[0]:g} to {axis[-1]:g}; let it span its period, "
                f"{period:g}"
            )
    states = np.stack(np.meshgrid(*values, indexing="ij"), axis=-1).reshape(-1, len(values))
    bits = fitted.bits(states).reshape([len(axis) for axis in values])
    return Gridded(tuple(values), bits, tuple(cycles), target=fitted.target)
