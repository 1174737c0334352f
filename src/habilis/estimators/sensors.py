"""Sensors of simulators.

A sensor of a simulator is one of

- "state": the whole state, float[n, d];
- a name that the simulator lists in `names`, or a list of such names; of a table, the name of a
  factor;
- an index, a list of indices or a slice: these entries of the observation, which is what the
  simulator's `observe` returns, and the state itself where it has none;
- a function of observations, float[n, o] -> float[n, p] (or [n]), written in JAX where the
  simulator is.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from habilis.estimators.protocol import SensorOfSimulator, Simulator

Reading = Callable[[Any], Any]
"""From states, float[n, d], to what the sensor shows of them, float[n, p]."""


def reading(simulator: Simulator, sensor: SensorOfSimulator) -> Reading:
    """The function that a sensor is.

    Args:
        simulator: the world.
        sensor: see the module.

    Returns:
        From states, float[n, d], to readings, float[n, p]; for JAX arrays where the simulator is
        one of JAX.

    Raises:
        ValueError: no such name, or no sensor at all.
    """
    if isinstance(sensor, str) and sensor == "state":
        return lambda states: states
    observe = getattr(simulator, "observe", None) or (lambda states: states)
    if callable(sensor):
        return lambda states: _as_columns(sensor(observe(states)))
    entries = _entries(simulator, sensor)
    return lambda states: _picked(observe(states), entries, sensor)


def _picked(shown: Any, entries: Any, sensor: SensorOfSimulator) -> Any:
    """Some columns; JAX would take the last one for any that does not exist."""
    there = shown.shape[1]
    if not isinstance(entries, slice) and not (-there <= entries.min() and entries.max() < there):
        raise ValueError(
            f"sensor is {sensor!r:.60}, but an observation has {there} entries; give indices from "
            f"0 to {there - 1}"
        )
    return shown[:, entries]


def _as_columns(shown: Any) -> Any:
    return shown[:, None] if shown.ndim == 1 else shown


def _entries(simulator: Simulator, sensor: SensorOfSimulator) -> Any:
    """What selects a sensor's columns of the observations."""
    if isinstance(sensor, str):
        sensor = _named(simulator, sensor)
    elif isinstance(sensor, list) and sensor and all(isinstance(name, str) for name in sensor):
        return np.concatenate([_indices(_named(simulator, name)) for name in sensor])
    if isinstance(sensor, slice):
        return sensor
    entries = np.asarray(sensor)
    if entries.ndim > 1 or not entries.size or entries.dtype.kind not in "iu":
        raise ValueError(
            f"sensor is {sensor!r:.60}; give 'state', a name, an index, a list of either, a slice "
            "of the observation, or a function of observations"
        )
    return np.atleast_1d(entries)


def _named(simulator: Simulator, name: str) -> Any:
    names: Mapping[str, Any] = getattr(simulator, "names", None) or {}
    if name not in names:
        raise ValueError(f"sensor {name!r} is unknown; use one of {', '.join(['state', *names])}")
    return names[name]


def _indices(entries: Any) -> np.ndarray:
    """Entries as a list of indices; slices of names have both ends."""
    if isinstance(entries, slice):
        return np.arange(entries.start, entries.stop, entries.step)
    return np.atleast_1d(np.asarray(entries))


def checked_reading(shown: Any, rows: int) -> np.ndarray:
    """What a sensor shows as float64[n, p], else a ValueError."""
    values = np.asarray(shown, np.float64)
    if values.ndim != 2 or len(values) != rows:
        raise ValueError(
            f"the sensor gives shape {np.shape(shown)} of {rows} observations; give one row each"
        )
    if not np.isfinite(values).all():
        raise ValueError("the sensor shows numbers that are not finite; give another sensor")
    return values
