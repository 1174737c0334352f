"""Tables of deterministic environments by stepping through every state that can be reached."""

import copy
from collections.abc import Callable, Hashable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

import numpy as np
from jaxtyping import Int32

from habilis.gymnasium_tables.identity import frozen, identity, keep_counters
from habilis.gymnasium_tables.minigrid import is_minigrid, minigrid_factors
from habilis.mdp import TabularMDP
from habilis.progress import progress_bar


@dataclass(frozen=True)
class Enumerated:
    """All states of an environment that can be reached.

    Attributes:
        mdp: their table.
        place: the index of each state in it, by its mark.
    """

    mdp: TabularMDP
    place: Mapping[Hashable, int]


_RETRIES = 4  # of a step that drew random numbers, each with others


def enumerate_states(
    env: Any,
    max_states: int,
    seed: int | None,
    key: Callable[[Any], Hashable] | None,
    factors: Mapping[str, Callable[[Any], int]] | None,
    show_progress: bool,
) -> Enumerated:
    """Breadth first from one state; see `TabularMDP.from_gymnasium`."""
    actions = action_count(env)
    with first_state(env, seed) as (first, saved), progress_bar("states", show_progress) as tell:
        mark = key or saved.identity
        place: dict[Hashable, int] = {mark(first): 0}
        found, ended = [saved.save(first)], [False]
        table: list[list[int]] = []
        rewards: list[list[float]] = []
        while len(table) < len(found):
            state = len(table)
            row, earned = [state] * actions, [0.0] * actions
            for action in range(0 if ended[state] else actions):
                step = _certain_step(saved, found[state], action, state, mark)
                successor = place.setdefault(step.identity, len(found))
                if successor == len(found):
                    if successor >= max_states:
                        raise ValueError(
                            f"more than {max_states:,} states can be reached, {state:,} of them "
                            "looked into; raise max_states, or give a key= that leaves out "
                            "what does not matter, such as a counter of steps"
                        )
                    found.append(step.after)
                    ended.append(step.terminated)
                elif ended[successor] != step.terminated:
                    raise ValueError(
                        f"whether state {successor} ends an episode depends on how it is entered "
                        f"(state {state}, action {action}); give a key= that tells the two apart"
                    )
                row[action], earned[action] = successor, step.reward
            table.append(row)
            rewards.append(earned)
            tell(len(table), len(found))
        mdp = TabularMDP.deterministic(table, rewards, ended)
        named = minigrid_factors(map(saved.load, found)) if is_minigrid(first) else {}
        for name, label in (factors or {}).items():
            named[name] = _labels(name, [label(saved.load(state)) for state in found])
        mdp = replace(mdp, factors=named, actions=_action_names(first, actions))
        return Enumerated(mdp, place)


def action_count(env: Any) -> int:
    space = env.action_space
    if type(space).__name__ != "Discrete" or int(space.start) != 0:
        raise ValueError(
            f"the actions are {space}; only Discrete(n) can be enumerated: wrap the environment "
            "in one that has such actions"
        )
    return int(space.n)


def _action_names(env: Any, count: int) -> tuple[str, ...]:
    """The names of an enumeration of actions, as Minigrid has one."""
    known = getattr(env, "actions", None)
    if not isinstance(known, type) or not issubclass(known, Enum) or len(known) != count:
        return ()
    return tuple(action.name for action in known)


@dataclass(frozen=True)
class Saved:
    """How the states of an environment are kept.

    Attributes:
        save: from an environment to what is kept of its state; the environment may go on.
        load: from what was kept to an environment in that state.
        identity: from an environment to what makes two of its states the same.
    """

    save: Callable[[Any], Any]
    load: Callable[[Any], Any]
    identity: Callable[[Any], Hashable]


def marker(inner: Any) -> Callable[[Any], Hashable]:
    """What makes two states of an (unwrapped) environment the same."""
    return _by_state if _keeps_states(inner) else identity


def _keeps_states(inner: Any) -> bool:
    return all(callable(getattr(inner, name, None)) for name in ("get_state", "set_state"))


def _by_state(env: Any) -> Hashable:
    return frozen(env.get_state(), "get_state()")


@contextmanager
def first_state(env: Any, seed: int | None) -> Iterator[tuple[Any, Saved]]:
    """An environment of our own in the first state, and how its states are kept."""
    inner = env.unwrapped
    if _keeps_states(inner):
        before = copy.deepcopy(inner.get_state())

        def load(state: Any) -> Any:
            inner.set_state(copy.deepcopy(state))
            return inner

        def save(env: Any) -> Any:
            return copy.deepcopy(env.get_state())

        saved = Saved(save, load, _by_state)
        try:
            if seed is not None:
                inner.reset(seed=seed)
            yield inner, saved
        finally:
            inner.set_state(before)
        return
    first = _copied(env)
    if seed is not None:
        first.reset(seed=seed)
    first = first.unwrapped

    def copied_in_time(state: Any) -> Any:
        loaded = _copied(state)
        keep_counters(first, loaded)
        return loaded

    yield first, Saved(lambda env: env, copied_in_time, identity)


def _copied(env: Any) -> Any:
    try:
        return copy.deepcopy(env)
    except Exception as error:  # whatever the environment's own parts raise
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise ValueError(
            f"{type(env.unwrapped).__name__} cannot be copied ({reason}); make it without a "
            "renderer, or give it get_state() and set_state(state)"
        ) from None


@dataclass(frozen=True)
class _Step:
    """Where a step led, and what was had for it."""

    after: Any
    identity: Hashable
    reward: float
    terminated: bool


def _certain_step(
    saved: Saved, state: Any, action: int, number: int, mark: Callable[[Any], Hashable]
) -> _Step:
    """One step from a state. Raises if chance decides on where it leads."""
    step, drew = _step(saved, state, action, mark, None)
    for chance in range(_RETRIES if drew else 0):
        other, _ = _step(saved, state, action, mark, chance)
        if other.identity != step.identity or (other.reward, other.terminated) != (
            step.reward,
            step.terminated,
        ):
            raise ValueError(
                f"action {action} in state {number} has more than one outcome; only "
                "deterministic environments can be enumerated: give the probabilities to "
                "TabularMDP.stochastic"
            )
    return step


def _step(
    saved: Saved, state: Any, action: int, mark: Callable[[Any], Hashable], chance: int | None
) -> tuple[_Step, bool]:
    """One step, with other random numbers if asked, and whether it drew any."""
    env = saved.load(state)
    if chance is not None:
        env.np_random.bit_generator.state = np.random.default_rng(chance).bit_generator.state
    before = env.np_random.bit_generator.state
    _, reward, terminated, _, _ = env.step(action)
    drew = env.np_random.bit_generator.state != before
    return _Step(saved.save(env), mark(env), float(reward), bool(terminated)), drew


def _labels(name: str, values: list[int]) -> Int32[np.ndarray, "S"]:
    labels = np.array(values)
    if labels.ndim != 1 or labels.dtype.kind not in "biu":
        raise ValueError(f"factor {name!r} is not a whole number in every state; return an int")
    return labels.astype(np.int32)
