"""Networks over labels or numbers, and distributions over action sequences that they parametrise.

Everything is of a batch at once: the first axis is that of samples.
"""

import math
from collections.abc import Sequence
from functools import cache
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Float, Int, PRNGKeyArray

Inputs = Int[Any, "n labels"] | Float[Any, "n numbers"]
Given = tuple[Inputs, ...]

_LN2PI = math.log(2 * math.pi)
_NARROWEST, _WIDEST = -4.0, 3.0  # logarithms of standard deviations
_SLANT = 4.0  # of other entries of a factor: single precision has to invert it


class Encoder(eqx.Module):
    """The first layer over one or several inputs, of labels or numbers."""

    weights: tuple[Float[Array, "_ width"], ...]
    bias: Float[Array, "width"]

    def __init__(self, sizes: Sequence[int], width: int, key: PRNGKeyArray):
        keys = jax.random.split(key, len(sizes))
        self.weights = tuple(
            jax.random.normal(one, (size, width)) / math.sqrt(min(size, 8))
            for one, size in zip(keys, sizes, strict=True)
        )
        self.bias = jnp.zeros(width)

    def __call__(self, given: Given) -> Float[Array, "n width"]:
        total = self.bias[None]
        for weights, inputs in zip(self.weights, given, strict=True):
            labels = jnp.issubdtype(inputs.dtype, jnp.integer)
            total = total + (weights[inputs].sum(axis=1) if labels else inputs @ weights)
        return total


class Perceptron(eqx.Module):
    """Two hidden layers, and a linear way past them."""

    encoder: Encoder
    hidden: Float[Array, "width width"]
    bias: Float[Array, "width"]
    last: Float[Array, "width outputs"]
    past: Float[Array, "width outputs"]

    def __init__(
        self, sizes: Sequence[int], width: int, outputs: int, key: PRNGKeyArray, gain: float = 0.0
    ):
        first, second, third = jax.random.split(key, 3)
        self.encoder = Encoder(sizes, width, first)
        self.hidden = jax.random.normal(second, (width, width)) * math.sqrt(2 / width)
        self.bias = jnp.zeros(width)
        self.last = gain * jax.random.normal(third, (width, outputs)) / math.sqrt(width)
        self.past = jnp.zeros((width, outputs))

    def __call__(self, given: Given) -> Float[Array, "n outputs"]:
        encoded = self.encoder(given)
        inner = jax.nn.relu(jax.nn.relu(encoded) @ self.hidden + self.bias[None])
        return inner @ self.last + encoded @ self.past


class Symbols(eqx.Module):
    """A distribution over sequences of symbols, each given those before it.

    Attributes:
        encoder: of what it is conditioned on.
        positions, earlier: added for the place in the sequence, and for each symbol before.
        hidden, bias, last: the layers after that.
    """

    encoder: Encoder
    positions: Float[Array, "length width"]
    earlier: Float[Array, "length symbols width"]
    hidden: Float[Array, "width width"]
    bias: Float[Array, "width"]
    last: Float[Array, "width symbols"]

    def __init__(
        self, sizes: Sequence[int], width: int, symbols: int, length: int, key: PRNGKeyArray
    ):
        first, second, third, fourth = jax.random.split(key, 4)
        self.encoder = Encoder(sizes, width, first)
        self.positions = 0.1 * jax.random.normal(second, (length, width))
        before = symbols if length > 1 else 0
        self.earlier = jax.random.normal(third, (length, before, width)) / math.sqrt(8)
        self.hidden = jax.random.normal(fourth, (width, width)) * math.sqrt(2 / width)
        self.bias = jnp.zeros(width)
        self.last = jnp.zeros((width, symbols))

    def _logits(
        self, encoded: Float[Array, "n width"], x: Int[Any, "n length"]
    ) -> Float[Array, "n length symbols"]:
        """Of each symbol given those before it; later ones have no part in it."""
        inner = encoded[:, None] + self.positions[None, : x.shape[1]]
        if x.shape[1] > 1:
            each = jnp.stack([self.earlier[t][x[:, t]] for t in range(x.shape[1] - 1)], axis=1)
            inner = inner.at[:, 1:].add(jnp.cumsum(each, axis=1))
        inner = jax.nn.relu(jax.nn.relu(inner) @ self.hidden + self.bias[None, None])
        return jax.nn.log_softmax(inner @ self.last)

    def log_prob(self, given: Given, x: Int[Any, "n length"]) -> Float[Array, "n"]:
        """The logarithms of the probabilities of sequences, in nats."""
        logits = self._logits(self.encoder(given), x)
        return jnp.take_along_axis(logits, x[:, :, None], axis=2)[:, :, 0].sum(axis=1)

    def sample(self, given: Given, key: PRNGKeyArray) -> Int[Array, "n length"]:
        """One sequence for each."""
        encoded = self.encoder(given)
        x = jnp.zeros((len(encoded), len(self.positions)), jnp.int32)
        for t, one in enumerate(jax.random.split(key, x.shape[1])):
            logits = self._logits(encoded, x[:, : t + 1])[:, t]
            x = x.at[:, t].set(jax.random.categorical(one, logits))
        return x


