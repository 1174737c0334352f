"""Every tool by every object over all horizons, beside each of them by itself."""

import numpy as np

from habilis.analysis.averages import compare
from habilis.analysis.pairs import pairs
from habilis.benchmarks import Result, times
from habilis.worlds.world import World

_HORIZON = 12
_ROOM = """
R = rake
M = magnet
D = ball
G = goal of C
A.........
..P...R...
....##....
..C.......
......#...
.....M#...
..........
.##....D..
..........
.........G
"""


def one_by_one(world: World, horizon: int) -> np.ndarray:
    """The matrix as it comes of what else there is: `compare` for each object and horizon."""
    tools = [*(tool.name for tool in world.tools), "none"]
    alone = [world.with_object(thing.name) for thing in world.objects]
    return np.array(
        [
            np.transpose([[*compare(one, tools, h).values()] for one in alone])
            for h in range(1, horizon + 1)
        ]
    )


def results() -> list[Result]:
    world = World.parse(_ROOM, "room")
    found = pairs(world, _HORIZON)
    assert np.array_equal(found.averages, one_by_one(world, _HORIZON))
    seconds = times(
        {
            "ours": lambda: pairs(world, _HORIZON),
            "apart": lambda: one_by_one(world, _HORIZON),
        }
    )
    of = f"{len(found.tools) - 1} tools and none by {len(found.objects)} objects, 10x10"
    return [
        Result.of(f"pairs, h = 1 to {_HORIZON}", seconds["ours"], "s", f"{of}, all measures"),
        Result.of(
            f"pairs, h = 1 to {_HORIZON}: each pair and h alone / ours",
            seconds["apart"] / seconds["ours"],
            "times",
            "compare() of each object for each h, which has the averages alone",
        ),
    ]
