"""Ten million placements: time, memory, threads, and how the cost grows with the map."""

import resource
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from habilis.benchmarks import Result
from habilis.benchmarks.counting import room
from habilis.empowerment import empowerment
from habilis.empowerment.methods import Exact
from habilis.processors import processors
from habilis.worlds.table import tabulate

_SIDE, _SMALLER, _HUGE = 40, 33, 200


def results() -> list[Result]:
    small = tabulate(room(_SMALLER))
    empowerment(small, 1, "object")  # compilation is not what is measured
    empowerment(small, 1, "state")
    empowerment(room(7), 1, "object", states={"agent": (0, 0), "tool": (2, 2), "object": (4, 4)})
    cores = processors()
    world = room(_SIDE)
    table, mdp = timed(lambda: tabulate(world))
    toe, bits = timed(lambda: empowerment(mdp, 6, "object"))
    memory = _peak_gib()
    size = f"{_SIDE}x{_SIDE}, picker, {mdp.states:,} placements"
    lines = [
        Result("tabulate", table, "s", size),
        Result("TOE, h = 6", toe, "s", f"{size}, {cores} threads"),
        Result("peak memory so far", memory, "GiB", size),
    ]
    alone, same = timed(lambda: empowerment(mdp, 6, "object", method=Exact(threads=1)))
    assert np.array_equal(bits, same)
    lines.append(Result("TOE, h = 6: one thread / all", alone / toe, "times", f"{cores} cores"))
    smaller, _ = timed(lambda: empowerment(small, 6, "object"))
    per_state = (toe / mdp.states) / (smaller / small.states)
    lines.append(
        Result(
            f"TOE, h = 6, a state: {_SIDE}x{_SIDE} over {_SMALLER}x{_SMALLER}",
            per_state,
            "times",
            f"{mdp.states:,} and {small.states:,} placements; independent of the map: 1",
        )
    )
    foe, _ = timed(lambda: empowerment(mdp, 4, "state"))
    lines.append(Result("FOE, h = 4", foe, "s", f"{size}, {cores} threads"))
    lines.append(Result("peak memory in all", _peak_gib(), "GiB", size))
    huge = room(_HUGE)
    place = {"agent": (100, 100), "tool": (100, 101), "object": (100, 102)}
    one, _ = timed(lambda: empowerment(huge, 6, "object", states=place))
    lines.append(Result("TOE, h = 6, one state", one, "s", f"{_HUGE}x{_HUGE}, without a table"))
    return lines


def timed(call: Callable[[], Any]) -> tuple[float, Any]:
    """Seconds, and the result."""
    began = time.perf_counter()
    result = call()
    return time.perf_counter() - began, result


def _peak_gib() -> float:
    """The most memory that this process has had; macOS counts bytes, Linux kibibytes."""
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 2**30
