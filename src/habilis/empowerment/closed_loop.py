"""Closed-loop empowerment: the capacity of the channel from feedback policies to the sensor.

Inputs are deterministic policies of state and time, P_pi(o | s) what the sensor shows after h steps
of one. Policies that remember more add nothing: with a randomised choice of such a policy, the
probabilities of state, time and action, and so of what is observed, are mixtures of those of
policies of state and time (Puterman 1994, theorem 5.5.1).

For any distribution over some policies, with q its mixture of observations,

    I(p)  <=  C  <=  max over all policies of D(P_pi || q)          (Blahut 1972; Arimoto 1972).

The left side grows as policies with a large divergence are added. The maximum on the right is that
of a convex function, a sum over observations, over the polytope of all P_pi: branch and bound finds
it. In a box l <= P(o) <= u every term p log(p / q) is at most its chord from l to u. The sum of
the chords is linear in the policy, and its maximum under the constraints of the box a linear
program over the probabilities of state, time and action. Halving boxes closes the difference.
"""

import heapq
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np
from jaxtyping import Float64, Int64
from numpy.typing import ArrayLike

from habilis.channels.capacity import warn_of_gap
from habilis.channels.capacity_solver import best_inputs
from habilis.empowerment.api import Options, empowerment
from habilis.empowerment.arguments import (
    Unit,
    at_least_one,
    check_table,
    chosen_actions,
    chosen_states,
    per_bit,
    positive,
    whole_number,
)
from habilis.empowerment.combined import check_single
from habilis.empowerment.one_step import last_observations, moves_of
from habilis.empowerment.sensors import Sensor, is_noisy
from habilis.mdp import TabularMDP
from habilis.probabilities import shape_of
from habilis.progress import progress_bar

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Bits = Float64[np.ndarray, "n"]
Row = Float64[np.ndarray, "O"]

_LN2 = float(np.log(2))
_ROUNDS = 500  # of policies that are added
_TINY = 1e-12


@dataclass(frozen=True)
class _Steps:
    """What h steps from one state can do.

    Attributes:
        owner: for each step, int64[K], of each pair of a state and an action there the state's
            place in the layer.
        moves: for each step, float64[K, N], where the pairs lead: to the states of the next layer,
            after the last step to observations.
        sizes: the number of states of each layer.
    """

    owner: tuple[Int64[np.ndarray, "K"], ...]
    moves: "tuple[csr_array, ...]"
    sizes: tuple[int, ...]

    def best(self, payoff: Row) -> Row:
        """The observations of a deterministic policy whose mean payoff is the largest."""
        value, chosen = payoff, []
        for owner, moves, size in zip(
            reversed(self.owner), reversed(self.moves), reversed(self.sizes), strict=True
        ):
            each = moves @ value
            order = np.lexsort((-each, owner))
            first = order[np.searchsorted(owner[order], np.arange(size))]
            chosen.append(first)
            value = each[first]
        return self.followed(chosen[::-1])

    def followed(self, chosen: list[Int64[np.ndarray, "n"]]) -> Row:
        """The observations of a deterministic policy, by the pair of each state."""
        weights = np.ones(1)
        for pairs, moves in zip(chosen, self.moves, strict=True):
            weights = moves[pairs].T @ weights
        return np.asarray(weights)

    def extremes(self) -> tuple[Row, Row]:
        """The least and the largest probability of each observation, over all policies."""
        least, most = self.moves[-1].toarray(), self.moves[-1].toarray()
        for step in reversed(range(len(self.owner))):
            edges = np.searchsorted(self.owner[step], np.arange(self.sizes[step]))
            least = np.minimum.reduceat(least, edges)
            most = np.maximum.reduceat(most, edges)
            if step:
                least, most = self.moves[step - 1] @ least, self.moves[step - 1] @ most
        return least[0], most[0]


