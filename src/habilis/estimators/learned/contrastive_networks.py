"""The three encoders of `Contrastive`, and how they are trained."""

import math
from collections.abc import Callable
from functools import cache, partial
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from habilis.estimators.learned.networks import Perceptron, optimiser

State = tuple[Any, Any]
"""The encoders, and the state of the optimiser."""


class Encoders(eqx.Module):
    """All that is learned.

    Attributes:
        pair: of a state and an action.
        alone: of a state.
        outcome: of what the sensor shows later.
    """

    pair: Perceptron
    alone: Perceptron
    outcome: Perceptron

    def __init__(self, sizes: tuple[int, int, int], width: int, features: int, key: PRNGKeyArray):
        first, second, third = jax.random.split(key, 3)
        state, action, outcome = sizes
        self.pair = Perceptron((state, action), width, features, first, gain=1.0)
        self.alone = Perceptron((state,), width, features, second, gain=1.0)
        self.outcome = Perceptron((outcome,), width, features, third, gain=1.0)


def _scores(
    encoders: Encoders, states: Any, actions: Any, shown: Any
) -> tuple[Float[Array, "n m"], Float[Array, "n m"]]:
    """Of n pairs and of their states alone with m outcomes."""
    seen = encoders.outcome((shown,))
    scale = 1 / math.sqrt(seen.shape[1])
    pair, alone = encoders.pair((states, actions)), encoders.alone((states,))
    return scale * pair @ seen.T, scale * alone @ seen.T


def _infonce(scores: Float[Array, "n n"]) -> Array:
    """The bound of a batch, in nats: log n at most. It is the mean of both directions."""
    own = jnp.diagonal(scores)
    both = [own - jax.scipy.special.logsumexp(scores, axis=axis) for axis in (0, 1)]
    return (both[0] + both[1]).mean() / 2 + math.log(len(scores))


def _bounds(encoders: Encoders, states: Any, actions: Any, shown: Any) -> tuple[Array, Array]:
    pair, alone = _scores(encoders, states, actions, shown)
    return _infonce(pair), _infonce(alone)


@cache
def improve_with(rate: float, batch: int) -> Callable[..., tuple[State, Array]]:
    """One pass over a round's data, compiled, and the sum of both bounds on it before, in nats."""

    @jax.jit
    def improve(now: State, states: Any, actions: Any, shown: Any) -> tuple[State, Array]:
        data = [one.reshape(-1, batch, *one.shape[1:]) for one in (states, actions, shown)]
        before = jax.lax.map(lambda some: sum(_bounds(now[0], *some)), tuple(data)).mean()

        def once(now: State, some: Any) -> tuple[State, None]:
            encoders, memory = now
            slopes = jax.grad(lambda these: -sum(_bounds(these, *some)))(encoders)
            changes, memory = optimiser(rate).update(slopes, memory, encoders)
            return (eqx.apply_updates(encoders, changes), memory), None

        return jax.lax.scan(once, now, data)[0], before

    return improve


@partial(jax.jit, static_argnames="batch")
def gains(
    encoders: Encoders, states: Any, actions: Any, shown: Any, others: Any, batch: int
) -> Float[Array, "n"]:
    """What the action tells of the outcome, for each sample, in nats.

    The log ratio of the outcome's density given state and action to that given the state alone.
    Each is a score against the mean score of a batch, the outcome's own and those of the others in
    proportion, so that it is at most the logarithm of the batch.
    """
    own = [jnp.diagonal(one) for one in _scores(encoders, states, actions, shown)]
    rest = _scores(encoders, states, actions, others)
    share = math.log((batch - 1) / others.shape[0])
    known = [
        mine
        - jnp.logaddexp(mine, share + jax.scipy.special.logsumexp(some, axis=1))
        + math.log(batch)
        for mine, some in zip(own, rest, strict=True)
    ]
    return known[0] - known[1]
