"""The distribution of inputs that attains a channel's capacity.

Few inputs matter: as many as there are outputs suffice (Gallager 1968, corollary 3 to theorem
4.5.1). So a small working set is solved by Newton's method, all inputs are asked whether they
would do better (one product of matrix and vector), those that would are added, and again.
"""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float64
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from habilis.channels.bounds import LEAST, Bounds, Inputs, bounds, neg_entropies
from habilis.probabilities import shape_of

if TYPE_CHECKING:
    from habilis.channels.bounds import Channel

_ROUNDS = 200  # of working sets
STEPS = 60  # of Newton's method in a round
FINEST = float(np.finfo(np.float64).eps)  # nats: inputs that are the best at once leave no slack
_WARM_UP = 40  # of Blahut and Arimoto's iteration, which finds out which inputs matter
SHARE = 0.99  # how far to go towards the boundary
_UNUSED = 1e-9  # inputs with less are left out of the next working set


def best_inputs(
    channel: "Channel", tolerance: float, price: Inputs | None = None
) -> tuple[Inputs, Bounds]:
    """Inputs that attain the capacity to within `tolerance` nats, if rounding permits.

    Args:
        channel: float64[n, m], every output possible; dense or sparse.
        tolerance: the gap to stop at, in nats.
        price: float64[n], nats that each input costs, of which the least is 0: what is maximised,
            and certified, is the information less the mean price (Blahut 1972, theorem 10).

    Returns:
        float64[n] and the certificate over all n inputs; the best found if its gap is larger.
    """
    rows, columns = shape_of(channel)
    entropy = neg_entropies(channel) - (0 if price is None else price)
    inputs, chosen = _first_inputs(channel, entropy)
    best, certificate = inputs, bounds(channel, entropy, inputs)
    sought = tolerance / 2
    for _ in range(_ROUNDS):
        part = channel[chosen]
        part = part if isinstance(part, np.ndarray) else part.toarray()
        seen = part.any(axis=0)
        part = part if seen.all() else part[:, seen]
        among = np.zeros(rows)
        among[chosen] = newton(part, entropy[chosen], inputs[chosen], sought)
        inputs, found = among, bounds(channel, entropy, among)
        if not found.gap >= certificate.gap:
            best, certificate = inputs, found
        if certificate.gap <= tolerance:
            break
        outside = found.excess.copy()
        outside[chosen] = 0
        most = max(columns // 2, 16)
        added = np.argsort(-outside)[:most]
        added = added[outside[added] > tolerance / 4]
        if not len(added):
            if sought <= tolerance / 64:
                break
            sought /= 4
        chosen = np.union1d(np.flatnonzero(inputs > _UNUSED), added)
    return best, certificate


def _first_inputs(channel: "Channel", entropy: Inputs) -> tuple[Inputs, np.ndarray]:
    """A distribution not far off, and the inputs to start with."""
    rows, columns = shape_of(channel)
    inputs = np.full(rows, 1 / rows)
    if rows <= columns:
        return inputs, np.arange(rows)
    for _ in range(_WARM_UP):
        divergence = entropy - channel @ np.log(np.maximum(channel.T @ inputs, LEAST))
        # Twice the step of Blahut and Arimoto: it still converges, in half the time.
        inputs *= np.exp(2 * (divergence - divergence.max()))
        inputs /= inputs.sum()
    return inputs, np.sort(np.argsort(-inputs)[:columns])


def newton(
    P: Float64[np.ndarray, "n m"], entropy: Inputs, inputs: Inputs, tolerance: float
) -> Inputs:
    """Maximises I by a primal-dual interior point method (Mehrotra 1992).

    Seeks p >= 0 with sum 1, slacks s >= 0 and a price c with s_x = c - D_x(p) and p_x s_x = 0:
    the conditions of Kuhn and Tucker, under which c is the capacity.
    """
    n, _ = P.shape
    tolerance = max(tolerance, FINEST)
    p = np.maximum(inputs, 1e-3 / n)
    p /= p.sum()
    q = np.maximum(p @ P, LEAST)
    divergence = entropy - P @ np.log(q)
    gap = max(divergence.max() - p @ divergence, tolerance)
    c = divergence.max() + gap / 2
    s = c - divergence
    best, best_gap = p, np.inf
    for _ in range(STEPS):
        try:
            solve = _solver(P, q, s / p)
        except LinAlgError:
            break
        # Once straight for p * s = 0 to see how far that goes, then for a reachable target.
        residual = divergence - c
        x, ones = solve(np.stack([residual, np.ones(n)], axis=1)).T
        dc = (x.sum() - (1 - p.sum())) / ones.sum()
        dp = x - dc * ones
        ds = -s * dp / p - s
        mean = p @ s / n
        after = (p + _reach(p, dp) * dp) @ (s + _reach(s, ds) * ds) / n
        target = (after / mean) ** 3 * mean - dp * ds
        x = solve((residual + target / p)[:, None])[:, 0]
        dc = (x.sum() - (1 - p.sum())) / ones.sum()
        dp = x - dc * ones
        ds = (target - s * dp) / p - s
        length = min(1.0, SHARE * min(_reach(p, dp), _reach(s, ds)))
        if not np.isfinite(length * dc):
            break
        p, s, c = p + length * dp, s + length * ds, c + length * dc
        q = np.maximum(p @ P, LEAST)
        divergence = entropy - P @ np.log(q)
        gap = divergence.max() - p @ divergence / p.sum()
        if gap < best_gap:
            best, best_gap = p, gap
        if gap <= tolerance:
            break
    return best / best.sum()


def _solver(P: Float64[np.ndarray, "n m"], q: np.ndarray, theta: np.ndarray):
    """Solves (P diag(1/q) P' + diag(theta)) x = b, in the smaller of the two dimensions."""
    n, m = P.shape
    if n <= m:
        scaled = P / np.sqrt(q)
        matrix = scaled @ scaled.T
        matrix[np.diag_indices(n)] += theta + 1e-14 * matrix.diagonal()
        factor = cho_factor(matrix, lower=True, overwrite_a=True, check_finite=False)
        return lambda b: cho_solve(factor, b, check_finite=False)
    theta = theta[:, None]
    weighted = P / theta
    matrix = P.T @ weighted
    matrix[np.diag_indices(m)] += q
    factor = cho_factor(matrix, lower=True, overwrite_a=True, check_finite=False)
    return lambda b: b / theta - weighted @ cho_solve(factor, P.T @ (b / theta), check_finite=False)


def _reach(v: np.ndarray, dv: np.ndarray) -> float:
    """How far `v` can go along `dv` without leaving v >= 0; 1 if farther."""
    down = dv < 0
    return min(1.0, float((-v[down] / dv[down]).min())) if down.any() else 1.0