@overload
def closed_loop_empowerment(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor = ...,
    states: Any = ...,
    return_gap: Literal[False] = ...,
    *,
    actions: ArrayLike | None = ...,
    tolerance: float = ...,
    max_boxes: int = ...,
    unit: Unit = ...,
    show_progress: bool = ...,
) -> Bits: ...


@overload
def closed_loop_empowerment(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor = ...,
    states: Any = ...,
    *,
    return_gap: Literal[True],
    actions: ArrayLike | None = ...,
    tolerance: float = ...,
    max_boxes: int = ...,
    unit: Unit = ...,
    show_progress: bool = ...,
) -> tuple[Bits, Bits]: ...


def closed_loop_empowerment(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor = "state",
    states: Any = None,
    return_gap: bool = False,
    *,
    actions: ArrayLike | None = None,
    tolerance: float = 1e-6,
    max_boxes: int = 2000,
    unit: Unit = "bits",
    show_progress: bool = False,
) -> Bits | tuple[Bits, Bits]:
    """The capacity of the channel from h-step feedback policies to the sensor.

    As `empowerment`, but the agent looks at the state after every step: the inputs are the
    deterministic policies of state and time,

        C_h(s) = max over p(pi) of I(pi; O_h | s)

    what variational intrinsic control (Gregor, Rezende and Wierstra 2016) approximates from below.
    It is never less than open-loop empowerment, and equal to it in deterministic models.

    Args:
        mdp: the table.
        horizon: h, how many actions, 0 or more.
        sensor: as in `empowerment`, one alone.
        states: the n states asked about, as indices or as bool[S]; by default all.
        return_gap: whether to return the certificate too.
        actions: the action indices that policies choose from; by default all.
        tolerance: the gap to reach, in `unit`.
        max_boxes: how many linear programs to solve for one upper bound; where they do not
            suffice, the gap is larger.
        unit: "bits" or "nats", of values, gaps and tolerance.
        show_progress: whether to draw a progress bar on standard error, once it takes two seconds.

    Returns:
        float64[n]; with `return_gap` also float64[n], a proven upper bound on how much larger the
        true value is.

    Raises:
        ValueError: as in `empowerment`; or a policy can come to a state without actions.

    Warns:
        ConvergenceWarning: a gap is above the tolerance.

    Example:
        >>> ring = TabularMDP.deterministic([[(s - 1) % 5, (s + 1) % 5] for s in range(5)])
        >>> closed_loop_empowerment(ring.slippery(0.2), 2, states=[0]).round(3)
        array([0.887])
        >>> empowerment(ring.slippery(0.2), 2, states=[0]).round(3)
        array([0.804])
    """
    check_table(mdp)
    horizon, scale = whole_number("horizon", horizon), per_bit(unit)
    tolerance = positive("tolerance", tolerance) / scale
    at_least_one("max_boxes", max_boxes)
    used, starts = chosen_actions(mdp, actions), chosen_states(mdp, states)
    if horizon == 0 or (not mdp.is_stochastic and not is_noisy(sensor)):
        some: Options = {"unit": unit, "show_progress": show_progress}
        bits = empowerment(mdp, horizon, sensor, used, starts, **some)
        return (bits, np.zeros(len(bits))) if return_gap else bits
    check_single(mdp, sensor)
    moves, seen = moves_of(mdp.transitions), last_observations(mdp, sensor)
    asked, place = np.unique(starts, return_inverse=True)
    found = np.zeros((len(asked), 2))
    with progress_bar("states", show_progress) as report:
        for number, start in enumerate(asked.tolist()):
            steps = _steps_of(mdp, moves, seen, start, horizon, used)
            found[number] = _capacity(steps, tolerance * _LN2, max_boxes)
            report(number + 1, len(asked))
    lower, upper = (found[place] / _LN2).T
    gap = np.maximum(upper - lower, 0)
    if (gap > tolerance).any():
        warn_of_gap(float(gap.max()), tolerance)
    return (lower * scale, gap * scale) if return_gap else lower * scale


