"""Who is compared in which worlds."""

from habilis.studies.comparing.study import Agent, Case, world_of

STEPS = 1_500_000
FITTING = "rake"
"""The one tool with which the goal can be reached, in both worlds."""

CASES = tuple(Case(name, world_of(__package__ or "", name)) for name in ("niche", "shelf"))

OBJECT, VANILLA = "A2C + object empowerment", "A2C"
PPO_OBJECT, PPO_VANILLA = "PPO + object empowerment", "PPO"

AGENTS = (
    Agent.of(VANILLA),
    Agent.of(PPO_VANILLA, algorithm="ppo"),
    Agent.of("A2C + full-state empowerment", "state"),
    Agent.of("A2C + visit counts", "count"),
    Agent.of("A2C + random network distillation", "rnd"),
    Agent.of(OBJECT, "object"),
    Agent.of(PPO_OBJECT, "object", algorithm="ppo"),
)

PAIRS = (
    *((OBJECT, agent.name) for agent in AGENTS[:5]),
    (PPO_OBJECT, PPO_VANILLA),
)
