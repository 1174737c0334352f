"""Matrices of probabilities, checked once: channels, transitions and noisy sensors are such."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Bool
from numpy.typing import ArrayLike

if TYPE_CHECKING:  # SciPy takes as long to import as all the rest: only who needs it pays
    from scipy.sparse import csr_array

_ROUNDING = 1e-9  # by how much a row of float64 may miss 1
_COARSE_ROUNDING = 1e-5  # of a narrower type


def as_array(name: str, values: Any, otherwise: str = "") -> np.ndarray:
    """`values` as an array.

    Args:
        name: what the caller calls it, for messages.
        values: what an array is made of.
        otherwise: what else to do with masked entries, for messages.

    Raises:
        ValueError: they are lists of different lengths, no array can be made of them, entries are
            masked (a plain array would have what the mask hides), they can be gone through only
            once, or they are times.
    """
    if isinstance(values, Iterator):
        raise ValueError(f"{name} is a {type(values).__name__}; give a list, as list({name})")
    refuse_masked(name, values, otherwise)
    try:
        array = np.asarray(values)
    except ValueError:
        raise ValueError(f"{name} is ragged; give rows of one length") from None
    except (TypeError, RuntimeError) as error:  # of tensors on a device, or with a gradient
        raise ValueError(f"{name} is not an array ({error}); give a NumPy array of it") from None
    if array.dtype.kind == "m":  # which NumPy takes for integers
        raise ValueError(f"{name} has type {array.dtype}; give numbers, as .astype(int) has them")
    return array


def as_flags(name: str, values: ArrayLike) -> np.ndarray:
    """`values` as an array of bool; 0 and 1 stand for them.

    Raises:
        ValueError: as in `as_array`, or an entry is something else, which might be an index.
    """
    array = as_array(name, values)
    if array.dtype.kind not in "biuf":
        raise ValueError(f"{name} has type {array.dtype}; give true or false for each state")
    other = array[(array != 0) & (array != 1)]
    if len(other):
        raise ValueError(f"{name} has {other[0]}; give true or false for each state")
    return array.astype(bool)


def refuse_masked(name: str, values: Any, otherwise: str = "") -> None:
    """Raises ValueError: there are masked entries; arguments as in `as_array`."""
    if _is_masked(values):
        raise ValueError(f"{name} has masked entries; fill them with .filled(value){otherwise}")


def _is_masked(values: Any) -> bool:
    """Whether there is a masked entry in an array, or in lists of them."""
    if isinstance(values, list | tuple):
        return any(map(_is_masked, values))
    return bool(np.ma.is_masked(values))


def is_sparse(values: Any) -> bool:
    """Whether `values` is one of scipy.sparse's matrices or arrays."""
    return hasattr(values, "tocsr")


def shape_of(matrix: Any) -> tuple[int, int]:
    """Rows and columns; SciPy's types do not promise that a matrix has both."""
    rows, columns = matrix.shape
    return rows, columns


def row_stochastic(
    name: str,
    values: Any,
    row: str = "row {}",
    rows_are: str = "inputs",
    ignored: Bool[np.ndarray, "n"] | None = None,
    empty: bool = False,
) -> "csr_array":
    """A matrix whose rows are probability distributions.

    Args:
        name: what the caller calls it, for messages.
        values: float[n, m], dense or scipy.sparse.
        row: what row `{}` is called in messages.
        rows_are: what rows stand for, for messages.
        ignored: rows that are read as zeros, whatever they hold.
        empty: whether a row may be all zeros.

    Returns:
        float64[n, m] without explicit zeros; each row divided by its sum, which takes away
        what rounding left.

    Raises:
        ValueError: it is no matrix of finite numbers, is empty, has a negative entry, or a row
            that does not sum to one (by more than 1e-9; 1e-5 in types narrower than float64).
    """
    from scipy.sparse import csr_array

    if not is_sparse(values):
        values = as_array(name, values)
    kind, shape = np.dtype(values.dtype), values.shape
    if kind.kind not in "biuf" or len(shape) != 2 or 0 in shape:
        raise ValueError(
            f"{name} has shape {shape} and type {kind}; give probabilities of shape [rows, columns]"
        )
    matrix = csr_array(values, dtype=np.float64, copy=True)
    matrix.sum_duplicates()
    if ignored is not None:
        matrix.data[np.repeat(ignored, np.diff(matrix.indptr))] = 0
    bad = np.flatnonzero(~((matrix.data >= 0) & (matrix.data < np.inf)))
    if len(bad):
        at = int(np.searchsorted(matrix.indptr, bad[0], side="right")) - 1
        raise ValueError(
            f"{name}, {row.format(at)}, column {matrix.indices[bad[0]]} "
            f"is {matrix.data[bad[0]]:g}; probabilities are from 0 to 1"
        )
    sums = np.asarray(matrix.sum(axis=1))
    narrow = kind.kind == "f" and kind.itemsize < 8
    rounding = _COARSE_ROUNDING if narrow else _ROUNDING
    off = np.abs(sums - 1) > rounding
    if empty:
        off &= sums != 0
        sums = np.where(sums == 0, 1, sums)
    if off.any():
        first = int(np.argmax(off))
        problem = f"{name}, {row.format(first)} sums to {sums[first]:.12g}"
        columns = np.asarray(matrix.sum(axis=0))
        transposed = np.abs(columns - 1) <= rounding
        if (transposed | (empty & (columns == 0))).all():
            raise ValueError(f"{problem}, but every column to 1: rows are {rows_are}; transpose it")
        raise ValueError(f"{problem}; divide each row by its sum")
    matrix.data /= np.repeat(sums, np.diff(matrix.indptr))
    matrix.eliminate_zeros()
    matrix.sort_indices()
    return matrix
