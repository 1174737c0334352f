"""Episodes of an environment, as the user passed it, checked against its table.

First along shortest paths to transitions that were not seen yet, then by random actions; and all of
them again, with other random numbers everywhere.
"""

import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import count
from typing import Any, Protocol, runtime_checkable

import numpy as np

from habilis.progress import progress_bar

LEAST_SECONDS = 2.0  # of the processor, that the replays of any table may take
_EPISODES = 10  # of random actions
_STEPS = 100  # of such an episode, at most, and no more than 10 and one a state
_LATE_STEPS = 1000  # where something may happen late in an episode


@dataclass(frozen=True)
class Mismatch:
    """A step that differs from the table.

    Attributes:
        actions: of the episode so far, the last one that of this step.
        state: from which the step was made.
        expected, came: in the table, and in the environment.
        again: whether it was so only with other random numbers.
    """

    actions: tuple[int, ...]
    state: int
    expected: str
    came: str
    again: bool = False

    def message(self, name: str, advice: str) -> str:
        """One line.

        Args:
            name: of the environment.
            advice: what to do about it.
        """
        *before, action = self.actions
        shown = ", ".join(map(str, before[-10:]))
        after = f" after actions {'..., ' if len(before) > 10 else ''}{shown}" if before else ""
        return (
            f"{name} does not follow its table: in step {len(self.actions)} of an episode, action "
            f"{action} in state {self.state}{after}, {self.expected} was expected, and {self.came} "
            f"came; {advice}"
        )


@dataclass(frozen=True)
class Came:
    """The result of one step.

    Attributes:
        state: the state that was reached.
        ended: whether the episode is over.
        differs: what was expected and what came, where that is not the same.
    """

    state: int
    ended: bool
    differs: tuple[str, str] | None = None


@runtime_checkable
class Dynamics(Protocol):
    """A table, and the environment that it is checked against."""

    def successors(self) -> list[list[list[int]]]:
        """By state and action, the states that may follow; none where nothing follows."""
        ...

    def begin(self, seed: int) -> tuple[Any, int]:
        """An environment at the beginning of an episode, with its random numbers, and its state."""
        ...

    def step(self, env: Any, state: int, action: int) -> Came:
        """One step of the environment."""
        ...


@dataclass
class _Coverage:
    """Which transitions were not seen yet, and how to get to one."""

    successors: list[list[list[int]]]
    unseen: list[set[int]] = field(init=False)
    seen: set[tuple[int, int]] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.unseen = [{a for a, after in enumerate(row) if after} for row in self.successors]

    def saw(self, state: int, action: int) -> None:
        self.unseen[state].discard(action)
        self.seen.add((state, action))

    def path(self, start: int) -> list[int]:
        """Actions of a shortest way to, and through, a transition that was not seen yet."""
        come: dict[int, tuple[int, int]] = {start: (-1, -1)}
        todo = deque([start])
        while todo:
            state = todo.popleft()
            if self.unseen[state]:
                actions = [min(self.unseen[state])]
                while (step := come[state])[0] >= 0:
                    state, action = step
                    actions.append(action)
                return actions[::-1]
            for action, after in enumerate(self.successors[state]):
                for reached in after:
                    if reached not in come:
                        come[reached] = (state, action)
                        todo.append(reached)
        return []

    def give_up(self, start: int) -> None:
        """The nearest transition is out of reach: episodes are over before."""
        path, state = self.path(start), start
        if not path:
            return
        for action in path[:-1]:
            state = self.successors[state][action][0]
        self.unseen[state].discard(path[-1])


def replayed(
    dynamics: Dynamics, seconds: float, late: bool = False, show_progress: bool = False
) -> tuple[set[tuple[int, int]], Mismatch | None]:
    """Replays episodes.

    Args:
        dynamics: the table and its environment.
        seconds: that they may take; a quarter of it, at least, for those that are made again.
        late: whether to go on with long episodes until the time is up, since something may
            happen late in one.
        show_progress: whether to draw a progress bar.

    Returns:
        The transitions (state, action) that were seen, and the first that was another than the
        table's.
    """
    coverage = _Coverage(dynamics.successors())
    end = time.thread_time() + seconds
    logs = []
    with progress_bar("transitions in replays", show_progress) as report:
        every = sum(map(len, coverage.unseen))
        for choose in _choosers(coverage, dynamics, end - seconds / 4, late):
            log, mismatch = _episode(dynamics, choose, 1 + len(logs), coverage)
            if mismatch is not None:
                return coverage.seen, mismatch
            logs.append(log)
            report(len(coverage.seen), every)
    with progress_bar("replays with other random numbers", show_progress) as report:
        for seed, log in enumerate(logs):
            if time.thread_time() > end:
                break
            _, mismatch = _episode(dynamics, _listed(log), -1 - seed, coverage)
            if mismatch is not None:
                return coverage.seen, replace(mismatch, again=True)
            report(seed + 1, len(logs))
    return coverage.seen, None


Chooser = Callable[[int], int | None]
"""From a state to the next action; `None` for the end of the episode."""


def _choosers(
    coverage: _Coverage, dynamics: Dynamics, deadline: float, late: bool
) -> Iterator[Chooser]:
    """Choosers for one episode after the other."""
    starts = [dynamics.begin(0)[1]]  # of the episode before
    while coverage.path(starts[-1]) and time.thread_time() < deadline:
        before = len(coverage.seen)
        yield _to_unseen(coverage, deadline, starts)
        if len(coverage.seen) == before:
            coverage.give_up(starts[-1])
    rng = np.random.default_rng(0)
    steps = min(_STEPS, 10 + len(coverage.successors))
    for episode in count():
        if time.thread_time() > deadline or (episode >= _EPISODES and not late):
            return
        yield _random(coverage.successors, rng, _LATE_STEPS if late else steps)


def _to_unseen(coverage: _Coverage, deadline: float, starts: list[int]) -> Chooser:
    plan: list[int] = []
    expected = [-1]

    def choose(state: int) -> int | None:
        if expected[0] < 0:
            starts.append(state)
        if not plan or state != expected[0]:
            plan[:] = coverage.path(state) if time.thread_time() < deadline else []
        if not plan:
            return None
        action = plan.pop(0)
        expected[0] = coverage.successors[state][action][0]
        return action

    return choose


def _random(successors: list[list[list[int]]], rng: np.random.Generator, steps: int) -> Chooser:
    left = [steps]

    def choose(state: int) -> int | None:
        possible = [action for action, after in enumerate(successors[state]) if after]
        left[0] -= 1
        return int(rng.choice(possible)) if possible and left[0] >= 0 else None

    return choose


def _listed(actions: Iterable[int]) -> Chooser:
    rest = iter(actions)
    return lambda state: next(rest, None)


def _episode(
    dynamics: Dynamics, choose: Chooser, seed: int, coverage: _Coverage
) -> tuple[list[int], Mismatch | None]:
    """One episode: its actions, and the step that was another than the table's, if any."""
    env, state = dynamics.begin(abs(seed) * 2 + (seed < 0))
    actions = []
    while (action := choose(state)) is not None and coverage.successors[state][action]:
        came = dynamics.step(env, state, action)
        actions.append(action)
        if came.differs is not None:
            return actions, Mismatch(tuple(actions), state, *came.differs)
        coverage.saw(state, action)
        if came.ended:
            break
        state = came.state
    return actions, None
