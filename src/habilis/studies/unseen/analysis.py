"""From what share of placements, seen and unseen, a trained agent reaches the goal."""

import numpy as np
import polars as pl
from matplotlib.figure import Figure

from habilis.colours import COLOURS
from habilis.learning.replay import success
from habilis.learning.runs import Run
from habilis.studies.comparing.study import CONVERGED, Measure, Study
from habilis.studies.unseen.sweep import AGENTS, CASES, HELD_OUT, PAIRS, STEPS

UNSEEN = Measure("unseen", "success from unseen placements", False)
SEEN = Measure("seen", "success from those of training", False)


def tell(run: Run, index: int) -> dict[str, float | None]:
    """The success rates of a run's greedy policy."""
    return dict(success(run, index)._asdict())


def figure(table: pl.DataFrame, runs: pl.DataFrame) -> Figure:
    """Success rates over the number of placements that agents were trained from."""
    drawn = Figure(figsize=(10, 4.2), dpi=96)
    axes = drawn.subplots(1, 2, sharey=True)
    cases = table["case"].unique(maintain_order=True).to_list()
    places = np.arange(len(cases))
    for ax, measure in zip(axes, (SEEN, UNSEEN), strict=True):
        for number, agent in enumerate(AGENTS):
            rows = table.filter(agent=agent.name)
            middle, low, high = (
                rows[measure.column + end].to_numpy() for end in ("", "_low", "_high")
            )
            colour = COLOURS[number // 2]
            style = "-" if agent.has_bonus else "--"
            x = places + 0.06 * (number - (len(AGENTS) - 1) / 2)
            ax.plot(x, middle, style, color=colour, label=agent.name, linewidth=1.4)
            ax.errorbar(
                *(x, middle, [middle - low, high - middle]),
                **{"fmt": "o", "color": colour, "markersize": 5, "capsize": 3},
            )
        ax.set(title=measure.title, xlabel="placements trained from", ylim=(-0.02, 1.04))
        ax.set_xticks(places, [str(case).removesuffix(" placements") for case in cases])
        ax.spines[["top", "right"]].set_visible(False)
    axes[0].set_ylabel("share from which the goal is reached")
    axes[1].legend(frameon=False, loc="upper left")
    drawn.tight_layout()
    return drawn


STUDY = Study(
    name="unseen",
    title="Placements never seen",
    question="Tool and can are put into random cells for every episode, out of so many placements. "
    f"Afterwards the greedy policy begins in {HELD_OUT} others. Does object empowerment in the "
    "reward help it there? Every run has placements of its own.",
    cases=CASES,
    agents=AGENTS,
    pairs=PAIRS,
    measures=(UNSEEN, SEEN, CONVERGED),
    tell=tell,
    figure=figure,
    caption="Success of the greedy policy from placements that it was trained from (left) and from "
    "others (right): means over runs, and 95 % bootstrap intervals.",
    steps=STEPS,
)
