"""Object empowerment that is lost without each movable, of several targets and states at once."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from habilis.bridges.puzzles.pushworld import OBJECT, PushWorld, State
from habilis.empowerment.api import empowerment
from habilis.models.explore import explore
from habilis.models.limits import TooManyStatesError

STATES, BUDGET = 6, 8_000_000
HORIZONS = (2, 3, 5, 8, 12, 16, 20)
LADDER = (12, 16, 20, 24, 28, 32, 40, 50, 64, 80, 100)
MOST_STATES, SECONDS, PATIENCE = 10_000_000, 60.0, 8.0


def chosen_states(states: Sequence[State], count: int = STATES) -> list[State]:
    """Evenly spaced states of a solution: the first is its first, its last is left out."""
    length = len(states) - 1
    return [states[place] for place in sorted({i * length // count for i in range(count)})]


@dataclass(frozen=True, eq=False)
class Loss:
    """The bits over one target with all movables, and those lost without one, state by state."""

    target: str
    object: str
    bits: Float64[np.ndarray, "n"]
    fixed: Float64[np.ndarray, "n"]
    removed: Float64[np.ndarray, "n"]


def losses(
    puzzle: PushWorld,
    targets: Sequence[str],
    states: Sequence[State],
    horizon: int,
    budget: int = BUDGET,
) -> list[Loss]:
    """As `tool_ranking`, each puzzle explored once for all targets.

    Args:
        puzzle: any.
        targets: names of movables.
        states: where the agent begins to act.
        horizon: in actions.
        budget: how many states to explore, of all variants of the puzzle, by what the puzzle itself
            has. A number of states, not of seconds, so that it is the same on each machine.

    Raises:
        TooManyStatesError: it is above the budget.
    """
    share = budget // (2 * len(puzzle.objects) - 1)
    free = _bits(puzzle, targets, states, horizon, share)
    found = []
    for other in puzzle.objects:
        if not (left_targets := [name for name in targets if name != other]):
            continue
        place = puzzle.place(other)
        left = [state[:place] + state[place + 1 :] for state in states]
        removed = _bits(puzzle.without(other), left_targets, left, horizon, 4 * share)
        fixed = {name: np.empty(len(states)) for name in left_targets}
        cells = np.array([state[place] for state in states])
        for cell in np.unique(cells):
            here = np.flatnonzero(cells == cell).tolist()
            walled = puzzle.fixed(other, states[here[0]])
            some = _bits(walled, left_targets, [left[i] for i in here], horizon, 4 * share)
            for name in left_targets:
                fixed[name][here] = some[name]
        for name in left_targets:
            without = (free[name] - fixed[name], free[name] - removed[name])
            found.append(Loss(name, other, free[name], *without))
    return found


def _bits(
    puzzle: PushWorld,
    targets: Sequence[str],
    states: Sequence[State],
    horizon: int,
    max_states: int,
) -> dict[str, Float64[np.ndarray, "n"]]:
    mdp = explore(puzzle, states, horizon, max_states)
    numbers = [mdp.index(state) for state in states]
    return {t: empowerment(mdp, horizon, f"{OBJECT}{t}", states=numbers) for t in targets}


def feasible(puzzle: PushWorld, patience: float = PATIENCE) -> dict[str, Any]:
    """Up to which horizon object empowerment in the initial state takes under a minute.

    The target is the first movable with a goal. Horizons of `LADDER` are tried from the shortest to
    20, and on while the next one is likely to take less than some seconds.

    Args:
        puzzle: any that has a goal.
        patience: how many seconds.

    Returns:
        `horizon`, the longest one tried that took less than 10 million states and 60 seconds, or
        the longest of all if no more states can be reached; `states_20` and `seconds_20`, at
        horizon 20, and `bits_20`, all empty if it is not feasible.
    """
    target = puzzle.goals[0].bodies[0]
    found: dict[str, Any] = dict.fromkeys(("horizon", "states_20", "seconds_20", "bits_20"))
    spent = [0.0, 0.0]
    reached = 0
    for horizon in LADDER:
        growth = min(max(spent[1] / spent[0], 4.0), 16.0) if spent[0] else 8.0
        if horizon > 20 and spent[1] * growth > patience:
            break
        start = time.perf_counter()
        try:
            mdp = explore(puzzle, [puzzle.initial], horizon, MOST_STATES)
            bits = empowerment(mdp, horizon, f"{OBJECT}{target}", states=[0])
        except (TooManyStatesError, MemoryError):
            break
        seconds = time.perf_counter() - start
        if seconds > SECONDS:
            break
        found["horizon"] = horizon
        if horizon == 20:
            found |= {"states_20": mdp.states, "seconds_20": round(seconds, 2)}
            found["bits_20"] = round(float(bits[0]), 4)
        if mdp.states == reached and horizon >= 20:
            found["horizon"] = LADDER[-1]
            break
        spent, reached = [spent[1], seconds], mdp.states
    return found
