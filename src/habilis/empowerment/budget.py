"""Empowerment within a budget: the capacity of a channel whose inputs cost something.

Of the sequences with one outcome the cheapest stands for all. The capacity at a mean cost of at
most B is a concave function of B with, for every price l >= 0 of a unit of cost,

    C(B) <= max over x of (D(P_x || q) - l c_x) + l B           (Blahut 1972)

for any q; the price at which the best inputs just meet the budget closes the bound.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Float64, Int64
from numpy.typing import ArrayLike

from habilis.checks import is_number
from habilis.empowerment.each_step import cheapest, written_out
from habilis.empowerment.limits import Clock, Limits, too_much
from habilis.empowerment.one_step import last_observations, moves_of
from habilis.empowerment.sensors import Sensor
from habilis.mdp import TabularMDP
from habilis.probabilities import as_array

Bits = Float64[np.ndarray, "n"]
Channel = Float64[np.ndarray, "K O"]
Costs = Float64[np.ndarray, "K"]

_LN2 = float(np.log(2))
_HALVINGS = 80
_ROUNDING = 1e-12  # of costs, which are sums


def within_budget(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor,
    actions: Int64[np.ndarray, "A"],
    states: Int64[np.ndarray, "n"],
    each_step: bool,
    cost: ArrayLike | None,
    budget: Any,
    tolerance: float,
    limits: Limits,
    report: Callable[[int, int], None],
) -> tuple[Float64[np.ndarray, "n *budgets"], Float64[np.ndarray, "n *budgets"]]:
    """Empowerment at a mean cost of at most the budget, and its gap, in bits.

    Args:
        mdp, horizon, sensor, actions, states: as in `empowerment`.
        each_step: whether the output is the sequence of observations, and not the last alone.
        cost: float[S, A], 0 or more, of each action in each state.
        budget: one, or several in a sequence.
        tolerance: the gap to reach, in bits.
        limits: on the memory of the beliefs of one state.
        report: hears how many capacities are known, and of how many.

    Returns:
        float64[n], or float64[n, budgets].

    Raises:
        ValueError: another shape of costs, a budget below the cheapest sequence of a state, or
            beliefs that take more memory.
    """
    each, budgets = checked_cost(mdp, cost), checked_budgets(budget)
    seen, moves = last_observations(mdp, sensor), moves_of(mdp.transitions)
    clock = Clock(horizon, limits)
    asked, place = np.unique(states, return_inverse=True)
    bits, gaps = np.zeros((2, len(asked), len(budgets)))
    for number, start in enumerate(asked.tolist()):
        report(number * len(budgets), bits.size)
        if each_step:
            channel, costs = written_out(mdp, sensor, start, horizon, actions, limits, each)
        else:
            channel, costs = priced_channel(mdp, moves, seen, start, horizon, actions, each, limits)
        if not len(costs):
            continue  # no sequence can surely be carried out
        if costs.min() - budgets.min() > _ROUNDING * max(costs.min(), 1.0):
            raise ValueError(
                f"budget is {budgets.min():.12g}, but the cheapest sequence of {horizon} actions "
                f"from states[{list(states).index(start)}] costs {costs.min():.12g}; give at least "
                "that"
            )
        for column, most in enumerate(budgets.tolist()):
            found = capacity_within(channel, costs, most, tolerance * _LN2)
            bits[number, column], gaps[number, column] = np.array(found) / _LN2
            report(number * len(budgets) + column + 1, bits.size)
            clock.check_all((number * len(budgets) + column + 1) / bits.size)
    if np.ndim(budget) == 0:
        bits, gaps = bits[:, 0], gaps[:, 0]
    return bits[place], gaps[place]


def checked_cost(mdp: TabularMDP, cost: ArrayLike | None) -> Float64[np.ndarray, "S A"]:
    """Costs of actions.

    Raises:
        ValueError: another shape, or one below 0 or not finite.
    """
    wanted = mdp.states, mdp.action_count
    given = as_array("cost", [] if cost is None else cost)
    if given.shape != wanted or given.dtype.kind not in "biuf":
        raise ValueError(
            f"cost has shape {given.shape} and type {given.dtype}; give float[states, actions], "
            f"here {wanted}"
        )
    given = given.astype(np.float64)
    bad = np.argwhere(~((given >= 0) & (given < np.inf)))
    if len(bad):
        state, action = bad[0]
        raise ValueError(
            f"cost has {given[state, action]:g} for action {action} in state {state}; give finite "
            "numbers from 0 up"
        )
    return given


def mean_costs(mdp: TabularMDP, cost: ArrayLike, beliefs: Any) -> Float64[np.ndarray, "more A"]:
    """Costs with further rows, of distributions over states: the mean cost of each action."""
    each = checked_cost(mdp, cost)
    return np.concatenate([each, beliefs @ each])


def checked_budgets(budget: Any) -> Float64[np.ndarray, "k"]:
    """Budgets as an array."""
    given = np.atleast_1d(as_array("budget", budget))
    single = given.ndim == 1 and given.dtype.kind in "biuf" and len(given)
    if not single or np.isnan(given.astype(np.float64)).any():
        raise ValueError(f"budget is {budget!r}; give a number, or a sequence of numbers")
    return given.astype(np.float64)


def priced_channel(
    mdp: TabularMDP,
    moves: Any,
    seen: Any,
    start: int,
    horizon: int,
    actions: Int64[np.ndarray, "A"],
    cost: Float64[np.ndarray, "S A"],
    limits: Limits,
) -> tuple[Channel, Costs]:
    """The distinct outcomes of sequences from a state, and the least mean cost of each.

    Without an action there is one outcome, which costs nothing.
    """
    layer, beliefs, costs = np.array([start]), np.ones((1, 1)), np.zeros(1)
    if horizon == 0:
        return np.ones((1, 1)), costs
    for step in range(horizon):
        last = step == horizon - 1
        available = mdp.available[layer]
        rows, prices, columns = [], [], []
        for action in actions.tolist():
            sure = (beliefs[:, ~available[:, action]] == 0).all(axis=1)
            after = (seen if last else moves)[layer * mdp.action_count + action]
            rows.append((beliefs[sure], after))
            prices.append(costs[sure] + beliefs[sure] @ cost[layer, action])
            columns.append(after.indices)
        reached = np.unique(np.concatenate(columns))
        if sum(map(len, prices)) * len(reached) * 8 > limits.gib * 2**30:
            raise too_much(horizon, step, limits)
        mixed = np.concatenate([b @ after[:, reached].toarray() for b, after in rows])
        beliefs, costs = cheapest(mixed, np.concatenate(prices))
        layer = reached
    return beliefs, costs


def capacity_within(
    channel: Channel, cost: Costs, budget: float, tolerance: float
) -> tuple[float, float]:
    """The capacity at a mean cost of at most a budget, and its gap, in nats.

    Args:
        channel: float64[K, O].
        cost: float64[K], of each input; the least is at most the budget, but for rounding.
        budget: B.
        tolerance: the gap to stop at.

    Example:
        >>> nats, gap = capacity_within(np.eye(2), np.array([0.0, 1.0]), 0.11, 1e-9)
        >>> round(float(nats / np.log(2)), 3)  # the entropy of 0.11
        0.5
    """
    from habilis.channels.capacity_solver import best_inputs

    channel = np.ascontiguousarray(channel[:, channel.any(axis=0)])
    rows = np.ascontiguousarray(channel / channel.sum(axis=1, keepdims=True))
    least = float(cost.min())
    spare, above = max(budget - least, 0.0), cost - least
    above[above <= _ROUNDING * max(least, 1.0)] = 0.0
    inputs, found = best_inputs(rows, tolerance / 2)
    if inputs @ above <= spare:
        return found.lower, found.gap
    free = np.flatnonzero(above == 0)
    within = np.zeros(len(cost))
    within[free], _ = best_inputs(_possible(rows[free]), tolerance / 4)
    upper = found.upper
    beyond, low, high = inputs, 0.0, 1.0
    while True:  # a price at which the best inputs keep within the budget
        inputs, found = best_inputs(rows, tolerance / 8, high * above)
        upper = min(upper, found.upper + high * spare)
        if inputs @ above <= spare or high > 1e12:
            within = inputs if inputs @ above <= spare else within
            break
        beyond, low, high = inputs, high, 4 * high
    lower = _mixed(rows, above, within, beyond, spare)
    for _ in range(_HALVINGS):
        if upper - lower <= tolerance:
            break
        price = (low + high) / 2
        inputs, found = best_inputs(rows, tolerance / 8, price * above)
        upper = min(upper, found.upper + price * spare)
        if inputs @ above <= spare:
            within, high = inputs, price
        else:
            beyond, low = inputs, price
        lower = max(lower, _mixed(rows, above, within, beyond, spare))
    return lower, max(upper - lower, 0.0)


def _mixed(rows: Channel, cost: Costs, within: Costs, beyond: Costs, budget: float) -> float:
    """The information of the mixture of two inputs that spends the budget."""
    less, more = float(within @ cost), float(beyond @ cost)
    share = (budget - less) / (more - less) if more > less else 0.0
    inputs = within + min(max(share, 0.0), 1.0) * (beyond - within)
    outputs = np.maximum(inputs @ rows, 1e-300)
    terms = np.where(rows > 0, rows * np.log(np.maximum(rows, 1e-300) / outputs), 0.0)
    return max(float(inputs @ terms.sum(axis=1)), 0.0)


def _possible(rows: Channel) -> Float64[np.ndarray, "K o"]:
    return np.ascontiguousarray(rows[:, rows.any(axis=0)])


def is_budgeted(cost: ArrayLike | None, budget: Any) -> bool:
    """Whether there are costs and a budget.

    Raises:
        ValueError: one without the other.
    """
    if (cost is None) != (budget is None):
        has, lacks = ("cost", "budget") if budget is None else ("budget", "cost")
        raise ValueError(f"{has} is given without {lacks}; give both, or neither")
    if budget is not None and np.ndim(budget) == 0 and not is_number(budget):
        raise ValueError(f"budget is {budget!r}; give a number, or a sequence of numbers")
    return cost is not None
