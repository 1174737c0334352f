"""Sums and products of the values through several sensors.

They are sums and products of bits: not the empowerment through a joint sensor, which a joint label
of each state gives.
"""

from collections.abc import Callable, Sequence
from itertools import chain

import numpy as np
from jaxtyping import Float64

from habilis.empowerment.sensors import Sensor, factor_of
from habilis.mdp import TabularMDP

Values = Float64[np.ndarray, "*n"]


def terms_of(mdp: TabularMDP, sensor: Sensor) -> list[list[Sensor]]:
    """The sensors whose values are multiplied in each term of a sum.

    Args:
        mdp: the table. What is all of it a factor's name is that factor.
        sensor: as in `empowerment`.

    Example:
        >>> mdp = TabularMDP.deterministic([[0]])
        >>> terms_of(mdp, "object:can + object:can2")
        [['object:can'], ['object:can2']]
        >>> terms_of(mdp, "object:can*object:can2")
        [['object:can', 'object:can2']]
    """
    if not isinstance(sensor, str) or sensor in mdp.factors:
        return [[sensor]]
    return [[name.strip() for name in term.split("*")] for term in sensor.split("+")]


def is_combined(mdp: TabularMDP, sensor: Sensor) -> bool:
    """Whether a sensor is a sum or a product of several."""
    terms = terms_of(mdp, sensor)
    return len(terms) > 1 or len(terms[0]) > 1


def check_single(mdp: TabularMDP, sensor: Sensor, beside: str = "") -> None:
    """Refuses a sum or a product of sensors.

    Args:
        mdp: the table.
        sensor: as in `empowerment`.
        beside: what does not go with several, for the message.

    Raises:
        ValueError: it is one.
    """
    if is_combined(mdp, sensor):
        why = f"with {beside} " if beside else ""
        raise ValueError(f"sensor is {sensor!r}, several; {why}give one alone")


def check_names(
    mdp: TabularMDP, sensor: str, argument: str = "sensor", besides: Sequence[str] = ()
) -> None:
    """Refuses a sensor of which the table lacks a factor.

    Args:
        mdp: the table.
        sensor: a name, or sums and products of several.
        argument: what the error calls it.
        besides: what else the argument may be, where it is no sum or product.

    Raises:
        ValueError: names the factor that is missing, and those that there are.
    """
    others = () if is_combined(mdp, sensor) else besides
    for name in chain(*terms_of(mdp, sensor)):
        factor_of(mdp, str(name), argument, others)


def combined(mdp: TabularMDP, sensor: Sensor, through: Callable[[Sensor], Values]) -> Values:
    """Values through a sensor, or the sums and products of those through several.

    Args:
        mdp: the table.
        sensor: as in `empowerment`.
        through: is asked for the values through each single sensor, once.

    Raises:
        ValueError: as in `check_names`, before anything is computed.
    """

    def certain(one: Sensor) -> tuple[Values, Values]:
        values = through(one)
        return values, np.zeros_like(values)

    return combined_with_gaps(mdp, sensor, certain)[0]


def combined_with_gaps(
    mdp: TabularMDP, sensor: Sensor, through: Callable[[Sensor], tuple[Values, Values]]
) -> tuple[Values, Values]:
    """As `combined`, of lower bounds and their gaps.

    A value lies from m to m + g, all of them from 0 up, so that

        m_1 + m_2 <= sum <= m_1 + m_2 + (g_1 + g_2)
        m_1 m_2 <= product <= (m_1 + g_1)(m_2 + g_2) = m_1 m_2 + (m_1 g_2 + g_1 (m_2 + g_2))

    Gaps of a sum are added, and that of a product is the difference of the two bounds.
    """
    terms = terms_of(mdp, sensor)
    if len(terms) == len(terms[0]) == 1:
        return through(terms[0][0])
    check_names(mdp, str(sensor))
    known = {name: through(name) for name in dict.fromkeys(chain(*terms))}
    products = [_product([known[name] for name in term]) for term in terms]
    values, gaps = zip(*products, strict=True)
    return np.sum(values, axis=0), np.sum(gaps, axis=0)


def _product(factors: Sequence[tuple[Values, Values]]) -> tuple[Values, Values]:
    value, gap = factors[0]
    for other, wide in factors[1:]:
        value, gap = value * other, value * wide + gap * (other + wide)
    return value, gap
