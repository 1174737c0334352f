"""Tables of logged transitions: `TabularMDP.from_transitions`."""

from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Int64

from habilis.mdp import TabularMDP
from habilis.probabilities import as_array


def table_of(
    states: Any,
    actions: Any,
    next_states: Any,
    state_count: int | None = None,
    action_count: int | None = None,
) -> TabularMDP:
    """`TabularMDP.from_transitions`; see there."""
    from scipy.sparse import csr_array

    s, a, t = (
        _indices(name, given)
        for name, given in (("states", states), ("actions", actions), ("next_states", next_states))
    )
    if not len(s) == len(a) == len(t):
        raise ValueError(
            f"there are {len(s)} states, {len(a)} actions and {len(t)} next_states; give one of "
            "each for every transition"
        )
    if not len(s):
        raise ValueError("there are no transitions; give at least one")
    S = _count("state_count", state_count, max(int(s.max()), int(t.max())), "states")
    A = _count("action_count", action_count, int(a.max()), "actions")
    ones = np.ones(len(s), np.int64)
    counts = csr_array((ones, (s * A + a, t)), (S * A, S))  # the same transitions are added
    counts.sort_indices()
    tried = (np.diff(counts.indptr) > 0).reshape(S, A)
    return replace(TabularMDP.stochastic(probabilities(counts, A), available=tried), counts=counts)


def probabilities(counts: Any, actions: int) -> list[Any]:
    """Relative frequencies, one sparse float64[S, S] an action; rows without a count are empty."""
    total = np.asarray(counts.sum(axis=1), np.float64).ravel()
    share = counts.astype(np.float64)
    share.data /= np.repeat(total, np.diff(counts.indptr))
    return [share[action::actions] for action in range(actions)]


def _indices(name: str, given: Any) -> Int64[np.ndarray, "n"]:
    array = as_array(name, given)
    if array.ndim != 1 or (array.size and array.dtype.kind not in "iu"):
        raise ValueError(
            f"{name} has shape {array.shape} and type {array.dtype}; give a list of indices, as "
            "np.unique(observations, axis=0, return_inverse=True)[1] makes of observations"
        )
    if array.size and array.min() < 0:
        raise ValueError(f"{name} has {array.min()}; give indices from 0 up")
    return array.astype(np.int64)


def _count(name: str, given: int | None, largest: int, of: str) -> int:
    if given is None:
        return largest + 1
    if isinstance(given, bool) or not isinstance(given, int | np.integer) or given <= largest:
        raise ValueError(f"{name} is {given!r}; give at least {largest + 1}, as there are {of}")
    return int(given)
