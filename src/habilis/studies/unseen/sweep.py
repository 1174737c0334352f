"""Who is compared, after training from how many placements."""

from habilis.studies.comparing.study import Agent, Case, world_of

STEPS = 1_000_000
STARTS = (64,)
HELD_OUT = 100

_ROOM = world_of(__package__ or "", "room")
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
