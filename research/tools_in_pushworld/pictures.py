"""Six puzzles, each with the losses of its movables."""

from collections.abc import Mapping
from pathlib import Path

import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from habilis.bridges.puzzle_shapes import body_colours
from habilis.bridges.pushworld import PushWorld, load_pushworld
from habilis.worlds.pictures.figures import draw_world, new_figure, save_figure
from habilis.worlds.pictures.shapes import INK, STEEL
from research.tools_in_pushworld.cases import SHOWN

HORIZON = 12
_ACROSS, _DOWN = 1180, 1010  # pixels


def save_pictures(
    folder: Path, cases: pl.DataFrame, losses: pl.DataFrame, path: str | Path
) -> None:
    """Writes the picture of the puzzles of `SHOWN`.

    Args:
        folder: PushWorld's.
        cases, losses: the tables `cases.csv` and `losses.csv`.
        path: ends with .png or .svg.
    """
    files = {file.stem: file for file in folder.glob("puzzles/*/*.pwp")}
    puzzles = {name: load_pushworld(files[name]) for name in SHOWN}
    save_figure(figure_of(puzzles, SHOWN, cases, losses), path)


def figure_of(
    puzzles: Mapping[str, PushWorld],
    targets: Mapping[str, str],
    cases: pl.DataFrame,
    losses: pl.DataFrame,
) -> Figure:
    """Puzzles where they begin, and below each the bits that are lost without each movable.

    Args:
        puzzles: up to six, by name.
        targets: for each of them a movable.
        cases, losses: as in `save_pictures`.
    """
    figure = new_figure(_ACROSS, _DOWN)
    for place, (name, puzzle) in enumerate(puzzles.items()):
        row, column = divmod(place, 3)
        left, top = 0.02 + column / 3, 0.985 - 0.5 * row
        title = f"{name}: target {targets[name][1:]}"
        figure.text(left, top - 0.012, title, fontsize=11, fontweight="bold", color=INK, va="top")
        of_map = figure.add_axes((left, top - 0.34, 0.29, 0.295))
        draw_world(of_map, puzzle)
        of_map.add_patch(
            Rectangle((0, 0), puzzle.width, puzzle.height, fill=False, edgecolor=INK, linewidth=1.5)
        )
        of_map.set_anchor("NW")
        key = (pl.col("puzzle") == name) & (pl.col("target") == targets[name])
        table = losses.filter(key & (pl.col("horizon") == HORIZON)).join(
            cases.filter(key), on=["level", "puzzle", "target", "object"]
        )
        bars = figure.add_axes((left + 0.035, top - 0.465, 0.25, 0.115))
        _draw_losses(bars, table, body_colours(puzzle))
    return figure


def _draw_losses(ax: Axes, table: pl.DataFrame, colours: Mapping[str, str]) -> None:
    """For each movable a solid bar for the loss where it is fixed, a hollow one where removed."""
    for place, row in enumerate(table.iter_rows(named=True)):
        colour = colours[row["object"]]
        fixed, removed = row["lost_fixed"], row["lost_removed"]
        ax.bar(place - 0.2, fixed, 0.36, color=colour, edgecolor=INK, linewidth=0.8)
        ax.bar(place + 0.2, removed, 0.36, color="white", edgecolor=INK, linewidth=0.8, hatch="///")
        for x, bits in ((place - 0.2, fixed), (place + 0.2, removed)):
            where = "bottom" if bits >= 0 else "top"
            ax.annotate(
                f"{bits:.2f}", (x, bits), (0, 1 if bits >= 0 else -1), fontsize=6.5,
                textcoords="offset points", ha="center", va=where, color=INK,
            )  # fmt: skip
    names = [
        f"{row['object'][1:]}\nused" if row["steps_through"] else row["object"][1:]
        for row in table.iter_rows(named=True)
    ]
    ax.set_xticks(range(len(names)), names, fontsize=8)
    ax.set_xlim(-0.6, len(names) - 0.4)
    ax.margins(y=0.2)
    ax.axhline(0, color=INK, linewidth=0.8)
    ax.tick_params(axis="y", labelsize=7, colors=STEEL)
    ax.tick_params(axis="x", length=0)
    ax.set_ylabel("bits lost", fontsize=7.5, color=INK)
    ax.spines[["top", "right", "bottom"]].set_visible(False)
