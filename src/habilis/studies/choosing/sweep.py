"""Who is compared in which worlds."""

from habilis.studies.comparing.study import Agent, Case, world_of

STEPS = 1_500_000
FITTING = "rake"
"""The one tool with which the goal can be reached, in both worlds."""

CASES = tuple(Case(name, world_of(__package__ or "", name)) for name in ("niche", "shelf"))

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
