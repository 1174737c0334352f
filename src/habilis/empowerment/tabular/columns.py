"""Counting with rows of bits, a block of columns at a time; see `spreading`."""

import threading
from dataclasses import dataclass
from queue import SimpleQueue

import numpy as np
from jaxtyping import Int32, Int64

from habilis.compiled import compiled
from habilis.empowerment.limits import Progress, unwatched
from habilis.empowerment.tabular.blocks import in_turn
from habilis.empowerment.tabular.recurring import repeated
from habilis.empowerment.tabular.spreading import (
    WORDS,
    Block,
    Graph,
    advance,
    begin,
    current,
    sizes_of,
)

_COLUMNS = 64 * WORDS
_UNIONS = 20_000_000  # between looks at the clock: some hundredths of a second


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
    each = Block.memory(states) + (8 * WORDS * label_count if columns.forward else 8 * states)
    return 8 * states * actions + 24 * states + at_once * each


def count_columns(
    graph: Graph,
    labels: Int32[np.ndarray, "S"],
    label_count: int,
    horizon: int,
    columns: Columns,
    threads: int = 1,
    watch: Progress = unwatched,
) -> Int64[np.ndarray, "n"]:
    """|O_h(s)| of the states asked about, or of all if the columns are labels."""
    counts = np.zeros(columns.count if columns.forward else graph.nodes, np.int64)
    lock = threading.Lock()

    def count(block: Block, part: tuple[int, int], report: Progress) -> None:
        begin(block, *columns.begun(part), horizon)
        while not advance(way, block, _UNIONS):
            report(block.time / max(block.end, 1))
        if columns.forward:
            counts[slice(*part)] = seen_by(block, labels, label_count, part[1] - part[0])
        else:
            own = sizes_of(block)
            with lock:
                np.add(counts, own, out=counts)

    way = graph.turned if columns.forward else graph
    _for_blocks(count, graph.nodes, columns, threads, watch)
    return counts


def count_every_horizon(
    graph: Graph,
    labels: Int32[np.ndarray, "S"],
    label_count: int,
    horizon: int,
    starts: Int64[np.ndarray, "n"],
    threads: int = 1,
    watch: Progress = unwatched,
) -> Int64[np.ndarray, "{horizon}+1 n"]:
    """|O_0(s)|, |O_1(s)|, ... |O_h(s)| of some states, by a column for each label."""
    counts = np.zeros((horizon + 1, len(starts)), np.int64)
    lock = threading.Lock()

    def count(block: Block, part: tuple[int, int], report: Progress) -> None:
        begin(block, *columns.begun(part), horizon)
        rows = [sizes_of(block)[starts]]
        while not block.period and block.time < horizon:
            advance(graph, block, 1)
            rows.append(sizes_of(block)[starts])
            report(block.time / horizon)
        place = repeated(horizon, len(rows) - 1, block.period or 1)
        with lock:
            np.add(counts, np.stack(rows)[place], out=counts)

    columns = Columns.of(labels, label_count, None)
    _for_blocks(count, graph.nodes, columns, threads, watch)
    return counts


def _for_blocks(count, nodes: int, columns: Columns, threads: int, watch: Progress) -> None:
    """Calls `count` for every block of columns, in memory used again and again."""
    parts = columns.parts(threads)
    free: SimpleQueue[Block] = SimpleQueue()
    for _ in range(min(threads, len(parts))):
        free.put(Block.empty(nodes))

    def work(part: int, report: Progress) -> None:
        block = free.get()
        try:
            count(block, parts[part], report)
        finally:
            free.put(block)

    in_turn(work, len(parts), threads, watch)


def seen_by(
    block: Block, labels: Int32[np.ndarray, "S"], label_count: int, columns: int
) -> Int64[np.ndarray, "columns"]:
    """How many labels the states have together that each column has come to."""
    return _seen_by(current(block), block.touched, labels, label_count)[:columns]


@compiled
def _seen_by(sets, touched, labels, label_count):
    seen = np.zeros((label_count, WORDS), np.uint64)
    for k in range(len(touched)):
        label = labels[touched[k]]
        if label >= 0:
            for w in range(WORDS):
                seen[label, w] |= sets[touched[k], w]
    counts = np.zeros(64 * WORDS, np.int64)
    for label in range(label_count):
        for w in range(WORDS):
            word = seen[label, w]
            bit = 64 * w
            while word != 0:
                if word & np.uint64(0xFF) == 0:
                    word >>= np.uint64(8)
                    bit += 8
                    continue
                counts[bit] += np.int64(word & np.uint64(1))
                word >>= np.uint64(1)
                bit += 1
    return counts
