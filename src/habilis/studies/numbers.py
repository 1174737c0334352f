"""Every number that the paper states about its worlds, recomputed."""

from dataclasses import dataclass

from habilis.studies.measured import measured
from habilis.studies.published import EXPERIMENTS
from habilis.studies.scenes import Scene
from habilis.studies.stated import Stated, load_stated
from habilis.worlds.world import load_world


@dataclass(frozen=True)
class Number:
    """A stated number beside ours.

    Attributes:
        section: where the paper states it.
        text: what it is.
        published: as printed, or the bounds that are meant.
        ours: not rounded.
        unit: "bits" or "steps", or "" for returns.
        agrees: whether ours is the published number, to the digits that were published.
    """

    section: str
    text: str
    published: str
    ours: float
    unit: str
    agrees: bool

    @classmethod
    def of(cls, scene: Scene, stated: Stated) -> "Number":
        """A stated number as it is in a scene."""
        ours = measured(scene, stated)
        agrees = stated.miss(ours) == 0
        return cls(stated.section, stated.text, stated.published, ours, stated.unit, agrees)


def published_numbers() -> list[Number]:
    """All that are printed as numbers, in the worlds of the experiments, in the paper's order."""
    numbers = []
    for experiment in EXPERIMENTS:
        scene, stated = Scene(load_world(experiment.world)), load_stated(experiment.stated)
        printed = [number for number in stated.numbers if number.value is not None]
        numbers += [Number.of(scene, number) for number in printed]
    return numbers
