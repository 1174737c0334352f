"""Source, decoder and baseline of `Variational`, and how they are trained."""

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from habilis.estimators.learned.coding import Coding
from habilis.estimators.learned.networks import Normal, Perceptron, Symbols, optimiser

_NEAR = 0.2  # by how much a round changes the probability of a sequence (Schulman et al. 2017)
_SURPLUS = 3.0  # nats: one sequence that the decoder has no idea of does not spoil the source
_OUTLIER = 20.0  # nats

State = tuple[Any, Any]
"""The networks, and the state of the optimiser."""


class Networks(eqx.Module):
    """All that is learned.

    Attributes:
        source: w, over sequences, given a state.
        decoder: q, over sequences, given a state and what the sensor shows.
        baseline: V, of a state, in nats.
    """

    source: Symbols | Normal
    decoder: Symbols | Normal
    baseline: Perceptron


def begin(
    sizes: tuple[int, int], coding: Coding, width: int, power: float | None, key: PRNGKeyArray
) -> Networks:
    """Networks before training: source and decoder are uniform, or independent normals."""
    first, second, third = jax.random.split(key, 3)
    state, _ = sizes
    if coding.kind == "symbols":
        shape = width, coding.symbols, coding.length
        source, decoder = Symbols((state,), *shape, first), Symbols(sizes, *shape, second)
    else:
        source = Normal((state,), width, coding.length, first, power)
        decoder = Normal(sizes, width, coding.length, second)
    return Networks(source, decoder, Perceptron((state,), width, 1, third))


def first_codes(coding: Coding, count: int, power: float | None, key: PRNGKeyArray) -> Array:
    """Sequences of a source that has not learned anything."""
    if coding.kind == "symbols":
        return jax.random.randint(key, (count, coding.length), 0, coding.symbols)
    scale = 1.0 if power is None else jnp.sqrt(power / coding.length)
    return scale * jax.random.normal(key, (count, coding.length))


@jax.jit
def draw(networks: Networks, states: Any, key: PRNGKeyArray) -> Array:
    """A coded sequence of the source for each state."""
    return networks.source.sample((states,), key)


@jax.jit
def gains(networks: Networks, states: Any, shown: Any, coded: Any) -> Float[Array, "n"]:
    """What each sequence adds to the bound: log q(a | s, o) - log w(a | s), in nats."""
    guessed = networks.decoder.log_prob((states, shown), coded)
    return guessed - networks.source.log_prob((states,), coded)


@jax.jit
def predicted(networks: Networks, states: Any) -> Float[Array, "n"]:
    """The baseline, in nats."""
    return networks.baseline((states,))[:, 0]


def _loss(networks: Networks, states: Any, shown: Any, coded: Any, before: Any) -> Array:
    """Of one batch, whose gradient is that of minus the bound, of decoder and source apart."""
    guessed = networks.decoder.log_prob((states, shown), coded)
    said = networks.source.log_prob((states,), coded)
    expected = networks.baseline((states,))[:, 0]
    gained = jax.lax.stop_gradient(guessed - said)
    surplus = gained - jax.lax.stop_gradient(expected)
    surplus = jnp.clip(surplus, -_SURPLUS, _SURPLUS)
    # The sequences were drawn before this round's first update: no step goes far from there.
    ratio = jnp.exp(jnp.clip(said - before, -5.0, 5.0))
    near = jnp.clip(ratio, 1 - _NEAR, 1 + _NEAR)
    drawn_to = jnp.minimum(ratio * surplus, near * surplus)
    off = jnp.clip(expected - gained, -_OUTLIER, _OUTLIER)
    return (-guessed - drawn_to + off**2 / 2).mean()


@cache
def improve_with(rate: float, batch: int) -> Callable[..., tuple[State, Array]]:
    """One pass over a round's data, compiled, and the bound on it before that, in nats."""

    @partial(jax.jit, donate_argnums=())
    def improve(now: State, states: Any, shown: Any, coded: Any) -> tuple[State, Array]:
        bound = gains(now[0], states, shown, coded).mean()
        before = now[0].source.log_prob((states,), coded)
        data = [one.reshape(-1, batch, *one.shape[1:]) for one in (states, shown, coded, before)]

        def once(now: State, some: Any) -> tuple[State, None]:
            networks, memory = now
            slopes = jax.grad(_loss)(networks, *some)
            changes, memory = optimiser(rate).update(slopes, memory, networks)
            return (eqx.apply_updates(networks, changes), memory), None

        return jax.lax.scan(once, now, data)[0], bound

    return improve
