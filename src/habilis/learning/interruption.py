"""Work in a folder that one process at a time does, and that can be stopped from outside."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

from habilis.files import remove_partial

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
def alone(folder: Path) -> Iterator[None]:
    """Holds the folder's lock, which the system lets go when the process ends, however it does."""
    lock = FileLock(folder / "lock")
    try:
        lock.acquire(timeout=0)
    except Timeout:
        raise ValueError(
            f"{folder}: another process trains in it; wait for it, or name another folder"
        ) from None
    except OSError as error:
        raise ValueError(f"{folder}: cannot be written ({error.strerror or error})") from None
    try:
        remove_partial(folder)
        yield
    finally:
        lock.release()


@contextmanager
def stop_signals() -> Iterator[Callable[[], int]]:
    """Yields what tells which of Ctrl-C and SIGTERM has come, if one has, and 0 before.

    A second one ends the process as it always does.
    """
    came = 0
    if threading.current_thread() is not threading.main_thread():
        yield lambda: 0
        return
    before = {number: signal.getsignal(number) for number in _SIGNALS}

    def restore() -> None:
        for number, handler in before.items():
            signal.signal(number, handler)

    def stop(number: int, frame: object) -> None:
        nonlocal came
        came = number
        restore()

    for number in _SIGNALS:
        signal.signal(number, stop)
    try:
        yield lambda: came
    finally:
        restore()
