"""The agent's network: policy and value over the factors of a state."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PRNGKeyArray


class ActorCritic(eqx.Module):
    """A multilayer perceptron over one-hot factors, with one trunk for policy and value.

    The first layer times a one-hot vector is a row of its weights, so it is kept as rows that
    are looked up and added: one row per value of each factor.

    Example:
        >>> key = jax.random.key(0)
        >>> network = ActorCritic(rows=6, factors=2, actions=4, hidden=(8, 8), key=key)
        >>> logits, value = network(jnp.array([0, 5]))
        >>> logits.shape, value.shape
        ((4,), ())
    """

    embedding: Float[Array, "rows hidden"]
    bias: Float[Array, "hidden"]
    layers: list[tuple[Float[Array, "inputs outputs"], Float[Array, "outputs"]]]

    def __init__(
        self, rows: int, factors: int, actions: int, hidden: tuple[int, ...], key: PRNGKeyArray
    ):
        """
        Args:
            rows: how many values all factors have together.
            factors: how many rows are added up for one state.
            actions: how many actions there are.
            hidden: the width of each hidden layer, at least one.
            key: for the initial weights.
        """
        first, *keys = jax.random.split(key, len(hidden) + 1)
        self.embedding = jax.random.normal(first, (rows, hidden[0])) / jnp.sqrt(factors)
        self.bias = jnp.zeros(hidden[0])
        widths = (*hidden, actions + 1)
        # Small last weights: a policy that starts uniform, a value that starts near zero.
        gains = [1.0] * (len(hidden) - 1) + [0.01]
        self.layers = [
            (jax.random.normal(k, (i, o)) * gain / jnp.sqrt(i), jnp.zeros(o))
            for k, i, o, gain in zip(keys, widths[:-1], widths[1:], gains, strict=True)
        ]

    def __call__(
        self, inputs: Int[Array, "*batch factors"]
    ) -> tuple[Float[Array, "*batch actions"], Float[Array, "*batch"]]:
        """
        Args:
            inputs: for each factor the row of its value.

        Returns:
            The logits of the actions, and the value.
        """
        x = _add_rows(self.embedding, inputs) + self.bias
        for weight, bias in self.layers:
            x = jnp.tanh(x) @ weight + bias
        return x[..., :-1], x[..., -1]


def _add_rows(embedding, inputs):
    return embedding[inputs].sum(axis=-2)
