"""What a training on the page may choose from, in words, and what is chosen at first."""

from typing import Any

from habilis.learning.config import COUNT, DISTILLATION, NO_INTRINSIC

INTRINSIC = {
    NO_INTRINSIC: "None",
    "object": "Empowerment over the can",
    "state": "Empowerment over everything",
    "tool": "Empowerment over the tool",
    "agent": "Empowerment over the agent",
    COUNT: "Counts of visits",
    DISTILLATION: "Random network distillation",
}
ALGORITHMS = {
    "a2c": "A2C",
    "ppo": "PPO",
    "q-learning": "Q-learning",
    "soft-value-iteration": "Soft value iteration",
}
FIRST: dict[str, Any] = {
    "intrinsic": "object",
    "horizon": 3,
    "beta": 0.08,
    "runs": 5,
    "seed": 0,
    "algorithm": "a2c",
    "episodes": 2_000,
}
"""Settings as `habilis.learning.config.Config` has them: of the yard, the paper's."""
WITHOUT_HORIZON = (NO_INTRINSIC, COUNT, DISTILLATION)


def offered() -> dict[str, Any]:
    """As a page is told of it."""
    return {
        "intrinsic": INTRINSIC,
        "algorithms": ALGORITHMS,
        "without_horizon": WITHOUT_HORIZON,
        "first": FIRST,
    }
