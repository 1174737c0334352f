"""Per-state values as tables."""

from pathlib import Path

import numpy as np
import polars as pl
from jaxtyping import Float64

from habilis.mdp import TabularMDP


def state_table(
    mdp: TabularMDP,
    values: Float64[np.ndarray, "S"],
    gap: Float64[np.ndarray, "S"] | None = None,
    unit: str = "bits",
) -> pl.DataFrame:
    """One row a state: its index, its factors (cells as row and column), flags, and its value.

    Args:
        mdp: the table.
        values: one for every state.
        gap: their certified gaps; no column where there is none.
        unit: the name of the values' column.
    """
    columns: dict[str, np.ndarray] = {"state": np.arange(mdp.states)}
    for name, labels in mdp.factors.items():
        if mdp.shape is None:
            columns[name] = labels
        else:
            columns[f"{name}_row"], columns[f"{name}_column"] = np.divmod(labels, mdp.shape[1])
    measured = {unit: values} if gap is None else {unit: values, "gap": gap}
    return pl.DataFrame(columns | dict(mdp.flags) | measured)


def save_table(table: pl.DataFrame, path: str | Path) -> None:
    """Writes a table by the file's suffix.

    Raises:
        ValueError: the suffix is neither .csv nor .parquet, or the file cannot be written.
    """
    path = Path(path)
    writers = {".csv": table.write_csv, ".parquet": table.write_parquet}
    if path.suffix.lower() not in writers:
        raise ValueError(f"{path}: unknown kind of file {path.suffix!r}; use .csv or .parquet")
    try:
        writers[path.suffix.lower()](path)
    except (OSError, pl.exceptions.PolarsError) as error:
        raise ValueError(f"{path}: cannot be written ({str(error).splitlines()[0]})") from error
