"""Outcomes of sequences of actions: beliefs over states or distributions over observations.

If the observation depends on the last action too, that action leads from a belief to a distribution
over observations (`Successors.seen`); the actions before it lead to beliefs, as in `beliefs`.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Bool, Float64, Int32

from habilis.empowerment.tabular import beliefs
from habilis.empowerment.tabular.beliefs import Beliefs, TooManyBeliefsError, unheard
from habilis.empowerment.tabular.successors import Successors
from habilis.probabilities import is_sparse, shape_of

if TYPE_CHECKING:
    from scipy.sparse import csr_array


def outcomes_after(
    successors: Successors,
    start: int,
    horizon: int,
    most_entries: int = 2**62,
    report: Callable[[int, int], None] = unheard,
) -> Beliefs:
    """As `beliefs_after`, over observations where the last action leads to these.

    Without an action there is no observation. Rows over observations may be alike.
    """
    seen = successors.seen
    if seen is None:
        return beliefs.beliefs_after(successors, start, horizon, most_entries, report)
    if horizon == 0:
        return Beliefs(np.empty(0, np.int32), np.empty((1, 0)), ())
    before = beliefs.beliefs_after(successors, start, horizon - 1, most_entries, report)
    states, matrix = before.states, before.matrix
    observations, each = _observations(successors, seen, states)
    if len(each) * shape_of(matrix)[0] * len(observations) > most_entries:
        raise TooManyBeliefsError(horizon - 1)
    sure = _surely_available(successors, states, matrix)
    parents = [np.flatnonzero(sure[:, action]).astype(np.int32) for action in range(len(each))]
    rows = [_dense(matrix[parent] @ one) for parent, one in zip(parents, each, strict=True)]
    actions = np.repeat(np.arange(len(each), dtype=np.int32), [len(parent) for parent in parents])
    report(horizon, horizon)
    steps = (*before.steps, (np.concatenate(parents), actions))
    return Beliefs(observations, np.concatenate(rows), steps)


def followed(
    successors: Successors, start: int, sequences: Int32[np.ndarray, "n h"]
) -> tuple[Int32[np.ndarray, "N"], Float64[np.ndarray, "n N"]]:
    """As `beliefs.followed`, over observations where the last action leads to these."""
    seen = successors.seen
    if seen is None:
        return beliefs.followed(successors, start, sequences)
    if not sequences.shape[1]:
        return np.empty(0, np.int32), np.empty((len(sequences), 0))
    states, matrix = beliefs.followed(successors, start, sequences[:, :-1])
    return _looked(successors, seen, states, matrix, sequences[:, -1])


def wandered(
    successors: Successors, start: int, draws: Float64[np.ndarray, "n h"]
) -> tuple[Int32[np.ndarray, "N"], Float64[np.ndarray, "k N"]]:
    """As `beliefs.wandered`, over observations where the last action leads to these."""
    seen = successors.seen
    if seen is None:
        return beliefs.wandered(successors, start, draws)[:2]
    if not draws.shape[1]:
        return np.empty(0, np.int32), np.empty((len(draws), 0))
    states, matrix, complete = beliefs.wandered(successors, start, draws[:, :-1])
    sure, last = _surely_available(successors, states, matrix), draws[complete, -1]
    some = sure.any(axis=1)
    sure, last, matrix = sure[some], last[some], matrix[some]
    order = np.argsort(~sure, axis=1, kind="stable").astype(np.int32)  # the sure ones first
    drawn = np.minimum((last * sure.sum(axis=1)).astype(np.int64), sure.sum(axis=1) - 1)
    return _looked(successors, seen, states, matrix, order[np.arange(len(order)), drawn])


def _observations(
    successors: Successors, seen: "csr_array", states: Int32[np.ndarray, "N"]
) -> tuple[Int32[np.ndarray, "O"], "list[csr_array]"]:
    """The observations that one action in some states may lead to, and by action float64[N, O]."""
    rows = states.astype(np.int64) * successors.actions
    each = [seen[rows + action] for action in range(successors.actions)]
    observations = np.unique(np.concatenate([one.indices for one in each])).astype(np.int32)
    return observations, [one[:, observations] for one in each]


def _surely_available(
    successors: Successors,
    states: Int32[np.ndarray, "N"],
    matrix: "Float64[np.ndarray, 'K N'] | csr_array",
) -> Bool[np.ndarray, "K A"]:
    """Whether an action is available in every state that a belief holds possible."""
    missing = (np.diff(successors.first) == 0).reshape(-1, successors.actions)[states]
    return matrix @ missing.astype(np.float64) == 0


def _looked(
    successors: Successors,
    seen: "csr_array",
    states: Int32[np.ndarray, "N"],
    matrix: Float64[np.ndarray, "n N"],
    last: Int32[np.ndarray, "n"],
) -> tuple[Int32[np.ndarray, "O"], Float64[np.ndarray, "n O"]]:
    """The distributions over observations that one last action each leads to from beliefs."""
    observations, each = _observations(successors, seen, states)
    rows = np.empty((len(matrix), len(observations)))
    for action, one in enumerate(each):
        rows[last == action] = _dense(matrix[last == action] @ one)
    return observations, rows


def _dense(matrix: Any) -> Float64[np.ndarray, "n m"]:
    return matrix.toarray() if is_sparse(matrix) else matrix
