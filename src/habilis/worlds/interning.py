"""Numbers for keys in the order in which they are first met."""

import numpy as np
from jaxtyping import Int32, Int64

from habilis.compiled import compiled

_SCATTER = np.uint64(0x9E3779B97F4A7C15)  # 2**64 over the golden ratio: spreads keys that are near
_FIRST_BITS = 12


class Interned:
    """Keys, each once, and where in their order each is: an open hash table."""

    def __init__(self) -> None:
        self._bits = _FIRST_BITS
        self._keys = np.empty(1 << (_FIRST_BITS - 1), np.int64)
        self._slots = np.full(1 << _FIRST_BITS, -1, np.int32)
        self._count = 0

    def __len__(self) -> int:
        return self._count

    @property
    def keys(self) -> Int64[np.ndarray, "known"]:
        """All that are known, in the order in which they came."""
        return self._keys[: self._count]

    def add(self, keys: Int64[np.ndarray, "n"]) -> Int32[np.ndarray, "n"]:
        """The numbers of some keys, new ones for those that are not known yet."""
        while self._count + len(keys) > len(self._keys):
            self._grow()
        numbers = np.empty(len(keys), np.int32)
        self._count = _add(self._slots, self._keys, self._count, self._bits, keys, numbers)
        return numbers

    def _grow(self) -> None:
        self._bits += 1
        self._keys = np.concatenate([self._keys, np.empty_like(self._keys)])
        self._slots = np.full(1 << self._bits, -1, np.int32)
        _fill(self._slots, self._keys, self._count, self._bits)


@compiled
def _add(slots, known, count, bits, keys, numbers):
    for place in range(len(keys)):
        slot = _slot(slots, known, bits, keys[place])
        if slots[slot] < 0:
            known[count] = keys[place]
            slots[slot] = count
            count += 1
        numbers[place] = slots[slot]
    return count


@compiled
def _fill(slots, known, count, bits):
    for number in range(count):
        slots[_slot(slots, known, bits, known[number])] = number


@compiled
def _slot(slots, known, bits, key):
    """Where a key is, or the free slot where it would be."""
    slot = np.int64((np.uint64(key) * _SCATTER) >> np.uint64(64 - bits))
    while slots[slot] >= 0 and known[slots[slot]] != key:
        slot = (slot + 1) & (len(slots) - 1)
    return slot
