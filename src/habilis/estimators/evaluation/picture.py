"""The picture of an evaluation: error and rank correlation of every estimator in every case."""

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

if TYPE_CHECKING:
    import polars as pl
    from matplotlib.axes import Axes

_WORST = 2.0  # bits, where the colours end
_PANELS = {
    "bias": ("bias in bits: estimate minus truth", "RdBu_r", Normalize(-_WORST, _WORST)),
    "rank": ("rank correlation with the truth over states", "YlGn", Normalize(-0.3, 1.3)),
}


def evaluation_figure(table: "pl.DataFrame") -> Figure:
    """What `evaluate` found, as two matrices of cases and estimators.

    Args:
        table: of `evaluate`.

    Returns:
        The figure; `habilis.worlds.pictures.figures.save_figure` writes it.
    """
    cases = table["case"].unique(maintain_order=True).to_list()
    names = table["estimator"].unique(maintain_order=True).to_list()
    size = 3.2 + 2 * 0.72 * max(3, len(names)), 1.7 + 0.27 * len(cases)
    figure = Figure(figsize=size, dpi=96, layout="constrained")
    for ax, (measure, (title, colours, scale)) in zip(
        figure.subplots(1, 2, sharey=True), _PANELS.items(), strict=True
    ):
        values = np.full((len(cases), len(names)), np.nan)
        for row in table.iter_rows(named=True):
            if row[measure] is not None:
                values[cases.index(row["case"]), names.index(row["estimator"])] = row[measure]
        _draw(ax, values, colours, scale)
        ax.set_title(title, fontsize=10)
        ax.set_xticks(range(len(names)), names, rotation=35, ha="right", fontsize=8)
        ax.set_yticks(range(len(cases)), cases, fontsize=8)
    return figure


def _draw(ax: "Axes", values: np.ndarray, colours: str, scale: Any) -> None:
    ax.set_facecolor("#eceef2")
    ax.imshow(np.ma.masked_invalid(values), cmap=colours, norm=scale, aspect="auto")
    for (row, column), value in np.ndenumerate(values):
        if np.isfinite(value):
            red, green, blue, _ = colormaps[colours](scale(value))
            dark = 0.3 * red + 0.6 * green + 0.1 * blue < 0.5
            ink = "white" if dark else "#1f2430"
            text = f"{value + 0.0:.2f}".replace("-0.00", "0.00")
            ax.text(column, row, text, ha="center", va="center", fontsize=7, color=ink)
    ax.set_xticks(np.arange(values.shape[1] + 1) - 0.5, minor=True)
    ax.set_yticks(np.arange(values.shape[0] + 1) - 0.5, minor=True)
    ax.grid(which="minor", color="white", linewidth=1.5)
    ax.tick_params(which="both", length=0)
    ax.spines[:].set_visible(False)
