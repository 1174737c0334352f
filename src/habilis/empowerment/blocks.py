"""Work on many states, shared out among threads."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

T = TypeVar("T")

_WORTHWHILE = 500_000  # elementary operations below which a thread costs more than it does


def in_blocks(work: Callable[[int, int], T], states: int, operations: int, threads: int) -> list[T]:
    """The results of `work(first, end)` on consecutive blocks of states, in order.

    Args:
        work: must release the interpreter's lock for threads to be of use.
        states: how many there are.
        operations: roughly how many each of them takes.
        threads: at most how many blocks there are.
    """
    blocks = max(1, min(threads, states, states * operations // _WORTHWHILE))
    edges = [states * block // blocks for block in range(blocks + 1)]
    if blocks == 1:
        return [work(0, states)]
    with ThreadPoolExecutor(blocks) as pool:
        return list(pool.map(work, edges[:-1], edges[1:]))
