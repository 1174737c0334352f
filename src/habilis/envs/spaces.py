"""Spaces of the actions, observations and states of a functional environment, in JAX.

Where gymnax is installed these are its own, which its wrappers ask for by their class.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, ArrayLike, Bool, PRNGKeyArray


@dataclass(frozen=True)
class Discrete:
    """The whole numbers from 0 to n - 1, int32."""

    n: int

    shape = ()
    dtype = jnp.int32

    def sample(self, key: PRNGKeyArray) -> Array:
        return jax.random.randint(key, (), 0, self.n)

    def contains(self, x: Any) -> Bool[Array, ""]:
        return (jnp.asarray(x) >= 0) & (jnp.asarray(x) < self.n)


@dataclass(frozen=True, eq=False)
class Box:
    """Arrays of whole numbers, each from `low` to `high`."""

    low: ArrayLike
    high: ArrayLike
    shape: tuple[int, ...]
    dtype: Any

    def sample(self, key: PRNGKeyArray) -> Array:
        high = jnp.asarray(self.high, jnp.int32)
        return jax.random.randint(key, self.shape, self.low, high + 1).astype(self.dtype)

    def contains(self, x: Any) -> Bool[Array, ""]:
        return jnp.all((jnp.asarray(x) >= self.low) & (jnp.asarray(x) <= self.high))


@dataclass(frozen=True, eq=False)
class Dict:
    """A space for each attribute of a state."""

    spaces: Mapping[str, Any]

    def sample(self, key: PRNGKeyArray) -> dict[str, Any]:
        keys = jax.random.split(key, len(self.spaces))
        return {
            name: space.sample(one)
            for (name, space), one in zip(self.spaces.items(), keys, strict=True)
        }

    def contains(self, x: Any) -> Bool[Array, ""]:
        each = [space.contains(getattr(x, name)) for name, space in self.spaces.items()]
        return jnp.all(jnp.stack(each))


def classes() -> Any:
    """`Discrete`, `Box` and `Dict`: gymnax's, or those above."""
    try:
        from gymnax.environments import spaces  # pyright: ignore[reportMissingImports]
    except ImportError:
        return SimpleNamespace(Discrete=Discrete, Box=Box, Dict=Dict)
    return spaces