def possible_observations(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor,
    states: Int64[np.ndarray, "n"],
    actions: Int64[np.ndarray, "A"],
) -> list[int]:
    """The number of observations that are possible from each state; the cost grows fast with it."""
    moves, seen = moves_of(mdp.transitions), last_observations(mdp, sensor)
    if horizon == 0:
        return [1] * len(states)
    return [
        shape_of(_steps_of(mdp, moves, seen, start, horizon, actions).moves[-1])[1]
        for start in states.tolist()
    ]


def _steps_of(
    mdp: TabularMDP,
    moves: "csr_array",
    seen: "csr_array",
    start: int,
    horizon: int,
    actions: Int64[np.ndarray, "A"],
) -> _Steps:
    """The states that can be reached, layer by layer.

    Raises:
        ValueError: one of them has no action.
    """
    layer, owners, matrices, sizes = np.array([start]), [], [], []
    for step in range(horizon):
        available = mdp.available[np.ix_(layer, actions)]
        if not available.any(axis=1).all():
            state = int(layer[~available.any(axis=1)][0])
            raise ValueError(
                f"state {state}, which a policy from state {start} can reach before step "
                f"{step + 1}, has none of the actions; give it a self-loop, or a shorter horizon"
            )
        owner, action = np.nonzero(available)
        pairs = layer[owner] * mdp.action_count + actions[action]
        owners.append(owner)
        sizes.append(len(layer))
        rows = (moves if step < horizon - 1 else seen)[pairs]
        layer = np.unique(rows.indices)
        matrices.append(rows[:, layer])
    return _Steps(tuple(owners), tuple(matrices), tuple(sizes))


def _capacity(steps: _Steps, tolerance: float, max_boxes: int) -> tuple[float, float]:
    """Bounds on the capacity, in nats."""
    least, most = steps.extremes()
    outputs = len(most)
    if outputs == 1:
        return 0.0, 0.0
    rows = np.unique(np.array([steps.best(payoff) for payoff in np.eye(outputs)]), axis=0)
    program = _program(steps)
    upper, lower = np.inf, 0.0
    for _ in range(_ROUNDS):
        inputs, found = best_inputs(np.ascontiguousarray(rows), tolerance / 4)
        lower = max(lower, found.lower)
        q = np.maximum(inputs @ rows, 1e-300)
        enough = found.lower + tolerance / 2
        row, bound = _largest_divergence(steps, program, q, (least, most), enough, max_boxes)
        upper = min(upper, max(bound, found.upper))
        if upper - lower <= tolerance or _divergence(row, q) <= enough:
            break
        used = inputs > _TINY
        rows = np.unique(np.concatenate([rows[used], row[None]]), axis=0)
    return lower, max(upper, lower)


def _divergence(p: Row, q: Row) -> float:
    return float(_terms(p, q).sum())


def _terms(p: Row, q: Row) -> Row:
    return np.where(p > 0, p * (np.log(np.maximum(p, 1e-300)) - np.log(q)), 0.0)


def _largest_divergence(
    steps: _Steps,
    program: Callable[[Row, Row, Row], tuple[float, Row] | None],
    q: Row,
    box: tuple[Row, Row],
    enough: float,
    max_boxes: int,
) -> tuple[Row, float]:
    """A policy of large divergence from q, and an upper bound on all.

    Stops as soon as a policy is clearly above `enough`, whose bound is then not tight, or none is
    above it.
    """
    best, largest = steps.best(-np.log(q)), -np.inf

    def improve(p: Row) -> None:
        """From a point of the polytope uphill, policy by policy: a convex function's steps rise."""
        nonlocal best, largest
        value = -np.inf
        while True:
            p = steps.best(np.log(np.maximum(p, 1e-9)) - np.log(q))
            after = _divergence(p, q)
            if after <= value + _TINY:
                break
            value = after
        if value > largest:
            best, largest = p, value

    for p in (best, *np.eye(len(q))):
        improve(p)
    boxes, count = _bounded([], program, q, *box, 0), 1
    while boxes and -boxes[0][0] > max(enough, largest + _TINY) and count < max_boxes:
        if largest > enough + 1e-9 and count > 1:
            break
        _, _, p, low, high = heapq.heappop(boxes)
        improve(p)
        loose = _chords(low, high, q)(p) - _terms(p, q)
        o = int(loose.argmax())
        width = high[o] - low[o]
        cut = p[o] if 0.1 * width < p[o] - low[o] < 0.9 * width else (low[o] + high[o]) / 2
        for side in (0, 1):
            inside = low.copy(), high.copy()
            inside[1 - side][o] = cut
            boxes = _bounded(boxes, program, q, *inside, 2 * count + side)
        count += 2
    return best, max(largest, -boxes[0][0] if boxes else largest)


