"""Channel capacity with a certificate."""

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float64, Int64, Integer

from habilis.callers import caller_outside
from habilis.checks import is_number
from habilis.probabilities import row_stochastic, shape_of
from habilis.reprs import bars_svg, counted, quietly, short, table_html, unfailing

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from habilis.channels.bounds import Channel

_UNUSED = 1e-9  # inputs with less probability are not counted as used
_DENSE_FROM = 0.1  # share of entries that are not 0 from which a dense matrix is faster


class ConvergenceWarning(UserWarning):
    """A capacity is known less exactly than was asked for."""


@dataclass(frozen=True)
class Capacity:
    """The capacity of a channel lies from `bits` to `bits + gap`.

    Attributes:
        bits: what `input_distribution` attains.
        gap: a proven upper bound on how much more there could be, rounding included.
        input_distribution: float64[n], over the channel's inputs.
    """

    bits: float
    gap: float
    input_distribution: Float64[np.ndarray, "n"]

    @unfailing
    def __repr__(self) -> str:
        inputs = self.input_distribution
        used = f"{np.count_nonzero(inputs > _UNUSED):,} of {counted(inputs.size, 'input')} used"
        return short("Capacity", f"{self.bits:.6f} bits", f"gap {self.gap:.1e}", used)

    @quietly
    def _repr_html_(self) -> str:
        """The numbers, and the distribution as bars, for notebooks."""
        inputs = self.input_distribution
        used = f"{np.count_nonzero(inputs > _UNUSED):,} of {inputs.size:,}"
        rows = {"bits": f"{self.bits:.6f}", "gap": f"at most {self.gap:.1e}", "inputs used": used}
        return table_html("Capacity", rows, bars_svg(inputs))


def capacity(P: Any, tolerance: float = 1e-6) -> Capacity:
    """The capacity of a channel, and inputs that attain it.

        C = max over p of I(X; Y) <= max over x of D(P_x || q),   q = sum over x of p_x P_x

    (Blahut 1972; Arimoto 1972). Identical inputs and identical outputs are merged, parts of the
    channel that share no output are solved apart, and each by Newton's method on the few
    inputs that matter. The certificate is then computed over every input as given.

    Args:
        P: float[n, m], row x the probabilities of the outputs given input x; dense or
            scipy.sparse.
        tolerance: the gap to reach, in bits, above 0.

    Returns:
        Bits, their certified gap, and the distribution of inputs.

    Raises:
        ValueError: P is no matrix, is empty, has negative or infinite entries or a row that does
            not sum to one; or the tolerance is not above 0.

    Warns:
        ConvergenceWarning: the gap is above the tolerance; the message names it.

    Example:
        >>> binary_symmetric = [[0.9, 0.1], [0.1, 0.9]]
        >>> round(capacity(binary_symmetric).bits, 3)
        0.531
    """
    tolerance = checked_tolerance(tolerance)
    found = certified(row_stochastic("P", P), tolerance)
    if found.gap > tolerance:
        warn_of_gap(found.gap, tolerance)
    return found


def checked_tolerance(tolerance: float) -> float:
    """`tolerance` if it is a number above 0, else a ValueError."""
    if not is_number(tolerance) or not 0 < tolerance < np.inf:
        raise ValueError(f"tolerance is {tolerance!r}; give a number of bits above 0, such as 1e-6")
    return float(tolerance)


def warn_of_gap(gap: float, tolerance: float) -> None:
    """Says that a certificate is wider than was asked for."""
    warnings.warn(
        f"the gap is {gap:.3g} bits, above the tolerance of {tolerance:.3g}; "
        "bits and gap are right, but allow a larger tolerance",
        ConvergenceWarning,
        stacklevel=caller_outside(),
    )


def certified(channel: "csr_array", tolerance: float) -> Capacity:
    """`capacity` of a checked channel, without the warning."""
    from habilis.channels.bounds import bounds, neg_entropies

    smaller, group, _ = merge_rows(channel)
    outputs = smaller.T.tocsr()
    merged, _, _ = merge_rows(outputs, add=True)
    small = smaller if merged is outputs else merged.T.tocsr()
    inputs = _over_parts(small, tolerance * np.log(2) / 2)
    inputs = inputs[group] / np.bincount(group)[group]
    inputs /= inputs.sum()
    given = _dense_if_full(channel)
    bound = bounds(given, neg_entropies(given), inputs)
    return Capacity(float(bound.lower / np.log(2)), float(bound.gap / np.log(2)), inputs)


