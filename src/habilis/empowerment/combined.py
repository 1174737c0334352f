"""Empowerment through several sensors at once: sums and products of that through each."""

from collections.abc import Callable

import numpy as np
from jaxtyping import Float64

from habilis.empowerment.sensors import Sensor


def terms_of(sensor: str) -> list[list[str]]:
    """The sensors whose empowerments are multiplied in each term of a sum.

    Example:
        >>> terms_of("object:can + object:can2")
        [['object:can'], ['object:can2']]
        >>> terms_of("object:can*object:can2")
        [['object:can', 'object:can2']]
    """
    return [[name.strip() for name in term.split("*")] for term in sensor.split("+")]


def combined(
    sensor: Sensor, empowerment_through: Callable[[Sensor], Float64[np.ndarray, "S"]]
) -> Float64[np.ndarray, "S"]:
    """The empowerment of every state through a sensor, or the sum, or product, of several.

    Args:
        sensor: as in `empowerment`, or several names, as in `terms_of`.
        empowerment_through: what is asked for that through each of them, once.
    """
    if not isinstance(sensor, str):
        return empowerment_through(sensor)
    terms = terms_of(sensor)
    names = dict.fromkeys(name for term in terms for name in term)
    bits = {name: empowerment_through(name) for name in names}
    return np.sum([np.prod([bits[name] for name in term], axis=0) for term in terms], axis=0)
