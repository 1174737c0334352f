"""The choices of a training on the page, with labels, and its initial settings."""

from typing import Any

from habilis.learning.config import COUNT, DISTILLATION, NO_INTRINSIC

INTRINSIC = {
    NO_INTRINSIC: "None",
    "object": "Empowerment over the can",
    "state": "Empowerment over everything",
    "tool": "Empowerment over the tool",
    "agent": "Empowerment over the agent",
    COUNT: "Visit counts",
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
"""Settings of `habilis.learning.config.Config`: those of the paper for the yard."""
WITHOUT_HORIZON = (NO_INTRINSIC, COUNT, DISTILLATION)


def offered() -> dict[str, Any]:
    """The choices in the server's greeting."""
    return {
        "intrinsic": INTRINSIC,
        "algorithms": ALGORITHMS,
        "without_horizon": WITHOUT_HORIZON,
        "first": FIRST,
    }
