"""What may come of an action in a stochastic table, as arrays to draw from."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float, Int32

from habilis.mdp import TabularMDP
from habilis.worlds.described import rewards


@dataclass(frozen=True, eq=False)
class Chance:
    """The K outcomes that a transition may have, where there are fewer some of them twice.

    An action that is not available leads back to the state, for nothing; who chooses actions
    leaves it out.

    Attributes:
        next_state: int32[S * A, K], row `state * actions + action`.
        below: float64[S * A, K - 1], where in [0, 1) each outcome's share ends and the next begins.
        reward: float64[S * A, K].
    """

    next_state: Int32[np.ndarray, "transitions K"]
    below: Float[np.ndarray, "transitions K-1"]
    reward: Float[np.ndarray, "transitions K"]

    @classmethod
    def of(cls, mdp: TabularMDP) -> "Chance | None":
        """The outcomes in a world's table, with the rewards of rule 6; `None` without chance."""
        return None if isinstance(mdp.transitions, np.ndarray) else cls.in_any(mdp)

    @classmethod
    def in_any(cls, mdp: TabularMDP) -> "Chance":
        """The same, of tables without chance too: there every transition has one outcome.

        Of a stochastic table that has not the rewards of rule 6 every outcome has the mean.
        """
        if isinstance(mdp.transitions, np.ndarray):
            next_state = _staying(mdp).reshape(-1, 1)
            nothing = np.empty((len(next_state), 0))
            return cls(next_state, nothing, mdp.reward.reshape(-1, 1).astype(np.float64))
        table = mdp.transitions
        first, counts = table.indptr[:-1], np.diff(table.indptr)
        most = int(counts.max())
        last = np.maximum(first + counts, 1) - 1
        place = np.minimum(first[:, None] + np.arange(most), last[:, None])
        there = np.arange(most) < counts[:, None]
        share = np.where(there, table.data[place], 0.0)
        next_state = table.indices[place].astype(np.int32)
        gone = np.flatnonzero(counts == 0)
        next_state[gone] = gone[:, None] // mdp.action_count
        below = np.cumsum(share, axis=1)[:, :-1]
        return cls(next_state, below, _rewards(mdp, next_state, share))

    @property
    def shares(self) -> Float[np.ndarray, "transitions K"]:
        """The probability of each outcome."""
        return np.diff(self.below, axis=1, prepend=0.0, append=1.0)

    def led(self, transition, draw) -> tuple[Any, Any]:
        """Where transitions lead and what for, given a uniform number from [0, 1) for each."""
        outcome = transition, (self.below[transition] <= np.asarray(draw)[..., None]).sum(axis=-1)
        return self.next_state[outcome], self.reward[outcome]


def _staying(mdp: TabularMDP) -> Int32[np.ndarray, "S A"]:
    """Where actions lead that are certain; one that is not available, to the state itself."""
    if mdp.always_available:
        return mdp.next_state
    here = np.arange(mdp.states, dtype=np.int32)[:, None]
    return np.where(mdp.available, mdp.next_state, here)


def _rewards(
    mdp: TabularMDP,
    next_state: Int32[np.ndarray, "transitions K"],
    share: Float[np.ndarray, "transitions K"],
) -> Float[np.ndarray, "transitions K"]:
    """What each outcome earns; a table knows but the mean, and what a world's outcomes earn."""
    earned, mean = rewards(mdp.terminal, next_state).astype(np.float64), mdp.reward.reshape(-1, 1)
    if np.allclose((share * earned).sum(axis=1, keepdims=True), mean, atol=1e-5):
        return earned * share.any(axis=1, keepdims=True)
    return np.broadcast_to(mean.astype(np.float64), share.shape)
