"""The settings of a training: the page's choices with labels, defaults, and validation."""

from typing import Any

from habilis.learning.algorithms import ALGORITHMS
from habilis.learning.config import COUNT, DEFAULT, DISTILLATION, NO_INTRINSIC
from habilis.studio.fields import checked, number
from habilis.studio.limits import HORIZON, TRAINING
from habilis.studio.scenes import Scene

SETTINGS = (
    *("intrinsic", "horizon", "beta", "runs", "seed", "algorithm", "episodes"),
    *("beta_schedule", "beta_steps", "earned", "episode_limit", "learning_rate", "discount"),
)

INTRINSIC = {
    NO_INTRINSIC: "None",
    "object": "Empowerment over the can",
    "state": "Empowerment over everything",
    "tool": "Empowerment over the tool",
    "agent": "Empowerment over the agent",
    COUNT: "Visit counts",
    DISTILLATION: "Random network distillation",
}
FIRST: dict[str, Any] = {
    "intrinsic": "object",
    "horizon": 3,
    "beta": 0.08,
    "runs": 5,
    "seed": 0,
    "algorithm": DEFAULT,
    "episodes": 2_000,
}
"""Settings of `habilis.learning.config.Config`: those of the paper for the yard."""
WITHOUT_HORIZON = (NO_INTRINSIC, COUNT, DISTILLATION)


def offered() -> dict[str, Any]:
    """The choices in the server's greeting."""
    return {
        "intrinsic": INTRINSIC,
        "algorithms": ALGORITHMS.labels(),
        "without_horizon": WITHOUT_HORIZON,
        "first": FIRST,
    }


def checked_settings(value: Any) -> dict[str, Any]:
    """Settings from a message, within the limits; the library checks whether they make sense.

    Raises:
        ValueError: a field is unknown, or exceeds its limit.
    """
    given = checked("settings", value, (), SETTINGS)
    for name in ("runs", "episodes"):
        if name in given:
            number(name, given[name], 1, TRAINING[name], whole=True)
    if "horizon" in given:
        number("horizon", given["horizon"], 0, HORIZON, whole=True)
    return given


def check_trainable(scene: Scene) -> None:
    """Refuses worlds that would take too long to train in.

    Raises:
        ValueError: the world has too many placements.
    """
    free, world = len(scene.world.free_cells), scene.world
    placements = free ** (1 + len(world.objects)) * (1 + 4 * len(world.tools))
    if placements > TRAINING["placements"]:
        raise ValueError(
            f"{world.name}: has up to {placements:,} placements; train on at most "
            f"{TRAINING['placements']:,}: make the map smaller"
        )
