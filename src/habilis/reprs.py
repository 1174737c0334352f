"""How results show themselves: a line of text, and what a notebook draws.

A representation computes nothing expensive, is the same for the same object, and never raises.
"""

from base64 import b64encode
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import MISSING, fields
from functools import wraps
from html import escape
from itertools import groupby
from typing import Any

import numpy as np
from jaxtyping import Float64

from habilis.colours import COLOURS

_MOST = 12  # parts of a list that are named
_BAR, _HIGH, _MOST_BARS = 6, 60, 100  # pixels, and how many bars are drawn

_TABLE = 'style="border-collapse:collapse;display:inline-table;vertical-align:top"'
_NAME = 'style="text-align:left;padding:2px 12px 2px 6px;font-weight:600;vertical-align:top"'
_VALUE = 'style="text-align:left;padding:2px 12px 2px 0"'


def quietly(show: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """The method of a notebook's representation, `None` where it cannot draw.

    A notebook then shows the text; an object in the middle of being debugged must not be the
    cause of another traceback.
    """

    @wraps(show)
    def shown(self: Any) -> Any:
        try:
            return show(self)
        except Exception:
            return None

    return shown


def unfailing(line: Callable[[Any], str]) -> Callable[[Any], str]:
    """The method `__repr__`, the plain one of Python where it fails, as of a damaged object."""

    @wraps(line)
    def shown(self: Any) -> str:
        try:
            return line(self)
        except Exception:
            return object.__repr__(self)

    return shown


def settings(thing: Any, nested: Collection[str] = ()) -> str:
    """A dataclass of settings as the call that makes it: those that have not their defaults.

    Args:
        thing: the settings.
        nested: the fields that are settings themselves.

    Example:
        >>> from dataclasses import dataclass
        >>> @dataclass
        ... class Two:
        ...     one: int = 1
        ...     two: int = 2
        >>> settings(Two(two=3))
        'Two(two=3)'
    """
    parts = []
    for one in fields(thing):
        value = getattr(thing, one.name)
        usual = one.default if one.default_factory is MISSING else one.default_factory()
        if value is not usual and value != usual:
            parts.append(f"{one.name}={settings(value) if one.name in nested else repr(value)}")
    return f"{type(thing).__name__}({', '.join(parts)})"


def short(name: str, *parts: str) -> str:
    """A line, `<name: part; part>`; empty parts are left out, and what no line shows is escaped.

    Example:
        >>> short("Plan", "3 steps", "", "return 0")
        '<Plan: 3 steps; return 0>'
    """
    line = "; ".join(part for part in parts if part)
    return "".join(one if one.isprintable() else repr(one)[1:-1] for one in f"<{name}: {line}>")


def counted(number: int, one: str, many: str = "") -> str:
    """A number of things in words.

    Example:
        >>> counted(1, "state"), counted(6468, "state")
        ('1 state', '6,468 states')
    """
    return f"{number:,} {one if number == 1 else many or one + 's'}"


def listed(names: Iterable[str]) -> str:
    """Names in a line, a dozen of them at most."""
    names = list(names)
    more = len(names) - _MOST
    return ", ".join(names[:_MOST]) + (f", and {more:,} more" if more > 0 else "")


def repeated(names: Iterable[str]) -> str:
    """Names in a line, equal neighbours once.

    Example:
        >>> repeated(["north", "north", "east"])
        'north ×2, east'
    """
    runs = [(name, sum(1 for _ in same)) for name, same in groupby(names)]
    return listed(name if times == 1 else f"{name} ×{times}" for name, times in runs)


def number(value: float) -> str:
    """A number with up to four significant digits, whole ones in full."""
    whole = float(value).is_integer() and abs(value) < 1e15
    return f"{value:,.0f}".replace("-0", "0") if whole else f"{value:.4g}"


def table_html(title: str, rows: Mapping[str, str], *pictures: str) -> str:
    """A table of names and values, all of it escaped, and pictures beside it.

    Args:
        title: stands above.
        rows: values by their names; empty ones are left out.
        *pictures: HTML, as it is.
    """
    lines = "".join(
        f"<tr><th {_NAME}>{escape(name)}</th><td {_VALUE}>{escape(value)}</td></tr>"
        for name, value in rows.items()
        if value
    )
    table = f"<table {_TABLE}><tbody>{lines}</tbody></table>"
    beside = "".join(f'<div style="display:inline-block">{picture}</div>' for picture in pictures)
    row = f'<div style="display:flex;flex-wrap:wrap;gap:24px">{table}{beside}</div>'
    return f"<div><div><strong>{escape(title)}</strong></div>{row}</div>"


def bars_svg(shares: Float64[np.ndarray, "n"]) -> str:
    """Probabilities as bars, the highest of full height; of many the first."""
    shown = [max(share, 0.0) for share in shares[:_MOST_BARS].tolist()]
    most = max(shown, default=0.0) or 1.0
    path = "".join(
        f"M{place * _BAR} {_HIGH}v{-_HIGH * share / most:.2f}h{_BAR - 1}V{_HIGH}z"
        for place, share in enumerate(shown)
    )
    width = max(len(shown), 1) * _BAR
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{_HIGH + 1}" role="img">'
        f'<title>probabilities, at most {most:.4g}</title><path d="{path}" fill="{COLOURS[0]}"/>'
        f'<path d="M0 {_HIGH}.5h{width}" stroke="#8a94a3"/></svg>'
    )


def svg_image(svg: str, label: str) -> str:
    """An SVG as an image of HTML: its ids and styles stay in it."""
    data = b64encode(svg.encode()).decode()
    return f'<img alt="{escape(label)}" src="data:image/svg+xml;base64,{data}"/>'
