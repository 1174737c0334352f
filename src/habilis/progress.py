"""A bar that shows how far a long enumeration has come."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def progress_bar(what: str, show: bool) -> Iterator[Callable[[int, int], None]]:
    """A function that is told how many are done and how many are known so far.

    Args:
        what: is counted.
        show: whether to draw anything, on standard error.
    """
    if not show:
        yield lambda done, known: None
        return
    from rich.console import Console
    from rich.progress import MofNCompleteColumn, Progress, TimeElapsedColumn

    columns = (*Progress.get_default_columns()[:2], MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what)
        yield lambda done, known: bar.update(task, completed=done, total=known)
