"""Work in a folder that one process at a time does, and that can be stopped from outside."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Interrupted(KeyboardInterrupt):
    """Work was stopped from outside; the message says how to go on."""


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
        yield
    finally:
        lock.release()


@contextmanager
def stop_signals() -> Iterator[Callable[[], bool]]:
    """Whether Ctrl-C or SIGTERM has come. A second one ends the process as it always does."""
    asked = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield asked.is_set
        return
    before = {number: signal.getsignal(number) for number in _SIGNALS}

    def restore() -> None:
        for number, handler in before.items():
            signal.signal(number, handler)

    def stop(number: int, frame: object) -> None:
        asked.set()
        restore()

    for number in _SIGNALS:
        signal.signal(number, stop)
    try:
        yield asked.is_set
    finally:
        restore()
