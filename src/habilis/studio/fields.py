"""Validation of the fields of a message."""

import math
from collections.abc import Collection, Sequence
from reprlib import Repr
from typing import Any

from habilis.worlds.world import Cell

_SHORT = Repr()
_SHORT.maxlevel, _SHORT.maxstring, _SHORT.maxother = 2, 60, 60


def checked(
    what: str, value: Any, required: Collection[str], optional: Collection[str] = ()
) -> dict[str, Any]:
    """An object with its required fields and no unknown ones.

    Raises:
        ValueError: the value is not such an object; the message names the field.
    """
    if not isinstance(value, dict):
        raise ValueError(f"{what} is {shown(value)}; give an object")
    missing = [name for name in required if name not in value]
    if missing:
        raise ValueError(f"{what} has no {missing[0]!r}; give it")
    unknown = [name for name in value if name not in required and name not in optional]
    if unknown:
        known = ", ".join([*required, *optional])
        raise ValueError(f"{what} has {shown(unknown[0])}, which is unknown; it may have {known}")
    return value


def text(name: str, value: Any) -> str:
    if not isinstance(value, str):
        raise ValueError(f"{name} is {shown(value)}; give text")
    return value


def one_of(name: str, value: Any, known: Sequence[str]) -> str:
    if not isinstance(value, str) or value not in known:
        raise ValueError(f"{name} {shown(value)} is unknown; use one of {', '.join(known)}")
    return value


def number(name: str, value: Any, least: float, most: float, whole: bool = False) -> Any:
    """A number from `least` to `most`, an integer if `whole`."""
    kind = "whole number" if whole else "number"
    numeric = isinstance(value, int) if whole else isinstance(value, int | float)
    if isinstance(value, bool) or not numeric or not least <= value <= most:
        raise ValueError(f"{name} is {shown(value)}; give a {kind} from {least:,} to {most:,}")
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError(f"{name} is {shown(value)}; give a finite number")
    return value


def cell(name: str, value: Any) -> Cell:
    """A cell (row, column), on any map."""
    whole = isinstance(value, list) and len(value) == 2
    if not whole or not all(type(part) is int and abs(part) < 2**31 for part in value):
        raise ValueError(f"{name} has {shown(value)}; give a cell as [row, column]")
    return value[0], value[1]


def shown(value: Any) -> str:
    """A value as sent, truncated."""
    return _SHORT.repr(value)