class Normal(eqx.Module):
    """A Gaussian over vectors, with any covariance.

    Attributes:
        network: gives the mean and the entries of the covariance's Cholesky factor.
        power: E ||x||^2 of each, which mean and factor are scaled to; `None` for any.
    """

    network: Perceptron
    size: int = eqx.field(static=True)
    power: float | None = eqx.field(static=True)

    def __init__(
        self,
        sizes: Sequence[int],
        width: int,
        size: int,
        key: PRNGKeyArray,
        power: float | None = None,
    ):
        self.network = Perceptron(sizes, width, size + size * (size + 1) // 2, key)
        self.size, self.power = size, power

    def _moments(self, given: Given) -> tuple[Array, Array, Array]:
        """The mean, the factor, and the logarithms of its diagonal."""
        found = self.network(given)
        mean, entries = found[:, : self.size], found[:, self.size :]
        rows, columns = jnp.tril_indices(self.size, -1)
        wide = jnp.clip(entries[:, : self.size], _NARROWEST, _WIDEST)
        factor = jnp.zeros((len(found), self.size, self.size))
        factor = factor.at[:, rows, columns].set(
            _SLANT * jnp.tanh(entries[:, self.size :] / _SLANT)
        )
        factor = factor + jnp.exp(wide)[:, :, None] * jnp.eye(self.size)[None]
        if self.power is not None:
            spent = (mean**2).sum(axis=1) + (factor**2).sum(axis=(1, 2))
            scale = jnp.sqrt(self.power / spent)
            mean, factor = mean * scale[:, None], factor * scale[:, None, None]
            wide = wide + jnp.log(scale)[:, None]
        return mean, factor, wide

    def log_prob(self, given: Given, x: Float[Any, "n size"]) -> Float[Array, "n"]:
        """The logarithms of the densities, in nats."""
        mean, factor, wide = self._moments(given)
        white = jax.scipy.linalg.solve_triangular(factor, (x - mean)[:, :, None], lower=True)
        return -(white[:, :, 0] ** 2).sum(axis=1) / 2 - wide.sum(axis=1) - self.size * _LN2PI / 2

    def sample(self, given: Given, key: PRNGKeyArray) -> Float[Array, "n size"]:
        """One vector for each."""
        mean, factor, _ = self._moments(given)
        white = jax.random.normal(key, mean.shape)
        return mean + (factor @ white[:, :, None])[:, :, 0]


def arrays(networks: eqx.Module) -> Any:
    """The parts that are trained."""
    return eqx.filter(networks, eqx.is_inexact_array)


@cache
def optimiser(rate: float) -> optax.GradientTransformation:
    """Adam, its gradients clipped."""
    return optax.chain(optax.clip_by_global_norm(1.0), optax.adam(rate))
