"""Tools in the hand of a planar robot: the figures of docs/explanation/robots.md.

    python -m research.robots         # a quarter of an hour on two processors
    python -m research.robots check   # larger searches in some placements, five minutes
    python -m research.robots noisy   # noisy controls, a minute

Writes research/results/robots.csv, a row for each tool, placement and search, and the pictures and
the table beside the page. What robots.csv has is not computed again.
"""

import sys
from pathlib import Path

import numpy as np
import polars as pl

from habilis.estimators import Counting, MonteCarlo
from habilis.files import write_whole
from habilis.robots import (
    PushingSimulator,
    Reach,
    ToolComparison,
    compare_tools,
    draw_comparison,
    puck_placements,
    push_plan,
    push_scenes,
)
from habilis.robots.comparison import SEQUENCES
from habilis.worlds.pictures.figures import save_figure
from habilis.worlds.pictures.video import save_video

MODEL = "reach.xml"
TOOLS = ("none", "stick", "hook", "scoop")
HORIZON, SIDE, SEEDS = 8, 10, 4
RESULTS = Path(__file__).parent / "results" / "robots.csv"
PAGE = Path(__file__).parent.parent / "docs" / "explanation" / "robots"
PULL = (0.1, 0.7), (0.1, 0.4)
"""Where the puck is, and where the film's plan brings it."""


def long_table(found: ToolComparison) -> pl.DataFrame:
    """A row for each tool, placement and search."""
    rows = [
        {
            "tool": tool,
            "placement": place,
            "seed": seed,
            "bits": found.bits[row, place, seed],
            "latency": found.latency[row, place],
            "distance": found.distance[place],
        }
        for row, tool in enumerate(found.tools)
        for place in range(found.bits.shape[1])
        for seed in range(found.bits.shape[2])
    ]
    return pl.DataFrame(rows)


def comparison() -> ToolComparison:
    """The comparison, from the results if they are there."""
    if not RESULTS.exists():
        found = compare_tools(MODEL, TOOLS, HORIZON, side=SIDE, seeds=SEEDS, show_progress=True)
        write_whole(RESULTS, long_table(found).write_csv)
    table = pl.read_csv(RESULTS).sort("tool", "placement", "seed")
    where = puck_placements([PushingSimulator(MODEL, tool) for tool in TOOLS], SIDE)
    count = len(where.positions)

    def of(name: str, tool: str) -> np.ndarray:
        values = table.filter(tool=tool)[name].cast(pl.Float64).to_numpy()
        return values.reshape(count, SEEDS)

    return ToolComparison(
        TOOLS,
        where,
        np.stack([of("bits", tool) for tool in TOOLS]),
        np.stack([of("latency", tool)[:, 0] for tool in TOOLS]),
        of("distance", TOOLS[0])[:, 0],
        HORIZON,
        "lower bound",
    )


def regions(found: ToolComparison) -> pl.DataFrame:
    """The averages behind the wall, past it, and in the hand's own reach."""
    x, y = found.placements.positions.T
    beyond, left = y > Reach().wall, x < Reach().side / 2 - Reach().opening
    near = y < Reach().reach + 2 * Reach().radius
    masks = {
        "behind the wall": beyond & left,
        "on the open shelf": beyond & ~left,
        "between": ~beyond & ~near,
        "near the hand, left": near & left,
        "near the hand, right": near & ~left,
    }
    judged = found.verdicts("hook", "stick")
    rows = []
    for name, mask in masks.items():
        bits = dict(zip(found.tools, found.bits[:, mask].mean(axis=(1, 2)), strict=True))
        hook = {"hook better": judged.better[mask].sum(), "hook worse": judged.worse[mask].sum()}
        rows.append({"puck": name, "placements": mask.sum(), **bits, **hook})
    return pl.DataFrame(rows)


def film() -> list[int]:
    """A plan with the hook, and its film."""
    start, goal = PULL
    simulator = PushingSimulator(MODEL, "hook")
    state = simulator.placed([start])[0]
    plan = push_plan(simulator, state, goal)
    save_video(push_scenes(simulator, state, plan, goal), PAGE / "plan.gif", 24, 60)
    return plan.tolist()


def check() -> None:
    """Compares with searches that go on from four times as many states."""
    few, many = (
        compare_tools(MODEL, TOOLS, HORIZON, side=4, seeds=2, method=Counting(0.05, sequences))
        for sequences in (SEQUENCES, 4 * SEQUENCES)
    )
    for place, tool in enumerate(TOOLS):
        print(f"{tool}: {few.averages[place]:.3f} bits, {many.averages[place]:.3f}")
    for tool in TOOLS[1:]:
        first, second = few.verdicts(tool), many.verdicts(tool)
        turned = (first.better & second.worse) | (first.worse & second.better)
        changed = (first.better != second.better) | (first.worse != second.worse)
        print(f"{tool} against none: {turned.sum()} reversed, {changed.sum()} changed")


def noisy() -> None:
    """Compares the tools with noisy controls."""
    method = MonteCarlo(60, 12, "gaussian", noise=0.025, tolerance=0.1)
    found = compare_tools(MODEL, TOOLS, 5, side=4, seeds=4, noise=0.2, method=method)
    with pl.Config(tbl_cols=-1, float_precision=3, tbl_width_chars=240):
        print(found.frame())


def main() -> None:
    PAGE.mkdir(exist_ok=True)
    found = comparison()
    save_figure(draw_comparison(found, MODEL), PAGE / "landscape.png")
    save_figure(draw_comparison(found, MODEL, "stick"), PAGE / "against-stick.png")
    with pl.Config(tbl_cols=-1, float_precision=3, tbl_width_chars=240):
        print(found.frame(), regions(found))
    for tool, than in (("hook", "stick"), ("scoop", "hook"), ("scoop", "stick")):
        judged, ends = found.verdicts(tool, than), found.gain(than)
        place = found.tools.index(tool)
        print(
            f"{tool} against {than}: gain {ends[0][place]:.3f} to {ends[1][place]:.3f} bits, "
            f"better in {judged.better.mean():.2f}, worse in {judged.worse.mean():.2f}, "
            f"undecided in {judged.undecided.mean():.2f}"
        )
    print("plan:", film())


if __name__ == "__main__":
    parts = {"check": check, "noisy": noisy}
    parts.get(" ".join(sys.argv[1:]), main)()
