"""Several tools on a map, of which only one fits: which reward leads an agent to it?"""

import polars as pl

from habilis.learning.runs import Run
from habilis.studies.bonuses.figures import CAPTION, episodes_figure
from habilis.studies.bonuses.study import (
    CONVERGENCE,
    FIRST_SUCCESS,
    Agent,
    Case,
    Measure,
    Study,
    world_of,
)

STEPS = 1_500_000
FITTING = "rake"
"""The one tool with which the goal can be reached, in both worlds."""

CASES = tuple(Case(name, world_of(name)) for name in ("niche", "shelf"))

OBJECT = "A2C + object empowerment"

AGENTS = (
    Agent.of("A2C"),
    Agent.of("PPO", algorithm="ppo"),
    Agent.of("A2C + full-state empowerment", "state"),
    Agent.of("A2C + visit counts", "count"),
    Agent.of("A2C + random network distillation", "rnd"),
    Agent.of(OBJECT, "object"),
)

PAIRS = tuple((OBJECT, agent.name) for agent in AGENTS if agent.name != OBJECT)

EARLY, LATE = 1_000, 100
"""The numbers of first and of last episodes over which shares are taken."""


def measure_run(run: Run, index: int) -> dict[str, float]:
    """In what shares of a run's early and late episodes it has the fitting tool in hand.

    For most of their steps: where tools can be put down, a long episode meets them all.
    """
    episodes = run.episodes.filter(run=index)
    had = episodes.select(2 * pl.col(f"equipped:{FITTING}") > pl.col("steps")).to_series()
    return {"early": _share(had.head(EARLY)), "late": _share(had.tail(LATE))}


def _share(had: pl.Series) -> float:
    return float(had.cast(pl.Float64).sum() / max(1, len(had)))


STUDY = Study(
    name="choosing",
    title="The tool that fits",
    question="There are several tools, and with only one of them, the rake, can the can be "
    "brought to its goal. In niche the first tool that the agent comes to stays in its hand; in "
    "shelf it can be put down. Which reward leads to the rake, and to the goal, sooner? The rake "
    "counts as in hand in an episode where it is for most of its steps.",
    cases=CASES,
    agents=AGENTS,
    pairs=PAIRS,
    measures=(
        CONVERGENCE,
        FIRST_SUCCESS,
        Measure("early", f"rake in hand in the first {EARLY:,} episodes", False),
        Measure("late", f"rake in hand in the last {LATE} episodes", False),
    ),
    measure_run=measure_run,
    figure=episodes_figure,
    caption=CAPTION,
    steps=STEPS,
)
