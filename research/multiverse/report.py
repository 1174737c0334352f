"""The second part as a page, pictures and data."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import polars as pl
from matplotlib.figure import Figure

from habilis.files import write_whole
from habilis.studies.page import inlined, render
from habilis.worlds.pictures.figures import save_figure
from research.multiverse import claims, pictures
from research.multiverse.results import Multiverse, aggregate, paper_curves
from research.multiverse.settings import (
    BETAS,
    HORIZONS,
    LEARNERS,
    RUNS,
)


def write_study(study: Multiverse, folder: Path) -> None:
    """Writes `report.html`, every picture as SVG, and the data as CSV, into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    data = {
        "runs": study.runs.drop("curve"),
        "multiverse": study.multiverse,
        "maps": study.maps,
        "optima": study.optima,
        "rows": study.rows,
    }
    for name, frame in data.items():
        write_whole(folder / f"{name}.csv", frame.write_csv)
    for name, figure in _figures(study):
        save_figure(figure, folder / f"{name}.svg")
    write_page(study, folder)


def write_page(study: Multiverse, folder: Path) -> None:
    """Writes `report.html` into the folder that holds the pictures, which go into the page.

    Args:
        study: its content; the runs' learning curves are not needed.
        folder: as `write_study` leaves it.
    """
    page = render(
        "report.html",
        Path(__file__).parent,
        figure=lambda name: inlined(folder / f"{name}.svg"),
        shares=claims.shares(study.multiverse, ["measure"]).to_dicts(),
        shares_by_learner=claims.shares(study.multiverse, ["measure", "learner"]).to_dicts(),
        maps=claims.shares(study.maps, ["measure"]).to_dicts(),
        map_names=study.maps["map"].unique().sort().to_list(),
        rows=study.rows.to_dicts(),
        settings=settings_count(study),
        learners=LEARNERS,
        betas=BETAS,
        horizons=HORIZONS,
        runs=RUNS,
        trained=len(study.runs),
    )
    write_whole(folder / "report.html", lambda file: file.write(page.encode()))


def settings_count(study: Multiverse) -> int:
    """The number of settings of the multiverse: learner, horizon and beta."""
    return study.multiverse.drop_nulls("beta").select("learner", "horizon", "beta").n_unique()


def _figures(study: Multiverse) -> Iterator[tuple[str, Figure]]:
    yield "shares", pictures.shares_figure(_shares(study.multiverse))
    yield "maps-shares", pictures.shares_figure(_shares(study.maps))
    for measure, name in (("episodes", "choices"), ("first success", "choices-first")):
        figure = pictures.choices_figure(study.multiverse, study.changed(), measure)
        yield name, figure
    yield "explained", pictures.explained_figure(claims.explained(study.multiverse))
    yield "maps", pictures.maps_figure(study.maps, "episodes")
    yield "maps-first", pictures.maps_figure(study.maps, "first success")
    curves = paper_curves(study.runs)
    best = {
        world: float(study.runs.filter(map=world)["best_return"].max())  # pyright: ignore[reportArgumentType]
        for world in curves
    }
    yield "curves", pictures.curves_figure(curves, best)
    yield (
        "aggregate",
        pictures.intervals_figure(
            {
                "all worlds and tools": aggregate(study.runs).with_columns(
                    note=pl.lit(""), complete=True
                )
            },
            "episodes to first success / vanilla's mean (interquartile mean, 95 % interval)",
        ),
    )
    yield (
        "shaping",
        pictures.intervals_figure(
            {
                f"{world}, {tool}": _shaping_panel(study.rows, world, tool)
                for world, tool in (("corridor", "picker"), ("yard", "picker"), ("yard", "broom"))
            },
            "episodes to convergence (interquartile mean, 95 % interval)",
        ),
    )


def _shares(verdicts: pl.DataFrame) -> dict[str, pl.DataFrame]:
    titles = {
        "episodes": "episodes to convergence",
        "steps": "environment steps",
        "first success": "episodes to first success",
    }
    return {
        title: claims.shares(verdicts.filter(measure=measure)) for measure, title in titles.items()
    }


def _shaping_panel(rows: pl.DataFrame, world: str, tool: str) -> pl.DataFrame:
    part = rows.filter(map=world, tool=tool).sort("reward", "beta", maintain_order=True)
    names = [
        "vanilla"
        if row["reward"] == "none"
        else f"{row['reward']}, beta {row['beta']:g}, {row['how']}"
        for row in part.iter_rows(named=True)
    ]
    panel = part.select(
        *("middle", "low", "high"),
        pl.Series("agent", names),
        pl.format("{} of {}", "converged", "runs").alias("note"),
        (pl.col("converged") == pl.col("runs")).alias("complete"),
    )
    order = np.argsort([name != "vanilla" for name in names], kind="stable")
    return panel[order.tolist()]
