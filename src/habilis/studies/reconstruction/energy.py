"""The distance of a map from meeting a list of stated numbers."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite, log1p

from habilis.studies.paper.numbers import measure
from habilis.studies.paper.targets import Target
from habilis.studies.paper.worlds import OVER, CachedWorld
from habilis.worlds.world import NO_TOOL, World

_FAR = 1000.0  # in tolerances: a number that is undefined in a map
_COST = {"apart": 0, "steps": 1, "return": 1, "landscape": 2, "average": 3}
_THINGS = ("agent", "object", "goal", "tool_cell")


@dataclass(frozen=True)
class Weighed:
    """A map and how far it is off.

    Attributes:
        cached: of the map.
        parts: what each stated number adds; 0 where it is met.
    """

    cached: CachedWorld
    parts: tuple[float, ...]

    @property
    def world(self) -> World:
        return self.cached.world

    @property
    def energy(self) -> float:
        return sum(self.parts)


def weigh(
    world: World,
    numbers: Sequence[Target],
    limit: float = float("inf"),
    before: Weighed | None = None,
    over: str = OVER[0],
) -> Weighed | None:
    """The energy of a map: the sum over the stated numbers of log(1 + miss in tolerances).

    The quickest numbers are computed first, and no more of them once the sum is above the limit.

    Args:
        world: the map.
        numbers: the targets that it has to meet.
        limit: the largest energy that is of interest.
        before: another map; what cannot have changed from it is not computed again.
        over: the states over which averages go, for the other map, too.

    Returns:
        `None` above the limit.
    """
    cached = CachedWorld(world, over)
    parts: dict[int, float] = {}
    if before is not None:
        changed = {name for name in ("walls", *_THINGS) if _differ(world, before.world, name)}
        parts = {
            i: before.parts[i] for i, s in enumerate(numbers) if not changed & looks_at(s, over)
        }
        if not changed & {"walls", "tool_cell"}:
            cached = before.cached.restarted(world)
    total = sum(parts.values())
    for i in sorted(set(range(len(numbers))) - set(parts), key=lambda i: _cost(numbers[i])):
        if total > limit:
            return None
        parts[i] = _part(numbers[i], measure(cached, numbers[i]))
        total += parts[i]
    weighed = Weighed(cached, tuple(parts[i] for i in range(len(numbers))))
    return weighed if weighed.energy <= limit else None


def looks_at(target: Target, over: str = OVER[0]) -> frozenset[str]:
    """The fields of a world that a stated number depends on, averages going over some states."""
    if target.kind == "apart":
        return frozenset({target.of, "tool_cell"})
    if target.kind == "average":
        everything = {"walls", "agent", "object", "tool_cell"}
        seen = {"equipped": {"walls"}, "all": {"walls", "tool_cell"}, "reachable": everything}
        return frozenset(seen[over])
    if target.placed:
        return frozenset({"walls"})
    if target.kind == "landscape":
        around = {"goal"} if target.around == "goal" else set()
        return frozenset({"walls", "tool_cell", "object"} | around)
    return frozenset({"walls", *_THINGS} - ({"tool_cell"} if target.tool == NO_TOOL else set()))


def _differ(one: World, other: World, name: str) -> bool:
    return getattr(one, name) != getattr(other, name)


def _cost(target: Target) -> tuple[bool, bool, bool, int]:
    return target.kind != "apart", target.tool != NO_TOOL, target.placed, _COST[target.kind]


def _part(target: Target, number: float) -> float:
    scale = target.tolerance or (0.1 if target.unit == "bits" else 1.0)
    miss = target.miss(number) / scale if isfinite(number) else _FAR
    return log1p(min(miss, _FAR))
