"""The cases whose empowerment is known, and the choice among them."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float64, Int64

from habilis.estimators.protocol import SensorOfSimulator, Simulator, Target


@dataclass(frozen=True, eq=False)
class Case:
    """A question to an estimator whose answer is known.

    Attributes:
        name: of the case.
        simulator: the world.
        horizon: h, how many actions.
        sensor: see `habilis.estimators.sensors`.
        states: float64[n, d], the states asked about.
        bits: float64[n], the truth.
        error: float64[n], by how much the truth may be wrong: 0 of a count, the certified gap of a
            capacity that the solver found; of a line, by how much finer actions could be better.
        target: "capacity", or "effective": the information of the first of the h actions, all drawn
            uniformly, and the observation after the last.
        power: the bound on E ||(a_1 ... a_h)||^2 of a world whose actions have no other; `None`
            where the simulator's actions are all there is.
        about: the case in half a sentence.
    """

    name: str
    simulator: Simulator
    horizon: int
    sensor: SensorOfSimulator
    states: Float64[np.ndarray, "n d"]
    bits: Float64[np.ndarray, "n"] = field(repr=False)
    error: Float64[np.ndarray, "n"] = field(repr=False)
    target: Target = "capacity"
    power: float | None = None
    about: str = ""


def suite(names: Iterable[str] | None = None) -> list[Case]:
    """The cases with known empowerment.

    Finite worlds, deterministic and slippery, through full-state and object sensors; noisy channels
    from 2 inputs to 256; effective empowerment; linear systems with Gaussian noise under a power,
    in closed form; and continuous worlds whose sensors are rounded, or that are discretised finely.
    The truths are computed when they are asked for, those that take seconds once: they are kept in
    `habilis.cache.cache_folder()`.

    Args:
        names: which, see `case_names`; by default all. Continuous cases need `habilis[robots]`.

    Returns:
        The cases, in the order of the names.

    Raises:
        ValueError: an unknown name.
        MissingExtraError: JAX is not installed, and a continuous case is among them.

    Example:
        >>> (maze,) = suite(["maze"])
        >>> maze.horizon, maze.bits.min().round(2), maze.bits.max().round(2)
        (5, np.float64(3.46), np.float64(5.52))
    """
    made = _makers()
    chosen = list(made) if names is None else list(names)
    unknown = [name for name in chosen if name not in made]
    if unknown:
        raise ValueError(f"case {unknown[0]!r} is unknown; use {', '.join(made)}")
    return [made[name](name) for name in chosen]


def case_names() -> list[str]:
    """The names of all cases, in the order of `suite`.

    Returns:
        As `suite` takes them.

    Example:
        >>> case_names()[:2]
        ['maze', 'maze-10']
    """
    return list(_makers())


def _makers() -> dict[str, Callable[[str], Case]]:
    from habilis.estimators.evaluation import continuous_cases, finite_cases

    return finite_cases.MAKERS | continuous_cases.MAKERS


def spread(bits: Float64[np.ndarray, "n"], count: int) -> Int64[np.ndarray, "m"]:
    """The places of so many values, from the least to the largest at even distances."""
    free = np.ones(len(bits), bool)
    for wanted in np.linspace(bits.min(), bits.max(), min(count, len(bits))):
        free[np.argmin(np.where(free, abs(bits - wanted), np.inf))] = False
    return np.flatnonzero(~free)
