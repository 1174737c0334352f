"""How many observations h actions can bring about, without listing action sequences.

Two ways to the same number, |O_h(s)| with

    O_0(s) = {o(s)},   O_h(s) = union over a of O_{h-1}(next(s, a)),

where o(s) is what the sensor shows in s: nothing where the label is -1. With few labels, all
states' sets are carried backward together, one bit a label. With many, each state's set of
reachable states is grown forward and its labels are counted at the end.
"""

from collections import deque
from collections.abc import Iterator

import numpy as np
from jaxtyping import Int32, Int64, UInt64

from habilis.compiled import compiled
from habilis.empowerment.blocks import in_blocks

_WORD = 64
_FEW_WORDS = 4


def count_backward(
    next_state: Int32[np.ndarray, "S A"],
    labels: Int32[np.ndarray, "S"],
    label_count: int,
    horizon: int,
    threads: int = 1,
) -> Int64[np.ndarray, "S"]:
    """|O_h(s)| for every state, by packed bits: S * A * h * ceil(labels / 64) word operations.

    Stops as soon as one more action changes no state's set. Memory: two sets of ceil(labels / 64)
    words of 8 bytes a state.
    """
    grown = sets_backward(next_state, labels, label_count, horizon, threads)
    return sizes(deque(grown, maxlen=1).pop())


def sizes(sets: UInt64[np.ndarray, "n W"]) -> Int64[np.ndarray, "n"]:
    """How many bits are set in each row."""
    return np.bitwise_count(sets).sum(axis=1, dtype=np.int64)


def sets_backward(
    next_state: Int32[np.ndarray, "S A"],
    labels: Int32[np.ndarray, "S"],
    label_count: int,
    horizon: int,
    threads: int = 1,
) -> Iterator[UInt64[np.ndarray, "S W"]]:
    """O_0, O_1, ... O_h of every state, a bit a label; fewer if one more action changes none.

    What it gave is written over when it is asked for the next but one.
    """
    state = np.flatnonzero(labels >= 0)
    seen = labels[state]
    sets = np.zeros((len(labels), -(-label_count // _WORD)), np.uint64)
    sets[state, seen // _WORD] = np.uint64(1) << (seen % _WORD).astype(np.uint64)
    spare = np.empty_like(sets)
    operations = sets.shape[1] * next_state.shape[1]
    yield sets
    for _ in range(horizon):
        before, after = sets, spare
        changed = in_blocks(
            lambda a, b, before=before, after=after: unite(next_state, before, after, a, b),
            len(labels),
            operations,
            threads,
        )
        if not any(changed):
            break
        sets, spare = after, before
        yield sets


@compiled
def unite(
    next_state: Int32[np.ndarray, "S A"],
    sets: UInt64[np.ndarray, "S W"],
    out: UInt64[np.ndarray, "S W"],
    begin: int,
    end: int,
) -> bool:
    """One step backward: out[s] = union over a of sets[next(s, a)]; says if anything changed."""
    changed = False
    if sets.shape[1] <= _FEW_WORDS:  # a word stays in a register while its successors' come
        for s in range(begin, end):
            for w in range(sets.shape[1]):
                word = np.uint64(0)
                for a in range(next_state.shape[1]):
                    word |= sets[next_state[s, a], w]
                out[s, w] = word
                changed |= word != sets[s, w]
        return changed
    for s in range(begin, end):  # whole sets at a time, several words in one instruction
        first = next_state[s, 0]
        for w in range(sets.shape[1]):
            out[s, w] = sets[first, w]
        for a in range(1, next_state.shape[1]):
            t = next_state[s, a]
            for w in range(sets.shape[1]):
                out[s, w] |= sets[t, w]
        for w in range(sets.shape[1]):
            changed |= out[s, w] != sets[s, w]
    return changed


def count_forward(
    next_state: Int32[np.ndarray, "S A"],
    labels: Int32[np.ndarray, "S"],
    label_count: int,
    horizon: int,
    starts: Int64[np.ndarray, "n"],
    threads: int = 1,
) -> Int64[np.ndarray, "n"]:
    """|O_h(s)| for the asked states, each by its exact set of reachable states.

    Costs A times the sum of the sets' sizes a state; stops when a set no longer changes. Memory:
    16 bytes a state and 8 a label, for each thread.
    """
    counted = in_blocks(
        lambda a, b: _count_forward(next_state, labels, label_count, horizon, starts[a:b]),
        len(starts),
        100 * horizon,
        threads,
    )
    return np.concatenate(counted)


@compiled
def _count_forward(next_state, labels, label_count, horizon, starts):
    counts = np.empty(len(starts), np.int64)
    here = np.empty(next_state.shape[0], np.int32)
    there = np.empty(next_state.shape[0], np.int32)
    # met_at[s] is the last step (counted over all starts) at which s was in the set.
    met_at = np.full(next_state.shape[0], -1, np.int64)
    perceived_from = np.full(label_count, -1, np.int64)
    step = 0
    for i in range(len(starts)):
        step += 2
        here[0], size = starts[i], 1
        met_at[starts[i]] = step
        for _ in range(horizon):
            step += 1
            grown, old = 0, 0
            for k in range(size):
                for a in range(next_state.shape[1]):
                    s = next_state[here[k], a]
                    if met_at[s] != step:
                        old += met_at[s] == step - 1
                        met_at[s] = step
                        there[grown] = s
                        grown += 1
            same = grown == size and old == size
            here, there, size = there, here, grown
            if same:
                break
        count = 0
        for k in range(size):
            label = labels[here[k]]
            if label >= 0 and perceived_from[label] != i:
                perceived_from[label] = i
                count += 1
        counts[i] = count
    return counts
