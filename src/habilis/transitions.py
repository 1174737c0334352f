"""One step of a table, and drawing its outcome, with arrays of NumPy or of JAX."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Float64, Int, Int32

from habilis.mdp import TabularMDP

_ROUNDING = 1e-5  # of means in float32


class Transitions(NamedTuple):
    """The transitions (s, a, s') of a table: K for every state s and action a.

    That to the outcome k of action a in state s has the number `(s * A + a) * K + k`. Actions with
    fewer than K outcomes repeat their last, with probability 0. An action that is not available
    leads back to its state, for a reward of 0; policies exclude it.

    Attributes:
        next_state: int32[S * A * K].
        reward: float[S * A * K].
        cumulative: float[S * A, K - 1], the probability of each outcome or one before it; that of
            the last is 1.
    """

    next_state: Int32[Any, "transitions"]
    reward: Float[Any, "transitions"]
    cumulative: Float[Any, "choices K-1"]

    @classmethod
    def of(cls, mdp: TabularMDP) -> "Transitions":
        """The transitions of a table.

        Args:
            mdp: deterministic (K is 1) or stochastic.

        Returns:
            NumPy arrays, rewards and probabilities in float64.
        """
        if isinstance(mdp.transitions, np.ndarray):
            next_state = mdp.transitions
            if not mdp.always_available:
                here = np.arange(mdp.states, dtype=np.int32)[:, None]
                next_state = np.where(mdp.available, next_state, here)
            reward = mdp.reward.astype(np.float64)
            return cls(next_state.reshape(-1), reward.reshape(-1), np.empty((reward.size, 0)))
        table = mdp.transitions
        first, counts = table.indptr[:-1], np.diff(table.indptr)
        most = int(counts.max())
        last = np.maximum(first + counts, 1) - 1
        place = np.minimum(first[:, None] + np.arange(most), last[:, None])
        there = np.arange(most) < counts[:, None]
        probability = np.where(there, table.data[place], 0.0)
        next_state = table.indices[place].astype(np.int32)
        unavailable = np.flatnonzero(counts == 0)
        next_state[unavailable] = unavailable[:, None] // mdp.action_count
        reward = _rewards(mdp, next_state, probability)
        cumulative = np.cumsum(probability, axis=1)[:, :-1]
        return cls(next_state.reshape(-1), reward.reshape(-1), cumulative)

    def in_jax(self) -> "Transitions":
        """The same on JAX's device, in float32."""
        import jax.numpy as jnp

        return Transitions(
            jnp.asarray(self.next_state),
            jnp.asarray(self.reward, jnp.float32),
            jnp.asarray(self.cumulative, jnp.float32),
        )

    @property
    def outcomes(self) -> int:
        """K; 1 in a deterministic table."""
        return self.cumulative.shape[-1] + 1

    @property
    def probabilities(self) -> Float[Any, "choices K"]:
        """The probability of each outcome."""
        xp = self.cumulative.__array_namespace__()
        return xp.diff(self.cumulative, axis=1, prepend=0.0, append=1.0)

    def drawn(self, choice: Int[Any, "*n"] | int, draw: Float[Any, "*n"] | float | None) -> Any:
        """The numbers of the transitions that are made, int[*n].

        Args:
            choice: `s * A + a`, the actions that are taken.
            draw: a uniform number from [0, 1) for each, which decides on the outcome; `None` in a
                deterministic table.

        Returns:
            int[*n], indices into `next_state` and `reward`.
        """
        if draw is None:
            return choice
        uniform: Any = np.float64(draw) if isinstance(draw, float) else draw
        outcome = (self.cumulative[choice] <= uniform[..., None]).sum(axis=-1)
        return choice * self.outcomes + outcome


def _rewards(
    mdp: TabularMDP,
    next_state: Int32[np.ndarray, "choices K"],
    probability: Float64[np.ndarray, "choices K"],
) -> Float64[np.ndarray, "choices K"]:
    """The reward of each outcome: of entering its state, or the mean if that is all there is."""
    mean = mdp.reward.astype(np.float64).reshape(-1, 1)
    if mdp.entry_reward is None:
        return np.broadcast_to(mean, next_state.shape)
    entered = mdp.entry_reward.astype(np.float64)[next_state]
    expected = (probability * entered).sum(axis=1, keepdims=True)
    apart: Bool[np.ndarray, "choices 1"] = np.isclose(
        expected, mean, rtol=_ROUNDING, atol=_ROUNDING
    )
    apart &= probability.any(axis=1, keepdims=True)
    return np.where(apart, entered, mean)
