"""A bar that shows how far a long computation has come."""

import threading
import time
from bisect import bisect_right
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from datetime import timedelta
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.progress import Progress, ProgressColumn, Task, TaskID

PATIENCE = 2.0
"""Seconds that pass before a bar appears."""

_shown: "ContextVar[Progress | None]" = ContextVar("shown", default=None)


@contextmanager
def progress_bar(
    what: str, show: bool, time_left: bool = False
) -> Iterator[Callable[[int, int], None]]:
    """A function called with the numbers of steps done and known so far.

    The bar appears once `PATIENCE` seconds have passed, with the time that has passed even if
    nothing is known, and vanishes in the end. Within another bar it is a line below that.

    Args:
        what: is counted.
        show: whether to draw anything, on standard error.
        time_left: whether to estimate how long the rest takes: for steps of about one length.
    """
    if not show:
        yield lambda done, known: None
        return
    pace = Pace() if time_left else None
    bar = _shown.get()
    if bar is not None:
        task = bar.add_task(what, total=None, pace=pace)
        try:
            yield _report(bar, task, pace)
        finally:
            bar.remove_task(task)
        return
    from rich.console import Console
    from rich.progress import Progress

    bar = Progress(*_columns(), console=Console(stderr=True), transient=True)
    task = bar.add_task(what, total=None, pace=pace)
    late = threading.Timer(PATIENCE, bar.start)
    late.daemon = True
    outer = _shown.set(bar)
    late.start()
    try:
        yield _report(bar, task, pace)
    finally:
        _shown.reset(outer)
        late.cancel()
        late.join()  # it may just be starting the bar
        bar.stop()


class Pace:
    """The pace at which steps are done, and so the time that the rest takes.

    It is that of about the second half of the time so far: what was found finished at the beginning
    does not count for long, and a change of pace shows.

    Example:
        >>> pace = Pace()
        >>> for seconds, done in ((0, 0), (0.1, 6), (10, 7), (20, 8)):
        ...     pace.report(seconds, done, 10)
        >>> round(pace.seconds_left(20)), round(pace.seconds_left(25))
        (20, 15)
    """

    def __init__(self) -> None:
        self._reports: list[tuple[float, int]] = []
        self._end: float | None = None

    def report(self, now: float, done: int, known: int) -> None:
        """Takes notice of how many steps are done.

        Args:
            now: seconds since any moment.
            done: steps done.
            known: steps that there are.
        """
        reports = self._reports
        reports.append((now, done))
        half = (reports[0][0] + now) / 2
        before = bisect_right(reports, half, key=lambda report: report[0]) - 1
        at, then = reports[max(before, 0)]
        if done > then:
            self._end = now + (known - done) * (now - at) / (done - then)

    def seconds_left(self, now: float) -> float | None:
        """Seconds until all steps are done; `None` as long as none was."""
        return None if self._end is None else max(self._end - now, 0.0)


def _report(bar: "Progress", task: "TaskID", pace: Pace | None) -> Callable[[int, int], None]:
    def report(done: int, known: int) -> None:
        if pace is not None:
            pace.report(time.monotonic(), done, known)
        bar.update(task, completed=done, total=known)

    return report


def _columns() -> "tuple[ProgressColumn, ...]":
    """Description, bar, numbers, time so far and, where it is estimated, the time left."""
    from rich.progress import MofNCompleteColumn, Progress, ProgressColumn, TimeElapsedColumn
    from rich.text import Text

    class TimeLeft(ProgressColumn):
        def render(self, task: "Task") -> Text:
            pace: Pace | None = task.fields["pace"]
            left = None if pace is None else pace.seconds_left(time.monotonic())
            return Text("" if left is None else f"{timedelta(seconds=round(left))} left")

    numbers = MofNCompleteColumn(), TimeElapsedColumn(), TimeLeft()
    return *Progress.get_default_columns()[:2], *numbers  # pyright: ignore[reportReturnType]


def in_percent(report: Callable[[int, int], None]) -> Callable[[float], None]:
    """A bar as a function of the share that is done, from 0 to 1."""
    return lambda share: report(int(100 * share), 100)