def merge_rows(
    matrix: "csr_array", add: bool = False
) -> tuple["csr_array", Int64[np.ndarray, "n"], Int64[np.ndarray, "k"]]:
    """One row for all that are alike to the last bit; rows of zeros go when adding.

    Rows are distinguished by 64-bit sums of their bits. Should two unlike rows ever share one,
    the capacity's certificate, which looks at the channel as given, shows it.

    Args:
        matrix: csr[n, m], sorted, without explicit zeros.
        add: whether a row of the result is the sum of its group or its first member.

    Returns:
        csr[k, m], for each of the n rows its group, and for each group its first row.
    """
    from scipy.sparse import csr_array

    salt = np.random.default_rng(0).integers(2**63, size=shape_of(matrix)[1], dtype=np.uint64)
    terms = (matrix.data.view(np.uint64) * np.uint64(0x9E3779B97F4A7C15)) ^ (salt[matrix.indices])
    terms = (terms ^ (terms >> np.uint64(29))) * np.uint64(0xBF58476D1CE4E5B9)
    ends = np.concatenate([[np.uint64(0)], np.cumsum(terms ^ (terms >> np.uint64(32)))])
    keys = ends[matrix.indptr[1:]] - ends[matrix.indptr[:-1]]
    _, first, group = np.unique(keys, return_index=True, return_inverse=True)
    if len(first) == len(group):
        whole = bool(np.diff(matrix.indptr).all()) or not add
        every = np.arange(len(group))
        return matrix if whole else csr_array(matrix[np.diff(matrix.indptr) > 0]), every, every
    if not add:
        return matrix[first], group, first
    size = np.bincount(group).astype(np.float64)
    merged = matrix[first]
    merged.data = merged.data * np.repeat(size, np.diff(merged.indptr))
    return csr_array(merged[np.diff(merged.indptr) > 0]), group, first


def _over_parts(channel: "csr_array", tolerance: float) -> Float64[np.ndarray, "n"]:
    """The best inputs of a channel from the best of each of its parts.

    Parts share no output, so which part is used is always understood, and the capacities
    combine to ln(sum of exp(C)) with parts used in proportion to exp(C) (Shannon 1948, appendix).
    """
    from habilis.channels.capacity_solver import best_inputs

    inputs = np.ones(shape_of(channel)[0])
    part_of_input, part_of_output, parts = _parts(channel)
    worth = np.zeros(parts)
    by_part = np.argsort(part_of_input, kind="stable")
    sizes = np.bincount(part_of_input, minlength=parts)
    ends = np.cumsum(sizes)
    for part in np.flatnonzero(sizes > 1):
        members = by_part[ends[part] - sizes[part] : ends[part]]
        rows = channel if parts == 1 else channel[members][:, part_of_output == part]
        inputs[members], found = best_inputs(_dense_if_full(rows), tolerance)
        worth[part] = found.lower
    share = np.exp(worth - worth.max())
    return inputs * (share / share.sum())[part_of_input]


def _parts(
    channel: "csr_array",
) -> tuple[Integer[np.ndarray, "n"], Integer[np.ndarray, "m"], int]:
    """The part that each input and each output belongs to, and how many there are."""
    from scipy.sparse import block_array
    from scipy.sparse.csgraph import connected_components

    rows, columns = shape_of(channel)
    if (np.diff(channel.indptr) == columns).any():  # an input that can cause everything
        return np.zeros(rows, np.int64), np.zeros(columns, np.int64), 1
    both = block_array([[None, channel], [channel.T, None]], format="csr")
    count, part = connected_components(both, directed=False)
    return part[:rows], part[rows:], count


def _dense_if_full(channel: "csr_array") -> "Channel":
    rows, columns = shape_of(channel)
    if channel.nnz >= _DENSE_FROM * rows * columns:
        return channel.toarray()
    return channel
