"""Does empowerment help the more, the slower the learner is?

The hypothesis is one about learners: within a row of the tables, the ratio of regularised to
vanilla episodes should fall as the vanilla agent of the learner is slower. The ratio has the
vanilla agent's mean below the line, so that its noise alone would make the two go together; each
vanilla agent's runs are therefore split at random: one half says how slow it is, the other goes
into the ratio.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import polars as pl
from jaxtyping import Float

from habilis.statistics import spearman
from habilis.studies.comparison import Outcome
from habilis.studies.pace.data import MEASURES, AgentRuns, Learner
from habilis.studies.paper.published import EXPERIMENTS, Experiment, Row

_REPEATS = 2000
_FEWEST = 4  # learners over which a correlation says something

WAYS = ("ratio", "order")
"""The two comparisons. "ratio": mean vanilla episodes with the ratio of means, in which a run that
exceeded its budget counts with the episodes it had. "order": the vanilla median with how often the
vanilla agent comes first, where such a run is later than all others. Where there are such runs,
trust the order: their episodes are few where each of them is long."""

Sides = tuple[AgentRuns, AgentRuns]
"""A regularised agent, and the vanilla one of the same learner, map and tool."""


@dataclass(frozen=True)
class Association:
    """The association of the ratio of regularised to vanilla with the slowness of the learner.

    Attributes:
        measure: one of `data.MEASURES`.
        by: one of `WAYS`.
        middle: Spearman's rank correlation over the learners, averaged over the rows and over
            random halves of the vanilla runs.
        low, high: the ends of its 95 % bootstrap interval, learners resampled.
        learners: how many there are.
        below, marks: how many of the ratios are below 1, of how many.
    """

    measure: str
    by: str
    middle: float
    low: float
    high: float
    learners: int
    below: int
    marks: int

    @property
    def outcome(self) -> Outcome:
        """Whether slower learners are helped more: undecided where the interval holds 0."""
        if self.high < 0:
            return Outcome.HOLDS
        return Outcome.OPPOSITE if self.low > 0 else Outcome.UNDECIDED


def regularised_rows() -> list[tuple[Experiment, Row, Row]]:
    """The rows with a bonus, each with the vanilla row of its tool."""
    return [
        (experiment, row, vanilla)
        for experiment in EXPERIMENTS
        for row in experiment.rows
        for vanilla in experiment.rows
        if vanilla.vanilla and not row.vanilla and vanilla.tool == row.tool
    ]


def marks(learners: Sequence[Learner]) -> pl.DataFrame:
    """The marks of the figure: a row for each learner, row of the tables, and measure.

    Returns:
        "learner", "source", "row", "measure", "vanilla" (mean episodes), "ratio" (mean episodes
        regularised over vanilla, in which runs that exceeded their budget count with the episodes
        they had), and whether it is "complete" (no run of either exceeded its budget).
    """
    rows = [
        {"learner": learner.name, "source": learner.source, "row": row.label, "measure": measure}
        | {"vanilla": float(bare.budgeted(measure).mean())}
        | {"ratio": float(agent.budgeted(measure).mean() / bare.budgeted(measure).mean())}
        | {"complete": all(one.came(measure) == one.runs for one in (agent, bare))}
        for measure in MEASURES
        for experiment, row, vanilla in regularised_rows()
        for learner in learners
        for agent, bare in _sides(learner, experiment, row, vanilla)
    ]
    kinds = {"vanilla": pl.Float64, "ratio": pl.Float64, "complete": pl.Boolean}
    names = ("learner", "source", "row", "measure")
    return pl.DataFrame(rows, schema=dict.fromkeys(names, pl.String) | kinds)


def association(
    learners: Sequence[Learner],
    measure: str,
    by: str = "ratio",
    repeats: int = _REPEATS,
    seed: int = 0,
) -> Association | None:
    """The association of the ratio with slowness, by ranks (see the module's docstring).

    Args:
        learners: of all kinds together; those without all rows are left out.
        measure: one of `data.MEASURES`.
        by: one of `WAYS`.
        repeats: how often runs are split, and learners resampled.
        seed: of both.

    Returns:
        The association; `None` where there are fewer than four learners.

    Raises:
        ValueError: a vanilla agent has a single run.
    """
    rows = regularised_rows()
    whole = [one for one in learners if all(_sides(one, *row) for row in rows)]
    if len(whole) < _FEWEST:
        return None
    random = np.random.default_rng(seed)
    drawn = random.integers(len(whole), size=(repeats, len(whole)))
    once, resampled = np.empty((2, len(rows), repeats))
    for at, row in enumerate(rows):
        halves = [_halves(_sides(one, *row)[0], measure, by, repeats, random) for one in whole]
        slowness, ratio = (np.stack(part, axis=1) for part in zip(*halves, strict=True))
        once[at] = spearman(slowness, ratio)
        resampled[at] = spearman(*(np.take_along_axis(x, drawn, axis=1) for x in (slowness, ratio)))
    ratios = marks(whole).filter(measure=measure)["ratio"]
    low, high = np.quantile(resampled.mean(axis=0), [0.025, 0.975])
    return Association(
        *(measure, by),
        *(float(once.mean()), float(low), float(high)),
        *(len(whole), int((ratios < 1).sum()), len(ratios)),
    )


def _sides(learner: Learner, experiment: Experiment, row: Row, vanilla: Row) -> list[Sides]:
    agent, bare = learner.agent(experiment, row), learner.agent(experiment, vanilla)
    return [] if agent is None or bare is None else [(agent, bare)]


def _halves(
    sides: Sides, measure: str, by: str, repeats: int, random: np.random.Generator
) -> tuple[Float[np.ndarray, "repeats"], Float[np.ndarray, "repeats"]]:
    """The vanilla agent's slowness by one half of its runs, and the comparison by the other."""
    ratio = by == "ratio"
    agent, bare = (one.budgeted(measure) if ratio else one.counts[measure] for one in sides)
    if len(bare) < 2:
        raise ValueError("a vanilla agent has a single run; give at least two to split")
    order = np.argsort(random.random((repeats, len(bare))), axis=1)
    cut = len(bare) // 2
    one, other = bare[order[:, :cut]], bare[order[:, cut:]]
    if ratio:
        return one.mean(axis=1), agent.mean() / other.mean(axis=1)
    later = (agent > other[..., None]) + 0.5 * (agent == other[..., None])
    return np.median(one, axis=1), later.mean(axis=(1, 2))


def sentence(found: Association) -> str:
    """The verdict on the hypothesis by one measure, as a sentence."""
    words = {
        Outcome.HOLDS: "the hypothesis holds",
        Outcome.UNDECIDED: "the hypothesis is undecided",
        Outcome.OPPOSITE: "the opposite of the hypothesis comes out",
    }
    below = f" {found.below} of {found.marks} ratios are below 1." if found.by == "ratio" else ""
    return (
        f"By episodes to {found.measure}, over {found.learners} learners, the rank correlation of "
        f"slowness and {found.by} is {found.middle:+.2f} [{found.low:+.2f}, {found.high:+.2f}]: "
        f"{words[found.outcome]}.{below}"
    ).replace("-", "−")
