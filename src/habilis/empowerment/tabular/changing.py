"""The part of a counting problem that h actions can change at all.

Few actions leave most of what is observed as it is. In

    O_h(s) = union over a of O_{h-1}(next(s, a))

the set of s first differs from {o(s)} one step after that of a successor does, or in the first step
where a successor shows something else. So the step is found backward without any sets. States whose
step is after h see what they show; the others are a smaller problem, in which one more state for
each label, which leads to itself, stands for all those left out. In it states with the same label
lie side by side: what is observed seldom changes, so that their successors are near.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int32, Int64, UInt8

from habilis.compiled import compiled
from habilis.empowerment.tabular.blocks import in_blocks

_NEVER = 255  # no step of these changes it
_LAST = 254  # from this step on no more are looked for: all others count as changed
_ALMOST_ALL = 0.9  # share of the states from which on the others are not worth looking for
_WORTHWHILE = 0.5  # steps over all states
_IN_NUMPY = 20  # state-actions looked at while plain Python does an operation


@dataclass(frozen=True)
class Changing:
    """A smaller counting problem with the same counts.

    Attributes:
        states: the k states that can change, by label.
        table: int32[n, A], over these states, one without a label, and one for each label.
        labels: int32[n].
        first: uint8[n], the step before which a state's set is surely what the state shows.
        place: int32[S], the state of the smaller problem that has the same sets.
        sizes: how many states it has if the horizon is 0, 1, ..., up to where they are no more.
    """

    states: Int64[np.ndarray, "k"]
    table: Int32[np.ndarray, "n A"]
    labels: Int32[np.ndarray, "n"]
    first: UInt8[np.ndarray, "n"]
    place: Int32[np.ndarray, "S"]
    sizes: Int64[np.ndarray, "levels"]


def changing(
    table: Int32[np.ndarray, "S A"],
    labels: Int32[np.ndarray, "S"],
    label_count: int,
    horizon: int,
    threads: int,
) -> Changing | None:
    """The smaller problem; `None` if it would save less than half a step over all states.

    Memory: see `memory`.
    """
    first, sizes = _first_changes(table, labels, horizon, threads)
    spared = 1 - sizes / len(table)
    if spared[1:].sum() + (horizon - len(sizes) + 1) * spared[-1] < _WORTHWHILE:
        return None
    states = np.flatnonzero(first != _NEVER)
    small = labels[states].astype(np.uint16 if label_count <= 2**16 else np.int32)
    states = states[np.argsort(small, kind="stable")]
    size, others = len(states), np.arange(label_count + 1, dtype=np.int32)
    place = labels + np.int32(size + 1)
    place[states] = np.arange(size, dtype=np.int32)
    alone = np.broadcast_to(size + others[:, None], (len(others), table.shape[1]))
    return Changing(
        states,
        np.concatenate([place[table[states]], alone]),
        np.concatenate([labels[states], others - 1]),
        np.append(first[states], np.full(len(others), _NEVER, np.uint8)),
        place,
        sizes + len(others),
    )


def memory(states: int, all_states: int, actions: int) -> int:
    """Bytes that the problem of so many states takes, and finding it."""
    return 13 * all_states + (12 * actions + 24) * states


def _first_changes(
    table: Int32[np.ndarray, "S A"], labels: Int32[np.ndarray, "S"], horizon: int, threads: int
) -> tuple[UInt8[np.ndarray, "S"], Int64[np.ndarray, "levels"]]:
    """The step in which each state's set can first differ from what the state shows, or sooner.

    Returns:
        The steps; and in how many states it can have, after 0, 1, ... steps.
    """
    first = np.full(len(table), _NEVER, np.uint8)
    # Numba reads what may be negative as Python does, in nearly twice the time.
    unsigned = np.ascontiguousarray(table).view(np.uint32)
    sizes = [0]
    while len(sizes) <= horizon:
        time = len(sizes)
        if sizes[-1] > _ALMOST_ALL * len(table) or time == _LAST:
            first[first == _NEVER] = time
            sizes.append(len(table))
            break
        found = in_blocks(
            lambda a, b, time=time: _look_back(unsigned, labels, first, time, a, b),
            len(table),
            table.shape[1],
            threads,
        )
        if not sum(found):
            break
        sizes.append(sizes[-1] + sum(found))
    return first, np.array(sizes, np.int64)


def _looks(table, labels, first, time, begin, end):
    return (end - begin) * table.shape[1] / _IN_NUMPY


def _look_back_in_numpy(table, labels, first, time, begin, end):
    rows = begin + np.flatnonzero(first[begin:end] == _NEVER)
    if time == 1:
        near = (labels[table[rows]] != labels[rows, None]).any(axis=1)
    else:
        near = (first[table[rows]] < time).any(axis=1)
    first[rows[near]] = time
    return int(near.sum())


@compiled(_looks, _look_back_in_numpy)
def _look_back(table, labels, first, time, begin, end):
    """Marks the states of a block whose sets can first change in this step, and counts them."""
    found = 0
    for s in range(begin, end):
        if first[s] != _NEVER:
            continue
        near = False
        if time == 1:
            for a in range(table.shape[1]):
                near |= labels[table[s, a]] != labels[s]
        else:  # other threads only write this step
            for a in range(table.shape[1]):
                near |= first[table[s, a]] < time
        if near:
            first[s] = time
            found += 1
    return found
