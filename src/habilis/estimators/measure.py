"""Empowerment by an estimator, as `habilis.empowerment` asks for it."""

from typing import Any

import numpy as np
from jaxtyping import Float64

from habilis.estimators.protocol import (
    Estimator,
    SensorOfSimulator,
    Simulator,
    checked_simulator,
    checked_states,
)
from habilis.estimators.simulators.finite import FiniteSimulator
from habilis.mdp import TabularMDP
from habilis.progress import progress_bar
from habilis.worlds.world import World

_AT_ONCE = 64  # states between two reports


def estimated_bits(
    model: TabularMDP | Simulator | Any,
    horizon: int,
    sensor: SensorOfSimulator,
    states: Any,
    method: Estimator,
    seed: int = 0,
    show_progress: bool = False,
) -> Float64[np.ndarray, "n"]:
    """Fits an estimator, and returns its values of states.

    Args:
        model: a simulator, or a table, whose states are then indices.
        horizon, sensor, method, seed: of the fit.
        states: float[n, d]; of a table indices, by default all.
        show_progress: whether to draw a progress bar on standard error.

    Returns:
        float64[n].

    Raises:
        ValueError: the model is neither, or there are no states.
    """
    if isinstance(model, TabularMDP):
        finite = FiniteSimulator(model)
        simulator: Simulator = finite
        asked = np.arange(model.states) if states is None else np.asarray(states)
        if asked.dtype == bool and asked.shape == (model.states,):
            asked = np.flatnonzero(asked)
        given = checked_states(asked.reshape(-1, 1))
        finite.indices(given)  # which refuses others, also where no step is made
    elif isinstance(model, World):
        raise ValueError(
            "an estimator takes a simulator or a table, no world; give hb.tabulate(world)"
        )
    else:
        simulator = checked_simulator(model)
        if states is None:
            raise ValueError("a simulator has no list of its states; give states=, float[n, d]")
        given = checked_states(states)
    fitted = method.fit(simulator, horizon, sensor, seed=seed)
    if not show_progress:
        return fitted.bits(given)
    with progress_bar("states", show_progress) as report:
        found = []
        for first in range(0, len(given), _AT_ONCE):
            report(first, len(given))
            found.append(fitted.bits(given[first : first + _AT_ONCE]))
    return np.concatenate([np.empty(0), *found])
