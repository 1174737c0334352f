"""Whose line of code a warning is about."""

import sys


def caller_outside() -> int:
    """The `stacklevel` by which a warning points to the line that called into Habilis."""
    frame, level = sys._getframe(1), 1
    while frame.f_back is not None and _is_ours(frame.f_globals.get("__name__", "")):
        frame, level = frame.f_back, level + 1
    return level


def _is_ours(module: str) -> bool:
    return module == "habilis" or module.startswith("habilis.")
