"""Who is compared."""

from habilis.studies.comparing.study import Agent, Case, world_of

STEPS = 1_500_000

CASES = (Case("pair", world_of(__package__ or "", "pair")),)

VANILLA = "A2C"
SUM, PRODUCT = "A2C + sum of both cans", "A2C + product of both cans"
FIRST, SECOND = "A2C + first can", "A2C + second can"

AGENTS = (
    Agent.of(VANILLA),
    Agent.of("PPO", algorithm="ppo"),
    Agent.of(FIRST, "object:can"),
    Agent.of(SECOND, "object:can2"),
    Agent.of(SUM, "object:can + object:can2"),
    Agent.of(PRODUCT, "object:can * object:can2"),
)

PAIRS = (
    *((one, VANILLA) for one in (FIRST, SECOND, SUM, PRODUCT)),
    *((SUM, other) for other in ("PPO", FIRST, SECOND, PRODUCT)),
)
