"""Counting as packed bits, one for each cell near a thing instead of one for each of the map.

Within h actions a thing gets only so far. Where its cells are numbered relative to where it is, a
state's set needs as many bits as the window of all such displacements has cells, however large
the map; going one step back, a successor's set is shifted by what the thing moved.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int16, Int32, Int64, UInt64

from habilis.compiled import compiled
from habilis.empowerment.blocks import in_blocks

_WORD = 64
_WORTHWHILE = 16  # words of the whole map up to which it is as fast without a window
_LARGEST = 30_000  # rows or columns that fit the extents' 16 bits


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
) -> Window | None:
    """The least window for all states; `None` if it has `most_words` or more words.

    Args:
        next_state: the table.
        row, column: where the thing is in each state.
        horizon: h, in actions.
        most_words: how many words a set takes without a window.
        threads: how many work side by side.
    """
    reach = np.zeros((len(row), 4), np.int16)  # up, down, left, right in exactly k actions
    spare = np.empty_like(reach)
    window = Window(0, 0, 1, 1)
    for _ in range(horizon):
        if window.words >= most_words:
            return None
        before, after = reach, spare
        moved = in_blocks(
            lambda a, b, before=before, after=after: _extend(
                next_state, row, column, before, after, a, b
            ),
            len(row),
            4 * next_state.shape[1],
            threads,
        )
        reach, spare = after, before
        top, bottom = min(m[0] for m in moved), max(m[1] for m in moved)
        left, right = min(m[2] for m in moved), max(m[3] for m in moved)
        top, left = min(top, window.top), min(left, window.left)
        bottom = max(bottom, window.top + window.rows - 1)
        right = max(right, window.left + window.columns - 1)
        window = Window(top, left, bottom - top + 1, right - left + 1)
        if not any(m[4] for m in moved):
            break
    return window if window.words < most_words else None


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
) -> Int64[np.ndarray, "S"]:
    """To how many cells h actions can bring the thing, for every state.

    Memory: two sets of `window.words` words of 8 bytes a state.
    """
    place = row.astype(np.int32) * window.columns + column
    here = -window.top * window.columns - window.left
    sets = np.zeros((len(row), window.words), np.uint64)
    sets[:, here // _WORD] = np.uint64(1) << np.uint64(here % _WORD)
    spare = np.empty_like(sets)
    operations = window.words * next_state.shape[1]
    for _ in range(horizon):
        before, after = sets, spare
        changed = in_blocks(
            lambda a, b, before=before, after=after: _unite_shifted(
                next_state, place, before, after, a, b
            ),
            len(row),
            operations,
            threads,
        )
        if not any(changed):
            break
        sets, spare = after, before
    counted = in_blocks(
        lambda a, b: np.bitwise_count(sets[a:b]).sum(axis=1, dtype=np.int64),
        len(row),
        window.words,
        threads,
    )
    return np.concatenate(counted)


@compiled
def _extend(next_state, row, column, reach, out, begin, end):
    """One step back: how far up, down, left and right, and the extremes of this block."""
    top = bottom = left = right = 0
    changed = False
    for s in range(begin, end):
        up = down = west = east = 0
        for a in range(next_state.shape[1]):
            t = next_state[s, a]
            dr = np.int64(row[t]) - np.int64(row[s])
            dc = np.int64(column[t]) - np.int64(column[s])
            if a == 0:
                up, down = dr + reach[t, 0], dr + reach[t, 1]
                west, east = dc + reach[t, 2], dc + reach[t, 3]
            else:
                up, down = min(up, dr + reach[t, 0]), max(down, dr + reach[t, 1])
                west, east = min(west, dc + reach[t, 2]), max(east, dc + reach[t, 3])
        changed |= up != reach[s, 0] or down != reach[s, 1]
        changed |= west != reach[s, 2] or east != reach[s, 3]
        out[s, 0], out[s, 1], out[s, 2], out[s, 3] = up, down, west, east
        top, bottom = min(top, up), max(bottom, down)
        left, right = min(left, west), max(right, east)
    return top, bottom, left, right, changed


@compiled
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
