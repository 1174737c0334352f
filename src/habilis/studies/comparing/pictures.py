"""The picture that two of the studies share: points with intervals, a panel a case."""

import polars as pl
from matplotlib.figure import Figure

from habilis.studies.comparing.study import Measure
from habilis.studies.multiverse.pictures import intervals_figure


def episodes_figure(table: pl.DataFrame, measure: Measure) -> Figure:
    """How many episodes each agent takes.

    Args:
        table: of `analysis.summary`.
        measure: one that counts episodes to convergence.
    """
    names = {measure.column + end: name for end, name in _ENDS.items()}
    panels = {
        str(case): part.select(
            "agent",
            *(pl.col(column).alias(name) for column, name in names.items()),
            pl.format("{} of {}", "converged", "runs").alias("note"),
            (pl.col("converged") == pl.col("runs")).alias("complete"),
        )
        for (case,), part in table.group_by("case", maintain_order=True)
    }
    return intervals_figure(panels, f"{measure.title} (interquartile mean, 95 % interval)")


_ENDS = {"": "middle", "_low": "low", "_high": "high"}
