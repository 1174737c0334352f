"""Six puzzles, each with the losses of its movables."""

from collections.abc import Mapping
from pathlib import Path

import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from habilis.bridges.puzzles.pushworld import PushWorld, load_pushworld
from habilis.bridges.puzzles.shapes import body_colours
from habilis.worlds.pictures.figures import draw_world, new_figure, save_figure
from habilis.worlds.pictures.shapes import INK
from research.tools_in_pushworld.cases import SHOWN

HORIZON = 12
_ACROSS, _DOWN = 1180, 1080  # pixels
_SAMPLE = "#a9cbe0"  # a movable's colour, in the key


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
        left, top = 0.02 + column / 3, 0.99 - 0.475 * row
        title = f"{name}: target {targets[name][1:]}"
        figure.text(left, top, title, fontsize=11, fontweight="bold", color=INK, va="top")
        of_map = figure.add_axes((left, top - 0.305, 0.29, 0.28))
        draw_world(of_map, puzzle)
        whole = (0, 0), puzzle.width, puzzle.height
        of_map.add_patch(Rectangle(*whole, fill=False, edgecolor=INK, clip_on=False))
        of_map.set_anchor("NW")
        key = (pl.col("puzzle") == name) & (pl.col("target") == targets[name])
        table = losses.filter(key & (pl.col("horizon") == HORIZON)).join(
            cases.filter(key), on=["level", "puzzle", "target", "object"], maintain_order="left"
        )
        bars = figure.add_axes((left + 0.015, top - 0.415, 0.275, 0.095))
        _draw_losses(bars, table, body_colours(puzzle))
    bars = [
        Rectangle((0, 0), 1, 1, facecolor=_SAMPLE, edgecolor=INK),
        Rectangle((0, 0), 1, 1, facecolor="white", edgecolor=INK, hatch="///"),
    ]
    labels = [f"bits of {HORIZON}-step object empowerment lost: fixed", "removed"]
    figure.legend(bars, labels, loc=(0.015, 0.02), ncols=2, frameon=False, fontsize=9)
    return figure


def _draw_losses(ax: Axes, table: pl.DataFrame, colours: Mapping[str, str]) -> None:
    """For each movable a solid bar for the loss where it is fixed, a hatched one where removed."""
    lowest, highest = -0.1, 0.5
    for place, row in enumerate(table.iter_rows(named=True)):
        both = (row["lost_fixed"], row["lost_removed"])
        looks = ((colours[row["object"]], ""), ("white", "///"))
        for x, bits, look in zip((place - 0.2, place + 0.2), both, looks, strict=True):
            ax.bar(x, bits, 0.36, color=look[0], hatch=look[1], edgecolor=INK, linewidth=0.8)
            up = bits > -0.005
            ax.annotate(
                f"{bits:.2f}" if abs(bits) >= 0.005 else "0",
                (x, bits),
                (0, 1 if up else -2),
                textcoords="offset points",
                fontsize=7,
                ha="center",
                va="bottom" if up else "top",
                color=INK,
            )
        lowest, highest = min(lowest, *both), max(highest, *both)
    span = highest - lowest
    ax.set(ylim=(lowest - 0.15 * span, highest + 0.2 * span), xlim=(-0.6, max(len(table), 4) - 0.4))
    ax.axhline(0, color=INK, linewidth=0.8)
    for place, row in enumerate(table.iter_rows(named=True)):
        words = f"{row['object'][1:]}: used" if row["steps_through"] else row["object"][1:]
        weight = "bold" if row["steps_through"] else "normal"
        below = ax.get_xaxis_transform()
        ax.text(
            place, -0.02, words, transform=below, ha="center", va="top", fontsize=9, weight=weight
        )
    ax.set(xticks=[], yticks=[])
    ax.set_frame_on(False)
