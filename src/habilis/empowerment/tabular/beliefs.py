"""Where sequences of actions may lead when outcomes are uncertain, without listing all of them.

A belief is a distribution over next states. Sequences that lead to the same belief are one from
then on, since nothing that follows distinguishes them; so beliefs are carried forward
action by action and merged at every step. An action is available under a belief if it is in every
state that the belief holds possible; other actions lead to no belief.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float64, Int32, Int64

from habilis.compiled import compile_now, compiled, part
from habilis.empowerment.tabular.successors import Successors, around, compile_around
from habilis.mdp_arguments import UNAVAILABLE

if TYPE_CHECKING:
    from scipy.sparse import csr_array

SAME = 1e-14  # beliefs that differ by no more in any entry are one: what rounding can do

ENOUGH, FEWER = 2**15, 0.9
"""Numbers in beliefs, above which merging must leave no more than this share of them."""

_LEAST = float(np.finfo(np.float64).tiny)  # of what is possible: it must not round to 0

_GRAIN = float(2**30)  # coarse, so that rounding seldom puts the same beliefs in two places
_OFFSET = 0.318309886  # keeps round numbers away from the grains' edges


class TooManyBeliefsError(Exception):
    """The beliefs of one state outgrew what they may; `horizon` is the last that fitted."""

    def __init__(self, horizon: int):
        super().__init__(f"the beliefs of {horizon + 1} actions are too many")
        self.horizon = horizon


@dataclass(frozen=True)
class Beliefs:
    """The beliefs reachable with h actions.

    Attributes:
        states: int32[N], the states that can be reached at all; or the observations, where the
            last action leads to these.
        matrix: float64[K, N], a distribution over them each row; no two rows alike. Sparse where
            every row is certain of one state.
        steps: for each of the h actions (parent int32[K_t], action int32[K_t]): from which row
            of the step before, and by what, a row came about; one way of those merged.
    """

    states: Int32[np.ndarray, "N"]
    matrix: "Float64[np.ndarray, 'K N'] | csr_array"
    steps: tuple[tuple[Int32[np.ndarray, "_"], Int32[np.ndarray, "_"]], ...]

    def sequences(self, rows: Int64[np.ndarray, "n"]) -> Int32[np.ndarray, "n h"]:
        """A sequence of actions that leads to each of some rows."""
        actions = np.empty((len(rows), len(self.steps)), np.int32)
        for t in reversed(range(len(self.steps))):
            parent, action = self.steps[t]
            actions[:, t] = action[rows]
            rows = parent[rows].astype(np.int64)
        return actions


def unheard(done: int, known: int) -> None:
    """A progress callback that does nothing."""


def beliefs_after(
    successors: Successors,
    start: int,
    horizon: int,
    most_entries: int = 2**62,
    report: Callable[[int, int], None] = unheard,
) -> Beliefs:
    """All distinct beliefs that sequences of h actions from a state lead to.

    None if no sequence is certain to be executable. `report` receives how many actions are done.

    Raises:
        TooManyBeliefsError: at some step they are more than `most_entries` numbers.
    """
    if successors.certain:
        return _ends(successors, start, horizon, most_entries, report)
    states, local = around(successors, start, horizon)
    most = max(most_entries // len(states), 1)
    matrix = np.zeros((1, len(states)))
    matrix[0, 0] = 1.0
    steps = []
    partial = not successors.always_available
    for t in range(horizon):
        matrix, parent, action = _advance(
            matrix, local.first, local.state, local.probability, local.actions, most, partial
        )
        if len(matrix) > most:
            raise TooManyBeliefsError(t)
        steps.append((parent, action))
        report(t + 1, horizon)
    return Beliefs(states, matrix, tuple(steps))


def beliefs_before_last(
    successors: Successors, start: int, horizon: int, most_entries: int = 2**62
) -> tuple[Int32[np.ndarray, "N"], Successors, Float64[np.ndarray, "K N"], int]:
    """All distinct beliefs after as many actions, fewer than h, as it pays to merge beliefs.

    Beliefs are merged as long as they are small, or merging leaves clearly fewer.

    Args:
        successors: the transitions.
        start: the state.
        horizon: h, 1 or more.
        most_entries: how many numbers the beliefs may be.

    Returns:
        The states within h - 1 actions, the transitions among them, the beliefs over them, and
        how many actions have led there.
    """
    states, local = around(successors, start, horizon - 1)
    matrix, done = np.zeros((1, len(states))), 0
    matrix[0, 0] = 1.0
    actions, most = local.actions, max(most_entries // len(states), 1)
    partial = not successors.always_available
    merging = True
    while done < horizon - 1 and (merging or matrix.size * actions <= ENOUGH):
        further, _, _ = _advance(
            matrix, local.first, local.state, local.probability, actions, most, partial
        )
        if len(further) > most:
            break
        merging = len(further) < FEWER * actions * len(matrix)
        matrix, done = further, done + 1
    return states, local, matrix, done


def _ends(
    successors: Successors,
    start: int,
    horizon: int,
    most: int,
    report: Callable[[int, int], None],
) -> Beliefs:
    """`beliefs_after` where nothing is uncertain: a belief is a state."""
    from scipy.sparse import csr_array, eye_array

    next_state = successors.next_state
    here, steps = np.array([start], np.int32), []
    for t in range(horizon):
        here, index = np.unique(next_state[here], return_index=True)
        if len(here) and here[0] == UNAVAILABLE:
            here, index = here[1:], index[1:]
        parent, action = np.divmod(index.astype(np.int32), successors.actions)
        if len(here) > most:
            raise TooManyBeliefsError(t)
        steps.append((parent, action))
        report(t + 1, horizon)
    return Beliefs(here, csr_array(eye_array(len(here))), tuple(steps))


def followed(
    successors: Successors, start: int, sequences: Int32[np.ndarray, "n h"]
) -> tuple[Int32[np.ndarray, "N"], Float64[np.ndarray, "n N"]]:
    """The beliefs that given sequences of actions lead to, and over which states."""
    states, local = around(successors, start, sequences.shape[1])
    matrix = _follow(sequences, local.first, local.state, local.probability, local.actions)
    return states, matrix


def wandered(
    successors: Successors, start: int, draws: Float64[np.ndarray, "n h"]
) -> tuple[Int32[np.ndarray, "N"], Float64[np.ndarray, "k N"], Bool[np.ndarray, "n"]]:
    """As `followed`, of sequences drawn step by step, uniformly from what is surely available.

    Those that come to where nothing surely is are left out.

    Args:
        successors: the transitions.
        start: the state.
        draws: a uniform number from [0, 1) for each step of each sequence.

    Returns:
        Those two, and which sequences are complete.
    """
    states, local = around(successors, start, draws.shape[1])
    matrix, complete = _wander(draws, local.first, local.state, local.probability, local.actions)
    return states, matrix[complete], complete


def compile_kernels() -> None:
    """Leaves out the time as plain Python: what follows is timed."""
    compile_around()
    compile_now(_advance, _follow, _wander)


def distinct(
    rows: Float64[np.ndarray, "n m"],
) -> tuple[Float64[np.ndarray, "k m"], Int32[np.ndarray, "k"]]:
    """The rows that differ, each once, and where they were first."""
    width = rows.shape[1]
    stay = np.arange(width + 1), np.arange(width, dtype=np.int32), np.ones(width)
    different, parent, _ = _advance(rows, *stay, 1, len(rows), False)
    return different, parent


@part
def _copy(row, into):
    """Written out: an assignment between arrays takes seconds to compile, for its error."""
    for i in range(len(row)):
        into[i] = row[i]


@part
def _key(row):
    key = np.uint64(0x9E3779B97F4A7C15)
    for value in row:
        key ^= np.uint64(np.int64(value * _GRAIN + _OFFSET))
        key *= np.uint64(0x100000001B3)
        key ^= key >> np.uint64(29)
    return key


@part
def _find(row, key, slots, keys, rows, partial):
    """The slot of a row like this one, or the free slot where it belongs.

    Where actions are not available everywhere (`partial`), rows that are alike have their zeros in
    the same places: what is possible at all decides which actions are.
    """
    mask = np.uint64(len(slots) - 1)
    slot = key & mask
    while slots[slot] > 0:
        known = slots[slot] - 1
        if keys[known] == key:
            same = True
            for i in range(len(row)):
                if abs(row[i] - rows[known, i]) > SAME:
                    same = False
                    break
                if partial and (row[i] == 0.0) != (rows[known, i] == 0.0):
                    same = False
                    break
            if same:
                return slot
        slot = (slot + np.uint64(1)) & mask
    return slot


@part
def _surely(belief, first, actions, a):
    """Whether an action is available in every state that a belief holds possible."""
    for s in range(len(belief)):
        if belief[s] != 0.0 and first[s * actions + a] == first[s * actions + a + 1]:
            return False
    return True


@compiled(lambda matrix, first, state, probability, actions, *rest: 5 * matrix.size * actions)
def _advance(matrix, first, state, probability, actions, most, partial):
    """One action more: the distinct beliefs, and from which row and by what they came about."""
    count, width = matrix.shape
    size = 16
    while size < 2 * count * actions:
        size *= 2
    slots = np.zeros(size, np.int32)  # one more than a row's number
    room = 2 * count + 16
    rows = np.empty((room, width))
    keys = np.empty(count * actions, np.uint64)
    parent = np.empty(count * actions, np.int32)
    action = np.empty(count * actions, np.int32)
    found = 0
    row = np.empty(width)
    for i in range(count):
        for a in range(actions):
            if partial and not _surely(matrix[i], first, actions, a):
                continue
            for s in range(width):
                row[s] = 0.0
            for s in range(width):
                weight = matrix[i, s]
                if weight != 0.0:
                    for k in range(first[s * actions + a], first[s * actions + a + 1]):
                        share = weight * probability[k]
                        if partial and share < _LEAST:
                            share = _LEAST
                        row[state[k]] += share
            key = _key(row)
            slot = _find(row, key, slots, keys, rows, partial)
            if slots[slot] == 0:
                if found == room:
                    room *= 2
                    wider = np.empty((room, width))
                    for j in range(found):
                        _copy(rows[j], wider[j])
                    rows = wider
                slots[slot] = found + 1
                _copy(row, rows[found])
                keys[found] = key
                parent[found] = i
                action[found] = a
                found += 1
                if found > most:
                    return rows[:found], parent[:found], action[:found]
    return rows[:found].copy(), parent[:found].copy(), action[:found].copy()


@compiled(lambda sequences, first, *rest: 3 * sequences.size * len(first))
def _follow(sequences, first, state, probability, actions):
    width = (len(first) - 1) // actions
    rows = np.zeros((len(sequences), width))
    before = np.empty(width)
    for i in range(len(sequences)):
        rows[i, 0] = 1.0
        for a in sequences[i]:
            _copy(rows[i], before)
            for s in range(width):
                rows[i, s] = 0.0
            for s in range(width):
                if before[s] != 0.0:
                    for k in range(first[s * actions + a], first[s * actions + a + 1]):
                        rows[i, state[k]] += before[s] * probability[k]
    return rows


@compiled(lambda draws, first, *rest: 5 * draws.size * len(first))
def _wander(draws, first, state, probability, actions):
    width = (len(first) - 1) // actions
    rows = np.zeros((len(draws), width))
    complete = np.ones(len(draws), np.bool_)
    before = np.empty(width)
    available = np.empty(actions, np.int64)
    for i in range(len(draws)):
        rows[i, 0] = 1.0
        for t in range(draws.shape[1]):
            count = 0
            for a in range(actions):
                if _surely(rows[i], first, actions, a):
                    available[count] = a
                    count += 1
            if count == 0:
                complete[i] = False
                break
            a = available[min(int(draws[i, t] * count), count - 1)]
            _copy(rows[i], before)
            for s in range(width):
                rows[i, s] = 0.0
            for s in range(width):
                if before[s] != 0.0:
                    for k in range(first[s * actions + a], first[s * actions + a + 1]):
                        rows[i, state[k]] += max(before[s] * probability[k], _LEAST)
    return rows, complete
