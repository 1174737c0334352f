"""Two objects with a goal each: the empowerment of which of them helps to bring both home?"""

from habilis.learning.runs import Run
from habilis.studies.bonuses.figures import CAPTION, episodes_figure
from habilis.studies.bonuses.study import CONVERGENCE, FIRST_SUCCESS, Agent, Case, Study, world_of

STEPS = 1_500_000

CASES = (Case("pair", world_of("pair")),)

VANILLA = "A2C"
SUM, PRODUCT = "A2C + sum of both cans", "A2C + product of both cans"
FIRST_CAN, SECOND_CAN = "A2C + first can", "A2C + second can"

AGENTS = (
    Agent.of(VANILLA),
    Agent.of("PPO", algorithm="ppo"),
    Agent.of(FIRST_CAN, "object:can"),
    Agent.of(SECOND_CAN, "object:can2"),
    Agent.of(SUM, "object:can + object:can2"),
    Agent.of(PRODUCT, "object:can * object:can2"),
)

PAIRS = (
    *((one, VANILLA) for one in (FIRST_CAN, SECOND_CAN, SUM, PRODUCT)),
    *((SUM, other) for other in ("PPO", FIRST_CAN, SECOND_CAN, PRODUCT)),
)


def measure_run(run: Run, index: int) -> dict[str, float]:
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
    measures=(CONVERGENCE, FIRST_SUCCESS),
    measure_run=measure_run,
    figure=lambda table, runs: episodes_figure(table, runs, (CONVERGENCE,)),
    caption=CAPTION,
    steps=STEPS,
)
