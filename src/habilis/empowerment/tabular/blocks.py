"""Work on many states, shared out among threads."""

from collections.abc import Callable
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from typing import TypeVar

from habilis.empowerment.limits import Progress, unwatched

T = TypeVar("T")

_WORTHWHILE = 500_000  # elementary operations below which a thread costs more than it does
_GLANCE = 0.05  # seconds between looks at how far threads have come


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


def in_turn(
    work: Callable[[int, Progress], None], parts: int, threads: int, watch: Progress = unwatched
) -> None:
    """Runs the parts of a computation one after another, in several threads; an error ends all.

    Args:
        work: does a part, and calls its second argument with the share of the part that is done;
            must release the interpreter's lock for threads to be of use.
        parts: how many there are.
        threads: how many work side by side.
        watch: is called, in this thread, with the share of the whole that is done.
    """
    shares = [0.0] * parts
    if threads == 1 or parts < 2:
        for part in range(parts):
            work(part, lambda share, part=part: watch((part + share) / parts))
            watch((part + 1) / parts)
        return
    stopped = False

    def do(part: int) -> None:
        def report(share: float) -> None:
            if stopped:
                raise InterruptedError
            shares[part] = share

        report(0.0)
        work(part, report)
        shares[part] = 1.0

    with ThreadPoolExecutor(min(threads, parts)) as pool:
        waiting = {pool.submit(do, part) for part in range(parts)}
        try:
            while waiting:
                done, waiting = wait(waiting, timeout=_GLANCE, return_when=FIRST_EXCEPTION)
                for one in done:
                    one.result()
                watch(sum(shares) / parts)
        finally:
            stopped = True
            pool.shutdown(wait=False, cancel_futures=True)
