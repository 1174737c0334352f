"""Columns of bits, worked through in blocks; see `spreading`."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int32, Int64

WORDS = 8
"""Words of 64 columns in a block: a cache line."""

_COLUMNS = 64 * WORDS


@dataclass(frozen=True)
class Columns:
    """Which columns of bits there are, and which way they go.

    Attributes:
        nodes: int32[k], the states that have a column at first.
        columns: int32[k], ascending: which column each of them has.
        count: how many columns there are.
        forward: whether columns are states asked about, carried to all states that these reach;
            otherwise they are labels, carried back to all states that reach one that shows them.
    """

    nodes: Int32[np.ndarray, "k"]
    columns: Int32[np.ndarray, "k"]
    count: int
    forward: bool

    @classmethod
    def of(
        cls,
        labels: Int32[np.ndarray, "S"],
        label_count: int,
        starts: Int64[np.ndarray, "n"] | None,
    ) -> "Columns":
        """The fewer: labels, or states asked about."""
        if starts is not None and len(starts) < label_count:
            columns = np.arange(len(starts), dtype=np.int32)
            return cls(starts.astype(np.int32), columns, len(starts), True)
        nodes = np.argsort(labels, kind="stable").astype(np.int32)
        nodes = nodes[np.searchsorted(labels[nodes], 0) :]
        return cls(nodes, labels[nodes], label_count, False)

    def parts(self, threads: int) -> list[tuple[int, int]]:
        """The columns of each block: so many that a thread has one at least, if they suffice."""
        width = max(64, min(_COLUMNS, -(-self.count // threads)))
        return [(a, min(a + width, self.count)) for a in range(0, self.count, width)]

    def begun(self, part: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
        """The nodes that have a column of a block at first, and which of its columns."""
        here = slice(*np.searchsorted(self.columns, part))
        return self.nodes[here], self.columns[here] - np.int32(part[0])


def memory(states: int, actions: int, columns: Columns, label_count: int, threads: int) -> int:
    """Bytes that counting takes."""
    at_once = min(threads, max(1, len(columns.parts(threads))))
    each = block_bytes(states) + (8 * WORDS * label_count if columns.forward else 8 * states)
    return 8 * states * actions + 24 * states + at_once * each


def block_bytes(nodes: int) -> int:
    """Bytes that a block takes."""
    return nodes * (3 * 8 * WORDS + 5 * 4)
