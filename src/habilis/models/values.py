"""Models whose states are any hashable values, stepped one at a time."""

from array import array
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from numbers import Real
from typing import Any

import numpy as np
from jaxtyping import Int, Int32

from habilis.models.limits import Limits, made_again

Step = Callable[[Any, int], Any]
Available = Callable[[Any], Sequence[int]]

_PAIR = 2
_AGAIN = 1000  # states whose actions are asked for twice
_CLOSE = 1e-9  # to 1, that probabilities sum to
_ROUGHLY = 1e-5  # of a narrower type than float64
_REPORTED = 1 << 6  # states from one report of progress to the next
_OUTCOMES = "the next state, which is hashable, or a list of (probability, state)"


@dataclass
class ReachedValues:
    """States of any kind, in the order in which they were met.

    Attributes:
        states: the states.
        numbers: the number of each.
        actions: how many there are.
        leads: the next states, by state and action; -1 where the action is not available or has
            several outcomes.
        outcomes: of the latter, (probability, next state) by the number of the transition,
            `state * actions + action`.
    """

    states: list[Hashable]
    numbers: dict[Hashable, int]
    actions: int
    leads: "array[int]" = field(default_factory=lambda: array("i"))
    outcomes: dict[int, list[tuple[float, int]]] = field(default_factory=dict)

    @property
    def next_state(self) -> Int32[np.ndarray, "expanded A"]:
        return np.array(self.leads, np.int32).reshape(-1, self.actions)

    def take(self, states: Int[np.ndarray, "n"]) -> list[Any]:
        """Some states."""
        return [self.states[place] for place in states.tolist()]

    def state(self, index: int) -> Any:
        """A state as the model has it."""
        return self.states[index]

    def index(self, state: Any) -> int:
        """The number of a state; -1 if it was not reached."""
        try:
            return self.numbers.get(state, -1)
        except TypeError:
            return -1


