"""Functions that Numba compiles, and keeps on disk where there is a place for that.

Compiling takes a second for each of them, and reading what was compiled half as long in all. So a
function that says how much work a call is runs as plain Python, or in NumPy, until its calls have
taken some time together: a small model needs no compiler. The results are the same, to the bit.
"""

import inspect
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache, update_wrapper
from typing import Any, TypeVar, cast

import numpy as np

INTERPRETED = 300_000
"""Elementary operations as plain Python up to which a function is not compiled."""

_SECONDS = 0.15  # that so many take

Function = TypeVar("Function", bound=Callable[..., Any])

Operations = Callable[..., float]
"""Roughly how many elementary operations a call takes, from its arguments."""


class Compiled:
    """A function that is compiled once it has much to do.

    Attributes:
        plain: the function itself.
        operations: of a call; `None` compiles it at the first.
        instead: runs in place of plain Python, if given.
        body: returns what is compiled in place of the function, if given.
        is_part: whether only other such functions call it.
    """

    def __init__(
        self,
        function: Callable[..., Any],
        operations: Operations | None = None,
        instead: Callable[..., Any] | None = None,
        is_part: bool = False,
        body: Callable[[], Callable[..., Any]] | None = None,
    ):
        self.plain: Callable[..., Any] = inspect.unwrap(function)  # tests check arguments
        update_wrapper(self, self.plain)
        self.operations, self.instead, self.is_part = operations, instead, is_part
        self.body = body
        self._left = _SECONDS
        self._dispatcher: Any = None

    def __call__(self, *args: Any) -> Any:
        if self.is_part:  # of what runs as plain Python
            return self.plain(*args)
        if self._dispatcher is not None or not self._small(*args):
            return self.machine(*args)
        began = time.thread_time()
        try:
            return self.uncompiled(*args)
        finally:
            self._left -= time.thread_time() - began

    def uncompiled(self, *args: Any) -> Any:
        """A call without the compiler."""
        if self.instead is not None:
            return self.instead(*args)
        with np.errstate(over="ignore"):  # hashes wrap around
            return self.plain(*args)

    @property
    def machine(self) -> Any:
        """The function as Numba compiles it: of all further calls, too, once it is asked for."""
        if self._dispatcher is None:
            with _making:
                if self._dispatcher is None:
                    function = self.plain if self.body is None else inspect.unwrap(self.body())
                    self._dispatcher = _dispatcher(function, self.is_part)
        return self._dispatcher

    @property
    def _numba_type_(self) -> Any:
        """How Numba sees it in other compiled functions."""
        return self.machine._numba_type_

    def _small(self, *args: Any) -> bool:
        if self.operations is None:
            return False
        return bool(self.operations(*args) * _SECONDS <= self._left * INTERPRETED)


def compiled(
    operations: Operations | None = None,
    instead: Callable[..., Any] | None = None,
    body: Callable[[], Callable[..., Any]] | None = None,
) -> Callable[[Function], Function]:
    """Makes a function that is compiled once its calls have been much work together.

    The next process reads it from the disk. In an installation that is read-only, without a home
    that can be written, or on a full disk it is recompiled in every process.

    Args:
        operations: takes the arguments of a call, and returns roughly how many elementary
            operations it is, at most; `None` compiles the function at its first call.
        instead: the same in NumPy, which runs in place of plain Python.
        body: returns the same written for Numba alone, which is compiled in place of the function;
            so a module that needs Numba is not imported before.
    """
    return lambda function: cast(Function, Compiled(function, operations, instead, body=body))


def part(function: Function) -> Function:
    """Makes a function that compiled functions call: it runs as they do."""
    return cast(Function, Compiled(function, is_part=True))


def paths(branching: float, length: int) -> float:
    """At most how many steps all paths of a length take, each beginning once: b + b**2 + ...

    Example:
        >>> paths(2, 3)
        14.0
    """
    total = 0.0
    for _ in range(min(length, 64)):
        total = branching * (1 + total)
    return total if length <= 64 else float("inf")


def compile_now(*functions: Callable[..., Any]) -> None:
    """Leaves out the time as plain Python: what follows is timed."""
    for function in functions:
        assert isinstance(function, Compiled)
        _ = function.machine


@contextmanager
def compiling_announced(announce: Callable[[], object]) -> Iterator[None]:
    """Within it, `announce` is called whenever the compiler starts, from any thread."""
    _announcers.append(announce)
    try:
        yield
    finally:
        _announcers.remove(announce)


_making = threading.RLock()
_announcers: list[Callable[[], object]] = []


def _dispatcher(function: Callable[..., Any], is_part: bool) -> Any:
    from numba import njit

    _listen()
    # Without what callers in C or, of a part, in Python need: half of a small one's time.
    options: dict[str, Any] = {"no_cfunc_wrapper": True, "no_cpython_wrapper": is_part}
    options["error_model"] = "numpy"  # a check of every divisor keeps loops from wide words
    made: Any
    try:
        made = njit(cache=True, nogil=True, **options)(function)
    except RuntimeError:  # Numba has no place for its files
        return njit(nogil=True, **options)(function)
    if (kept := getattr(made, "_cache", None)) is not None:  # none under NUMBA_DISABLE_JIT
        kept.save_overload = _if_there_is_room(kept.save_overload)
    return made


def _if_there_is_room(save: Callable[[Any, Any], None]) -> Callable[[Any, Any], None]:
    def save_if_possible(signature: Any, data: Any) -> None:
        with suppress(OSError):
            save(signature, data)

    return save_if_possible


@cache
def _listen() -> None:
    """Has Numba say when it compiles; what it reads from the disk is no event."""
    from numba.core import event

    class Compiling(event.Listener):
        def on_start(self, event: Any) -> None:
            for announce in list(_announcers):
                announce()

        def on_end(self, event: Any) -> None:
            pass

    event.register("numba:compile", Compiling())
