"""The part of a table that some actions from the states asked about can touch."""

import numpy as np
from jaxtyping import Int32, Int64

from habilis.compiled import compiled, paths


def neighbourhood(
    table: Int32[np.ndarray, "S A"], starts: Int64[np.ndarray, "n"], horizon: int
) -> tuple[
    Int64[np.ndarray, "N"],
    Int32[np.ndarray, "N A"],
    Int64[np.ndarray, "n"],
    Int64[np.ndarray, "levels"],
]:
    """The part of the table that h actions from the starts can touch.

    Returns:
        The N states reached within h actions, in order; the table over them alone (states on the
        rim, whose successors no longer matter, stay where they are); the starts' places in it;
        and how many states are reached within 0, 1, ... actions, up to where they are no more.
    """
    near, levels = _reached(table, starts, horizon)
    near.sort()
    place = np.full(len(table), -1, np.int32)
    place[near] = np.arange(len(near), dtype=np.int32)
    small = place[table[near]]
    rim = small < 0
    small[rim] = np.nonzero(rim)[0]
    return near, small, place[starts].astype(np.int64), levels


def _few_steps(table, starts, horizon):
    return min(table.size, len(starts) * paths(table.shape[1], horizon)) / 10  # in NumPy


def _reached_in_numpy(table, starts, horizon):
    """`_reached`, with the states of each level in order."""
    met = np.zeros(len(table), np.bool_)
    newest = np.unique(starts)
    met[newest] = True
    found, levels = [newest], [len(newest)]
    while len(newest) and len(levels) <= horizon:
        led = table[newest].ravel()
        newest = np.unique(led[~met[led]]).astype(np.int64)
        met[newest] = True
        found.append(newest)
        levels.append(levels[-1] + len(newest))
    return np.concatenate(found), np.array(levels, np.int64)


@compiled(_few_steps, _reached_in_numpy)
def _reached(table, starts, horizon):
    states = len(table)
    met = np.zeros(states, np.bool_)
    found = np.empty(states, np.int64)
    levels = np.empty(min(horizon, states) + 1, np.int64)
    count = 0
    for s in starts:
        if not met[s]:
            met[s] = True
            found[count] = s
            count += 1
    levels[0] = count
    begin, time = 0, 0
    while begin < count and time < horizon:
        end = count
        for k in range(begin, end):
            for a in range(table.shape[1]):
                s = np.int64(table[found[k], a])
                if not met[s]:
                    met[s] = True
                    found[count] = s
                    count += 1
        begin = end
        time += 1
        levels[time] = count
    return found[:count].copy(), levels[: time + 1].copy()
