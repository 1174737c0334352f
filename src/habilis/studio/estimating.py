"""Averages estimated from placements drawn at random, in a stochastic table."""

import time
from collections.abc import AsyncIterator, Callable, Coroutine, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from habilis.worlds.world import NO_TOOL

_STRETCH = 0.1  # seconds of a step that is part of a longer computation
_SEEN_OFTEN = 1.96  # standard errors within which 95 % of averages are
_NOTHING = 1e-6  # bits: the tolerance to which each is computed

Verdict = dict[str, bool | None]


async def in_stretches(
    count: int, step: Callable[[int, int], Coroutine[Any, Any, list[float]]]
) -> AsyncIterator[list[float]]:
    """All values so far, again and again until there are `count`, each time after a moment.

    Args:
        count: of the values.
        step: computes those from an index up to another.
    """
    bits: list[float] = []
    size = 1
    while len(bits) < count:
        began = time.perf_counter()
        bits += await step(len(bits), min(len(bits) + size, count))
        seconds = time.perf_counter() - began
        size = max(1, min(int(size * _STRETCH / seconds), 2 * size))
        yield bits


@dataclass(frozen=True)
class Estimate:
    """An average that is known so far.

    Attributes:
        bits: the average.
        within: where it is exact, 0; else the half width of its 95 % interval.
        some: whether any placement was worth anything.
    """

    bits: float
    within: float
    some: bool

    @classmethod
    def of(cls, values: list[float]) -> "Estimate":
        several = len(values) > 1
        error = float(np.std(values, ddof=1)) / len(values) ** 0.5 if several else float("inf")
        return cls(float(np.mean(values)), _SEEN_OFTEN * error, max(values) > _NOTHING)


def verdicts(known: Mapping[str, Estimate]) -> dict[str, Verdict]:
    """Whether tools are of use, and better than none or equal to it.

    Returns:
        By tool: `useful`, `better_than_none` (`None` where estimates leave that open) and `equal`,
        where the two averages are the same within the tolerance of both.
    """
    bare = known.get(NO_TOOL)
    if bare is None:
        return {}
    return {tool: _verdict(known[tool], bare) for tool in known if tool != NO_TOOL}


def _verdict(tool: Estimate, bare: Estimate) -> Verdict:
    apart = tool.bits - bare.bits
    doubt = float(np.hypot(tool.within, bare.within))
    open_ = doubt > 0 and abs(apart) <= doubt
    return {
        "useful": tool.some,
        "better_than_none": None if open_ else apart > _NOTHING,
        "equal": not open_ and abs(apart) <= _NOTHING,
    }
