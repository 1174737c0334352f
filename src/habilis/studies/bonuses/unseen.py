"""Training from some placements of tool and object: success from placements never seen."""

import polars as pl
from matplotlib.figure import Figure

from habilis.learning.replay import success
from habilis.learning.runs import Run
from habilis.studies.bonuses.figures import shares_panel
from habilis.studies.bonuses.study import CONVERGENCE, Agent, Case, Measure, Study, world_of

STEPS = 1_000_000
STARTS = (64,)
HELD_OUT = 100

_ROOM = world_of("room")
CASES = tuple(
    Case(f"{count} placements", _ROOM, {"starts": count, "unseen": HELD_OUT}) for count in STARTS
)

AGENTS = (
    Agent.of("A2C"),
    Agent.of("A2C + object empowerment", "object"),
    Agent.of("PPO", algorithm="ppo"),
    Agent.of("PPO + object empowerment", "object", algorithm="ppo"),
)

PAIRS = tuple((f"{learner} + object empowerment", learner) for learner in ("A2C", "PPO"))

UNSEEN = Measure("unseen", "success from unseen placements", False)
SEEN = Measure("seen", "success from those of training", False)


def measure_run(run: Run, index: int) -> dict[str, float | None]:
    """The success rates of a run's greedy policy."""
    return dict(success(run, index)._asdict())


def figure(table: pl.DataFrame, runs: pl.DataFrame) -> Figure:
    """Success rates: every run, and the mean over them with its interval.

    Args:
        table: of `analysis.summary`.
        runs: a row a run, as `training.trained` has them.
    """
    cases = table["case"].unique(maintain_order=True).to_list()
    agents = table["agent"].unique(maintain_order=True).to_list()
    size = 9.6, (0.8 + 0.32 * len(agents)) * len(cases)
    drawn = Figure(figsize=size, dpi=96)
    axes = drawn.subplots(len(cases), 2, sharex=True, sharey=True, squeeze=False)
    for row, case in zip(axes, cases, strict=True):
        for ax, measure in zip(row, (SEEN, UNSEEN), strict=True):
            shares_panel(ax, table.filter(case=case), runs.filter(case=case), measure)
            ax.set_title(f"{case}: {measure.title}", fontsize=9)
        row[0].set_yticks(range(len(agents)), agents, fontsize=8)
    axes[0, 0].invert_yaxis()
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
    measures=(UNSEEN, SEEN, CONVERGENCE),
    measure_run=measure_run,
    figure=figure,
    caption="Success of the greedy policy from the placements that it was trained from (left) and "
    "from others (right): every run, and the mean over them with its 95 % bootstrap interval.",
    steps=STEPS,
)