def _chords(low: Row, high: Row, q: Row) -> Callable[[Row], Row]:
    """The chords of the terms of the divergence over a box."""
    at_low, at_high = _terms(low, q), _terms(high, q)
    slope = (at_high - at_low) / np.maximum(high - low, 1e-300)
    return lambda p: at_low + slope * (p - low)


def _bounded(
    boxes: list[Any],
    program: Callable[[Row, Row, Row], tuple[float, Row] | None],
    q: Row,
    low: Row,
    high: Row,
    number: int,
) -> list[Any]:
    """The heap of boxes with one more, unless no policy is in it."""
    chord = _chords(low, high, q)
    constant = chord(np.zeros_like(q))
    found = program(chord(np.ones_like(q)) - constant, low, high)
    if found is not None:
        value, p = found
        heapq.heappush(boxes, (-(value + float(constant.sum())), number, p, low, high))
    return boxes


def _program(steps: _Steps) -> Callable[[Row, Row, Row], tuple[float, Row] | None]:
    """The largest mean payoff of policies whose observations are in a box, and these; or None.

    A linear program over the probabilities of state, time and action, and of observations.
    """
    from scipy.optimize import linprog
    from scipy.sparse import block_array, csr_array, eye_array

    blocks: list[list[Any]] = []
    for step, (owner, size) in enumerate(zip(steps.owner, steps.sizes, strict=True)):
        line: list[Any] = [None] * (len(steps.owner) + 1)
        ones = np.ones(len(owner))
        line[step] = csr_array((ones, (owner, np.arange(len(owner)))), (size, len(owner)))
        if step:
            line[step - 1] = -steps.moves[step - 1].T
        blocks.append(line)
    outputs = shape_of(steps.moves[-1])[1]
    last: list[Any] = [None] * (len(steps.owner) + 1)
    last[-2], last[-1] = -steps.moves[-1].T, eye_array(outputs)
    blocks.append(last)
    equal = csr_array(block_array(blocks, format="csr"))
    right = np.zeros(shape_of(equal)[0])
    right[0] = 1
    inner = shape_of(equal)[1] - outputs

    def solve(payoff: Row, low: Row, high: Row) -> tuple[float, Row] | None:
        cost = np.concatenate([np.zeros(inner), -payoff])
        bounds = np.concatenate(
            [np.tile([0.0, 1.0], (inner, 1)), np.stack([low - 1e-10, high + 1e-10], axis=1)]
        )
        found = linprog(cost, A_eq=equal, b_eq=right, bounds=bounds, method="highs")
        if found.status == 2:  # infeasible
            return None
        if found.status != 0:
            raise ArithmeticError(f"a linear program failed: {found.message}")
        # By weak duality any prices prove a bound, however exact the solution is.
        prices = found.eqlin.marginals
        reduced = cost - equal.T @ prices
        least = right @ prices + np.where(reduced > 0, bounds[:, 0], bounds[:, 1]) @ reduced
        return -float(least), np.clip(found.x[inner:], 0, 1)

    return solve
