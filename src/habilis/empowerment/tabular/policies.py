"""Effective empowerment's linear system, and compiled parts: products with a matrix, channels.

A channel's row, of a state and an action, is made of three parts with weights: what is observed at
once, what after one step, and the discounted observations of the next states. The matrices are the
three arrays of scipy's CSR format.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float64

from habilis.compiled import compiled, part
from habilis.empowerment.limits import Progress, unwatched
from habilis.processors import processors

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_ABREAST = 16  # columns that are solved together: so many states' rows stay in the cache
_RESTART = 50
_CYCLES = 20
_MOST_STEPS = 1_000_000
_ROUNDING = 1e-15  # of a residual's entries, together


def _of_rows(at_once, seen, moves, discounted, weights, policy, states, *rest):
    """Roughly the operations of all rows of the channel."""
    start, stop = rest[-2:]
    each = 4 + len(moves[2]) / max(len(moves[0]) - 1, 1)
    return (stop - start) * policy.shape[1] * discounted.shape[1] * each


def _of_iterations(*args):
    return 50 * _of_rows(*args)


@compiled(lambda first, column, value, old, *rest: len(value) * old.shape[1])
def add_product(first, column, value, old, factor, new, start, stop):
    """new[start:stop] += factor * matrix[start:stop] @ old."""
    for row in range(start, stop):
        for place in range(first[row], first[row + 1]):
            weight, other = factor * value[place], column[place]
            for o in range(old.shape[1]):
                new[row, o] += weight * old[other, o]


def discounted(
    matrix: "csr_array",
    emitted: Float64[np.ndarray, "S O"],
    discount: float,
    distance: float,
    report: Progress = unwatched,
) -> tuple[Float64[np.ndarray, "S O"], float]:
    """The fixed point N = (1 - g) E + g T N, of distributions E or some of their columns.

    Iteration from E comes closer by the factor g a step. Where that takes long, BiCGSTAB (van der
    Vorst 1992) goes first, and iteration adds what it leaves. The residual R of a solution bounds
    what is missing: N - N' = (1 - g T)^-1 R, and the rows of T sum to 1.

    Args:
        matrix: T, stochastic.
        emitted: E.
        discount: g, above 0.
        distance: the total variation distance to reach, in every state.
        report: called with the share that is done, from several threads.

    Returns:
        N, and a bound on its distance: that which was to be reached, unless rounding, or a
        million steps of iteration, came first.
    """
    starts = range(0, emitted.shape[1], _ABREAST)
    shares = np.zeros(len(starts))

    def some(number: int) -> tuple[Float64[np.ndarray, "S o"], float]:
        def come(left: float) -> None:
            shares[number] = min(np.log(left) / np.log(distance / len(starts)), 1.0)
            report(float(shares.mean()))

        columns = np.ascontiguousarray(emitted[:, starts[number] : starts[number] + _ABREAST])
        return _fixed_point(matrix, columns, discount, distance / len(starts), come)

    rounding = _ROUNDING / (1 - discount)  # of all columns together

    with ThreadPoolExecutor(processors()) as pool:
        parts, reached = zip(*pool.map(some, range(len(starts))), strict=True)
    return np.hstack(parts), sum(reached) + rounding


def _fixed_point(
    matrix: "csr_array",
    emitted: Float64[np.ndarray, "S O"],
    g: float,
    distance: float,
    come: Callable[[float], None],
) -> tuple[Float64[np.ndarray, "S O"], float]:
    """As `discounted`, of a few columns; `come` hears the distance that is left."""
    added, found = (1 - g) * emitted, emitted
    left = 1.0  # E and N are parts of distributions
    come(left)
    least = max(distance, _ROUNDING / (1 - g))
    cycles = _CYCLES if np.log(distance) / np.log(g) > 2 * _RESTART else 0
    while cycles and left > least:
        closer = _closer(matrix, found, added, g, least)
        then = _missing(added - _applied(matrix, closer, g), g)
        cycles = cycles - 1 if then < left / 2 else 0
        if then < left:
            found, left = closer, then
            come(max(left, distance))
    steps = int(np.ceil(np.log(least / left) / np.log(g))) if left > least else 0
    steps = min(steps, _MOST_STEPS)
    for step in range(steps):
        come(left * g**step)
        new = added.copy()
        add_product(matrix.indptr, matrix.indices, matrix.data, found, g, new, 0, len(new))
        found = new
    return np.maximum(found, 0), max(left * g**steps, distance)


def _applied(
    matrix: "csr_array", some: Float64[np.ndarray, "S O"], g: float
) -> Float64[np.ndarray, "S O"]:
    """The product (1 - g T) some."""
    product = some.copy()
    add_product(matrix.indptr, matrix.indices, matrix.data, some, -g, product, 0, len(product))
    return product


def _missing(residual: Float64[np.ndarray, "S O"], g: float) -> float:
    """A bound on the total variation distance of a solution with this residual."""
    bound = float(np.abs(residual).sum(axis=1).max()) / (2 * (1 - g))
    return bound if np.isfinite(bound) else np.inf


def _closer(
    matrix: "csr_array",
    found: Float64[np.ndarray, "S O"],
    added: Float64[np.ndarray, "S O"],
    g: float,
    distance: float,
) -> Float64[np.ndarray, "S O"]:
    """A solution after some steps of BiCGSTAB in every column."""
    found, residual = found.copy(), added - _applied(matrix, found, g)
    shadow, part_of = residual.copy(), np.empty_like(residual)
    direction, image = np.zeros_like(residual), np.zeros_like(residual)
    rho = alpha = omega = np.ones(found.shape[1])
    for step in range(_RESTART):
        before, rho = rho, _dot(shadow, residual)
        beta = _ratio(rho, before) * _ratio(alpha, omega)
        direction -= np.multiply(image, omega, out=part_of)
        direction *= beta
        direction += residual
        image = _applied(matrix, direction, g)
        alpha = _ratio(rho, _dot(shadow, image))
        residual -= np.multiply(image, alpha, out=part_of)
        other = _applied(matrix, residual, g)
        omega = _ratio(_dot(other, residual), _dot(other, other))
        found += np.multiply(direction, alpha, out=part_of)
        found += np.multiply(residual, omega, out=part_of)
        residual -= np.multiply(other, omega, out=part_of)
        if step % 10 == 9 and _missing(residual, g) < distance / 2:
            break
    return found


def _dot(
    one: Float64[np.ndarray, "S O"], other: Float64[np.ndarray, "S O"]
) -> Float64[np.ndarray, "O"]:
    return np.einsum("so,so->o", one, other)


def _ratio(
    one: Float64[np.ndarray, "O"], other: Float64[np.ndarray, "O"]
) -> Float64[np.ndarray, "O"]:
    """The quotients, 0 where a column is solved or cannot go on."""
    return np.divide(one, other, out=np.zeros_like(one), where=np.abs(other) > 1e-300)


@part
def channel_row(at_once, seen, moves, discounted, weights, state, action, actions, row):
    """Writes P(o | state, action) into `row`."""
    row[:] = 0.0
    for place in range(at_once[0][state], at_once[0][state + 1]):
        row[at_once[1][place]] += weights[0] * at_once[2][place]
    pair = state * actions + action
    for place in range(seen[0][pair], seen[0][pair + 1]):
        row[seen[1][place]] += weights[1] * seen[2][place]
    if weights[2] > 0:
        for place in range(moves[0][pair], moves[0][pair + 1]):
            weight, other = weights[2] * moves[2][place], moves[1][place]
            for o in range(len(row)):
                row[o] += weight * discounted[other, o]


@compiled(_of_rows)
def add_information(at_once, seen, moves, discounted, weights, policy, states, nats, start, stop):
    """Adds what these observations contribute to I(A; O), A by the policy, to nats[start:stop]."""
    actions = policy.shape[1]
    rows = np.empty((actions, discounted.shape[1]))
    mean = np.empty(discounted.shape[1])
    for place in range(start, stop):
        state = states[place]
        mean[:] = 0.0
        for action in range(actions):
            if policy[state, action] > 0:
                row = rows[action]
                channel_row(at_once, seen, moves, discounted, weights, state, action, actions, row)
                mean += policy[state, action] * row
        total = 0.0
        for action in range(actions):
            if policy[state, action] > 0:
                for o in range(len(mean)):
                    if rows[action, o] > 0 and mean[o] > 0:  # it may underflow
                        ratio = np.log(rows[action, o] / mean[o])
                        total += policy[state, action] * rows[action, o] * ratio
        nats[place] += total


@compiled(_of_iterations)
def add_capacity(
    at_once, seen, moves, discounted, weights, available, states, sought, lower, upper, start, stop
):
    """Writes bounds on max I(A; O) over distributions of available actions, in nats.

    By the iteration of Blahut and Arimoto with a step that grows as long as I does, until they are
    `sought` apart or after 200 steps.
    """
    actions = available.shape[1]
    rows = np.empty((actions, discounted.shape[1]))
    entropy, divergence = np.empty(actions), np.empty(actions)
    inputs, mean = np.empty(actions), np.empty(discounted.shape[1])
    for place in range(start, stop):
        state = states[place]
        count = 0
        for action in range(actions):
            if available[state, action]:
                row = rows[count]
                channel_row(at_once, seen, moves, discounted, weights, state, action, actions, row)
                entropy[count] = 0.0
                for o in range(len(row)):
                    if row[o] > 0:
                        entropy[count] += row[o] * np.log(row[o])
                count += 1
        inputs[:count] = 1 / count
        lower[place], upper[place] = 0.0, np.inf
        before, step = 0.0, 2.0
        for _ in range(200):
            mean[:] = 0.0
            for x in range(count):
                if inputs[x] > 1e-12:
                    mean += inputs[x] * rows[x]
            for o in range(len(mean)):
                mean[o] = np.log(max(mean[o], 1e-300))
            information, most = 0.0, 0.0
            for x in range(count):
                divergence[x] = entropy[x]
                for o in range(len(mean)):
                    divergence[x] -= rows[x, o] * mean[o]
                information += inputs[x] * divergence[x]
                most = max(most, divergence[x])
            lower[place] = max(lower[place], information)
            upper[place] = min(upper[place], max(most, lower[place]))
            if upper[place] - lower[place] <= sought:
                break
            step = step * 1.5 if information > before else 2.0
            before, total = information, 0.0
            for x in range(count):
                inputs[x] *= np.exp(step * (divergence[x] - most))
                total += inputs[x]
            for x in range(count):
                inputs[x] = max(inputs[x] / total, 1e-300)
