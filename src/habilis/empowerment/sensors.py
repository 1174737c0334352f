"""Sensors: what the agent perceives of a state, as one label a state."""

import numpy as np
from jaxtyping import Int32
from numpy.typing import ArrayLike

from habilis.mdp import TabularMDP
from habilis.probabilities import as_array

Sensor = str | ArrayLike
"""A factor's name, "state" for all of it, or int[S] labels."""


def observations(mdp: TabularMDP, sensor: Sensor) -> tuple[Int32[np.ndarray, "S"], int]:
    """What is perceived in each state.

    Args:
        mdp: the table.
        sensor: "state", the name of a factor, or an int[S] array of labels. Labels need not be
            consecutive: states with equal labels look alike, and nothing else matters.

    Returns:
        Labels renumbered from 0 without gaps, and how many there are.

    Raises:
        ValueError: no such factor, or an array that is not one integer a state.
    """
    if isinstance(sensor, str):
        if sensor == "state":
            return np.arange(mdp.states, dtype=np.int32), mdp.states
        if sensor not in mdp.factors:
            raise ValueError(
                f"sensor {sensor!r} is unknown; use one of {', '.join(['state', *mdp.factors])}"
            )
        labels = mdp.factors[sensor]
    else:
        labels = as_array("sensor", sensor)
        if labels.shape != (mdp.states,) or not np.issubdtype(labels.dtype, np.integer):
            raise ValueError(
                f"sensor has shape {labels.shape} and type {labels.dtype}; "
                f"give one integer label for each of the {mdp.states} states"
            )
    values, renumbered = np.unique(labels, return_inverse=True)
    return renumbered.astype(np.int32), len(values)
