"""Where an environment is in its table, and the values of its states."""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float64

from habilis.bridges.gymnasium.enumeration import Mark, action_count
from habilis.bridges.gymnasium.indexed import Indexed
from habilis.bridges.gymnasium.keeping import kept_states
from habilis.bridges.gymnasium.snapshots import Identity, unwrapped
from habilis.bridges.gymnasium.tables import check_environment, indexed, is_indexed
from habilis.bridges.gymnasium.transition_dict import has_table
from habilis.bridges.gymnasium.verification import step_changers
from habilis.cache import fingerprint
from habilis.envs.table import TableEnv
from habilis.mdp import TabularMDP

Measure = Callable[[TabularMDP], Float64[np.ndarray, "S"]]


@runtime_checkable
class TabulatedStates(Protocol):
    """The states of an environment as indices."""

    values: Float64[np.ndarray, "S"]
    """float64[S]."""

    def begun(self, env: Any, observation: Any) -> int:
        """The state in which an episode begins."""
        ...

    def reached(self, env: Any, observation: Any, ended: bool) -> int | None:
        """The state that a step led to; `None` if it is in no table."""
        ...

    def possible(self, state: int, action: int) -> Collection[int]:
        """The states that an action may lead to."""
        ...

    def measure(self, measure: Measure) -> None:
        """Computes the values anew."""
        ...


def tabulated_states(
    env: Any, measure: Measure, max_states: int, identity: Identity
) -> TabulatedStates:
    """The states of an environment, and their values.

    Args:
        env: one of ours, one with a table `P` as toy-text's, or one whose states can be
            enumerated (see `TabularMDP.from_gymnasium`).
        measure: a value for every state of a table.
        max_states: how many states to enumerate, at most.
        identity: what makes two states the same.

    Raises:
        ValueError: it has no table, or does not follow it.
    """
    check_environment(env, identity)
    if is_indexed(env, identity):
        found = indexed(env, max_states)
        return _IndexedStates(found, measure(found.mdp))
    return _EnumeratedStates(env, measure, max_states, identity)


def same_table(one: Any, other: Any) -> bool:
    """Whether the states of one environment serve for another too.

    Where states are enumerated they do: other layouts are distinguished.
    """
    one, other = one.unwrapped, other.unwrapped
    if isinstance(one, TableEnv) and isinstance(other, TableEnv):
        return one.slip == other.slip and _content(one.mdp) == _content(other.mdp)
    if isinstance(one, TableEnv) or isinstance(other, TableEnv):
        return False
    tables = [env.P if has_table(env) else None for env in (one, other)]
    return tables[0] is tables[1] or tables[0] == tables[1]


def _content(mdp: TabularMDP) -> str:
    return fingerprint(mdp.transitions, *(part for pair in mdp.factors.items() for part in pair))


@dataclass
class Position:
    """The state that an environment is in, followed through its episodes.

    Attributes:
        env: the environment, with the wrappers inside.
        states: its states as indices.
        state: the index of the present one; -1 before the first reset.
        reached: that which the last step led to, before another episode began.
    """

    env: Any
    states: TabulatedStates
    state: int = -1
    reached: int = -1

    def __post_init__(self) -> None:
        self._steps, self._over = 0, True

    def begin(self, observation: Any) -> None:
        """After a reset."""
        self.state = self.states.begun(self.env, observation)
        self._steps, self._over = 0, False

    def step(
        self,
        action: Any,
        observation: Any,
        terminated: bool | np.bool_,
        truncated: bool | np.bool_,
    ) -> None:
        """After a step.

        Raises:
            ValueError: it was not one that the table has.
        """
        if self._over:  # a wrapper that resets by itself has begun another episode
            self.begin(observation)
            self.reached, self._over = self.state, bool(terminated or truncated)
            return
        self._steps += 1
        possible = self.states.possible(self.state, int(action))
        reached = self.states.reached(self.env, observation, bool(terminated))
        if reached is None or reached not in possible:
            raise ValueError(self._difference(int(action), possible, reached, bool(terminated)))
        self.state = self.reached = reached
        self._over = bool(terminated or truncated)

    def _difference(
        self, action: int, possible: Collection[int], reached: int | None, terminated: bool
    ) -> str:
        came = "one that its table does not have" if reached is None else f"state {reached}"
        expected = ", ".join(map(str, list(possible)[:5])) or "none"
        changers = step_changers(self.env)
        what = (
            f"{', '.join(changers)} changes what a step does: put it around EmpowermentReward"
            if changers
            else "it is random, or depends on something that is not in its state"
        )
        name = type(unwrapped(self.env)).__name__
        return (
            f"{name} does not follow its table: in step {self._steps} of an episode, action "
            f"{action} in state {self.state}, state {expected} was expected, and {came} came "
            f"(terminated={terminated}); {what}, or give state=(save, load)"
        )


@dataclass
class _IndexedStates:
    """The states of environments that hold the row of their table themselves."""

    table: Indexed
    values: Float64[np.ndarray, "S"]

    def begun(self, env: Any, observation: Any) -> int:
        return self.table.place(env, observation, False)

    def reached(self, env: Any, observation: Any, ended: bool) -> int | None:
        state = self.table.place(env, observation, ended)
        return state if self.table.ends[state] == ended else None

    def possible(self, state: int, action: int) -> Collection[int]:
        return self.table.after(state, action)

    def measure(self, measure: Measure) -> None:
        self.values = measure(self.table.mdp)


class _EnumeratedStates:
    """The states of enumerated environments; further layouts are added as they appear."""

    def __init__(self, env: Any, measure: Measure, max_states: int, identity: Identity):
        self._measure, self._max_states, self._identity = measure, max_states, identity
        self._known: dict[Mark, int] = {}
        self._tables: list[TabularMDP] = []
        self.values = np.empty(0)
        self._next_state = np.empty((0, action_count(env)), np.int64)
        self._add(env, seed=0)

    def _add(self, env: Any, seed: int | None) -> None:
        found = kept_states(env, self._max_states, seed, self._identity)
        first = len(self.values)
        self._known |= {mark: first + i for i, mark in enumerate(found.marks)}
        self._tables.append(found.mdp)
        self.values = np.append(self.values, self._measure(found.mdp))
        self._next_state = np.append(self._next_state, first + found.mdp.next_state, axis=0)

    def begun(self, env: Any, observation: Any) -> int:
        mark = self._identity.of(env).digest, False
        if mark not in self._known:  # a new episode has another layout
            self._add(env, seed=None)
        if mark not in self._known:
            raise ValueError(
                f"a copy of {type(unwrapped(env)).__name__} is not in the state that it was copied "
                "in; give state=(save, load)"
            )
        return self._known[mark]

    def reached(self, env: Any, observation: Any, ended: bool) -> int | None:
        return self._known.get((self._identity.of(env).digest, ended))

    def possible(self, state: int, action: int) -> Collection[int]:
        return (int(self._next_state[state, action]),)

    def measure(self, measure: Measure) -> None:
        self._measure = measure
        self.values = np.concatenate([measure(mdp) for mdp in self._tables])
