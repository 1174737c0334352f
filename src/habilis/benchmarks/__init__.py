"""Our speed beside what users would pick instead, measured in one run on the reader's machine."""

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from importlib import import_module
from typing import Any

BENCHMARKS = (
    "start",
    "empowerment",
    "scale",
    "kinds",
    "worlds",
    "models",
    "environments",
    "learning",
    "lanes",
    "studio",
    "sb3",
)
_EXTRAS = {"learning": "learn", "lanes": "learn", "sb3": "learn", "studio": "studio"}
_LARGE = ("kinds",)  # which have sizes that take minutes
_APART = ("sb3", "lanes")  # measured when named: it needs torch, or is of interest on a GPU


@dataclass(frozen=True)
class Result:
    """One line of a benchmark.

    Attributes:
        name: what was measured.
        value: how much.
        unit: of `value`.
        note: what it is measured against, or on what.
    """

    name: str
    value: float
    unit: str
    note: str

    def as_dict(self) -> dict[str, Any]:
        return asdict(self)

    def __str__(self) -> str:
        return f"{self.name:<52} {self.value:>12,.3g} {self.unit:<14} {self.note}"


def run_benchmarks(names: Sequence[str], large: bool = False) -> list[Result]:
    """Runs benchmarks one after the other.

    Args:
        names: some of `BENCHMARKS`; if there are none, all that need no other environment.
        large: whether to measure the largest sizes too, of those that have some.

    Raises:
        ValueError: no such benchmark, or none with larger sizes.
        MissingExtraError: what a benchmark needs is not installed.
    """
    from habilis.extras import import_from

    unknown = [name for name in names if name not in BENCHMARKS]
    if unknown:
        raise ValueError(
            f"benchmark {unknown[0]!r} is unknown; use some of {', '.join(BENCHMARKS)}"
        )
    if large and names and not set(names) & set(_LARGE):
        raise ValueError(
            f"--large is of {', '.join(_LARGE)}, and not of {', '.join(names)}; leave it out"
        )
    results = []
    for name in names or [name for name in BENCHMARKS if name not in _APART]:
        path = f"habilis.benchmarks.{name}"
        extra = _EXTRAS.get(name)
        module = import_module(path) if extra is None else import_from(path, extra)
        results += module.results(large=True) if large and name in _LARGE else module.results()
    return results


def best_seconds(call: Callable[[], Any], repeats: int = 5) -> float:
    """The least time of a call, after one that warms up: the machine's noise only adds."""
    call()
    times = []
    for _ in range(repeats):
        began = time.perf_counter()
        call()
        times.append(time.perf_counter() - began)
    return min(times)