def reach_values(
    step: Step,
    actions: int,
    available: Available | None,
    initial: Sequence[Any],
    limits: Limits,
    report: Callable[[int, int], None],
    again: bool = True,
) -> ReachedValues:
    """Breadth first, one step after the other, those of a state in the order of the actions.

    Args:
        step, actions, available, initial: of a `Model`.
        limits: how far to go.
        report: called with the numbers of states expanded and known so far.
        again: whether some steps are made a second time in the end.

    Raises:
        ValueError: a step is not what a `Model` makes, or there are too many states.
    """
    found, level = ReachedValues([], {}, actions), 0
    numbers, states, leads = found.numbers, found.states, found.leads
    known, every = numbers.get, range(actions)

    def number_of(state: Any) -> int:
        if state not in numbers:
            if len(states) >= limits.max_states:
                raise limits.exceeded(len(leads) // actions, level)
            numbers[state] = len(states)
            states.append(state)
        return numbers[state]

    for state in initial:
        try:
            number_of(state)
            if isinstance(state, Iterator):
                raise TypeError
        except TypeError:
            raise ValueError(
                f"states has {state!r:.80}, which is not a hashable value; use tuples"
            ) from None
    while (done := len(leads) // actions) < len(states):
        if not limits.goes_on(level, lambda first=done: states[first:]):
            break
        for place in range(done, len(states)):
            state = states[place]
            usable = every if available is None else usable_actions(available, state, actions)
            for action in every:
                if usable is not every and action not in usable:
                    leads.append(-1)
                    continue
                reached = step(state, action)
                try:
                    number = known(reached)
                except TypeError:  # not hashable, as a list of outcomes is
                    where = _call(state, action)
                    outcomes = [(p, number_of(to)) for p, to in _outcomes(reached, where)]
                    found.outcomes[place * actions + action] = outcomes
                    number = -1
                if number is None:
                    if reached is None or isinstance(reached, Iterator):
                        kind = type(reached).__name__
                        raise ValueError(
                            f"{_call(state, action)} returns a {kind}; return {_OUTCOMES}"
                        )
                    number = number_of(reached)
                leads.append(number)
            if not place % _REPORTED:
                report(place, len(states))
        level += 1
    if again:
        _check_again(found, step)
        if available is not None:
            _check_available_again(found, available)
    return found


def usable_actions(available: Available, state: Any, actions: int) -> set[int]:
    """The available actions of a state.

    Raises:
        ValueError: there is no such action.
    """
    given = available(state)
    listed = list(given) if isinstance(given, Iterable) else [given]
    for action in listed:
        whole = isinstance(action, int | np.integer) and not isinstance(action, bool)
        if not whole or not 0 <= action < actions:
            raise ValueError(
                f"available({state!r:.80}) returns {given!r:.80}; return indices from 0 to "
                f"{actions - 1}, which are whole numbers"
            )
    return {int(action) for action in listed}


def _outcomes(returned: Any, where: str) -> list[tuple[float, Any]]:
    """A list of (probability, state), without those of probability 0.

    Raises:
        ValueError: it is none.
    """
    if not isinstance(returned, list):
        raise ValueError(
            f"{where} returns {returned!r:.80}, which is not hashable; return {_OUTCOMES}"
        )
    for outcome in returned:
        pair = isinstance(outcome, tuple) and len(outcome) == _PAIR
        if not pair or not isinstance(outcome[0], Real) or isinstance(outcome[0], bool):
            raise ValueError(f"{where} has the outcome {outcome!r:.80}; give (probability, state)")
        if not outcome[0] >= 0:
            raise ValueError(f"{where} has the probability {outcome[0]}; give one from 0 to 1")
        try:
            hash(outcome[1])
        except TypeError:
            raise ValueError(
                f"{where} leads to {outcome[1]!r:.80}, which is not hashable; use tuples for lists "
                "and arrays"
            ) from None
    narrow = any(isinstance(p, np.floating) and not isinstance(p, float) for p, _ in returned)
    total = sum(float(p) for p, _ in returned)
    if not abs(total - 1) <= (_ROUGHLY if narrow else _CLOSE):
        raise ValueError(f"{where} has probabilities that sum to {total:.12g}; let them sum to 1")
    return [(float(p) / total, state) for p, state in returned if p > 0]


def _check_again(found: ReachedValues, step: Step) -> None:
    """Makes steps a second time.

    Raises:
        ValueError: one has another outcome then.
    """
    for transition in made_again(len(found.leads)).tolist():
        place, action = divmod(transition, found.actions)
        before = found.leads[transition]
        if before < 0 and transition not in found.outcomes:  # not available
            continue
        state = found.states[place]
        reached = step(state, action)
        if before >= 0:
            same = found.index(reached) == before
        else:
            where = _call(state, action)
            again = [(p, found.index(to)) for p, to in _outcomes(reached, where)]
            same = sorted(again) == sorted(found.outcomes[transition])
        if not same:
            raise ValueError(
                f"{_call(state, action)} has another outcome the second time, {reached!r:.80}; let "
                "it depend on the state and the action alone: add to the state what else matters, "
                "or return a list of (probability, state)"
            )


def _check_available_again(found: ReachedValues, available: Available) -> None:
    """Asks a second time which actions are available.

    Raises:
        ValueError: others are.
    """
    expanded = len(found.leads) // found.actions
    for place in made_again(expanded)[:_AGAIN].tolist():
        state, first = found.states[place], place * found.actions
        before = {
            action
            for action in range(found.actions)
            if found.leads[first + action] >= 0 or first + action in found.outcomes
        }
        if usable_actions(available, state, found.actions) != before:
            raise ValueError(
                f"available({state!r:.80}) returns something else the second time; let it depend "
                "on the state alone"
            )


def _call(state: Any, action: int) -> str:
    return f"step({state!r:.80}, {action})"
