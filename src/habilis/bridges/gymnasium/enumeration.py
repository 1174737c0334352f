"""Tables of deterministic environments by stepping through every state that can be reached."""

import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sized
from dataclasses import dataclass, field, replace
from enum import Enum
from itertools import pairwise
from typing import Any

import numpy as np
from jaxtyping import Int32, Int64

from habilis.bridges.gymnasium.encodings import attributes
from habilis.bridges.gymnasium.identity import view
from habilis.bridges.gymnasium.minigrid import is_minigrid, minigrid_factors
from habilis.bridges.gymnasium.randomness import global_states, left_alone, reseed
from habilis.bridges.gymnasium.snapshots import (
    Access,
    Seen,
    Snapshot,
    called,
    reason,
    short,
    unwrapped,
)
from habilis.mdp import TabularMDP
from habilis.models.limits import Limits
from habilis.models.values import reach_values
from habilis.progress import progress_bar

Mark = tuple[bytes, bool]
"""A state: the digest of its identity, and whether an episode has ended in it."""

_TRIES = 20_000  # of steps that drew random numbers, with other numbers, in all
_TRIES_AT_ONCE = 4  # of these, for each such step when it first appears
_ROUNDS = 10  # in which all such steps are tried, some times each
_SECONDS = 10.0  # that all of them may take


@dataclass(frozen=True)
class Step:
    """Where a step led, and what came with it.

    Attributes:
        mark: the state.
        reward: as a table holds it.
        observed: the beginning of a digest of the observation; 0 where it cannot be compared.
    """

    mark: Mark
    reward: np.float32
    observed: int


@dataclass(frozen=True)
class Enumerated:
    """All states of an environment that can be reached.

    Attributes:
        mdp: their table.
        marks: of each state.
        snapshots: of each state.
        observed: int64[S, A], `Step.observed` of each transition.
        parent, action: int32[S], the state from which, and the action by which, a state was
            first reached, along a shortest path; -1 for the first.
        seconds: that it took.
    """

    mdp: TabularMDP
    marks: list[Mark]
    snapshots: list[Snapshot]
    observed: Int64[np.ndarray, "S A"]
    parent: Int32[np.ndarray, "S"]
    action: Int32[np.ndarray, "S"]
    seconds: float


@dataclass
class _Found:
    """The states found so far, in order, and the steps from those that were expanded."""

    access: Access
    max_states: int
    place: dict[Mark, int] = field(init=False)
    snapshots: list[Snapshot] = field(init=False)
    parent: list[int] = field(default_factory=lambda: [-1])
    action: list[int] = field(default_factory=lambda: [-1])
    steps: list[list[Step]] = field(default_factory=list)
    drew: list[tuple[int, int]] = field(default_factory=list)  # steps that drew random numbers
    unmoved: Any = None  # an environment in the state last stepped from, if nothing happened there

    def __post_init__(self) -> None:
        first = self.access.first
        self.marks: list[Mark] = [(first.seen.digest, False)]
        self.place, self.snapshots = {self.marks[0]: 0}, [first]

    def add(self, mark: Mark, keep: Callable[[], Snapshot], state: int, action: int) -> None:
        """A state that an action led to, which may be known.

        Raises:
            ValueError: it is one more than there may be.
        """
        if mark in self.place:
            return
        if len(self.marks) >= self.max_states:
            raise ValueError(
                f"more than {self.max_states:,} states can be reached, {state:,} of them "
                f"expanded; raise max_states{self._growing()}"
            )
        self.place[mark] = len(self.marks)
        self.marks.append(mark)
        self.snapshots.append(keep())
        self.parent.append(state)
        self.action.append(action)

    def step(self, mark: Mark, action: int) -> Mark:
        """Makes a step out of a state, whose others are made before and after it.

        Raises:
            ValueError: it has more than one outcome, or leads to a state too many.
        """
        state, access = self.place[mark], self.access
        if action == 0:
            self.steps.append([])
            self.unmoved = None
        if mark[1]:  # an end is not stepped out of
            self.steps[state].append(Step(mark, np.float32(0), 0))
            return mark
        snapshot = self.snapshots[state]
        env = access.load(snapshot) if self.unmoved is None else self.unmoved
        before = [*global_states(), *access.shared(), *access.drawn_before(snapshot)]
        step, seen = _step(access, env, action, state)
        self.steps[state].append(step)
        draws = [*global_states(), *access.shared(), *seen.drawn] != before
        self.add(step.mark, lambda: Snapshot(access.save(env), seen), state, action)
        self.unmoved = None
        if step.mark == mark and not draws:
            access.rewind(env)  # nothing happened: the next step can be made from here
            self.unmoved = env
        if draws:
            self.drew.append((state, action))
            _try_others(access, self, (state, action), step, range(_TRIES_AT_ONCE))
        return step.mark

    def _growing(self) -> str:
        """Which attribute grows with every step of a longest one of the shortest paths."""
        path = [len(self.marks) - 1]
        while self.parent[path[-1]] >= 0:
            path.append(self.parent[path[-1]])
        found = (self.access.parts(self.snapshots[state]) for state in reversed(path))
        states = [_flat(parts) for parts in found]
        for name in states[0] if len(path) > 2 else ():
            sizes = [_size(state.get(name)) for state in states]
            if all(before < after for before, after in pairwise(sizes)):
                return (
                    f", or leave out the attribute {name!r}, which grows with every step, with "
                    f"ignore=[{name!r}] if no transition depends on it"
                )
        return ", or say with key= what makes two states the same"


