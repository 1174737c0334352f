"""Effective empowerment: one action's influence on a random later observation, under a policy.

The channel from the action A in state s to the observation K steps later, K geometric and itself
not observed, all later actions by the policy. With T the transition matrix under the policy and E
the probabilities of what is observed after one step under it, the discounted observations

    N = (1 - g) E + g T N,     g the discount,

are the solution of a linear system. Its residual bounds the total variation distance from it in
every state, and is the certificate.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np
from jaxtyping import Float64, Int64
from numpy.typing import ArrayLike

from habilis.channels.bounds import information_error
from habilis.channels.capacity import warn_of_gap
from habilis.checks import is_number
from habilis.empowerment.arguments import (
    Unit,
    check_table,
    checked_policy,
    chosen_states,
    per_bit,
    positive,
    whole_number,
)
from habilis.empowerment.combined import check_single
from habilis.empowerment.limits import Progress
from habilis.empowerment.one_step import last_observations, moves_of
from habilis.empowerment.sensors import Sensor, is_by_action, observation_probabilities
from habilis.mdp import TabularMDP
from habilis.probabilities import shape_of
from habilis.processors import processors
from habilis.progress import in_percent, progress_bar

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Bits = Float64[np.ndarray, "n"]

_MOST = 10**12  # products for the steps before the first, at most: minutes
_BLOCK = 32_000_000  # numbers of the discounted observations that are worked on at once
_LN2 = float(np.log(2))


@dataclass(frozen=True)
class _Channel:
    """The channel of every state, as sparse matrices with a row for each state and action.

    Attributes:
        moves: float64[S * A, S], the probabilities of next states.
        seen: float64[S * A, O], of what is observed in them.
        under: float64[S, S], the probabilities of next states under the policy.
        mean: float64[S, O], of what is observed in them.
        at_once: float64[S, O], what is observed without any action.
        discount: g.
        first_step: the least number of steps.
    """

    moves: "csr_array"
    seen: "csr_array"
    under: "csr_array"
    mean: "csr_array"
    at_once: "csr_array"
    discount: float
    first_step: int


@overload
def effective_empowerment(
    mdp: TabularMDP,
    policy: ArrayLike | Literal["uniform"],
    discount: float,
    sensor: Sensor = ...,
    states: Any = ...,
    first_step: int = ...,
    maximise: bool = ...,
    *,
    tolerance: float = ...,
    return_gap: Literal[False] = ...,
    unit: Unit = ...,
    show_progress: bool = ...,
) -> Bits: ...


@overload
def effective_empowerment(
    mdp: TabularMDP,
    policy: ArrayLike | Literal["uniform"],
    discount: float,
    sensor: Sensor = ...,
    states: Any = ...,
    first_step: int = ...,
    maximise: bool = ...,
    *,
    tolerance: float = ...,
    return_gap: Literal[True],
    unit: Unit = ...,
    show_progress: bool = ...,
) -> tuple[Bits, Bits]: ...


def effective_empowerment(
    mdp: TabularMDP,
    policy: ArrayLike | Literal["uniform"],
    discount: float,
    sensor: Sensor = "state",
    states: Any = None,
    first_step: int = 1,
    maximise: bool = False,
    *,
    tolerance: float = 1e-6,
    return_gap: bool = False,
    unit: Unit = "bits",
    show_progress: bool = False,
) -> Bits | tuple[Bits, Bits]:
    """The influence of one action on later observations, under a policy.

    The mutual information of an action and the observation K steps later,

        E(s) = I(A_t; O_(t+K) | s_t = s),   P(K = k) = (1 - g) g^(k - first_step), k >= first_step,

    with A_t drawn from the policy at s, all actions after it by the policy, and K not observed
    (Myers et al. 2024; Song, Gore and Kleiman-Weiner 2025). Unlike empowerment it depends on what
    the agent does; it is at most the entropy of the policy at s. With `maximise` it is the
    capacity over the distribution of A_t alone. Dynamics go on in terminal states.

    Args:
        mdp: a table with an action in every state.
        policy: float[S, A], the probabilities of actions in each state, as `run.policy()` gives
            those of a trained agent; or "uniform", over the available ones.
        discount: g, from 0 up to but not 1. At 0 the observation is that after `first_step` steps.
        sensor: as in `empowerment`, but one alone.
        states: the n states asked about, as indices or as bool[S]; by default all.
        first_step: the least number of steps until the observation, from 0 up.
        maximise: whether A_t is drawn from its best distribution over the available actions.
        tolerance: the gap to reach, in `unit`.
        return_gap: whether to return the certificate too.
        unit: "bits" or "nats", of values, gaps and tolerance.
        show_progress: whether to draw a progress bar on standard error, once it takes two seconds.

    Returns:
        float64[n]; with `return_gap` also float64[n], by how much the true value may differ at
        most.

    Raises:
        ValueError: a policy that is not one distribution over available actions a state, a
            discount outside [0, 1), a state without actions, a `first_step` that takes more than
            10^12 products, or what `empowerment` refuses.

    Warns:
        ConvergenceWarning: a gap is above the tolerance.

    Example:
        >>> ring = TabularMDP.deterministic([[(s - 1) % 9, (s + 1) % 9] for s in range(9)])
        >>> effective_empowerment(ring, "uniform", discount=0.0, states=[0])
        array([1.])
        >>> effective_empowerment(ring, "uniform", discount=0.9, states=[0]).round(3)
        array([0.071])
    """
    check_table(mdp)
    if not is_number(discount) or not 0 <= discount < 1:
        raise ValueError(f"discount is {discount!r}; give a number from 0 up to but not 1")
    first_step, scale = whole_number("first_step", first_step), per_bit(unit)
    tolerance = positive("tolerance", tolerance) / scale
    starts, chosen = chosen_states(mdp, states), checked_policy(mdp, policy)
    channel = _channel_of(mdp, chosen, sensor, float(discount), first_step)
    outputs = shape_of(channel.seen)[1]
    effort = first_step * (channel.moves.nnz * outputs + 10**5)
    if effort > _MOST:
        raise ValueError(
            f"first_step is {first_step:,}, whose steps take {effort:.1e} products, above "
            f"{_MOST:.0e}; give fewer steps, or a coarser sensor"
        )
    distance = _distance_of(tolerance / 2, outputs)
    with progress_bar("effective empowerment", show_progress) as bar:
        some = starts, distance, in_percent(bar)
        if maximise:
            bits, gap, off = _capacities(channel, mdp.available, *some, tolerance)
        else:
            bits, off = _informations(channel, chosen, *some)
            gap = np.zeros(len(starts))
    if discount > 0:  # half of the distance is for rows that do not quite sum to 1
        gap = gap + information_error(max(distance, off + distance / 2), outputs)
    if (gap > tolerance).any():
        warn_of_gap(float(gap.max()), tolerance)
    return (bits * scale, gap * scale) if return_gap else bits * scale


def _channel_of(
    mdp: TabularMDP,
    policy: Float64[np.ndarray, "S A"],
    sensor: Sensor,
    discount: float,
    first_step: int,
) -> _Channel:
    from scipy.sparse import csr_array

    states, actions = policy.shape
    check_single(mdp, sensor)
    if not is_by_action(sensor):
        at_once = observation_probabilities(mdp, sensor)
    elif first_step > 0:
        at_once = csr_array((states, np.shape(sensor)[2]))
    else:
        raise ValueError(
            "first_step is 0, but the sensor shows nothing before an action; give 1 or more"
        )
    first = np.arange(0, states * actions + 1, actions)
    choice = csr_array((policy.ravel(), np.arange(states * actions), first))
    moves, seen = moves_of(mdp.transitions), last_observations(mdp, sensor)
    under, mean = csr_array(choice @ moves), csr_array(choice @ seen)
    return _Channel(moves, seen, under, mean, at_once, discount, first_step)


def _distance_of(bits: float, outputs: int) -> float:
    """A total variation distance that changes I by at most so many bits."""
    low, high = 0.0, 0.5
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if information_error(middle, outputs) <= bits else (low, middle)
    return low


def _discounted(
    channel: _Channel, columns: slice, distance: float, report: Progress
) -> tuple[Float64[np.ndarray, "S O"], float]:
    """The part of N for some observations, and by what total variation distance it is off."""
    from habilis.empowerment.tabular.policies import discounted

    emitted: Any = channel.mean[:, columns]
    found, off = np.asarray(emitted.toarray()), 0.0
    if channel.discount > 0:
        # Half the distance: rows that do not quite sum to 1 cost less than the other half. And a
        # little less than half, so that the bound on what is reached is not above it by rounding.
        share = 0.49 * distance * found.shape[1] / shape_of(channel.mean)[1]
        found, off = discounted(channel.under, found, channel.discount, max(share, 1e-300), report)
    for _ in range(max(channel.first_step - 2, 0)):
        found = _after_a_step(channel.under, found)
    return found, off


def _after_a_step(
    under: "csr_array", found: Float64[np.ndarray, "S O"]
) -> Float64[np.ndarray, "S O"]:
    """The product of both."""
    from habilis.empowerment.tabular.policies import add_product

    product = np.zeros_like(found)
    arguments = (under.indptr, under.indices, under.data, found, 1.0, product)
    _split(partial(_in_range, add_product, arguments), len(product))
    return product


def _in_range(
    kernel: Callable[..., None], arguments: tuple[Any, ...], rows: tuple[int, int]
) -> None:
    kernel(*arguments, *rows)


def _split(some: Callable[[tuple[int, int]], None], count: int) -> None:
    """Calls a function with ranges of rows, in as many threads as there are processors."""
    workers = processors() if count >= 4096 else 1
    edges = np.linspace(0, count, 1 + workers * (4 if workers > 1 else 1)).astype(int)
    ranges = list(zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True))
    if workers == 1:
        for one in ranges:
            some(one)
        return
    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(some, ranges))


def _of_part(report: Progress, before: float, part: float, share: float) -> None:
    """Reports a share of a part of the whole."""
    report(before + part * share)


def _weights(channel: _Channel) -> tuple[float, float, float]:
    """The weights in a row of the channel of O at once, after one step, and of N after one."""
    g = channel.discount
    if channel.first_step == 0:
        return 1 - g, g * (1 - g), g * g
    if channel.first_step == 1:
        return 0.0, 1 - g, g
    return 0.0, 0.0, 1.0


def _informations(
    channel: _Channel,
    policy: Float64[np.ndarray, "S A"],
    starts: Int64[np.ndarray, "n"],
    distance: float,
    report: Progress,
) -> tuple[Bits, float]:
    """I(A; O) with the action drawn from the policy, and by what distance N is off.

    It is a sum over observations, some at a time.
    """
    from habilis.empowerment.tabular.policies import add_information

    states, outputs = shape_of(channel.at_once)
    width = max(_BLOCK // states, 1)
    nats, off = np.zeros(len(starts)), 0.0
    for first in range(0, outputs, width):
        columns = slice(first, min(first + width, outputs))
        share = partial(_of_part, report, first / outputs, (columns.stop - first) / outputs)
        found, more = _discounted(channel, columns, distance, share)
        given, off = _arguments(channel, found, columns), off + more
        _split(partial(_in_range, add_information, (*given, policy, starts, nats)), len(starts))
    return np.maximum(nats, 0) / _LN2, off


def _capacities(
    channel: _Channel,
    available: np.ndarray,
    starts: Int64[np.ndarray, "n"],
    distance: float,
    report: Progress,
    tolerance: float,
) -> tuple[Bits, Bits, float]:
    """The capacity over the distribution of the action, its gap, and by what N is off."""
    from habilis.channels.capacity_solver import best_inputs
    from habilis.empowerment.tabular.policies import add_capacity, channel_row

    outputs = shape_of(channel.at_once)[1]
    columns, share = slice(0, outputs), partial(_of_part, report, 0.0, 0.5)
    found, off = _discounted(channel, columns, distance, share)
    given = _arguments(channel, found, columns)
    report(0.5)
    lower, upper = np.zeros(len(starts)), np.zeros(len(starts))
    sought = tolerance * _LN2 / 2

    arguments = (*given, available, starts, sought, lower, upper)
    _split(partial(_in_range, add_capacity, arguments), len(starts))
    for place in np.flatnonzero(upper - lower > sought).tolist():  # few: those near to a tie
        usable = np.flatnonzero(available[starts[place]])
        rows = np.zeros((len(usable), outputs))
        for row, action in zip(rows, usable.tolist(), strict=True):
            arguments: Any = (*given, int(starts[place]), action, available.shape[1], row)
            channel_row(*arguments)
        rows = np.ascontiguousarray(rows[:, rows.any(axis=0)])
        _, found = best_inputs(rows, sought)
        if found.gap < upper[place] - lower[place]:
            lower[place], upper[place] = found.lower, max(found.upper, found.lower)
    return lower / _LN2, np.maximum(upper - lower, 0) / _LN2, off


def _arguments(
    channel: _Channel, discounted: Float64[np.ndarray, "S O"], columns: slice
) -> tuple[Any, ...]:
    """A channel's rows for some observations, as the kernels read them."""
    moves, seen, at_once = channel.moves, channel.seen[:, columns], channel.at_once[:, columns]
    return (
        (at_once.indptr, at_once.indices, at_once.data),
        (seen.indptr, seen.indices, seen.data),
        (moves.indptr, moves.indices, moves.data),
        discounted,
        np.array(_weights(channel)),
    )
