"""The number of observations reachable with h actions, without enumerating sequences.

Three ways to the same number, |O_h(s)| with

    O_0(s) = {o(s)},   O_h(s) = union over a of O_{h-1}(next(s, a)),

where o(s) is what the sensor shows in s; a state labelled -1 shows nothing. With few labels, all
states' sets are carried backward together, one bit a label. With many, each state's set of
reachable states is grown forward as a list while it is short. Sets that outgrow lists are rows of
bits again, a block of columns at a time: a column for each label, carried backward from the
states that show it, or for each state asked about, carried forward to all that it reaches.
"""

from collections.abc import Generator

import numpy as np
from jaxtyping import Int32, Int64, UInt8, UInt64

from habilis.compiled import compile_now, compiled, paths
from habilis.empowerment.limits import Progress, unwatched
from habilis.empowerment.tabular.blocks import in_blocks, in_turn
from habilis.empowerment.tabular.recurring import FIRST_LOOK, last_of, recurring

_WORD = 64
_IN_NUMPY = 50  # words united while plain Python does an operation
_PARTS = 8  # of the starts, for each thread: they are done one after another
_STARTS = 500  # in a part at least


def count_backward(
    next_state: Int32[np.ndarray, "S A"],
    labels: Int32[np.ndarray, "S"],
    label_count: int,
    horizon: int,
    threads: int = 1,
    watch: Progress = unwatched,
    first: UInt8[np.ndarray, "S"] | None = None,
) -> Int64[np.ndarray, "S"]:
    """|O_h(s)| for every state, by packed bits: S * A * h * ceil(labels / 64) word operations.

    Stops at a fixed point, and goes on from a period with the remainder of the horizon. The last
    step's sets are counted as they are made, and not kept. Memory: three sets of
    ceil(labels / 64) words of 8 bytes a state.

    Args:
        next_state, labels, label_count, horizon: as above.
        threads: how many work side by side.
        watch: is called with the share that is done.
        first: the step before which a state's set is surely what the state itself shows (see
            `changing`); by default 0.
    """
    counts = (labels >= 0).astype(np.int64)
    if horizon == 0:
        return counts
    first = np.zeros(len(labels), np.uint8) if first is None else first
    next_state = np.ascontiguousarray(next_state)
    grown = sets_backward(next_state, labels, label_count, horizon - 1, threads, first)
    sets = last_of(grown, horizon - 1, lambda share: watch(share * (1 - 1 / horizon)))
    in_blocks(
        lambda a, b: count_unions(next_state, first, horizon, sets, counts, a, b),
        len(labels),
        sets.shape[1] * next_state.shape[1],
        threads,
    )
    return counts


def sizes(sets: UInt64[np.ndarray, "n W"]) -> Int64[np.ndarray, "n"]:
    """How many bits are set in each row."""
    return np.bitwise_count(sets).sum(axis=1, dtype=np.int64)


