"""Clipping, optimisers, schedules and initial weights for `reference_actor_critic`, in NumPy.

From the documentation of torch.optim.Adam, torch.optim.RMSprop, torch.nn.utils.clip_grad_norm_,
torch.nn.init.calculate_gain and torch.nn.Linear.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

Arrays = Sequence[Float[np.ndarray, "..."]]

GAINS = {"tanh": 5 / 3, "relu": math.sqrt(2), "selu": 3 / 4, "sigmoid": 1.0}


class Moments(NamedTuple):
    """An optimiser's state for each array: averages of gradients and of their squares."""

    steps: int
    first: Arrays
    second: Arrays

    @classmethod
    def fresh(cls, arrays: Arrays) -> "Moments":
        """Before the first step."""
        return cls(0, [np.zeros(a.shape) for a in arrays], [np.zeros(a.shape) for a in arrays])


def apply(
    optimizer: str, arrays: Arrays, gradients: Arrays, moments: Moments, rate: float
) -> tuple[list[np.ndarray], Moments]:
    """The arrays and moments after one step.

    adam: decays 0.9 and 0.999, bias correction, epsilon 1e-8 outside the root.
    rmsprop: decay 0.99, epsilon 1e-5 inside the root. rmsprop-torch: outside.
    """
    steps = moments.steps + 1
    after, first, second = [], [], []
    for array, g, m, v in zip(arrays, gradients, moments.first, moments.second, strict=True):
        if optimizer == "adam":
            m = 0.9 * m + 0.1 * g
            v = 0.999 * v + 0.001 * g**2
            change = (m / (1 - 0.9**steps)) / (np.sqrt(v / (1 - 0.999**steps)) + 1e-8)
        elif optimizer == "rmsprop":
            v = 0.99 * v + 0.01 * g**2
            change = g / np.sqrt(v + 1e-5)
        elif optimizer == "rmsprop-torch":
            v = 0.99 * v + 0.01 * g**2
            change = g / (np.sqrt(v) + 1e-5)
        else:
            raise ValueError(f"optimizer is {optimizer!r}")
        after.append(array - rate * change)
        first.append(m)
        second.append(v)
    return after, Moments(steps, first, second)


def norm(arrays: Arrays) -> float:
    """The Euclidean norm of all numbers together."""
    return math.sqrt(sum(float((array**2).sum()) for array in arrays))


def clipped(gradients: Arrays, largest: float, epsilon: float = 0.0) -> list[np.ndarray]:
    """All of them shortened together to this norm, where it is larger; 0: as they are."""
    size = norm(gradients)
    if largest == 0 or size + epsilon <= largest:
        return list(gradients)
    return [gradient * largest / (size + epsilon) for gradient in gradients]


def linear(start: float, end: float, steps: float, count: float) -> float:
    """From start to end over so many steps, then end; with 0 steps start for ever."""
    if steps == 0:
        return start
    return start + (end - start) * min(max(count / steps, 0), 1)


def decayed(decay: float, every: float, count: float) -> float:
    """The decay to the power of how often `every` has passed; 0: never."""
    return 1.0 if every == 0 else decay ** (count // every)


def orthogonality_error(weight: Float[np.ndarray, "inputs outputs"], gain: float) -> float:
    """How far the smaller side's vectors are from orthogonal ones of length `gain`."""
    square = weight @ weight.T if weight.shape[0] <= weight.shape[1] else weight.T @ weight
    return float(np.abs(square - gain**2 * np.eye(len(square))).max())


def linear_bound(weight: Float[np.ndarray, "inputs outputs"]) -> float:
    """torch.nn.Linear draws weights and biases uniformly from +- this."""
    return 1 / math.sqrt(weight.shape[0])
