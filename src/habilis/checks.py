"""Settings as dataclass fields: their descriptions, and what is refused."""

from collections.abc import Sequence
from dataclasses import field, fields
from typing import Any, TypeVar

import numpy as np

Value = TypeVar("Value")

_LARGEST = 1e30  # of a number that is learned with, in float32
_WIDEST = 65_536
_MOST = 2_000_000_000  # of what is counted; seeds go further


def is_number(value: Any) -> bool:
    """Whether a value is a real number, of Python's or of NumPy's; true and false are none."""
    numbers = int, float, np.integer, np.floating
    return isinstance(value, numbers) and not isinstance(value, bool)


def is_probability(value: Any) -> bool:
    """Whether a value is a number from 0 to 1."""
    return is_number(value) and bool(0 <= value <= 1)


def setting(default: Value, text: str, static: bool = False) -> Value:
    """A field with its description, which the command line shows as help.

    Args:
        default: its value.
        text: what it is.
        static: whether the compiled program depends on it.
    """
    return field(default=default, metadata={"help": text, "static": static})


def as_in(kind: Any, name: str) -> Any:
    """The same setting as another dataclass has: its default and its description."""
    (same,) = (f for f in fields(kind) if f.name == name)
    return field(default=same.default, metadata=same.metadata)


def check_types(settings: Any, besides: Sequence[str] = ()) -> None:
    """Refuses values that are not of their field's type, or no finite numbers.

    Numbers of NumPy become Python's, which JSON can hold.

    Args:
        settings: a dataclass.
        besides: fields that may have any type.
    """
    for f in fields(settings):
        if f.name in besides:
            continue
        value, wanted = getattr(settings, f.name), type(f.default)
        if wanted in (int, float) and isinstance(value, np.integer | np.floating):
            value = int(value) if isinstance(value, np.integer) else float(value)
            object.__setattr__(settings, f.name, value)  # they are frozen
        _check_type(f.name, value, wanted)


def at_least(settings: Any, **least: float) -> None:
    for name, smallest in least.items():
        if not getattr(settings, name) >= smallest:
            raise ValueError(f"{name} is {getattr(settings, name)!r}; give at least {smallest}")


def above_zero(settings: Any, *names: str) -> None:
    for name in names:
        if not getattr(settings, name) > 0:
            raise ValueError(f"{name} is {getattr(settings, name)!r}; give a number above 0")


def share(settings: Any, *names: str) -> None:
    for name in names:
        if not 0 <= getattr(settings, name) <= 1:
            raise ValueError(f"{name} is {getattr(settings, name)!r}; give a number from 0 to 1")


def one_of(settings: Any, name: str, known: Sequence[str]) -> None:
    if getattr(settings, name) not in known:
        raise ValueError(
            f"{name} {getattr(settings, name)!r} is unknown; use one of {', '.join(known)}"
        )


def widths(value: Any) -> tuple[int, ...]:
    """Layer widths as a tuple; lists come from JSON."""
    if (
        not isinstance(value, tuple | list)
        or not value
        or not all(type(width) is int and 1 <= width <= _WIDEST for width in value)
    ):
        raise ValueError(f"hidden is {value!r}; give at least one width from 1 to {_WIDEST:,}")
    return tuple(value)


def _check_type(name: str, value: Any, wanted: type) -> None:
    if wanted is bool and not isinstance(value, bool):
        raise ValueError(f"{name} is {value!r}; give true or false")
    if wanted is int and (isinstance(value, bool) or not isinstance(value, int)):
        raise ValueError(f"{name} is {value!r}; give a whole number")
    if wanted is int and name != "seed" and not abs(value) <= _MOST:
        raise ValueError(f"{name} is {value}; give at most {_MOST:,}")
    if wanted is float:
        if not is_number(value) or not abs(value) < float("inf"):
            raise ValueError(f"{name} is {value!r}; give a finite number")
        if abs(value) > _LARGEST:
            size = f"{value:.3g}" if isinstance(value, float) else "too large"
            raise ValueError(
                f"{name} is {size}; give one from {-_LARGEST:g} to {_LARGEST:g}, since "
                "learning uses float32"
            )
    if wanted is str and not isinstance(value, str):
        raise ValueError(f"{name} is {value!r:.60}; give a string")
