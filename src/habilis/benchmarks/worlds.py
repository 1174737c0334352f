"""Tables: placements a second."""

from habilis.benchmarks import Result, placements, time_of
from habilis.benchmarks.counting import room
from habilis.worlds.plans import solve
from habilis.worlds.table import tabulate
from habilis.worlds.world import load_world


def results() -> list[Result]:
    lines = []
    for world in (load_world("corridor"), room(24)):
        mdp = tabulate(world)
        seconds = time_of(lambda world=world: tabulate(world))
        note = f"{world.name}, {mdp.states:,} states, one core"
        lines.append(Result.of("tabulate", mdp.states / seconds / 1e6, "M states/s", note))
    mdp = tabulate(load_world("corridor"))
    lines.append(Result.of("solve", 1e3 * time_of(lambda: solve(mdp)), "ms", "corridor"))
    return lines + placements.results()
