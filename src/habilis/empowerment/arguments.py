"""Validation of the arguments of all measures."""

from typing import Any, Literal

import numpy as np
from jaxtyping import Float64, Int64
from numpy.typing import ArrayLike

from habilis.checks import is_number
from habilis.mdp import TabularMDP
from habilis.models.protocol import action_names
from habilis.probabilities import as_array, row_stochastic
from habilis.worlds.world import World

Unit = Literal["bits", "nats"]

_LARGEST = 2**31 - 1
_OF_BELIEFS = " (hb.empowerment alone takes beliefs, as float[n, S], one a row)"


def whole_number(name: str, value: int) -> int:
    """`value` if it is an integer from 0 up, else a ValueError that names it."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 0:
        raise ValueError(f"{name} is {value!r}; give a whole number from 0 up")
    if value > _LARGEST:
        raise ValueError(f"{name} is {value}; give at most {_LARGEST:,}")
    return int(value)


def at_least_one(name: str, value: int) -> int:
    """`value` if it is an integer from 1 up, else a ValueError that names it."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 1:
        raise ValueError(f"{name} is {value!r}; give a whole number from 1 up")
    return int(value)


def positive(name: str, value: float) -> float:
    """`value` if it is a number above 0 (infinity is one), else a ValueError that names it."""
    if not is_number(value) or not value > 0:
        raise ValueError(f"{name} is {value!r}; give a number above 0")
    return float(value)


def per_bit(unit: Unit) -> float:
    """How many of a unit are one bit: 1 for "bits", ln 2 for "nats"."""
    sizes = {"bits": 1.0, "nats": float(np.log(2))}
    if unit not in sizes:
        raise ValueError(f"unit is {unit!r}; use 'bits' or 'nats'")
    return sizes[unit]


def check_table(mdp: Any) -> None:
    """Refuses what is not a table; plain empowerment alone makes one of a model.

    Raises:
        ValueError: says how to make one, if there is a way.
    """
    if isinstance(mdp, TabularMDP):
        return
    if isinstance(mdp, World):
        fix = "give hb.tabulate(world)"
    elif hasattr(mdp, "actions"):
        action_names(mdp)  # of a simulator there is no table
        fix = "give hb.explore(model)"
    else:
        fix = "give a hb.TabularMDP"
    raise ValueError(f"{type(mdp).__name__} is no table; {fix}")


def chosen_actions(
    mdp: TabularMDP, actions: ArrayLike | None, count: int | None = None
) -> Int64[np.ndarray, "A"]:
    """The given action indices, each once, in order; all by default, or the first `count`."""
    count = mdp.action_count if count is None else count
    if actions is None:
        return np.arange(count)
    chosen = as_array("actions", actions)
    if chosen.dtype == object and chosen.ndim == 1:  # integers beyond NumPy's
        large = [one for one in chosen if isinstance(one, int) and not 0 <= one < count]
        if large:
            raise ValueError(f"actions has {large[0]}; use indices from 0 to {count - 1}")
    if chosen.ndim != 1 or not len(chosen) or not np.issubdtype(chosen.dtype, np.integer):
        raise ValueError(
            f"actions has shape {chosen.shape} and type {chosen.dtype}; "
            "give a list of action indices, at least one"
        )
    outside = chosen[(chosen < 0) | (chosen >= count)]
    if len(outside):
        raise ValueError(f"actions has {outside[0]}; use indices from 0 to {count - 1}")
    return np.unique(chosen).astype(np.int64)


def chosen_states(mdp: TabularMDP, states: Any, name: str = "states") -> Int64[np.ndarray, "n"]:
    """The given state indices, in order and as often as given; all by default."""
    if states is None:
        return np.arange(mdp.states)
    chosen = np.atleast_1d(as_array(name, states))
    if chosen.dtype == bool and chosen.shape == (mdp.states,):
        return np.flatnonzero(chosen)
    if chosen.size == 0:
        return np.empty(0, np.int64)
    if chosen.ndim != 1 or not np.issubdtype(chosen.dtype, np.integer):
        belief = chosen.dtype.kind == "f" and chosen.shape[-1] == mdp.states
        raise ValueError(
            f"{name} has shape {chosen.shape} and type {chosen.dtype}; "
            f"give state indices, or one bool a state{_OF_BELIEFS if belief else ''}"
        )
    outside = chosen[(chosen < 0) | (chosen >= mdp.states)]
    if len(outside):
        raise ValueError(f"{name} has {outside[0]}; use indices from 0 to {mdp.states - 1}")
    return chosen.astype(np.int64)


def checked_policy(
    mdp: TabularMDP, policy: ArrayLike | Literal["uniform"], name: str = "policy"
) -> Float64[np.ndarray, "S A"]:
    """A policy as probabilities of available actions.

    Args:
        mdp: the table.
        policy: as in `effective_empowerment`.
        name: what the error calls it.

    Raises:
        ValueError: as `effective_empowerment` says of it.
    """
    available = mdp.available
    if not available.any(axis=1).all():
        state = int(np.flatnonzero(~available.any(axis=1))[0])
        raise ValueError(
            f"state {state} has no action, so that a policy ends there; give it a self-loop"
        )
    if isinstance(policy, str):
        if policy != "uniform":
            raise ValueError(f"{name} is {policy!r}; give 'uniform' or float[S, A]")
        return available / available.sum(axis=1, keepdims=True)
    given = as_array(name, policy)
    wanted = mdp.states, mdp.action_count
    if given.shape != wanted:
        raise ValueError(
            f"{name} has shape {given.shape}; give float[states, actions], here {wanted}"
        )
    chosen = row_stochastic(name, given, "state {}", "states").toarray()
    outside = np.argwhere((chosen > 0) & ~available)
    if len(outside):
        state, action = outside[0]
        raise ValueError(
            f"{name} has {chosen[state, action]:g} for action {action} in state {state}, which is "
            "not available there; give 0"
        )
    return chosen
