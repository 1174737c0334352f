"""The entries of a file in Cassandra's format as arrays: transitions, observations, rewards."""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float64, Int

from habilis.bridges.cassandra.parsing import ROUNDING, Entry, File, Names
from habilis.files import shown

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_MOST = 2**30  # numbers of a dense sensor: 8 GiB

Row = dict[int, float] | Float64[np.ndarray, "S"]


def transitions(file: File) -> "list[csr_array]":
    """The transition matrix [S, S] of each action.

    Raises:
        FormatError: the next states of an action do not have probabilities that sum to one.
    """
    states, actions = file.states.count, file.actions.count
    rows: list[list[Row]] = [[{} for _ in range(states)] for _ in range(actions)]
    lines = np.zeros((actions, states), np.int64)
    for entry in _of_kind(file, "T"):
        action, state, *_ = (*entry.selected, None)
        for a in _all(action, actions):
            for s in _all(state, states):
                lines[a, s] = entry.line
                if len(entry.selected) < 3:
                    rows[a][s] = _row(file, entry, s)
                    continue
                row, value = rows[a][s], float(np.asarray(entry.values))
                for column in _all(entry.selected[2], states):
                    row[column] = value
    return [_matrix(file, action, each, lines[action]) for action, each in enumerate(rows)]


def _row(file: File, entry: Entry, state: int) -> Row:
    """The row of a state in an entry that gives whole rows."""
    values, states = entry.values, file.states.count
    if isinstance(values, np.ndarray):
        return (values[state] if values.ndim == 2 else values).copy()
    if values == "identity":
        return {state: 1.0}
    return file.belief.copy() if values == "reset" else np.full(states, 1 / states)


def _matrix(file: File, action: int, rows: list[Row], lines: Int[np.ndarray, "S"]) -> "csr_array":
    from scipy.sparse import csr_array

    columns, weights = [], []
    for state, row in enumerate(rows):
        if isinstance(row, dict):
            column = np.array(sorted(k for k, p in row.items() if p), np.int64)
            weight = np.array([row[k] for k in column.tolist()], np.float64)
        else:
            column = np.flatnonzero(row)
            weight = row[column]
        _check(file, "T", action, file.states, state, float(weight.sum()), int(lines[state]))
        columns.append(column)
        weights.append(weight / weight.sum())
    first = np.cumsum([0, *map(len, columns)])
    return csr_array(
        (np.concatenate(weights), np.concatenate(columns), first), (len(rows), len(rows))
    )


def observation_probabilities(file: File, observations: Names) -> Float64[np.ndarray, "A S O"]:
    """The probability of each observation after an action, in the state that it led to.

    Raises:
        FormatError: they do not sum to one, or are too many.
    """
    shape = file.actions.count, file.states.count, observations.count
    if np.prod(shape, dtype=float) > _MOST:
        raise file.words.error(
            f"{shape[0]} actions, {shape[1]} states and {shape[2]} observations are a sensor of "
            f"{8 * np.prod(shape, dtype=float) / 2**30:.0f} GiB; give a smaller model",
            0,
        )
    table, lines = np.zeros(shape), np.zeros(shape[:2], np.int64)
    for entry in _of_kind(file, "O"):
        where = tuple(slice(None) if one is None else one for one in entry.selected)
        values = entry.values
        table[where] = 1 / shape[2] if isinstance(values, str) else values
        lines[where[:2]] = entry.line
    sums = table.sum(axis=2)
    for action, state in np.argwhere(abs(sums - 1) > ROUNDING).tolist():
        total, line = float(sums[action, state]), int(lines[action, state])
        _check(file, "O", action, file.states, state, total, line)
    return table / sums[..., None]


def _check(
    file: File, kind: str, action: int, states: Names, state: int, total: float, line: int
) -> None:
    if abs(total - 1) <= ROUNDING:
        return
    which = shown(f"{kind}: {file.actions.name(action)} : {states.name(state)}")
    if not line:
        raise file.words.error(f"{which} is given nowhere; add its probabilities", 0)
    raise file.words.error(
        f"the probabilities of {which} sum to {total:.8g}; make them sum to 1", line
    )


def rewards(
    file: File,
    moves: "list[csr_array]",
    seen: Float64[np.ndarray, "A S O"] | None,
) -> Float64[np.ndarray, "S A"]:
    """The mean reward of each action in each state, over next states and observations.

    Only transitions that are possible are looked at: R is as large as all pairs of states.

    Args:
        file: its rewards depend on action, state, next state and observation.
        moves: as `transitions` returns them.
        seen: as `observation_probabilities` returns them; `None` in an MDP.
    """
    of_action: list[list[Entry]] = [[] for _ in moves]
    for entry in _of_kind(file, "R"):
        for action in _all(entry.selected[0], len(moves)):
            of_action[action].append(entry)
    means = [
        _mean(matrix, entries, None if seen is None else seen[action])
        for action, (matrix, entries) in enumerate(zip(moves, of_action, strict=True))
    ]
    sign = -1.0 if file.cost else 1.0
    return sign * np.stack(means, axis=1) + 0.0  # no -0


def _mean(
    matrix: "csr_array", entries: list[Entry], seen: Float64[np.ndarray, "S O"] | None
) -> Float64[np.ndarray, "S"]:
    """The mean reward of one action in each state."""
    states, reached = len(matrix.indptr) - 1, matrix.indices
    left = np.repeat(np.arange(states), np.diff(matrix.indptr))
    by_column = np.argsort(reached, kind="stable")
    begins = np.searchsorted(reached[by_column], np.arange(states + 1))
    reward = np.zeros((len(reached), 1 if seen is None else seen.shape[1]))

    def transitions_of(state: int | None, following: int | None) -> np.ndarray | slice:
        if state is None:
            if following is None:
                return slice(None)
            return by_column[begins[following] : begins[following + 1]]
        first, last = matrix.indptr[state : state + 2]
        if following is None:
            return slice(first, last)
        return first + np.flatnonzero(reached[first:last] == following)

    for entry in entries:
        _, state, following, observation = (*entry.selected, None, None, None)[:4]
        where, values = transitions_of(state, following), np.asarray(entry.values)
        if seen is None and values.ndim == 2:
            reward[where, 0] = values[left[where], reached[where]]
        elif seen is None and values.ndim == 1:
            reward[where, 0] = values[reached[where]]
        elif values.ndim == 2:
            reward[where] = values[reached[where]]
        elif values.ndim == 0 and observation is not None:
            reward[where, observation] = values
        else:
            reward[where] = values
    each = reward[:, 0] if seen is None else (reward * seen[reached]).sum(axis=1)
    return np.bincount(left, matrix.data * each, minlength=states)


def _of_kind(file: File, kind: str) -> list[Entry]:
    return [entry for entry in file.entries if entry.kind == kind]


def _all(index: int | None, count: int) -> range:
    return range(count) if index is None else range(index, index + 1)
