"""The arguments of a table, checked: transitions, available actions, rewards, terminal states."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from jaxtyping import Bool, Float32, Int, Int32, Integer
from numpy.typing import ArrayLike

from habilis.probabilities import (
    as_array,
    as_flags,
    is_sparse,
    refuse_masked,
    row_stochastic,
    shape_of,
)

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Axes = Literal["SAS", "ASS"]

_OR_AVAILABLE = ", or pass available="

UNAVAILABLE = -1
"""The next state of an action that is not available."""


def next_states(next_state: ArrayLike, available: ArrayLike | None) -> Int32[np.ndarray, "S A"]:
    """A transition table, with `UNAVAILABLE` where an action is not available.

    Raises:
        ValueError: as in `TabularMDP.deterministic`.
    """
    table = as_array("next_state", next_state, _OR_AVAILABLE)
    if table.ndim != 2 or table.size == 0 or not np.issubdtype(table.dtype, np.integer):
        raise ValueError(
            f"next_state has shape {table.shape} and type {table.dtype}; "
            "give integers of shape [states, actions]"
        )
    there = None if available is None else _mask(available, table.shape)
    wrong = (table < 0) | (table >= len(table))
    wrong &= (table != UNAVAILABLE) if there is None else there
    if wrong.any():
        state, action = np.argwhere(wrong)[0]
        value = table[state, action]
        if value == UNAVAILABLE:
            raise ValueError(
                f"next_state[{state}, {action}] is -1, but available[{state}, {action}] is True; "
                "give the next state, or False"
            )
        raise ValueError(
            f"next_state[{state}, {action}] is {value}; use states 0 to {len(table) - 1}, "
            "or -1 for an action that is not available"
        )
    table = np.array(table, np.int32, order="C")
    if there is not None:
        table[~there] = UNAVAILABLE
    return table


def transition_matrix(
    P: Any, available: ArrayLike | None, axes: Axes | None
) -> tuple["csr_array", int]:
    """Transition probabilities, sparse float64[S * A, S] with row `s * A + a`, and A.

    The row of an action that is not available is empty.

    Raises:
        ValueError: as in `TabularMDP.stochastic`.
    """
    from scipy.sparse import csr_array, vstack

    matrices = _by_action(P, axes)
    states, actions = shape_of(matrices[0])[0], len(matrices)
    there = None if available is None else _mask(available, (states, actions))
    each = []
    for action, given in enumerate(matrices):
        name = f"P, action {action}"
        if np.shape(given) != (states, states):
            raise ValueError(
                f"{name} has shape {np.shape(given)}; give {(states, states)}; in a list there is "
                "one matrix [states, states] an action"
            )
        ignored = None if there is None else ~there[:, action]
        each.append(row_stochastic(name, given, "state {}", "states", ignored, empty=True))
        if there is not None:
            missing = np.flatnonzero(there[:, action] & (np.diff(each[-1].indptr) == 0))
            if len(missing):
                raise ValueError(
                    f"{name}, state {missing[0]} sums to 0, but available[{missing[0]}, {action}] "
                    "is True; give its probabilities, or False"
                )
    by_action = np.arange(states * actions).reshape(actions, states)
    return csr_array(vstack(each, format="csr"))[by_action.T.ravel()], actions


def _by_action(P: Any, axes: Axes | None) -> list[Any]:
    """The transition matrices [S, S], one an action."""
    if axes not in (None, "SAS", "ASS"):
        raise ValueError(
            f"axes is {axes!r}; use 'SAS' for [states, actions, next states] or 'ASS' for "
            "[actions, states, next states]"
        )
    if is_sparse(P):
        raise ValueError("P is one sparse matrix; give a sequence of them, one an action")
    if isinstance(P, np.ndarray) and P.dtype == object and any(map(is_sparse, P.flat)):
        raise ValueError("P is an array of sparse matrices; give a list of them, as P.tolist()")
    listed = list(P) if isinstance(P, Sequence) else []
    refuse_masked("P", listed, _OR_AVAILABLE)
    if any(is_sparse(matrix) for matrix in listed):
        if axes == "SAS":
            raise ValueError("P is a list of sparse matrices, one an action; leave out axes")
        return [m if is_sparse(m) else as_array("P", m, _OR_AVAILABLE) for m in listed]
    if axes is None and any(getattr(matrix, "ndim", None) == 2 for matrix in listed):
        if len(listed) == len(listed[0]) > 1:
            raise ValueError(
                f"P is a list of {len(listed)} matrices with {len(listed)} rows: it could be by "
                "state or by action; give axes='SAS' or axes='ASS', or np.array(P) for [states, "
                "actions, states]"
            )
        axes = "ASS"
        if (shape := np.shape(listed[0]))[0] != shape[-1]:
            raise ValueError(
                f"P is a list of matrices, the first of shape {shape}; give one [states, states] "
                "an action, or axes='SAS' for one [actions, states] a state"
            )
    table = as_array("P", P, _OR_AVAILABLE)
    if table.dtype.kind not in "biuf" and table.ndim == 0:
        raise ValueError(
            f"P is a {type(P).__name__}; give an array [states, actions, states], or a sequence of "
            "scipy.sparse matrices [states, states], one an action"
        )
    if table.ndim == 3 and axes == "ASS":
        table = np.moveaxis(table, 0, 1)
    if table.ndim != 3 or 0 in table.shape or len(table) != table.shape[2]:
        shape = np.shape(table if table.ndim != 3 or axes != "ASS" else np.moveaxis(table, 1, 0))
        square = axes is None and len(shape) == 3 and shape[1] == shape[2]
        wanted = "actions, states, states" if axes == "ASS" else "states, actions, states"
        raise ValueError(
            f"P has shape {shape}; give [{wanted}], "
            + ("axes='ASS' for [actions, states, states], " if square else "")
            + "or a sequence of scipy.sparse matrices [states, states], one an action"
        )
    return list(np.moveaxis(table, 1, 0))


def _mask(available: ArrayLike, shape: tuple[int, int]) -> Bool[np.ndarray, "S A"]:
    mask = as_array("available", available)
    if mask.shape != shape:
        raise ValueError(f"available has shape {mask.shape}; give {shape}, [states, actions]")
    if mask.dtype.kind not in "biu" or not ((mask == 0) | (mask == 1)).all():
        raise ValueError("available has entries that are neither True nor False; give bools")
    return mask.astype(bool)


def rewards_and_ends(
    available: Bool[np.ndarray, "S A"],
    reward: ArrayLike | None,
    terminal: ArrayLike | None,
    start: int,
) -> tuple[Float32[np.ndarray, "S A"], Bool[np.ndarray, "S"]]:
    """The rewards of a table, 0 where an action is not available, and its terminal states.

    Raises:
        ValueError: they do not fit the available actions' shape [S, A], or are not finite.
    """
    shape = available.shape
    states = shape[0]
    reward = np.zeros(shape) if reward is None else as_array("reward", reward)
    terminal = np.zeros(states, bool) if terminal is None else as_flags("terminal", terminal)
    if reward.shape != shape:
        raise ValueError(f"reward has shape {reward.shape}; give {shape}, [states, actions]")
    if reward.dtype.kind in "biuf" and not available.all():
        reward = np.where(available, reward, 0)
    if reward.dtype.kind not in "biuf" or not (abs(reward) <= np.finfo(np.float32).max).all():
        raise ValueError("reward has entries that are not finite (in float32); give numbers")
    if terminal.shape != (states,):
        raise ValueError(f"terminal has shape {terminal.shape}; give ({states},)")
    if not isinstance(start, int | np.integer) or not 0 <= start < states:
        raise ValueError(f"start is {start}; use a state from 0 to {states - 1}")
    return reward.astype(np.float32), terminal.astype(bool)


def simplest(stacked: "csr_array", actions: int) -> "Int32[np.ndarray, 'S A'] | csr_array":
    """Transitions in their simplest form: one next state each where there are no several."""
    outcomes = np.diff(stacked.indptr)
    if outcomes.max(initial=0) > 1:
        return stacked
    table = np.full(len(outcomes), UNAVAILABLE, np.int32)
    table[outcomes > 0] = stacked.indices
    return table.reshape(-1, actions)


def moves_of(transitions: "Integer[np.ndarray, 'S A'] | csr_array") -> "csr_array":
    """The probabilities of next states, float64[S * A, S], of a table's transitions."""
    from scipy.sparse import csr_array

    if not isinstance(transitions, np.ndarray):
        return transitions
    there = transitions.ravel() >= 0
    first = np.concatenate([[0], np.cumsum(there)])
    reached = transitions.ravel()[there]
    shape = transitions.size, len(transitions)
    return csr_array((np.ones(len(reached)), reached, first), shape)


def self_loops(states: Int[np.ndarray, "n"], actions: int, count: int) -> "csr_array":
    """Transitions of `count` states in which all actions of some states lead back to them."""
    from scipy.sparse import csr_array

    rows = (states[:, None] * actions + np.arange(actions)).ravel()
    columns = np.repeat(states, actions)
    return csr_array((np.ones(len(rows)), (rows, columns)), (count * actions, count))


def only_rows(matrix: "csr_array", wanted: Bool[np.ndarray, "n"]) -> "csr_array":
    """The same with zeros in all rows that are not wanted."""
    found = matrix.copy()
    found.data *= np.repeat(wanted, np.diff(matrix.indptr))
    return found
