"""The agent's networks: multilayer perceptrons over what is shown of a state."""

import math
from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PRNGKeyArray

_SELU_SCALE, _SELU_ALPHA = 1.0507009873554805, 1.6732632423543772

ACTIVATIONS: dict[str, tuple[Callable[[Array], Array], Callable[[Array], Array], float]] = {
    "tanh": (jnp.tanh, lambda y: 1 - jnp.square(y), 5 / 3),
    "relu": (jax.nn.relu, lambda y: (y > 0).astype(y.dtype), math.sqrt(2)),
    "selu": (
        jax.nn.selu,
        lambda y: jnp.where(y > 0, _SELU_SCALE, y + _SELU_SCALE * _SELU_ALPHA),
        3 / 4,
    ),
    "sigmoid": (jax.nn.sigmoid, lambda y: y * (1 - y), 1.0),
}
"""Each activation, its derivative in terms of what it gives out, and the gain that PyTorch's
`calculate_gain` recommends for orthogonal weights."""

NETWORKS = ("shared", "separate")
INITIALISATIONS = ("lecun", "orthogonal", "pytorch")

Inputs = Int[Array, "*batch factors"] | Float[Array, "*batch coordinates"]
"""Rows of the first layer's weights, for one-hot factors, or coordinates."""


class Network(eqx.Module):
    """A multilayer perceptron over one-hot factors, or over coordinates.

    The first layer times a one-hot vector is a row of its weights, so it is kept as rows that
    are looked up and added: one row per value of each factor. Inputs that are not integers are
    coordinates, which are multiplied with the rows as with any weights.

    Example:
        >>> network = Network(rows=6, factors=2, outputs=5, hidden=(8, 8), key=jax.random.key(0))
        >>> network(jnp.array([0, 5])).shape
        (5,)
    """

    embedding: Float[Array, "rows hidden"]
    bias: Float[Array, "hidden"]
    layers: list[tuple[Float[Array, "inputs outputs"], Float[Array, "outputs"]]]
    activation: str = eqx.field(static=True)

    def __init__(
        self,
        rows: int,
        factors: int,
        outputs: int,
        hidden: tuple[int, ...],
        key: PRNGKeyArray,
        gain: float = 0.01,
        activation: str = "tanh",
        initialisation: str = "lecun",
    ):
        """
        Args:
            rows: how many values all factors have together; of coordinates, how many there are.
            factors: how many inputs are not 0 at a time: how many rows are added up for one
                state; of coordinates, all.
            outputs: how many outputs there are.
            hidden: the width of each hidden layer, at least one.
            key: for the initial weights.
            gain: of the last layer, with "lecun": small, outputs start near zero.
            activation: of `ACTIVATIONS`.
            initialisation: "lecun", normal with variance 1 / inputs and no biases; "orthogonal",
                orthogonal matrices times the activation's gain in every layer and no biases;
                "pytorch", weights and biases uniform within 1 / sqrt(inputs), the default of
                PyTorch's `Linear`.
        """
        first, *keys = jax.random.split(key, len(hidden) + 1)
        self.activation = activation
        widths = (*hidden, outputs)
        if initialisation == "lecun":
            self.embedding = jax.random.normal(first, (rows, hidden[0])) / jnp.sqrt(factors)
            self.bias = jnp.zeros(hidden[0])
            gains = [1.0] * (len(hidden) - 1) + [gain]
            self.layers = [
                (jax.random.normal(k, (i, o)) * gain / jnp.sqrt(i), jnp.zeros(o))
                for k, i, o, gain in zip(keys, widths[:-1], widths[1:], gains, strict=True)
            ]
            return
        draw = _orthogonal if initialisation == "orthogonal" else _uniform
        (self.embedding, self.bias), *self.layers = (
            draw(k, i, o, ACTIVATIONS[activation][2])
            for k, i, o in zip((first, *keys), (rows, *hidden), widths, strict=True)
        )

    def __call__(self, inputs: Inputs) -> Float[Array, "*batch outputs"]:
        """
        Args:
            inputs: for each factor the row of its value, or coordinates.
        """
        return self.activations(inputs)[-1]

    def activations(self, inputs: Inputs) -> list[Float[Array, "*batch _"]]:
        """The activations of each hidden layer, and the outputs."""
        active = ACTIVATIONS[self.activation][0]
        x = jnp.broadcast_to(self.bias, (*inputs.shape[:-1], *self.bias.shape))
        if jnp.issubdtype(inputs.dtype, jnp.integer):
            for factor in range(inputs.shape[-1]):
                x = x + self.embedding[inputs[..., factor]]
        else:
            x = x + inputs @ self.embedding
        given = []
        for weight, bias in self.layers:
            given.append(active(x))
            x = given[-1] @ weight
            x = x + jnp.broadcast_to(bias, x.shape)
        return [*given, x]

    def gradient(
        self,
        inputs: Inputs,
        activations: list[Float[Array, "n _"]],
        of_outputs: Float[Array, "n outputs"],
    ) -> "Network":
        """The gradient of a loss, from what the layers gave out when they were last evaluated.

        An agent that learns once from each rollout has these from acting: to evaluate the
        network again for its gradient would be a third of all work.

        Args:
            inputs, activations: of the n evaluations.
            of_outputs: the gradient of the loss with respect to the outputs.

        Returns:
            A network that has gradients in the place of weights.
        """
        derivative = ACTIVATIONS[self.activation][1]
        layers = []
        change = of_outputs
        for (weight, _), given in zip(self.layers[::-1], activations[-2::-1], strict=True):
            layers.append((_product(given, change), change.sum(axis=0)))
            change = (change @ weight.T) * derivative(given)
        if jnp.issubdtype(inputs.dtype, jnp.integer):
            # A product, since XLA fills an array with a constant element by element on a CPU.
            embedding = 0 * self.embedding
            for factor in range(inputs.shape[-1]):
                embedding = embedding.at[inputs[:, factor]].add(change)
        else:
            embedding = inputs.T @ change
        return eqx.tree_at(
            lambda n: (n.embedding, n.bias, n.layers),
            self,
            (embedding, change.sum(axis=0), layers[::-1]),
        )


