"""Models whose states are rows of integers, stepped many at a time."""

from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from jaxtyping import Bool, Int, Int32, Int64

from habilis.models.interning import InternedRows
from habilis.models.limits import Limits
from habilis.processors import processors

Rows = Int64[np.ndarray, "n k"]
Step = Callable[[Rows], tuple[Int64[np.ndarray, "n A k"], Bool[np.ndarray, "n A"] | None]]
"""Where each action leads from some states, and which are available; `None`: all."""

_BLOCK = 1 << 13  # states stepped at once: the arrays of one block stay in the cache


@dataclass(frozen=True)
class ReachedRows:
    """States as rows of integers, in the order in which they were met.

    Attributes:
        found: the states.
        next_state: int32[expanded, A], where actions lead from the first of them; -1 where they
            are not available.
    """

    found: InternedRows
    next_state: Int32[np.ndarray, "expanded A"]

    def take(self, states: Int[np.ndarray, "n"]) -> Rows:
        """Some states, one a row."""
        return self.found.take(states)

    def state(self, index: int) -> tuple[int, ...]:
        """A state as the model has it."""
        return tuple(self.found.rows(index, index + 1)[0].tolist())

    def index(self, state: Any) -> int:
        """The number of a state; -1 if it was not reached."""
        row = np.asarray(state)
        if row.dtype.kind not in "iub" or row.shape != (self.found.columns,):
            return -1
        return int(self.found.find(row.astype(np.int64)[None])[0])


def reach_rows(
    step: Step,
    actions: int,
    initial: Rows,
    limits: Limits,
    report: Callable[[int, int], None],
) -> ReachedRows:
    """Breadth first through rows. All processors make steps; one thread finds out which are new.

    Raises:
        TooManyStatesError: there are more than max_states.
    """
    found = InternedRows(initial.shape[1])
    found.add(initial)
    if len(found) > limits.max_states:
        raise limits.exceeded(0, 0)
    leads: list[Int32[np.ndarray, "n A"]] = []
    done = level = 0
    with ThreadPoolExecutor(processors()) as pool:
        while done < len(found) and limits.goes_on(level, partial(found.rows, done)):
            frontier = len(found)
            for after, there in _in_order(pool, step, found, done, frontier):
                mask = None if there is None else there.ravel()
                numbers = found.add(after.reshape(-1, initial.shape[1]), mask)
                leads.append(numbers.reshape(-1, actions))
                done += len(after)
                if len(found) > limits.max_states:
                    raise limits.exceeded(done, level)
                report(done, len(found))
            level += 1
    none = np.empty((0, actions), np.int32)
    return ReachedRows(found, np.concatenate([none, *leads]))


def _in_order(
    pool: ThreadPoolExecutor, step: Step, found: InternedRows, first: int, last: int
) -> Iterator[tuple[Int64[np.ndarray, "n A k"], Bool[np.ndarray, "n A"] | None]]:
    """The steps from some states, in blocks, some of which are made ahead."""
    ahead: deque[Future[Any]] = deque()
    for start in range(first, last, _BLOCK):
        rows = found.rows(start, min(start + _BLOCK, last))
        if last - first <= _BLOCK:  # another thread is not worth while
            yield step(rows)
            return
        ahead.append(pool.submit(step, rows))
        if len(ahead) > 2 * processors():
            yield ahead.popleft().result()
    while ahead:
        yield ahead.popleft().result()
