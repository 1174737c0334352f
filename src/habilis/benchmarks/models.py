"""Exploring models: transitions a second."""

import time
from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from habilis.benchmarks import Result, times
from habilis.models import explore


@dataclass(frozen=True)
class Counters:
    """Some counters, each of which an action advances: every combination is a state.

    Attributes:
        sizes: how many values each counter has.
    """

    sizes: tuple[int, ...]

    @property
    def actions(self) -> int:
        return len(self.sizes)

    @property
    def initial(self) -> tuple[int, ...]:
        return (0,) * len(self.sizes)

    def step_many(
        self, states: Int[np.ndarray, "n k"], actions: Int[np.ndarray, "n"]
    ) -> Int[np.ndarray, "n k"]:
        after, place = states.copy(), np.arange(len(states))
        after[place, actions] = (states[place, actions] + 1) % np.array(self.sizes)[actions]
        return after


@dataclass(frozen=True)
class CountersOneByOne:
    """The same, one state at a time."""

    counters: Counters

    @property
    def actions(self) -> int:
        return self.counters.actions

    @property
    def initial(self) -> tuple[int, ...]:
        return self.counters.initial

    def step(self, state: tuple[int, ...], action: int) -> tuple[int, ...]:
        next_value = (state[action] + 1) % self.counters.sizes[action]
        return (*state[:action], next_value, *state[action + 1 :])


SMALL = Counters((6,) * 6)
LARGE = Counters((4,) * 10 + (3, 4))
"""Twelve variables and 12.6 million states."""


def results() -> list[Result]:
    lines = []
    transitions = SMALL.actions * int(np.prod(SMALL.sizes))
    one_by_one = CountersOneByOne(SMALL)
    calls = {"vectorised": lambda: explore(SMALL), "scalar": lambda: explore(one_by_one)}
    for name, seconds in times(calls).items():
        note = f"6 variables, {transitions:,} transitions"
        lines.append(Result.of(f"explore, {name}", transitions / seconds / 1e6, "M/s", note))
    began = time.perf_counter()
    mdp = explore(LARGE, max_states=20_000_000)
    seconds = time.perf_counter() - began
    note = f"12 variables, {mdp.states:,} states"
    rate = mdp.states * mdp.action_count / seconds / 1e6
    return [*lines, Result("explore, large", rate, "M/s", note)]