def _flat(parts: Mapping[str, Any], depth: int = 3) -> dict[str, Any]:
    """Attributes, and those of attributes as "simulator.time"."""
    every = dict(parts)
    for name, part in parts.items() if depth else ():
        inside = attributes(part) if hasattr(part, "__dict__") and not callable(part) else {}
        every |= {f"{name}.{one}": value for one, value in _flat(inside, depth - 1).items()}
    return every


def _size(value: Any) -> float:
    """A number itself, and how many things a container has; NaN of all else."""
    if isinstance(value, int | float | np.number):
        return float(value)
    return float(len(value)) if isinstance(value, Sized) else float("nan")


def enumerate_states(
    access: Access,
    actions: int,
    max_states: int,
    factors: Mapping[str, Callable[[Any], int]] | None,
    show_progress: bool,
) -> Enumerated:
    """Breadth first from the first state; see `TabularMDP.from_gymnasium`."""
    began = time.thread_time()  # of the processor: what else runs here leaves replays no less
    found = _Found(access, max_states)
    with progress_bar("states", show_progress) as report:
        limits = Limits(None, max_states)
        reach_values(found.step, actions, None, found.marks[:1], limits, report, again=False)
    if found.drew:
        _try_again(access, found, found.drew, show_progress)
    seconds = time.thread_time() - began
    table = [[found.place[step.mark] for step in row] for row in found.steps]
    rewards = np.array([[step.reward for step in row] for row in found.steps])
    mdp = TabularMDP.deterministic(table, rewards, [ended for _, ended in found.marks])
    inner = unwrapped(access.load(access.first))
    names = _action_names(inner, actions)
    named = _factors(access, found.snapshots, factors or {}, is_minigrid(inner))
    return Enumerated(
        replace(mdp, factors=named, actions=names),
        *(found.marks, found.snapshots),
        np.array([[step.observed for step in row] for row in found.steps], np.int64),
        *(np.array(found.parent, np.int32), np.array(found.action, np.int32)),
        seconds,
    )


def action_count(env: Any) -> int:
    """The number of actions of an environment.

    Raises:
        ValueError: they are not `Discrete(n)`.
    """
    space = env.action_space
    if type(space).__name__ != "Discrete" or int(getattr(space, "start", 0)) != 0:
        raise ValueError(
            f"the actions are {short(space)}; only Discrete(n) can be enumerated: wrap the "
            "environment in one that has such actions"
        )
    return int(space.n)


