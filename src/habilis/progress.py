"""A bar that shows how far a long computation has come."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.progress import Progress

PATIENCE = 2.0
"""Seconds that pass before a bar appears."""

_shown: "ContextVar[Progress | None]" = ContextVar("shown", default=None)


@contextmanager
def progress_bar(what: str, show: bool) -> Iterator[Callable[[int, int], None]]:
    """A function called with the numbers of steps done and known so far.

    The bar appears once `PATIENCE` seconds have passed, with the time that has passed even if
    nothing is known, and vanishes in the end. Within another bar it is a line below that.

    Args:
        what: is counted.
        show: whether to draw anything, on standard error.
    """
    if not show:
        yield lambda done, known: None
        return
    bar = _shown.get()
    if bar is not None:
        task = bar.add_task(what, total=None)
        try:
            yield lambda done, known: bar.update(task, completed=done, total=known)
        finally:
            bar.remove_task(task)
        return
    from rich.console import Console
    from rich.progress import MofNCompleteColumn, Progress, TimeElapsedColumn

    columns = (*Progress.get_default_columns()[:2], MofNCompleteColumn(), TimeElapsedColumn())
    bar = Progress(*columns, console=Console(stderr=True), transient=True)
    task = bar.add_task(what, total=None)
    late = threading.Timer(PATIENCE, bar.start)
    late.daemon = True
    outer = _shown.set(bar)
    late.start()
    try:
        yield lambda done, known: bar.update(task, completed=done, total=known)
    finally:
        _shown.reset(outer)
        late.cancel()
        late.join()  # it may just be starting the bar
        bar.stop()


def in_percent(report: Callable[[int, int], None]) -> Callable[[float], None]:
    """A bar as a function of the share that is done, from 0 to 1."""
    return lambda share: report(int(100 * share), 100)
