"""Counting as packed bits, one for each cell near a thing instead of one for each of the map.

Within h actions a thing gets only so far. Where its cells are numbered relative to where it is, a
state's set needs as many bits as the window of all such displacements has cells, however large
the map; going one step back, a successor's set is shifted by what the thing moved.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int16, Int32, Int64, UInt64

from habilis.compiled import compiled
from habilis.empowerment.limits import Progress, unwatched
from habilis.empowerment.tabular.blocks import in_blocks
from habilis.empowerment.tabular.recurring import last_of, recurring

_WORD = 64
_WORTHWHILE = 16  # words of the whole map up to which it is as fast without a window
_LARGEST = 30_000  # rows or columns that fit the extents' 16 bits
_NOWHERE = 1, -1, 1, -1  # extents of a thing that is not seen: the least exceed the largest


@dataclass(frozen=True)
class Window:
    """The displacements, in rows and columns, that a thing can have after at most h actions."""

    top: int
    left: int
    rows: int
    columns: int

    @property
    def words(self) -> int:
        return -(-self.rows * self.columns // _WORD)


def window_of(
    next_state: Int32[np.ndarray, "S A"],
    row: Int16[np.ndarray, "S"],
    column: Int16[np.ndarray, "S"],
    horizon: int,
    most_words: int,
    threads: int,
    *,
    shown: Bool[np.ndarray, "S"] | None = None,
    watch: Progress = unwatched,
) -> Window | None:
    """The least window for all states; `None` if it has `most_words` or more words.

    Args:
        next_state: the table.
        row, column: where the thing is in each state.
        horizon: h, in actions.
        most_words: how many words a set takes without a window.
        threads: how many work side by side.
        shown: where the thing is seen; by default everywhere.
        watch: is called with the share that is done.
    """
    reach = np.zeros((len(row), 4), np.int16)  # up, down, left, right in exactly k actions
    if shown is not None:
        reach[~shown] = _NOWHERE
    widest = np.zeros(4, np.int64)

    def step(before: np.ndarray, after: np.ndarray) -> bool:
        moved = in_blocks(
            lambda a, b: _extend(next_state, row, column, before, after, a, b),
            len(row),
            4 * next_state.shape[1],
            threads,
        )
        for extents in moved:
            widest[::2] = np.minimum(widest[::2], extents[:4:2])
            widest[1::2] = np.maximum(widest[1::2], extents[1:4:2])
        return any(m[4] for m in moved)

    for _, left in recurring(step, reach, horizon):
        if _window(widest).words >= most_words:
            return None
        watch(1 - left / max(horizon, 1))
    window = _window(widest)
    return window if window.words < most_words else None


def _window(widest: Int64[np.ndarray, "4"]) -> Window:
    up, down, left, right = widest.tolist()
    return Window(up, left, down - up + 1, right - left + 1)


def worth_a_window(shape: tuple[int, int]) -> bool:
    """Whether a map is so large that a window may save words, and small enough for its numbers."""
    return shape[0] * shape[1] > _WORTHWHILE * _WORD and max(shape) < _LARGEST


def count_in_window(
    next_state: Int32[np.ndarray, "S A"],
    row: Int16[np.ndarray, "S"],
    column: Int16[np.ndarray, "S"],
    horizon: int,
    window: Window,
    threads: int,
    *,
    shown: Bool[np.ndarray, "S"] | None = None,
    watch: Progress = unwatched,
) -> Int64[np.ndarray, "S"]:
    """To how many cells h actions can bring the thing, for every state.

    Memory: three sets of `window.words` words of 8 bytes a state.
    """
    place = row.astype(np.int32) * window.columns + column
    here = -window.top * window.columns - window.left
    sets = np.zeros((len(row), window.words), np.uint64)
    sets[:, here // _WORD] = np.uint64(1) << np.uint64(here % _WORD)
    if shown is not None:
        sets[~shown] = 0
    operations = window.words * next_state.shape[1]

    def step(before: np.ndarray, after: np.ndarray) -> bool:
        changed = in_blocks(
            lambda a, b: _unite_shifted(next_state, place, before, after, a, b),
            len(row),
            operations,
            threads,
        )
        return any(changed)

    last = last_of(recurring(step, sets, horizon), horizon, watch)
    counted = in_blocks(
        lambda a, b: np.bitwise_count(last[a:b]).sum(axis=1, dtype=np.int64),
        len(row),
        window.words,
        threads,
    )
    return np.concatenate(counted)


@compiled()
def _extend(next_state, row, column, reach, out, begin, end):
    """One step back: how far up, down, left and right, and the extremes of this block."""
    top = bottom = left = right = 0
    changed = False
    for s in range(begin, end):
        up, down, west, east = 1, -1, 1, -1  # nowhere yet
        for a in range(next_state.shape[1]):
            t = next_state[s, a]
            if reach[t, 0] > reach[t, 1]:
                continue
            dr = np.int64(row[t]) - np.int64(row[s])
            dc = np.int64(column[t]) - np.int64(column[s])
            if up > down:
                up, down = dr + reach[t, 0], dr + reach[t, 1]
                west, east = dc + reach[t, 2], dc + reach[t, 3]
            else:
                up, down = min(up, dr + reach[t, 0]), max(down, dr + reach[t, 1])
                west, east = min(west, dc + reach[t, 2]), max(east, dc + reach[t, 3])
        changed |= up != reach[s, 0] or down != reach[s, 1]
        changed |= west != reach[s, 2] or east != reach[s, 3]
        out[s, 0], out[s, 1], out[s, 2], out[s, 3] = up, down, west, east
        if up > down:
            continue
        top, bottom = min(top, up), max(bottom, down)
        left, right = min(left, west), max(right, east)
    return top, bottom, left, right, changed


@compiled()
def _unite_shifted(
    next_state: Int32[np.ndarray, "S A"],
    place: Int32[np.ndarray, "S"],
    sets: UInt64[np.ndarray, "S W"],
    out: UInt64[np.ndarray, "S W"],
    begin: int,
    end: int,
) -> bool:
    """One step back: out[s] = union over a of the set of next(s, a), seen from s."""
    words = sets.shape[1]
    changed = False
    union = np.empty(words, np.uint64)
    for s in range(begin, end):
        union[:] = np.uint64(0)
        for a in range(next_state.shape[1]):
            t = next_state[s, a]
            shift = place[t] - place[s]
            if shift == 0:
                for w in range(words):
                    union[w] |= sets[t, w]
                continue
            jump = shift >> 6
            bits = np.uint64(shift & 63)
            rest = np.uint64(64) - bits
            for w in range(words):
                source = w - jump
                if 0 <= source < words:
                    union[w] |= sets[t, source] << bits
                if bits != 0 and 0 <= source - 1 < words:
                    union[w] |= sets[t, source - 1] >> rest
        for w in range(words):
            changed |= union[w] != sets[s, w]
            out[s, w] = union[w]
    return changed
