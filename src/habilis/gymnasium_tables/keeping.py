"""Enumerated tables, kept on disk: looking into every state of an environment takes seconds."""

import inspect
import sys
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import UInt8

from habilis.cache import Arrays, fingerprint, kept
from habilis.gymnasium_tables.enumeration import (
    Enumerated,
    action_count,
    enumerate_states,
    first_state,
)
from habilis.gymnasium_tables.identity import digest
from habilis.mdp import TabularMDP

_EDITION = 1  # of what is kept: to be raised when it becomes another
_STEPS = 50  # of the walk by which a table from the disk is tried
_FACTOR = "factor "


@dataclass(frozen=True)
class States:
    """The states of an enumerated environment.

    Attributes:
        mdp: their table.
        digests: of each state's mark (see `identity.digest`).
    """

    mdp: TabularMDP
    digests: UInt8[np.ndarray, "S 32"]


def kept_states(env: Any, max_states: int, seed: int | None) -> States:
    """The table of an environment by enumeration; the second time from the disk.

    What is kept goes by the first state and by the source of the environment's classes. Since
    a table from the disk could be that of other code still, it is tried by a random walk first.

    Args:
        env, max_states, seed: as in `TabularMDP.from_gymnasium`.

    Raises:
        ValueError: as there.
    """

    def compute() -> Arrays:
        return _arrays(enumerate_states(env, max_states, seed, None, None, False))

    with first_state(env, seed) as (first, saved):
        code = _code(type(first))
        if code is None:
            return _states(compute())
        begin = digest(saved.identity(first)).hex()
        name = fingerprint("states", _EDITION, begin, code, max_states, action_count(env))

    return _states(kept(name, compute, accept=lambda arrays: _agrees(env, seed, arrays)))


def _code(kind: type) -> str | None:
    """What an environment's classes are made of; `None` where that cannot be read."""
    parts = []
    for cls in kind.__mro__[:-1]:
        package = sys.modules.get(cls.__module__.partition(".")[0])
        try:
            source = inspect.getsource(cls)
        except (OSError, TypeError):
            return None
        parts.append((cls.__qualname__, getattr(package, "__version__", ""), source))
    return fingerprint(parts)


def _agrees(env: Any, seed: int | None, arrays: Arrays) -> bool:
    """Whether an environment does what a table says, on a random walk from its first state."""
    actions = np.random.default_rng(0).integers(action_count(env), size=_STEPS)
    with first_state(env, seed) as (first, saved):
        walker, state = saved.load(saved.save(first)), 0
        for action in actions:
            if arrays["terminal"][state]:
                break
            _, reward, terminated, _, _ = walker.step(int(action))
            seen = np.frombuffer(digest(saved.identity(walker)), np.uint8)
            after = arrays["next_state"][state, action]
            if (
                not np.array_equal(seen, arrays["digests"][after])
                or np.float32(reward) != arrays["reward"][state, action]
                or terminated != arrays["terminal"][after]
            ):
                return False
            state = after
    return True


def _arrays(found: Enumerated) -> Arrays:
    mdp = found.mdp
    marks = b"".join(digest(mark) for mark in found.place)  # in the order of their places
    return {
        "next_state": mdp.next_state,
        "reward": mdp.reward,
        "terminal": mdp.terminal,
        "digests": np.frombuffer(marks, np.uint8).reshape(mdp.states, -1),
        "actions": np.array(mdp.actions, np.str_),
        **{_FACTOR + name: labels for name, labels in mdp.factors.items()},
    }


def _states(arrays: Arrays) -> States:
    mdp = TabularMDP.deterministic(arrays["next_state"], arrays["reward"], arrays["terminal"])
    factors = {
        name.removeprefix(_FACTOR): labels
        for name, labels in arrays.items()
        if name.startswith(_FACTOR)
    }
    mdp = replace(mdp, factors=factors, actions=tuple(arrays["actions"].tolist()))
    return States(mdp, arrays["digests"])
