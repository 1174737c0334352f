"""Counting with rows of bits, a block of columns at a time; see `spreading`."""

import threading
from queue import SimpleQueue

import numpy as np
from jaxtyping import Int32, Int64

from habilis.compiled import compiled
from habilis.empowerment.limits import Progress, unwatched
from habilis.empowerment.tabular.blocks import in_turn
from habilis.empowerment.tabular.columns import WORDS, Columns
from habilis.empowerment.tabular.recurring import repeated
from habilis.empowerment.tabular.spreading import (
    Block,
    Graph,
    advance,
    begin,
    current,
    sizes_of,
)

_UNIONS = 20_000_000  # between looks at the clock: some hundredths of a second


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


@compiled()
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
