"""Settings of a method given to a measure itself: deprecated, to be removed after one release."""

import warnings
from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import wraps
from typing import Any, ParamSpec, TypeVar

from habilis.callers import caller_outside
from habilis.empowerment.methods import Exact, Sampled, checked_method

P = ParamSpec("P")
R = TypeVar("R")

OLD_KEYWORDS = ("tolerance", "samples", "seed", "threads", "max_gib", "max_seconds")
_METHODS = {"exact": Exact, "sampled": Sampled}


def takes_old_keywords(measure: Callable[P, R]) -> Callable[P, R]:
    """A measure with a `method` that can still be given the settings of one as keywords.

    Example:
        >>> @takes_old_keywords
        ... def kept_within(method=Exact()):
        ...     return method.max_gib
        >>> with warnings.catch_warnings(record=True) as caught:
        ...     warnings.simplefilter("always")
        ...     kept_within(max_gib=2)
        2.0
        >>> print(caught[0].message)
        max_gib= of kept_within is deprecated; give method=hb.Exact(max_gib=2)
    """

    @wraps(measure)
    def call(*args: P.args, **given: P.kwargs) -> R:
        new: Any = with_method(measure.__name__, given)
        return measure(*args, **new)  # pyright: ignore[reportCallIssue]

    return call


def with_method(measure: str, given: Mapping[str, Any]) -> dict[str, Any]:
    """Keywords of a measure with a method in the place of its settings.

    Args:
        measure: its name.
        given: keywords, the settings of a method among them.

    Raises:
        ValueError: a setting is out of its range, or given beside a method.

    Warns:
        DeprecationWarning: names the replacement.
    """
    if not isinstance(given.get("method"), str) and given.keys().isdisjoint(OLD_KEYWORDS):
        return dict(given)
    old = {name: value for name, value in given.items() if name in OLD_KEYWORDS}
    name = given.get("method", "exact")
    if not isinstance(name, str) or name not in _METHODS:
        kind = type(checked_method(name))
        raise ValueError(
            f"{' and '.join(old)} given beside a method; give the method its settings, as "
            f"method=hb.{_called(kind, old)}"
        )
    kind = _METHODS[name]
    Sampled(**old)  # which has all of them, and refuses also what an exact method ignores
    called = [f"{one}=" for one in old] + [f"method={name!r}"] * ("method" in given)
    warnings.warn(
        f"{', '.join(called)} of {measure} {'are' if len(called) > 1 else 'is'} deprecated; give "
        f"method=hb.{_called(kind, old)}",
        DeprecationWarning,
        stacklevel=caller_outside(),
    )
    return {k: v for k, v in given.items() if k not in old} | {"method": kind(**_of(kind, old))}


def _of(kind: type[Exact | Sampled], old: Mapping[str, Any]) -> dict[str, Any]:
    """The settings that a kind of method has."""
    return {f.name: old[f.name] for f in fields(kind) if f.name in old}


def _called(kind: type[Exact | Sampled], old: Mapping[str, Any]) -> str:
    settings = ", ".join(f"{name}={value!r}" for name, value in _of(kind, old).items())
    return f"{kind.__name__}({settings})"