def made_step(env: Any, action: int, where: str) -> tuple[Any, np.float32, bool, bool]:
    """Observation, reward, terminated and truncated of one step.

    Args:
        env: makes the step.
        action: its index.
        where: for messages, as "state 3".

    Raises:
        ValueError: it raises something, or returns something else.
    """
    try:
        returned = env.step(action)
    except Exception as error:  # whatever the environment's own code raises
        kind = "" if str(error).startswith(type(error).__name__) else f"{type(error).__name__}: "
        raise ValueError(
            f"action {action} in {where} raises {kind}{reason(error)}; reset the environment "
            "before it is tabulated with seed=None, and let every action be possible in every state"
        ) from None
    if not isinstance(returned, tuple) or len(returned) != 5:
        raise ValueError(
            f"step(action) returns {short(returned)}; Gymnasium's is "
            "(observation, reward, terminated, truncated, info)"
        )
    observation, reward, terminated, truncated, _ = returned
    number, ended = np.asarray(reward), np.asarray(terminated)
    if number.size != 1 or number.dtype.kind not in "biuf" or ended.size != 1:
        raise ValueError(
            f"action {action} in {where} has reward {short(reward)} and terminated "
            f"{short(terminated)}; give a number and a bool"
        )
    return observation, np.float32(number.item()), bool(ended.item()), bool(truncated)


def observed(observation: Any) -> int:
    """The first 63 bits of an observation's digest."""
    return int.from_bytes(view(observation, strict=False).digest[:8], "little") >> 1


def _step(access: Access, env: Any, action: int, state: int) -> tuple[Step, Seen]:
    """One step, and what the environment looks like after it."""
    observation, reward, terminated, _ = made_step(env, action, f"state {state}")
    seen = access.look(env)
    return Step((seen.digest, terminated), reward, observed(observation)), seen


def _try_again(
    access: Access, found: _Found, drew: list[tuple[int, int]], show_progress: bool
) -> None:
    """Makes steps that drew random numbers with thousands of others, until time is up."""
    deadline = time.perf_counter() + _SECONDS
    tried, at_once = _TRIES_AT_ONCE * len(drew), max(1, _TRIES // (_ROUNDS * len(drew)))
    with progress_bar("steps that draw random numbers", show_progress) as report:
        while tried < _TRIES:
            for state, action in drew:
                if time.perf_counter() > deadline:
                    return
                step, seeds = found.steps[state][action], range(tried, tried + at_once)
                _try_others(access, found, (state, action), step, seeds)
                tried += at_once
                report(tried, _TRIES)


def _try_others(
    access: Access, found: _Found, transition: tuple[int, int], step: Step, seeds: range
) -> None:
    """Raises ValueError: with other random numbers a step is another."""
    state, action = transition
    load = access.loader(found.snapshots[state])
    for seed in seeds:
        env, generators = load()
        with left_alone(generators):  # so that what it comes to can be recognised at once
            reseed(generators, seed)
            observation, reward, ended, _ = made_step(env, action, f"state {state}")
        if Step((access.look(env).digest, ended), reward, observed(observation)) != step:
            raise ValueError(
                f"action {action} in state {state} has more than one outcome; only deterministic "
                "environments can be enumerated: give the probabilities to TabularMDP.stochastic"
            )


def _action_names(env: Any, count: int) -> tuple[str, ...]:
    """The names of an enumeration of actions, as Minigrid has one."""
    known = getattr(env, "actions", None)
    if not isinstance(known, type) or not issubclass(known, Enum) or len(known) != count:
        return ()
    return tuple(action.name for action in known)


def _factors(
    access: Access,
    snapshots: list[Snapshot],
    factors: Mapping[str, Callable[[Any], int]],
    minigrid: bool,
) -> dict[str, Int32[np.ndarray, "S"]]:
    """The labels of all states, those of Minigrid and those asked for."""
    if not factors and not minigrid:
        return {}
    asked: dict[str, list[Any]] = {name: [] for name in factors}

    def loaded() -> Iterator[Any]:
        for snapshot in snapshots:
            env = unwrapped(access.load(snapshot))
            for name, label in factors.items():
                asked[name].append(called(label, env, name=f"factor {name!r}"))
            yield env

    named = minigrid_factors(loaded()) if minigrid else {}
    if not minigrid:
        deque(loaded(), maxlen=0)
    return named | {name: _labels(name, values) for name, values in asked.items()}


def _labels(name: str, values: list[Any]) -> Int32[np.ndarray, "S"]:
    try:
        labels = np.array(values)
    except ValueError:  # ragged
        labels = np.array([values], object)
    if labels.ndim != 1 or labels.dtype.kind not in "biu":
        raise ValueError(f"factor {name!r} is not a whole number in every state; return an int")
    return labels.astype(np.int32)
