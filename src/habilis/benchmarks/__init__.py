"""Our speed beside what users would pick instead, measured in one run on the reader's machine."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib import import_module
from typing import Any

import numpy as np
from jaxtyping import Float64

BENCHMARKS = (
    "start",
    "empowerment",
    "noise",
    "scale",
    "growth",
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
_LARGE = ("kinds", "noise")  # which have sizes that take minutes
_APART = ("sb3", "lanes", "growth")  # when named: needs torch, is of interest on a GPU, minutes

ROUNDS = 5
_WARM = 1.5  # seconds; kernels that have run for less are not compiled (habilis.compiled)

Seconds = Float64[np.ndarray, "rounds"]


@dataclass(frozen=True)
class Result:
    """One line of a benchmark.

    Attributes:
        name: what was measured.
        value: how much; of several rounds the median.
        unit: of `value`.
        note: what it is measured against, or on what.
        least, most: of the rounds, where there are several.
    """

    name: str
    value: float
    unit: str
    note: str
    least: float | None = None
    most: float | None = None

    @classmethod
    def of(cls, name: str, rounds: Seconds, unit: str, note: str) -> "Result":
        """The median of some rounds, with their spread."""
        return cls(
            name, float(np.median(rounds)), unit, note, float(rounds.min()), float(rounds.max())
        )

    def as_dict(self) -> dict[str, Any]:
        return asdict(self)

    def __str__(self) -> str:
        spread = ""
        if self.least is not None and self.most is not None:
            spread = f"{self.least:,.3g} to {self.most:,.3g}"
        return f"{self.name:<52} {self.value:>12,.3g} {self.unit:<10} {spread:<18} {self.note}"


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


def times(calls: Mapping[str, Callable[[], Any]], rounds: int = ROUNDS) -> dict[str, Seconds]:
    """Seconds of each call in each round.

    Each is called for a while before, so that all is compiled that will be. A round calls
    all of them in turn, so that a noisy moment hits all alike: a ratio is taken round by round.

    Example:
        >>> seconds = times({"ours": lambda: sum(range(9)), "theirs": lambda: sum([*range(9)])})
        >>> (seconds["theirs"] / seconds["ours"]).shape
        (5,)
    """
    for call in calls.values():
        end = time.perf_counter() + _WARM
        call()
        while time.perf_counter() < end:
            call()
    seconds = {name: np.empty(rounds) for name in calls}
    for one in range(rounds):
        for name, call in calls.items():
            began = time.perf_counter()
            call()
            seconds[name][one] = time.perf_counter() - began
    return seconds


def time_of(call: Callable[[], Any], rounds: int = ROUNDS) -> Seconds:
    """Seconds of a call in each round, compiled before."""
    return times({"it": call}, rounds)["it"]
