"""What makes two copies of an environment the same state: all they hold, but for a few things."""

import enum
import hashlib
from collections.abc import Hashable
from typing import Any

import numpy as np

_COUNTERS = ("step_count", "_elapsed_steps", "elapsed_steps", "steps", "num_steps", "t", "timestep")
"""Counters of steps: time is not part of a state of a Markov decision process."""

_APART = (
    *("_np_random", "_np_random_seed", "np_random", "spec", "metadata", "render_mode"),
    *("window", "window_surface", "clock", "screen", "viewer", "renderer", "lastaction"),
    *("action_space", "observation_space", "reward_range", "mission"),
)
"""Random numbers, spaces and pictures."""

_PLAIN = (bool, int, float, complex, str, bytes, type(None))


def identity(env: Any) -> Hashable:
    """All that an environment's attributes hold, but for chance, pictures and counters of steps.

    Raises:
        ValueError: an attribute is of a kind that has no value to compare; it is named.
    """
    return tuple(
        (name, frozen(value, name))
        for name, value in sorted(vars(env).items())
        if name not in _APART and name not in _COUNTERS
    )


def keep_counters(first: Any, env: Any) -> None:
    """Sets an environment's counters of steps to those of the first state."""
    for name in _COUNTERS:
        if isinstance(vars(first).get(name), int):
            setattr(env, name, vars(first)[name])


def digest(mark: Hashable) -> bytes:
    """32 bytes that are the same in every process for equal marks, which hashes are not."""
    return hashlib.sha256(_ordered(mark).encode()).digest()


def _ordered(mark: Any) -> str:
    if isinstance(mark, frozenset):
        return "{" + ",".join(sorted(map(_ordered, mark))) + "}"
    if isinstance(mark, tuple):
        return "(" + ",".join(map(_ordered, mark)) + ")"
    return repr(mark)


def frozen(value: Any, where: str) -> Hashable:
    """A hashable value that is equal for equal contents."""
    if isinstance(value, enum.Enum):
        return type(value).__name__, value.name
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, _PLAIN):
        return value
    if isinstance(value, np.ndarray):
        if value.dtype == object:
            return tuple(frozen(part, where) for part in value.ravel().tolist())
        return value.shape, str(value.dtype), value.tobytes()
    if isinstance(value, list | tuple):
        return tuple(frozen(part, where) for part in value)
    if isinstance(value, set | frozenset):
        return frozenset(frozen(part, where) for part in value)
    if isinstance(value, dict):
        return frozenset((frozen(k, where), frozen(v, where)) for k, v in value.items())
    if isinstance(value, type) or callable(value):
        return getattr(value, "__qualname__", type(value).__qualname__)
    if hasattr(value, "__dict__"):
        parts = ((name, frozen(part, f"{where}.{name}")) for name, part in vars(value).items())
        return type(value).__name__, tuple(sorted(parts))
    raise ValueError(
        f"the attribute {where!r} ({type(value).__name__}) cannot be compared; "
        "give key=, a function from the environment to what makes its state"
    )
