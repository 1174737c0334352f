"""Simulated annealing over walls and start cells (Kirkpatrick, Gelatt and Vecchi 1983)."""

from collections.abc import Callable
from dataclasses import dataclass
from math import log
from random import Random

from habilis.studies.paper.targets import TargetMap
from habilis.studies.reconstruction.energy import Weighed, weigh
from habilis.studies.reconstruction.moves import neighbour, random_map
from habilis.worlds.world import World

Show = Callable[[int, float], None]
"""Called with the number of changes tried, and the lowest energy so far."""


@dataclass(frozen=True)
class Schedule:
    """The length of one attempt, and its cooling.

    Attributes:
        changes: how many are tried at most.
        hot, cold: temperatures at the beginning and at the end, in units of energy; in between
            they fall by the same factor at each change.
    """

    changes: int = 2000
    hot: float = 1.0
    cold: float = 0.08

    def temperature(self, change: int) -> float:
        return self.hot * (self.cold / self.hot) ** (change / self.changes)


def anneal(
    targets: TargetMap,
    random: Random,
    schedule: Schedule,
    show: Show,
    begin: World | None = None,
    wanted: Callable[[World], bool] = lambda world: True,
) -> tuple[Weighed, bool]:
    """One attempt.

    A change that raises the energy by d is taken with probability exp(-d / temperature).

    Args:
        targets: the numbers that the map has to meet.
            random: the source of all random numbers.
        schedule: length and cooling.
        show: called with the progress.
        begin: the map to begin with; by default one at random.
        wanted: whether a map that meets everything is one to stop at.

    Returns:
        The first map that meets all numbers (energy 0) and is wanted, and True; or else the best
        that was met, and False.
    """
    first = (begin or random_map(targets, random)).with_reading(targets.reading)
    here = weigh(first, targets.numbers, over=targets.over)
    assert here is not None, "there was no limit"
    best = here
    for change in range(schedule.changes):
        if here.energy == 0 and wanted(here.world):
            return here, True
        # Drawn before the energy is known, so that its computation can be cut short.
        rise = -schedule.temperature(change) * log(1 - random.random())
        world, limit = neighbour(here.world, random), here.energy + rise
        there = weigh(world, targets.numbers, limit, here, targets.over)
        if there is not None:
            here = there
            best = min(best, here, key=lambda weighed: weighed.energy)
        show(change + 1, best.energy)
    return (here, True) if here.energy == 0 and wanted(here.world) else (best, False)
