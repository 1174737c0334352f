"""Values of states as tables, in memory and as files."""

from collections.abc import Callable, Mapping
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from habilis.empowerment.arguments import chosen_states
from habilis.files import save_whole, suffix_of
from habilis.models.explore import AnyModel
from habilis.probabilities import as_array
from habilis.worlds.table import whole_table

if TYPE_CHECKING:
    import polars as pl


def to_dataframe(
    model: AnyModel,
    values: ArrayLike | Mapping[str, ArrayLike] | None = None,
    *,
    states: ArrayLike | None = None,
    **measures: ArrayLike,
) -> "pl.DataFrame":
    """One row a state: its index, its factors (cells as row and column), flags, and its values.

    Args:
        model: a table; or any other model, which is explored whole.
        values: one for every state, as `empowerment` gives them, for a column "bits"; or several
            such arrays by the names of their columns.
        states: the n states that the rows are about, as indices or as bool[S], where `empowerment`
            was asked about these. By default all, in order.
        **measures: more columns of values.

    Returns:
        A Polars data frame; `.to_pandas()` makes a Pandas one of it (with pyarrow installed).

    Raises:
        ValueError: no such states, not as many values as states, or a column's name twice.

    Example:
        >>> import habilis as hb
        >>> mdp = hb.TabularMDP.deterministic([[0, 1], [1, 0]])
        >>> to_dataframe(mdp, foe=[1.0, 0.5]).rows(named=True)
        [{'state': 0, 'foe': 1.0}, {'state': 1, 'foe': 0.5}]
    """
    mdp = whole_table(model)
    rows = chosen_states(mdp, states)
    columns: dict[str, np.ndarray] = {"state": rows}
    for name, labels in mdp.factors.items():
        if mdp.shape is None or not mdp.is_cell(name):
            columns[name] = labels[rows]
        else:
            row, column = np.divmod(labels[rows], mdp.shape[1])
            columns |= {f"{name}_row": row, f"{name}_column": column}
    columns |= {name: flags[rows] for name, flags in mdp.flags.items()}
    given = [] if values is None else [values if isinstance(values, Mapping) else {"bits": values}]
    for name, measured in ((n, m) for mapping in [*given, measures] for n, m in mapping.items()):
        column = as_array(name, measured)
        if column.shape != (len(rows),):
            raise ValueError(
                f"{name} has shape {column.shape}; give one value for each of the "
                f"{len(rows):,} states, or select states with states="
            )
        if name in columns:
            raise ValueError(f"the column {name!r} exists already; give the values another name")
        columns[name] = column
    import polars as pl

    return pl.DataFrame(columns)


def save_table(table: "pl.DataFrame", path: str | Path) -> None:
    """Writes a table by the file's suffix.

    Args:
        table: any.
        path: ends with .csv, .parquet, .npz (an array a column), or .npy (the one column of
            floating point numbers that there is). Nulls are NaN in arrays.

    Raises:
        ValueError: another suffix, no or several columns of floating point numbers for .npy, or
            the file cannot be written.
    """
    from polars.exceptions import PolarsError

    write = TABLES[suffix_of(path, TABLES)]

    def fill(file: BytesIO) -> None:
        try:
            write(table, file)
        except (ValueError, PolarsError) as error:
            raise ValueError(f"{path}: {str(error).splitlines()[0]}") from error

    save_whole(path, fill)


def _npz(table: "pl.DataFrame", file: BytesIO) -> None:
    try:
        np.savez(file, allow_pickle=False, **{c.name: _array(c) for c in table})
    except (TypeError, ValueError) as error:
        raise ValueError(f".npz cannot have these columns ({error}); use .parquet") from None


def _array(column: "pl.Series") -> np.ndarray:
    """A column; words as NumPy's own, which need no pickle."""
    import polars as pl

    words = column.dtype == pl.String and not column.has_nulls()
    return np.array(column.to_list(), str) if words else column.to_numpy()


def _npy(table: "pl.DataFrame", file: BytesIO) -> None:
    columns = [column for column in table if column.dtype.is_float()]
    if len(columns) != 1:
        names = ", ".join(column.name for column in columns) or "none"
        raise ValueError(
            f".npy is for one column of values, here are {names}; use .npz, .csv, .parquet"
        )
    write_array(columns[0].to_numpy(), file)


def write_array(array: np.ndarray, file: BytesIO) -> None:
    """Writes an array as .npy."""
    np.save(file, array, allow_pickle=False)


TABLES: dict[str, Callable[["pl.DataFrame", BytesIO], None]] = {
    ".csv": lambda table, file: table.write_csv(file),
    ".parquet": lambda table, file: table.write_parquet(file),
    ".npz": _npz,
    ".npy": _npy,
}
"""How a table is written, by the file's suffix."""
