"""Empowerment where the output is the sequence of observations, one after each action.

Without noise the channel is noiseless, and what counts is the number of sequences of observations
that some sequence of actions produces. Of the states that are possible after some observations only
the set matters: with succ(X) the successors of the states in X,

    N_0(X) = 1,    N_h(X) = sum over o of N_(h-1)(those states of succ(X) that show o),

as in the determinisation of an automaton. With noise, the channel is written out: a row for each
sequence of actions, a column for each sequence of observations that is possible.
"""

import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from jaxtyping import Float64, Int32, Int64

from habilis.empowerment.limits import Clock, Limits, too_much
from habilis.empowerment.one_step import moves_of
from habilis.empowerment.sensors import (
    Sensor,
    is_by_action,
    is_noisy,
    observation_probabilities,
    observations,
)
from habilis.mdp import TabularMDP

Bits = Float64[np.ndarray, "n"]
Channel = Float64[np.ndarray, "K O"]
Costs = Float64[np.ndarray, "K"]

_LN2 = float(np.log(2))
_DIGITS = 12  # to which rows are compared
_SETS = 2_000_000  # of states that are remembered, at most


def of_trajectories(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor,
    actions: Int64[np.ndarray, "A"],
    states: Int64[np.ndarray, "n"],
    tolerance: float,
    limits: Limits,
    report: Callable[[int, int], None],
) -> tuple[Bits, Bits]:
    """Empowerment over sequences of observations, and its gap, in bits.

    Args:
        mdp, horizon, sensor, actions, states: as in `empowerment`.
        tolerance: the gap to reach, in bits.
        limits: on the memory of the channel of one state.
        report: hears how many states, or steps of all of them, are done, and of how many.

    Raises:
        ValueError: a channel, or the sets of states, that take more memory.
    """
    from habilis.channels.capacity_solver import best_inputs

    clock = Clock(horizon, limits)
    asked, place = np.unique(states, return_inverse=True)
    bits, gaps = np.zeros((2, len(asked)))
    if not mdp.is_stochastic and not is_noisy(sensor):
        labels, _ = observations(mdp, sensor)
        table = np.ascontiguousarray(mdp.next_state[:, actions])
        bits = _counted(table, labels, asked, horizon, limits, report)
    else:
        for number, start in enumerate(asked.tolist()):
            report(number, len(asked))
            rows, _ = written_out(mdp, sensor, start, horizon, actions, limits)
            if len(rows) > 1 and rows.shape[1] > 1:
                _, found = best_inputs(rows, tolerance * _LN2)
                bits[number], gaps[number] = found.lower / _LN2, found.gap / _LN2
            clock.check_all((number + 1) / len(asked))
    return bits[place], gaps[place]


def _counted(
    table: Int32[np.ndarray, "S A"],
    labels: Int32[np.ndarray, "S"],
    states: Int64[np.ndarray, "n"],
    horizon: int,
    limits: Limits,
    report: Callable[[int, int], None],
) -> Bits:
    """The logarithm of the number of sequences of observations."""
    kept = 0

    @cache
    def after(possible: frozenset[int]) -> list[frozenset[int]]:
        nonlocal kept
        kept += 1
        if kept > _SETS:
            raise too_much(horizon, -1, limits)
        reached = np.unique(table[list(possible)])
        reached = reached[reached >= 0]
        groups: dict[int, list[int]] = {}
        for state, label in zip(reached.tolist(), labels[reached].tolist(), strict=True):
            groups.setdefault(label, []).append(state)
        return [frozenset(group) for group in groups.values()]

    starts = [frozenset([state]) for state in states.tolist()]
    layers = [set(starts)]
    for step in range(horizon):
        report(step, horizon)
        layers.append({part for one in layers[-1] for part in after(one)})
    count: dict[frozenset[int], int] = dict.fromkeys(layers[-1], 1)
    for layer in reversed(layers[:-1]):
        count = {one: sum(count[part] for part in after(one)) for one in layer}
    return np.array([math.log2(max(count[one], 1)) for one in starts])


def written_out(
    mdp: TabularMDP,
    sensor: Sensor,
    start: int,
    horizon: int,
    actions: Int64[np.ndarray, "A"],
    limits: Limits,
    cost: Float64[np.ndarray, "S A"] | None = None,
) -> tuple[Channel, Costs]:
    """The channel from sequences of actions to sequences of observations.

    Returns:
        Its distinct rows, and the least mean cost of each.
    """
    seen, moves = observation_probabilities(mdp, sensor), moves_of(mdp.transitions)
    by_action = is_by_action(sensor)
    layer, held = np.array([start]), np.ones((1, 1, 1))  # [sequences, histories, states]
    costs = np.zeros(1)
    for step in range(horizon):
        available = mdp.available[layer]
        possible = held.sum(axis=1) > 0
        parts: list[Any] = []
        prices = []
        columns = [moves[layer * mdp.action_count + a].indices for a in actions.tolist()]
        reached = np.unique(np.concatenate(columns))
        shown = seen[reached] if not by_action else None
        outputs = np.unique(
            np.concatenate(
                [seen[reached + (a * mdp.states if by_action else 0)].indices for a in actions]
            )
        )
        size = held.shape[0] * len(actions) * held.shape[1] * len(outputs) * len(reached) * 8
        if size > limits.gib * 2**30:
            raise too_much(horizon, step, limits)
        for action in actions.tolist():
            sure = ~(possible & ~available[:, action]).any(axis=1)
            after = moves[layer * mdp.action_count + action][:, reached].toarray()
            of = seen[reached + action * mdp.states] if shown is None else shown
            through = of[:, outputs].toarray()  # [states, observations]
            came = held[sure] @ after
            price = np.zeros(len(layer)) if cost is None else cost[layer, action]
            prices.append(costs[sure] + held[sure].sum(axis=1) @ price)
            shape = len(came), came.shape[1] * len(outputs), len(reached)
            parts.append((came[:, :, None, :] * through.T).reshape(shape))
        held, costs = np.concatenate(parts), np.concatenate(prices)
        held = np.ascontiguousarray(held[:, held.any(axis=(0, 2))])
        layer = reached
    return cheapest(held.sum(axis=2), costs)


def cheapest(
    rows: Channel, costs: Costs
) -> tuple[Float64[np.ndarray, "k O"], Float64[np.ndarray, "k"]]:
    """Distinct rows, each with its least cost."""
    if not len(rows):
        return rows, costs
    _, first, group = np.unique(
        np.round(rows, _DIGITS), axis=0, return_index=True, return_inverse=True
    )
    least = np.full(len(first), np.inf)
    np.minimum.at(least, group.ravel(), costs)
    return rows[first], least