def sets_backward(
    next_state: Int32[np.ndarray, "S A"],
    labels: Int32[np.ndarray, "S"],
    label_count: int,
    horizon: int,
    threads: int,
    first: UInt8[np.ndarray, "S"],
    *,
    jump: bool = True,
) -> Generator[tuple[UInt64[np.ndarray, "S W"], int], None, int]:
    """O_0, O_1, ... of every state, a bit a label, until they repeat; see `recurring`."""
    next_state = np.ascontiguousarray(next_state)
    shown = np.flatnonzero(labels >= 0)
    sets = np.zeros((len(labels), max(-(-label_count // _WORD), 1)), np.uint64)
    bits = np.uint64(1) << (labels[shown] % _WORD).astype(np.uint64)
    sets[shown, labels[shown] // _WORD] = bits
    operations = sets.shape[1] * next_state.shape[1]
    time = 0

    def step(before: np.ndarray, after: np.ndarray) -> bool:
        nonlocal time
        time += 1
        changed = in_blocks(
            lambda a, b: unite(next_state, first, time, before, after, a, b),
            len(labels),
            operations,
            threads,
        )
        return any(changed)

    return recurring(step, sets, horizon, jump=jump)


def words_united(next_state, first, time, sets, out, begin, end):
    """What a step costs in NumPy, in operations of plain Python."""
    return (end - begin) * next_state.shape[1] * sets.shape[1] / _IN_NUMPY


def _unite_rows():
    from habilis.empowerment.tabular.rows import unite_rows

    return unite_rows


def _count_rows():
    from habilis.empowerment.tabular.rows import count_rows

    return count_rows


@compiled(words_united, body=_unite_rows)
def unite(
    next_state: Int32[np.ndarray, "S A"],
    first: UInt8[np.ndarray, "S"],
    time: int,
    sets: UInt64[np.ndarray, "S W"],
    out: UInt64[np.ndarray, "S W"],
    begin: int,
    end: int,
) -> bool:
    """Step `time` backward: out[s] = union over a of sets[next(s, a)]; says if anything changed.

    States whose sets cannot change yet are left out: `out` has theirs already.
    """
    rows, union = _unions(next_state, first, time, sets, begin, end)
    out[rows] = union
    return bool((union != sets[rows]).any())


@compiled(words_united, body=_count_rows)
def count_unions(
    next_state: Int32[np.ndarray, "S A"],
    first: UInt8[np.ndarray, "S"],
    time: int,
    sets: UInt64[np.ndarray, "S W"],
    out: Int64[np.ndarray, "S"],
    begin: int,
    end: int,
) -> None:
    """As `unite`, but writes how many bits of each set there are."""
    rows, union = _unions(next_state, first, time, sets, begin, end)
    out[rows] = sizes(union)


def _unions(next_state, first, time, sets, begin, end):
    """The states of a block whose sets may change in a step, and these sets, in NumPy."""
    rows = begin + np.flatnonzero(first[begin:end] <= time)
    successors = next_state[rows]
    union = sets[successors[:, 0]]
    for a in range(1, successors.shape[1]):
        union |= sets[successors[:, a]]
    return rows, union


def count_forward(
    next_state: Int32[np.ndarray, "S A"],
    labels: Int32[np.ndarray, "S"],
    label_count: int,
    horizon: int,
    starts: Int64[np.ndarray, "n"],
    threads: int = 1,
    most: int = 2**62,
    most_steps: int = 2**62,
    watch: Progress = unwatched,
) -> Int64[np.ndarray, "n"]:
    """|O_h(s)| for the asked states, each by the exact list of states that it reaches.

    Costs A times the sum of the lists' lengths a state; stops at a fixed point, and goes on from a
    period with the remainder of the horizon. Memory: 24 bytes a state and 8 a label, for each
    thread.

    Args:
        next_state, labels, label_count, horizon, starts: as above.
        threads: how many work side by side.
        most: how long a list may become; where it would be longer, the count is -1.
        most_steps: how many steps from state to state it may take; likewise.
        watch: is called with the share that is done.
    """
    parts = max(1, min(len(starts) // _STARTS, threads * _PARTS))
    edges = [len(starts) * part // parts for part in range(parts + 1)]
    counts = np.empty(len(starts), np.int64)

    def work(part: int, report: Progress) -> None:
        here = slice(edges[part], edges[part + 1])
        counts[here] = _count_forward(
            next_state,
            labels,
            label_count,
            horizon,
            starts[here],
            min(most, len(next_state)),
            most_steps,
        )

    in_turn(work, parts, threads, watch)
    return counts


def few_steps(next_state, labels, label_count, horizon, starts, most, most_steps):
    """Steps from state to state that the lists take, at most."""
    actions = next_state.shape[1]
    longest = min(horizon * min(most, len(next_state)) * actions, most_steps)
    return len(starts) * min(paths(actions, horizon), longest)


@compiled(few_steps)
def _count_forward(next_state, labels, label_count, horizon, starts, most, most_steps):
    counts = np.empty(len(starts), np.int64)
    room = max(min(len(next_state), most * next_state.shape[1]), 1)
    here = np.empty(room, np.int32)
    there = np.empty(room, np.int32)
    # met_at[s] is the last step (counted over all starts) at which s was in the set, kept_at[s]
    # the last at which it was in one that was kept to compare later ones with.
    met_at = np.full(len(next_state), -1, np.int64)
    kept_at = np.full(len(next_state), -1, np.int64)
    perceived_from = np.full(label_count, -1, np.int64)
    step = 0
    for i in range(len(starts)):
        step += 2
        here[0], size = starts[i], 1
        met_at[starts[i]] = step
        time, end = 0, horizon
        kept, kept_size, kept_time, keep = -2, 0, 0, FIRST_LOOK
        taken = 0
        while time < end and size <= most and taken <= most_steps:
            taken += size * next_state.shape[1]
            step += 1
            time += 1
            grown, old, again = 0, 0, 0
            for k in range(size):
                for a in range(next_state.shape[1]):
                    s = next_state[here[k], a]
                    if met_at[s] != step:
                        old += met_at[s] == step - 1
                        again += kept_at[s] == kept
                        met_at[s] = step
                        there[grown] = s
                        grown += 1
            same = grown == size and old == size
            here, there, size = there, here, grown
            if same:
                break
            if again == size == kept_size:
                end = time + (end - time) % (time - kept_time)
                kept, keep = -2, -1
            if time == keep:
                kept, kept_size, kept_time = step, size, time
                keep = time + max(FIRST_LOOK, time // 4)
                for k in range(size):
                    kept_at[here[k]] = step
        if size > most or (time < end and taken > most_steps):
            counts[i] = -1
            continue
        count = 0
        for k in range(size):
            label = labels[here[k]]
            if label >= 0 and perceived_from[label] != i:
                perceived_from[label] = i
                count += 1
        counts[i] = count
    return counts


def compile_lists() -> None:
    """Leaves out the time as plain Python."""
    compile_now(_count_forward)
