"""Functions that Numba compiles, and keeps on disk where there is a place for that."""

import inspect
from collections.abc import Callable
from contextlib import suppress
from typing import Any, TypeVar

from numba import njit

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """Compiles a function at its first call; the next process reads it from the disk.

    In an installation that is read-only, without a home that can be written, or on a full disk it
    is recompiled in every process.
    """
    made: Any
    function = inspect.unwrap(function)  # tests check arguments by a wrapper
    try:
        made = njit(cache=True, nogil=True)(function)
    except RuntimeError:  # Numba has no place for its files
        made = njit(nogil=True)(function)
        return made
    if (cache := getattr(made, "_cache", None)) is not None:  # none under NUMBA_DISABLE_JIT
        cache.save_overload = _if_there_is_room(cache.save_overload)
    return made


def _if_there_is_room(save: Callable[[Any, Any], None]) -> Callable[[Any, Any], None]:
    def save_if_possible(signature: Any, data: Any) -> None:
        with suppress(OSError):
            save(signature, data)

    return save_if_possible
