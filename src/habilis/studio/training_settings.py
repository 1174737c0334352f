"""The settings of a training: the page's choices with labels, defaults, and limits."""

from habilis.learning.algorithms import ALGORITHMS
from habilis.learning.config import COUNT, DEFAULT, DISTILLATION, NO_INTRINSIC
from habilis.studio.limits import TRAINING
from habilis.studio.protocol.hello import FirstSettings, Offered
from habilis.studio.scenes import Scene

INTRINSIC = {
    NO_INTRINSIC: "None",
    "object": "Empowerment over the can",
    "state": "Empowerment over everything",
    "tool": "Empowerment over the tool",
    "agent": "Empowerment over the agent",
    COUNT: "Visit counts",
    DISTILLATION: "Random network distillation",
}
FIRST = FirstSettings(
    intrinsic="object",
    horizon=3,
    beta=0.08,
    runs=5,
    seed=0,
    algorithm=DEFAULT,
    episodes=2_000,
)
"""Settings of `habilis.learning.config.Config`: those of the paper for the yard."""
WITHOUT_HORIZON = (NO_INTRINSIC, COUNT, DISTILLATION)


def offered() -> Offered:
    """The choices in the server's greeting."""
    return Offered(INTRINSIC, ALGORITHMS.labels(), list(WITHOUT_HORIZON), FIRST)


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
