"""Numbers for states in the order in which they are first met."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int, Int32, Int64

from habilis.compiled import compiled, part

_SCATTER = np.uint64(0x9E3779B97F4A7C15)  # 2**64 over the golden ratio: spreads keys that are near
_FIRST_BITS = 12
_LEAST = -(2**63)
_WORD = 63  # bits of a word that hold values; the sign is left alone


@dataclass(frozen=True)
class Packing:
    """A row of k integers as a few words, in the order of the rows.

    Attributes:
        least: int64[k], the smallest value of each column.
        bits: int64[k], how many bits each column has, less `least`.
        word, shift: int64[k], in which word, and from which bit on.
        words: how many there are.
    """

    least: Int64[np.ndarray, "k"]
    bits: Int64[np.ndarray, "k"]
    word: Int64[np.ndarray, "k"]
    shift: Int64[np.ndarray, "k"]
    words: int

    @classmethod
    def of(
        cls,
        least: Int64[np.ndarray, "k"],
        most: Int64[np.ndarray, "k"],
        falling: Bool[np.ndarray, "k"] | None = None,
    ) -> "Packing":
        """The packing of columns of integers from `least` to `most`.

        Args:
            least, most: of each column.
            falling: where the values that its bits can have besides are to be below `least`.

        Raises:
            ValueError: a column's values differ by 2**63 or more.
        """
        ranges = [int(high) - int(low) for low, high in zip(least, most, strict=True)]
        if max(ranges, default=0) >= 1 << _WORD:
            raise ValueError("the numbers of a state differ by 2**63 or more; use smaller ones")
        bits = [max(1, size.bit_length()) for size in ranges]
        word, shift, group, used = [], [], 0, 0
        for width in reversed(bits):
            if used + width > _WORD:
                group, used = group + 1, 0
            word.append(group)
            shift.append(used)
            used += width
        places = group - np.array(word[::-1], np.int64), np.array(shift[::-1], np.int64)
        if falling is not None:
            lowest = [
                max(high - (1 << b) + 1, _LEAST)
                for high, b in zip(most.tolist(), bits, strict=True)
            ]
            least = np.where(falling, np.array(lowest, np.int64), least)
        return cls(least, np.array(bits, np.int64), *places, words=group + 1)

    @property
    def most(self) -> Int64[np.ndarray, "k"]:
        """The largest value that each column can have."""
        with np.errstate(over="ignore"):
            top = self.least + ((np.int64(1) << (self.bits - 1)) - 1) * 2 + 1
        return np.where(top < self.least, np.iinfo(np.int64).max, top)

    def packed(self, rows: Int64[np.ndarray, "n k"]) -> Int64[np.ndarray, "n words"]:
        keys = np.zeros((len(rows), self.words), np.int64)
        for column in range(len(self.least)):
            field = (rows[:, column] - self.least[column]) << self.shift[column]
            keys[:, self.word[column]] |= field
        return keys

    def unpacked(self, keys: Int64[np.ndarray, "n words"]) -> Int64[np.ndarray, "n k"]:
        rows = np.empty((len(keys), len(self.least)), np.int64)
        half = np.int64(1) << (self.bits - 1)
        for column, mask in enumerate(half - 1 + half):
            field = (keys[:, self.word[column]] >> self.shift[column]) & mask
            rows[:, column] = field + self.least[column]
        return rows


class InternedRows:
    """Rows of integers, each once, and the place of each in their order: an open hash table.

    Rows are packed into as few bits as the values so far need, and repacked when one of them
    needs more.
    """

    def __init__(self, columns: int) -> None:
        none = np.zeros(columns, np.int64)
        self._ranges = none, none
        self._packing = Packing.of(none, none)
        self._bits = _FIRST_BITS
        self._keys = np.empty((1 << (_FIRST_BITS - 1), self._packing.words), np.int64)
        self._slots = np.full(1 << _FIRST_BITS, -1, np.int32)
        self._count = 0

    def __len__(self) -> int:
        return self._count

    @property
    def columns(self) -> int:
        return len(self._packing.least)

    @property
    def bytes(self) -> int:
        """How much memory they take."""
        return self._keys.nbytes + self._slots.nbytes

    def rows(self, first: int = 0, last: int | None = None) -> Int64[np.ndarray, "n k"]:
        """Those from the place `first` on, in the order in which they came."""
        return self._packing.unpacked(self._keys[first : self._count if last is None else last])

    def take(self, places: Int[np.ndarray, "n"]) -> Int64[np.ndarray, "n k"]:
        """Those in some places."""
        return self._packing.unpacked(self._keys[places])

    def order(self) -> Int64[np.ndarray, "n"]:
        """The places of all rows, sorted by their first column, then the second, and so on."""
        words = self._keys[: self._count].T
        return np.argsort(words[0]) if len(words) == 1 else np.lexsort(words[::-1])

    def add(
        self, rows: Int64[np.ndarray, "n k"], there: Bool[np.ndarray, "n"] | None = None
    ) -> Int32[np.ndarray, "n"]:
        """The places of some rows, new ones for those that are not known yet.

        Args:
            rows: the rows.
            there: which of them are meant, all by default; the place of the others is -1.
        """
        if there is not None:
            places = np.full(len(rows), -1, np.int32)
            places[there] = self.add(rows[there])
            return places
        self._widen(rows)
        while self._count + len(rows) > len(self._keys):
            self._grow()
        numbers = np.empty(len(rows), np.int32)
        packing = self._packing
        self._count = _add(
            *(self._slots, self._keys, self._count, self._bits),
            *(rows, packing.least, packing.word, packing.shift, numbers),
        )
        return numbers

    def find(self, rows: Int64[np.ndarray, "n k"]) -> Int32[np.ndarray, "n"]:
        """The places of some rows, -1 for those that are not known."""
        packing = self._packing
        inside = ((rows >= packing.least) & (rows <= packing.most)).all(axis=1)
        numbers = np.full(len(rows), -1, np.int32)
        keys = packing.packed(rows[inside])
        numbers[inside] = _find(self._slots, self._keys, self._bits, keys)
        return numbers

    def _widen(self, rows: Int64[np.ndarray, "n k"]) -> None:
        """Repacks all rows where a value of some new ones does not fit."""
        if not len(rows):
            return
        old = self._packing
        least, most = rows.min(axis=0), rows.max(axis=0)
        if self._count == 0:
            self._ranges = least, most
            self._packing = Packing.of(least, most)
        elif (least < old.least).any() or (most > old.most).any():
            known = self._ranges
            self._ranges = np.minimum(least, known[0]), np.maximum(most, known[1])
            self._packing = Packing.of(*self._ranges, falling=least < old.least)
        else:
            self._ranges = np.minimum(least, self._ranges[0]), np.maximum(most, self._ranges[1])
            return
        keys = np.empty((len(self._keys), self._packing.words), np.int64)
        if self._count:
            keys[: self._count] = self._packing.packed(old.unpacked(self._keys[: self._count]))
        self._keys = keys
        self._fill()

    def _grow(self) -> None:
        self._bits += 1
        keys = np.empty((2 * len(self._keys), self._keys.shape[1]), np.int64)
        keys[: self._count] = self._keys[: self._count]
        self._keys = keys
        self._fill()

    def _fill(self) -> None:
        self._slots = np.full(1 << self._bits, -1, np.int32)
        _fill(self._slots, self._keys, self._count, self._bits)


@part
def _pack(row, least, word, shift, key):
    for place in range(len(key)):
        key[place] = 0
    for column in range(len(row)):
        key[word[column]] |= (row[column] - least[column]) << shift[column]


@compiled(lambda *args: 8 * args[4].size)
def _add(slots, known, count, bits, rows, least, word, shift, numbers):
    key = np.empty(known.shape[1], np.int64)
    for place in range(len(rows)):
        _pack(rows[place], least, word, shift, key)
        slot = _slot(slots, known, bits, key)
        if slots[slot] < 0:
            for column in range(len(key)):  # an assignment of arrays takes seconds to compile
                known[count, column] = key[column]
            slots[slot] = count
            count += 1
        numbers[place] = slots[slot]
    return count


@compiled(lambda slots, known, bits, keys: 8 * keys.size)
def _find(slots, known, bits, keys):
    numbers = np.empty(len(keys), np.int32)
    for place in range(len(keys)):
        numbers[place] = slots[_slot(slots, known, bits, keys[place])]
    return numbers


@compiled(lambda slots, known, count, bits: 8 * count * known.shape[1])
def _fill(slots, known, count, bits):
    for number in range(count):
        slots[_slot(slots, known, bits, known[number])] = number


@part
def _slot(slots, known, bits, key):
    """Where a key is, or the free slot where it would be."""
    mixed = np.uint64(key[0]) * _SCATTER
    for word in range(1, len(key)):
        mixed = (mixed ^ (mixed >> np.uint64(32)) ^ np.uint64(key[word])) * _SCATTER
    slot = np.int64(mixed >> np.uint64(64 - bits))
    while slots[slot] >= 0:
        same = True
        for word in range(len(key)):
            same &= known[slots[slot], word] == key[word]
        if same:
            break
        slot = (slot + 1) & (len(slots) - 1)
    return slot
