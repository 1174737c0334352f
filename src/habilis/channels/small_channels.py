"""Newton's method of `capacity_solver` for channels of few outputs, in loops that Numba compiles.

It calls no BLAS, whose threads get in each other's way where several channels are solved side by
side, and it releases the interpreter's lock. Sums are in the order in which they are written, so a
result does not depend on who else is at work.
"""

import math

import numpy as np
from jaxtyping import Float64

from habilis.channels.bounds import LEAST, Inputs
from habilis.channels.capacity_solver import FINEST, SHARE, STEPS
from habilis.compiled import compile_now, compiled, part

MOST_OUTPUTS = 192
"""Outputs above which BLAS is faster, even if other threads use it too."""

_LEAST = float(LEAST)


def inputs_of_few_outputs(
    P: Float64[np.ndarray, "n m"], entropy: Inputs, inputs: Inputs, tolerance: float
) -> Inputs:
    """As `capacity_solver.newton`: inputs that attain the capacity to within `tolerance` nats."""
    rows, least = np.ascontiguousarray(P), float(max(tolerance, FINEST))
    return _newton(rows, np.ascontiguousarray(rows.T), entropy, inputs, least)


def compile_solver() -> None:
    """Leaves out the time as plain Python and as a compiler: what follows is timed."""
    compile_now(_newton)
    inputs_of_few_outputs(np.eye(2), np.zeros(2), np.full(2, 0.5), 1e-6)


def _few_inputs(P, columns, entropy, inputs, tolerance):
    n, m = P.shape
    return 15 * min(n, m) * (n * m + min(n, m) ** 2)


@compiled(_few_inputs)
def _newton(P, columns, entropy, inputs, tolerance):
    """A primal-dual interior point method (Mehrotra 1992); see `capacity_solver.newton`."""
    n, m = P.shape
    size = min(n, m)
    matrix = np.empty((size, size))
    p, s, x, ones = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    dp, ds, theta = np.empty(n), np.empty(n), np.empty(n)
    best, divergence = np.empty(n), np.empty(n)
    q, logs, inner = np.empty(m), np.empty(m), np.empty(m)
    weight = np.empty(max(n, m))

    total = 0.0
    for i in range(n):
        p[i] = max(inputs[i], 1e-3 / n)
        total += p[i]
    for i in range(n):
        p[i] /= total
        best[i] = p[i]
    best_gap = np.inf
    largest, mean = _diverge(P, columns, entropy, p, q, logs, divergence)
    c = largest + max(largest - mean, tolerance) / 2
    for i in range(n):
        s[i] = c - divergence[i]
    for _ in range(STEPS):
        for i in range(n):
            theta[i] = s[i] / p[i]
        if n <= m:
            for o in range(m):
                weight[o] = 1.0 / q[o]
            _gram(columns, weight, theta, matrix)
            for i in range(n):
                matrix[i, i] += 1e-14 * (matrix[i, i] - theta[i])
        else:
            for i in range(n):
                weight[i] = 1.0 / theta[i]
            _gram(P, weight, q, matrix)
        if not _factor(matrix):
            break
        # Once straight for p * s = 0 to see how far that goes, then for a reachable target.
        for i in range(n):
            x[i] = divergence[i] - c
            ones[i] = 1.0
        _solve(P, columns, matrix, theta, x, inner)
        _solve(P, columns, matrix, theta, ones, inner)
        total, all_x, all_ones, slack = 0.0, 0.0, 0.0, 0.0
        for i in range(n):
            total += p[i]
            all_x += x[i]
            all_ones += ones[i]
            slack += p[i] * s[i]
        mean = slack / n
        dc = (all_x - (1 - total)) / all_ones
        for i in range(n):
            dp[i] = x[i] - dc * ones[i]
            ds[i] = -s[i] * dp[i] / p[i] - s[i]
        along, up = _reach(p, dp), _reach(s, ds)
        after = 0.0
        for i in range(n):
            after += (p[i] + along * dp[i]) * (s[i] + up * ds[i])
        ratio = after / n / mean
        target = ratio * ratio * ratio * mean
        for i in range(n):
            ds[i] = target - dp[i] * ds[i]  # what p * s is to be, until the step is known
            x[i] = divergence[i] - c + ds[i] / p[i]
        _solve(P, columns, matrix, theta, x, inner)
        all_x = 0.0
        for i in range(n):
            all_x += x[i]
        dc = (all_x - (1 - total)) / all_ones
        for i in range(n):
            dp[i] = x[i] - dc * ones[i]
            ds[i] = (ds[i] - s[i] * dp[i]) / p[i] - s[i]
        length = min(1.0, SHARE * min(_reach(p, dp), _reach(s, ds)))
        if not np.isfinite(length * dc):
            break
        c += length * dc
        total = 0.0
        for i in range(n):
            p[i] += length * dp[i]
            s[i] += length * ds[i]
            total += p[i]
        largest, mean = _diverge(P, columns, entropy, p, q, logs, divergence)
        gap = largest - mean / total
        if gap < best_gap:
            best_gap = gap
            for i in range(n):
                best[i] = p[i]
        if gap <= tolerance:
            break
    total = 0.0
    for i in range(n):
        total += best[i]
    for i in range(n):
        best[i] /= total
    return best


