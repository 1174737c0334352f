"""Multilayer perceptrons for `reference_actor_critic`: values and gradients by hand, in NumPy."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Shaped

Layer = tuple[Float[np.ndarray, "inputs outputs"], Float[np.ndarray, " outputs"]]
Layers = Sequence[Layer]
Inputs = Shaped[np.ndarray, "batch features"]
Batch = Float[np.ndarray, " batch"]

SELU_SCALE = 1.0507009873554805
SELU_ALPHA = 1.6732632423543772


@dataclass(frozen=True)
class Parameters:
    """The weights and biases of the networks, a (weight, bias) for each layer.

    Separate networks have no trunk. Of a shared one, `trunk` has the hidden layers, each followed
    by the activation, and `policy` and `value` the layers on top, usually one each; one last layer
    with a column more than there are actions is the same network with its columns split.
    The last layers of `policy` and `value` are linear.
    """

    policy: Layers
    value: Layers
    trunk: Layers = ()

    def __post_init__(self) -> None:
        for name in ("policy", "value", "trunk"):
            layers = [(np.asarray(w, float), np.asarray(b, float)) for w, b in getattr(self, name)]
            object.__setattr__(self, name, layers)

    def arrays(self) -> list[np.ndarray]:
        """All of them, weight before bias: trunk, policy, value."""
        return [array for layer in (*self.trunk, *self.policy, *self.value) for array in layer]

    def replaced(self, arrays: Sequence[np.ndarray]) -> "Parameters":
        """The same networks with these arrays, in the order of `arrays`."""
        left = iter(arrays)

        def of(layers: Layers) -> Layers:
            return [(next(left), next(left)) for _ in layers]

        trunk = of(self.trunk)
        policy = of(self.policy)
        return Parameters(policy, of(self.value), trunk)


def activated(name: str, z: np.ndarray) -> np.ndarray:
    """The activation of each number."""
    below = np.minimum(z, 0)
    return {
        "tanh": lambda: np.tanh(z),
        "relu": lambda: np.maximum(z, 0),
        "selu": lambda: SELU_SCALE * np.where(z > 0, z, SELU_ALPHA * np.expm1(below)),
        "sigmoid": lambda: 1 / (1 + np.exp(-z)),
    }[name]()


def slope(name: str, z: np.ndarray) -> np.ndarray:
    """The derivative of the activation at each number, at the kink of ReLU 0."""
    below = np.minimum(z, 0)
    return {
        "tanh": lambda: 1 / np.cosh(z) ** 2,
        "relu": lambda: (z > 0).astype(float),
        "selu": lambda: SELU_SCALE * np.where(z > 0, 1.0, SELU_ALPHA * np.exp(below)),
        "sigmoid": lambda: np.exp(-z) / (1 + np.exp(-z)) ** 2,
    }[name]()


def forward(
    layers: Layers, x: Inputs, activation: str, *, linear_end: bool
) -> tuple[np.ndarray, list[tuple[np.ndarray, np.ndarray]]]:
    """The outputs, and of each layer its input and its sums before the activation."""
    passed = []
    for number, (weight, bias) in enumerate(layers):
        rows = np.issubdtype(x.dtype, np.integer)
        z = (weight[x].sum(axis=1) if rows else x @ weight) + bias
        passed.append((x, z))
        last = linear_end and number == len(layers) - 1
        x = z if last else activated(activation, z)
    return x, passed


def backward(
    layers: Layers,
    passed: list[tuple[np.ndarray, np.ndarray]],
    slopes: Float[np.ndarray, "batch outputs"],
    activation: str,
    *,
    linear_end: bool,
) -> tuple[list[Layer], np.ndarray]:
    """The gradient of each layer, and of the inputs, from that of the outputs."""
    found: list[Layer] = []
    for number in reversed(range(len(layers))):
        (x, z), (weight, _) = passed[number], layers[number]
        if not (linear_end and number == len(layers) - 1):
            slopes = slopes * slope(activation, z)
        if np.issubdtype(x.dtype, np.integer):
            by_weight = np.zeros_like(weight, dtype=float)
            for one, rows in zip(slopes, x, strict=True):
                for row in rows:
                    by_weight[row] += one
        else:
            by_weight = x.T @ slopes
        found.append((by_weight, slopes.sum(axis=0)))
        slopes = slopes @ weight.T
    return found[::-1], slopes


def values(parameters: Parameters, x: Inputs, activation: str) -> Batch:
    """The value of each state."""
    trunk, _ = forward(parameters.trunk, x, activation, linear_end=False)
    return forward(parameters.value, trunk, activation, linear_end=True)[0][:, 0]


def log_policy(
    parameters: Parameters,
    x: Inputs,
    activation: str,
    available: Bool[np.ndarray, "batch actions"] | None = None,
) -> Float[np.ndarray, "batch actions"]:
    """The logarithm of each action's probability, minus infinity where it is not available."""
    trunk, _ = forward(parameters.trunk, x, activation, linear_end=False)
    return log_softmax(forward(parameters.policy, trunk, activation, linear_end=True)[0], available)


def log_softmax(
    logits: Float[np.ndarray, "batch actions"],
    available: Bool[np.ndarray, "batch actions"] | None,
) -> Float[np.ndarray, "batch actions"]:
    if available is not None:
        logits = np.where(available, logits, -np.inf)
    logits = logits - logits.max(axis=1, keepdims=True)
    return logits - np.log(np.exp(logits).sum(axis=1, keepdims=True))
