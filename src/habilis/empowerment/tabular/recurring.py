"""Sets that are made from the sets before, step by step, until they repeat.

What follows from a set is always the same, so that once a step gives sets that were there before,
all later ones are known: at a fixed point no more steps are needed, and at a period only the
remainder of the horizon.
"""

from collections.abc import Callable, Generator
from typing import TypeVar

import numpy as np
from jaxtyping import Int64

from habilis.empowerment.limits import Progress, unwatched

T = TypeVar("T", bound=np.ndarray)

FIRST_LOOK = 16
"""Steps before the first comparison with earlier sets."""


def next_look(time: int) -> int:
    """When to keep sets for comparison next: periods up to a quarter of the time are found."""
    return time + max(FIRST_LOOK, time // 4)


def recurring(
    step: Callable[[T, T], bool], first: T, horizon: int, *, jump: bool = True
) -> Generator[tuple[T, int], None, int]:
    """The sets after 0, 1, 2, ... steps, and how many steps are left at most.

    What it gave is written over when it is asked for the next but one.

    Args:
        step: writes the next sets into its second argument; says if they differ from the first.
            Those that have never changed it may leave out, for they are there already.
        first: the sets to begin with.
        horizon: how many steps.
        jump: whether to go on from a period with what is left of the horizon after whole periods,
            so that the last sets given are those of the horizon; otherwise the sets that repeat
            are the last.

    Returns:
        After how many steps the last sets come again, 1 at a fixed point; 0 if that is not known.
    """
    sets = first
    kept, kept_at, keep_at, differs = None, 0, FIRST_LOOK, 0
    time, end, period = 0, horizon, 0
    yield sets, end
    spare = sets.copy() if end else sets
    while time < end:
        changed = step(sets, spare)
        if not changed:
            return 1
        sets, spare = spare, sets
        time += 1
        # Where they differed last they probably differ again: seldom must all be compared.
        if kept is not None and not period and sets.flat[differs] == kept.flat[differs]:
            different = sets != kept
            differs = int(different.argmax())
            if not different.flat[differs]:
                period = time - kept_at
                if not jump:
                    yield sets, 0
                    return period
                end = time + (end - time) % period
        if time == keep_at and not period and end - time >= FIRST_LOOK:
            if kept is None:
                kept = np.empty_like(sets)
            kept[...] = sets
            kept_at, keep_at = time, next_look(time)
        yield sets, end - time
    return period


def last_of(
    sets: Generator[tuple[T, int], None, int], horizon: int, watch: Progress = unwatched
) -> T:
    """The last of what `recurring` gives; `watch` is called with the share that is done."""
    last, left = next(sets)
    for now, left in sets:
        last = now
        watch(1 - left / max(horizon, 1))
    return last


def repeated(horizon: int, last: int, period: int) -> Int64[np.ndarray, "{horizon}+1"]:
    """Which of the sets after 0 to `last` steps are those after 0 to h, if they repeat from there.

    Args:
        horizon: h.
        last: so many steps were done.
        period: the next step would give those of `period` steps before it.
    """
    place = np.arange(horizon + 1)
    if last < horizon:
        place[last:] = last - period + 1 + (place[last:] - last - 1) % period
    return place
