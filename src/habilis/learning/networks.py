"""The agent's network: a multilayer perceptron over the factors of a state."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PRNGKeyArray


class Network(eqx.Module):
    """A multilayer perceptron over one-hot factors.

    The first layer times a one-hot vector is a row of its weights, so it is kept as rows that
    are looked up and added: one row per value of each factor.

    Example:
        >>> network = Network(rows=6, factors=2, outputs=5, hidden=(8, 8), key=jax.random.key(0))
        >>> network(jnp.array([0, 5])).shape
        (5,)
    """

    embedding: Float[Array, "rows hidden"]
    bias: Float[Array, "hidden"]
    layers: list[tuple[Float[Array, "inputs outputs"], Float[Array, "outputs"]]]

    def __init__(
        self,
        rows: int,
        factors: int,
        outputs: int,
        hidden: tuple[int, ...],
        key: PRNGKeyArray,
        gain: float = 0.01,
    ):
        """
        Args:
            rows: how many values all factors have together.
            factors: how many rows are added up for one state.
            outputs: how many outputs there are.
            hidden: the width of each hidden layer, at least one.
            key: for the initial weights.
            gain: of the last layer: small, outputs start near zero.
        """
        first, *keys = jax.random.split(key, len(hidden) + 1)
        self.embedding = jax.random.normal(first, (rows, hidden[0])) / jnp.sqrt(factors)
        self.bias = jnp.zeros(hidden[0])
        widths = (*hidden, outputs)
        gains = [1.0] * (len(hidden) - 1) + [gain]
        self.layers = [
            (jax.random.normal(k, (i, o)) * gain / jnp.sqrt(i), jnp.zeros(o))
            for k, i, o, gain in zip(keys, widths[:-1], widths[1:], gains, strict=True)
        ]

    def __call__(self, inputs: Int[Array, "*batch factors"]) -> Float[Array, "*batch outputs"]:
        """
        Args:
            inputs: for each factor the row of its value.
        """
        return self.activations(inputs)[-1]

    def activations(self, inputs: Int[Array, "*batch factors"]) -> list[Float[Array, "*batch _"]]:
        """What each hidden layer gives out, and the outputs."""
        x = self.bias
        for factor in range(inputs.shape[-1]):
            x = x + self.embedding[inputs[..., factor]]
        given = []
        for weight, bias in self.layers:
            given.append(jnp.tanh(x))
            x = given[-1] @ weight + bias
        return [*given, x]

    def gradient(
        self,
        inputs: Int[Array, "n factors"],
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
        layers = []
        change = of_outputs
        for (weight, _), given in zip(self.layers[::-1], activations[-2::-1], strict=True):
            # The narrower factor is the one that is turned round: that is a copy of all of it.
            product = (change.T @ given).T if change.shape[1] < given.shape[1] else given.T @ change
            layers.append((product, change.sum(axis=0)))
            change = (change @ weight.T) * (1 - jnp.square(given))
        embedding = jnp.zeros_like(self.embedding)
        for factor in range(inputs.shape[-1]):
            embedding = embedding.at[inputs[:, factor]].add(change)
        return eqx.tree_at(
            lambda n: (n.embedding, n.bias, n.layers),
            self,
            (embedding, change.sum(axis=0), layers[::-1]),
        )
