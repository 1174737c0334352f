"""Searching for maps that are different from each other until there are enough."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import count
from random import Random

from habilis.studies.paper.targets import TargetMap
from habilis.studies.reconstruction.annealing import Schedule, anneal
from habilis.studies.reconstruction.energy import Weighed
from habilis.studies.reconstruction.shapes import difference
from habilis.worlds.world import World

LEAST_DIFFERENCE = 0.6
"""The share of walls and things in which a map differs from every other; see `difference`."""

Report = Callable[[str], None]


@dataclass(frozen=True)
class Attempt:
    """The result of one attempt.

    Attributes:
        number: which it was, from 1.
        best: the map and how far it is off.
        found: whether the map meets everything and is different from all others.
    """

    number: int
    best: Weighed
    found: bool


def attempts(
    targets: TargetMap,
    seed: int,
    known: Sequence[World] = (),
    begin: World | None = None,
    schedule: Schedule | None = None,
    report: Report = lambda line: None,
    first: int = 1,
) -> Iterator[Attempt]:
    """One attempt after another, without end; the same for the same arguments.

    Args:
        targets: the numbers that maps have to meet.
        seed: of the randomness.
        known: maps from which those found must differ.
        begin: the map to begin with each time; by default one at random.
        schedule: the length of an attempt, by default 2000 changes.
        report: called with the progress, in words.
        first: the number of the attempt to begin with; each is seeded for itself.
    """
    schedule = schedule or Schedule()
    others = list(known)

    def different(world: World) -> bool:
        return all(difference(world, other) >= LEAST_DIFFERENCE for other in others)

    for number in count(first):

        def show(changes: int, energy: float, number: int = number) -> None:
            report(
                f"{targets.name}: {len(others) - len(known)} found; attempt {number}, change "
                f"{changes} of {schedule.changes}, best {energy:.2f} off"
            )

        random = Random(f"{seed}-{number - 1}")
        best, found = anneal(targets, random, schedule, show, begin, different)
        if found:
            others.append(best.world)
        yield Attempt(number, best, found)
