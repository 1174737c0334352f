"""Bounds on the capacity of a channel from a distribution over its inputs.

A channel is a matrix of probabilities P(y|x), one row an input x, dense or sparse. In nats:

    D_x = sum over y of P(y|x) ln(P(y|x) / q(y)),   q(y) = sum over x of p(x) P(y|x),
    I = sum over x of p(x) D_x   <=   C   <=   max over x of D_x,

with equality on the right exactly where p attains the capacity C (Blahut 1972, theorem 3; Arimoto
1972).
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float64

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    Channel = Float64[np.ndarray, "n m"] | csr_array

Inputs = Float64[np.ndarray, "n"]

LEAST = np.finfo(np.float64).tiny  # below, logarithms and quotients lose their digits


@dataclass(frozen=True)
class Bounds:
    """Where the capacity of a channel lies, in nats.

    Attributes:
        lower: I, what the distribution of inputs attains.
        upper: the largest D_x, and what rounding may have hidden of it.
        excess: float64[n], `D_x - I` of every input: above 0 for those worth using more.
    """

    lower: float
    upper: float
    excess: Inputs

    @property
    def gap(self) -> float:
        return max(self.upper - self.lower, 0.0)


def information_error(distance: float, outputs: int) -> float:
    """By how many bits an information changes if each row of its channel does, at most.

    Both of its entropies change by at most `T log2(O - 1) + H(T)`, T the total variation distance
    (Fannes 1973; Audenaert 2007).
    """
    t = min(distance, 0.5)
    if t <= 0:
        return 0.0
    binary = -t * np.log2(t) - (1 - t) * np.log2(1 - t)
    return float(2 * (t * np.log2(max(outputs - 1, 1)) + binary))


def neg_entropies(channel: "Channel") -> Inputs:
    """For every input, the sum of P ln P over outputs."""
    if isinstance(channel, np.ndarray):
        return np.einsum("xy,xy->x", channel, np.log(np.maximum(channel, LEAST)))
    terms = channel.copy()
    terms.data = channel.data * np.log(np.maximum(channel.data, LEAST))
    return np.asarray(terms.sum(axis=1))


def bounds(channel: "Channel", neg_entropy: Inputs, inputs: Inputs) -> Bounds:
    """The certificate of a distribution, over every input of the channel.

    The outputs' distribution is made from these very inputs and not carried along, so that the
    bounds hold whatever happened before; and the upper one is raised by the most that rounding
    can have taken from it.

    Args:
        channel: float64[n, m].
        neg_entropy: as `neg_entropies` gives them; they do not change with the inputs.
        inputs: float64[n], at least 0, with sum 1.
    """
    # Any distribution of outputs gives an upper bound, so also this one, which keeps off zero.
    outputs = np.maximum(channel.T @ inputs, LEAST)
    logs = np.log(outputs)
    divergence = neg_entropy - channel @ logs
    lower = max(float(inputs @ divergence), 0.0)
    terms = len(outputs) + len(inputs)
    largest = 1 + np.abs(logs).max() + np.abs(neg_entropy).max()
    rounding = terms * np.finfo(np.float64).eps * largest
    return Bounds(lower, float(divergence.max()) + rounding, divergence - lower)
