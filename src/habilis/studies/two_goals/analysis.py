"""How soon both objects are brought to their goals."""

from habilis.learning.runs import Run
from habilis.studies.comparing.pictures import CAPTION, episodes_figure
from habilis.studies.comparing.study import CONVERGED, FIRST, Study
from habilis.studies.two_goals.sweep import AGENTS, CASES, PAIRS, STEPS


def tell(run: Run, index: int) -> dict[str, float]:
    """Nothing besides episodes to first success and to convergence."""
    return {}


STUDY = Study(
    name="two-goals",
    title="Two objects, two goals",
    question="Two cans, each with a goal of its own, and a picker. Of which can should the agent "
    "be given the empowerment: of the one, of the other, the sum of both, or their product?",
    cases=CASES,
    agents=AGENTS,
    pairs=PAIRS,
    measures=(CONVERGED, FIRST),
    tell=tell,
    figure=lambda table, runs: episodes_figure(table, runs, (CONVERGED,)),
    caption=CAPTION,
    steps=STEPS,
)
