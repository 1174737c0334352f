"""Where an environment is in its table, and what its states are worth."""

from collections.abc import Callable, Hashable
from typing import Any, Protocol

import numpy as np
from gymnasium.spaces import Discrete
from jaxtyping import Float64

from habilis.cache import fingerprint
from habilis.envs.table import TableEnv
from habilis.gymnasium_tables.enumeration import action_count, marker
from habilis.gymnasium_tables.identity import digest
from habilis.gymnasium_tables.keeping import kept_states
from habilis.mdp import TabularMDP

Measure = Callable[[TabularMDP], Float64[np.ndarray, "S"]]


class Places(Protocol):
    """The states of an environment as indices."""

    values: Float64[np.ndarray, "S"]
    """What each is worth."""

    def of(self, env: Any) -> int:
        """The state that an (unwrapped) environment is in."""
        ...

    def last(self, before: int, action: int, observation: Any, info: dict[str, Any]) -> int:
        """The state in which an episode ended, when the environment has gone on to the next.

        Args:
            before: the state from which the last step was made.
            action: of that step.
            observation, info: with which the episode ended.
        """
        ...


def places_of(env: Any, measure: Measure, max_states: int) -> Places:
    """The states of an environment, and what they are worth.

    Args:
        env: one of ours, one with a table `P` as toy-text's, or one whose states can be
            enumerated (see `TabularMDP.from_gymnasium`).
        measure: a value for every state of a table.
        max_states: how many states to enumerate, at most.

    Raises:
        ValueError: it has no table that can be had.
    """
    inner = env.unwrapped
    if isinstance(inner, TableEnv):
        return _OwnPlaces(measure(inner.dynamics))
    if getattr(inner, "P", None) is not None:
        return _DictPlaces(env, measure, max_states)
    return _EnumeratedPlaces(env, measure, max_states)


def same_table(one: Any, other: Any) -> bool:
    """Whether `places_of` one environment serve for another too.

    Where states are enumerated they do: other layouts are told apart.
    """
    one, other = one.unwrapped, other.unwrapped
    if isinstance(one, TableEnv) and isinstance(other, TableEnv):
        return one.slip == other.slip and _content(one.mdp) == _content(other.mdp)
    both = (one, other)
    tables = [env.mdp if isinstance(env, TableEnv) else getattr(env, "P", None) for env in both]
    return tables[0] is tables[1] or tables[0] == tables[1]


def _content(mdp: TabularMDP) -> str:
    return fingerprint(mdp.transitions, *(part for pair in mdp.factors.items() for part in pair))


class _OwnPlaces:
    """Of our environments, which say where they are."""

    def __init__(self, values: Float64[np.ndarray, "S"]):
        self.values = values

    def of(self, env: Any) -> int:
        return env.state

    def last(self, before: int, action: int, observation: Any, info: dict[str, Any]) -> int:
        return int(info["state"])


class _DictPlaces:
    """Of toy-text's environments, whose state is the row of `P`, and is what they show."""

    def __init__(self, env: Any, measure: Measure, max_states: int):
        self.values = measure(TabularMDP.from_gymnasium(env, max_states=max_states))
        self._shown = isinstance(env.observation_space, Discrete)

    def of(self, env: Any) -> int:
        return int(env.s)

    def last(self, before: int, action: int, observation: Any, info: dict[str, Any]) -> int:
        if not self._shown:
            raise ValueError(
                "the state in which an episode ended cannot be told from what is observed; wrap "
                "each environment in EmpowermentReward before it is vectorised"
            )
        return int(observation)


class _EnumeratedPlaces:
    """Of environments whose table is enumerated; further layouts as they are met."""

    def __init__(self, env: Any, measure: Measure, max_states: int):
        self._measure, self._max_states = measure, max_states
        self._mark = marker(env.unwrapped)
        self._known: dict[bytes, int] = {}
        self._place: dict[Hashable, int] = {}  # of marks seen before: faster than their digests
        self.values = np.empty(0)
        self._reached = np.empty((0, action_count(env)), np.int64)
        self._add(env, seed=0)

    def _add(self, env: Any, seed: int | None) -> None:
        states = kept_states(env, self._max_states, seed)
        first = len(self.values)
        self._known |= {mark.tobytes(): first + i for i, mark in enumerate(states.digests)}
        self.values = np.append(self.values, self._measure(states.mdp))
        self._reached = np.append(self._reached, first + states.mdp.next_state, axis=0)

    def of(self, env: Any) -> int:
        mark = self._mark(env)
        if mark not in self._place:
            name = digest(mark)
            if name not in self._known:  # a new episode has another layout
                self._add(env, seed=None)
            self._place[mark] = self._known[name]
        return self._place[mark]

    def last(self, before: int, action: int, observation: Any, info: dict[str, Any]) -> int:
        return int(self._reached[before, action])