@part
def _diverge(P, columns, entropy, p, q, logs, divergence):
    """Sets outputs and divergences of inputs; returns the largest one and their weighted sum."""
    n, m = P.shape
    for o in range(m):
        q[o] = 0.0
    for i in range(n):
        for o in range(m):
            q[o] += p[i] * P[i, o]
    for i in range(n):
        divergence[i] = entropy[i]
    for o in range(m):
        q[o] = max(q[o], _LEAST)
        logs[o] = math.log(q[o])
        for i in range(n):
            divergence[i] -= logs[o] * columns[o, i]
    largest, mean = -np.inf, 0.0
    for i in range(n):
        largest = max(largest, divergence[i])
        mean += p[i] * divergence[i]
    return largest, mean


@part
def _gram(rows, weight, diagonal, into):
    """Upper triangle of rows' diag(weight) rows + diag(diagonal), four rows at a time."""
    n, m = rows.shape
    for i in range(m):
        for j in range(i, m):
            into[i, j] = 0.0
        into[i, i] = diagonal[i]
    whole = n - n % 4
    for x in range(0, whole, 4):
        for i in range(m):
            a, b = weight[x] * rows[x, i], weight[x + 1] * rows[x + 1, i]
            c, d = weight[x + 2] * rows[x + 2, i], weight[x + 3] * rows[x + 3, i]
            for j in range(i, m):
                into[i, j] += (a * rows[x, j] + b * rows[x + 1, j]) + (
                    c * rows[x + 2, j] + d * rows[x + 3, j]
                )
    for x in range(whole, n):
        for i in range(m):
            a = weight[x] * rows[x, i]
            for j in range(i, m):
                into[i, j] += a * rows[x, j]


@part
def _factor(matrix):
    """The upper factor of Cholesky's decomposition, in place; whether there is one."""
    m = len(matrix)
    for k in range(m):
        if not matrix[k, k] > 0.0:
            return False
        pivot = math.sqrt(matrix[k, k])
        matrix[k, k] = pivot
        for j in range(k + 1, m):
            matrix[k, j] /= pivot
        for i in range(k + 1, m):
            weight = matrix[k, i]
            for j in range(i, m):
                matrix[i, j] -= weight * matrix[k, j]
    return True


@part
def _solve(P, columns, factor, theta, b, inner):
    """Solves (P diag(1/q) P' + diag(theta)) x = b, in place, in the smaller dimension."""
    n, m = P.shape
    if n <= m:
        _substitute(factor, b)
        return
    for o in range(m):
        inner[o] = 0.0
    for i in range(n):
        b[i] /= theta[i]
        for o in range(m):
            inner[o] += b[i] * P[i, o]
    _substitute(factor, inner)
    for o in range(m):
        for i in range(n):
            b[i] -= inner[o] * (columns[o, i] / theta[i])


@part
def _substitute(factor, b):
    m = len(factor)
    for k in range(m):
        b[k] /= factor[k, k]
        for j in range(k + 1, m):
            b[j] -= factor[k, j] * b[k]
    for k in range(m - 1, -1, -1):
        total = b[k]
        for j in range(k + 1, m):
            total -= factor[k, j] * b[j]
        b[k] = total / factor[k, k]


@part
def _reach(v, dv):
    """How far `v` can go along `dv` without leaving v >= 0; 1 if farther."""
    reach = 1.0
    for i in range(len(v)):
        if dv[i] < 0.0:
            reach = min(reach, -v[i] / dv[i])
    return reach