def _product(given: Float[Array, "n inputs"], change: Float[Array, "n outputs"]) -> Array:
    """`given.T @ change`, the gradient of a layer's weights.

    The barriers keep XLA from folding the transpositions into the product, which on a CPU is then
    none of its fast ones. The narrower factor is turned round: that is a copy of all of it.
    """
    fixed = jax.lax.optimization_barrier
    if change.shape[1] < given.shape[1]:
        return fixed(fixed(change.T) @ given).T
    return fixed(given.T) @ change


class Separate(eqx.Module):
    """A network for the policy and one for the value, used as one that has both outputs.

    Attributes:
        policy: gives out the logits of the actions.
        value: gives out the value.
    """

    policy: Network
    value: Network

    def __call__(self, inputs: Inputs) -> Float[Array, "*batch outputs"]:
        return self.activations(inputs)[-1]

    def activations(self, inputs: Inputs) -> list[Float[Array, "*batch _"]]:
        """As in `Network`: the policy's hidden layers, the value's, and the outputs of both."""
        *of_policy, logits = self.policy.activations(inputs)
        *of_value, value = self.value.activations(inputs)
        return [*of_policy, *of_value, jnp.concatenate([logits, value], axis=-1)]

    def gradient(
        self,
        inputs: Inputs,
        activations: list[Float[Array, "n _"]],
        of_outputs: Float[Array, "n outputs"],
    ) -> "Separate":
        """As in `Network`."""
        hidden = len(self.policy.layers)
        logits, value = activations[-1][:, :-1], activations[-1][:, -1:]
        return Separate(
            self.policy.gradient(inputs, [*activations[:hidden], logits], of_outputs[:, :-1]),
            self.value.gradient(inputs, [*activations[hidden:-1], value], of_outputs[:, -1:]),
        )


ActorCritic = Network | Separate
"""A network whose outputs are the logits of the actions, then the value."""


def actor_critic_network(
    kind: str,
    rows: int,
    factors: int,
    actions: int,
    hidden: tuple[int, ...],
    key: PRNGKeyArray,
    activation: str,
    initialisation: str,
) -> ActorCritic:
    """A network with the logits of the actions and the value as its outputs.

    Args:
        kind: "shared", one trunk for both, or "separate", a network for each.
        rows, factors, hidden, key, activation, initialisation: as in `Network`.
        actions: how many logits there are.
    """

    def network(outputs: int, key: PRNGKeyArray) -> Network:
        more: Any = {"activation": activation, "initialisation": initialisation}
        return Network(rows, factors, outputs, hidden, key, **more)

    if kind == "shared":
        return network(actions + 1, key)
    for_policy, for_value = jax.random.split(key)
    return Separate(network(actions, for_policy), network(1, for_value))


def _orthogonal(key: PRNGKeyArray, inputs: int, outputs: int, gain: float):
    weight = jax.nn.initializers.orthogonal(gain)(key, (inputs, outputs))
    return weight, jnp.zeros(outputs)


def _uniform(key: PRNGKeyArray, inputs: int, outputs: int, gain: float):
    for_weight, for_bias = jax.random.split(key)
    bound = 1 / math.sqrt(inputs)
    weight = jax.random.uniform(for_weight, (inputs, outputs), minval=-bound, maxval=bound)
    return weight, jax.random.uniform(for_bias, (outputs,), minval=-bound, maxval=bound)
