"""Work that one process at a time does in a folder, and that signals stop."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

from habilis.files import remove_partial, writing

LOCK = "lock"
"""Name of the lock's file in a folder."""

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Interrupted(KeyboardInterrupt):
    """Work was stopped by a signal; the message says how to go on.

    Attributes:
        signal: its number.
    """

    def __init__(self, message: str, number: int):
        super().__init__(message)
        self.signal = number


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Holds the folder's lock, which the system releases when the process ends, however it does.

    Raises:
        ValueError: another process holds it, or the folder cannot be written to.
    """
    lock = FileLock(folder / LOCK)
    with writing(folder):
        try:
            lock.acquire(timeout=0)
        except Timeout:  # an OSError
            raise ValueError(
                f"{folder}: another process is using it; wait for it, or name another folder"
            ) from None
    try:
        remove_partial(folder)
        yield
    finally:
        lock.release()


@contextmanager
def stop_signals() -> Iterator[Callable[[], int]]:
    """Yields a function that returns the number of the Ctrl-C or SIGTERM received, 0 before any.

    A second signal ends the process as it always does.
    """
    received = 0
    if threading.current_thread() is not threading.main_thread():
        yield lambda: 0
        return
    before = {number: signal.getsignal(number) for number in _SIGNALS}

    def restore() -> None:
        for number, handler in before.items():
            signal.signal(number, handler)

    def stop(number: int, frame: object) -> None:
        nonlocal received
        received = number
        restore()

    for number in _SIGNALS:
        signal.signal(number, stop)
    try:
        yield lambda: received
    finally:
        restore()
