"""Averages estimated from placements drawn at random, in a stochastic table."""

import time
from collections.abc import AsyncIterator, Callable, Coroutine, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from habilis.studio.protocol.answers import Verdict
from habilis.worlds.world import NO_TOOL

_CHUNK = 0.1  # seconds per step of a longer computation
_INTERVAL = 1.96  # half width of a 95 % interval, in standard errors
_NOTHING = 1e-6  # bits: the tolerance to which each is computed


async def in_stretches(
    count: int, step: Callable[[int, int], Coroutine[Any, Any, list[float]]]
) -> AsyncIterator[list[float]]:
    """All values so far, repeatedly until there are `count`, in chunks of short duration.

    Args:
        count: the number of values.
        step: computes the values from one index up to another.
    """
    bits: list[float] = []
    size = 1
    while len(bits) < count:
        began = time.perf_counter()
        bits += await step(len(bits), min(len(bits) + size, count))
        seconds = time.perf_counter() - began
        size = max(1, min(int(size * _CHUNK / seconds), 2 * size))
        yield bits


@dataclass(frozen=True)
class Estimate:
    """The current estimate of an average.

    Attributes:
        bits: the average.
        within: the half width of its 95 % interval, 0 if it is exact.
        some: whether any placement has positive empowerment.
    """

    bits: float
    within: float
    some: bool

    @classmethod
    def of(cls, values: list[float]) -> "Estimate":
        several = len(values) > 1
        error = float(np.std(values, ddof=1)) / len(values) ** 0.5 if several else float("inf")
        return cls(float(np.mean(values)), _INTERVAL * error, max(values) > _NOTHING)


def verdicts(known: Mapping[str, Estimate]) -> dict[str, Verdict]:
    """Whether tools are useful, and better than none or equal to it.

    Returns:
        By tool; two averages are equal if they agree within their tolerance.
    """
    bare = known.get(NO_TOOL)
    if bare is None:
        return {}
    return {tool: _verdict(known[tool], bare) for tool in known if tool != NO_TOOL}


def _verdict(tool: Estimate, bare: Estimate) -> Verdict:
    apart = tool.bits - bare.bits
    doubt = float(np.hypot(tool.within, bare.within))
    open_ = doubt > 0 and abs(apart) <= doubt
    return Verdict(
        useful=tool.some,
        better_than_none=None if open_ else bool(apart > _NOTHING),
        equal=not open_ and abs(apart) <= _NOTHING,
    )
