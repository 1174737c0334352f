"""Empowerment: the capacity of the channel from the next h actions to the sensor."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float64, Int32, Int64
from numpy.typing import ArrayLike

from habilis.empowerment.sensors import Sensor, observations
from habilis.mdp import TabularMDP
from habilis.probabilities import as_array

_MOST_PACKED_LABELS = 4096  # above, sets of states cost less than 64 words a state


def empowerment(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor = "state",
    actions: Sequence[int] | None = None,
    states: ArrayLike | None = None,
) -> Float64[np.ndarray, "n"]:
    """The h-step empowerment of states, in bits.

    In a deterministic MDP the channel is noiseless, and its capacity is

        E_h(s) = log2 |O_h(s)|,

    the number of observations that some sequence of h actions leads to (Salge, Glackin and
    Polani 2014; equation 2 of Rasheed, Polani and Catenacci Volpi 2023). Terminal states do
    not stop the counted sequences.

    Args:
        mdp: the table.
        horizon: h, how many actions, 0 or more.
        sensor: "state" (fully observable empowerment), a factor's name ("object" for object
            empowerment), or int[S] labels.
        actions: the action indices that sequences are made of; by default all.
        states: the n states asked about, as indices or as bool[S]; by default all, in order.

    Returns:
        float64[n], bits.

    Raises:
        ValueError: a horizon that is not a whole number from 0 up, an unknown sensor, no
            actions, or an action or state that the MDP does not have.

    Example:
        >>> mdp = TabularMDP.deterministic([[0, 1], [1, 0]])
        >>> empowerment(mdp, horizon=3)
        array([1., 1.])
    """
    # Numba takes as long to import as everything else together: only who computes pays.
    from habilis.empowerment.counting import count_backward, count_forward

    horizon = whole_number("horizon", horizon)
    labels, label_count = observations(mdp, sensor)
    table = _chosen_actions(mdp, actions)
    starts = _chosen_states(mdp, states)
    if label_count > _MOST_PACKED_LABELS:
        return np.log2(count_forward(table, labels, label_count, horizon, starts))
    if states is None:
        return np.log2(count_backward(table, labels, label_count, horizon))
    near, table, place = _neighbourhood(table, starts, horizon)
    return np.log2(count_backward(table, labels[near], label_count, horizon)[place])


def whole_number(name: str, value: int) -> int:
    """`value` if it is an integer from 0 up, else a ValueError that names it."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 0:
        raise ValueError(f"{name} is {value!r}; give a whole number from 0 up")
    return int(value)


def _chosen_actions(mdp: TabularMDP, actions: Sequence[int] | None) -> Int32[np.ndarray, "S A"]:
    if actions is None:
        return mdp.next_state
    chosen = as_array("actions", actions)
    count = mdp.action_count
    if chosen.ndim != 1 or not len(chosen) or not np.issubdtype(chosen.dtype, np.integer):
        raise ValueError(
            f"actions has shape {chosen.shape} and type {chosen.dtype}; "
            "give a list of action indices, at least one"
        )
    outside = chosen[(chosen < 0) | (chosen >= count)]
    if len(outside):
        raise ValueError(f"actions has {outside[0]}; use indices from 0 to {count - 1}")
    return np.ascontiguousarray(mdp.next_state[:, np.unique(chosen)])


def _chosen_states(mdp: TabularMDP, states: ArrayLike | None) -> Int64[np.ndarray, "n"]:
    if states is None:
        return np.arange(mdp.states)
    chosen = np.atleast_1d(as_array("states", states))
    if chosen.dtype == bool and chosen.shape == (mdp.states,):
        return np.flatnonzero(chosen)
    if chosen.size == 0:
        return np.empty(0, np.int64)
    if chosen.ndim != 1 or not np.issubdtype(chosen.dtype, np.integer):
        raise ValueError(
            f"states has shape {chosen.shape} and type {chosen.dtype}; "
            "give state indices, or one bool a state"
        )
    outside = chosen[(chosen < 0) | (chosen >= mdp.states)]
    if len(outside):
        raise ValueError(f"states has {outside[0]}; use indices from 0 to {mdp.states - 1}")
    return chosen.astype(np.int64)


def _neighbourhood(
    table: Int32[np.ndarray, "S A"], starts: Int64[np.ndarray, "n"], horizon: int
) -> tuple[Int64[np.ndarray, "N"], Int32[np.ndarray, "N A"], Int64[np.ndarray, "n"]]:
    """The part of the table that h actions from the starts can touch.

    Returns:
        The N states reached within h actions, the table over them alone (states on the rim,
        whose successors no longer matter, stay where they are), and the starts' places in it.
    """
    reached = np.zeros(len(table), bool)
    reached[starts] = True
    frontier = np.unique(starts)
    for _ in range(horizon):
        successors = np.unique(table[frontier])
        frontier = successors[~reached[successors]]
        if not len(frontier):
            break
        reached[frontier] = True
    near = np.flatnonzero(reached)
    place = np.full(len(table), -1, np.int32)
    place[near] = np.arange(len(near), dtype=np.int32)
    small = place[table[near]]
    rim = small < 0
    small[rim] = np.nonzero(rim)[0]
    return near, small, place[starts].astype(np.int64)
