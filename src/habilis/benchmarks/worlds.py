"""Tables: placements a second."""

from habilis.benchmarks import Result, best_seconds, placements
from habilis.benchmarks.counting import room
from habilis.worlds.plans import solve
from habilis.worlds.table import tabulate
from habilis.worlds.world import load_world


def results() -> list[Result]:
    lines = []
    for world in (load_world("corridor"), room(24)):
        mdp = tabulate(world)
        seconds = best_seconds(lambda world=world: tabulate(world), 3)
        note = f"{world.name}, {mdp.states:,} states, one core"
        lines.append(Result("tabulate", mdp.states / seconds / 1e6, "M states/s", note))
    mdp = tabulate(load_world("corridor"))
    lines.append(Result("solve", 1e3 * best_seconds(lambda: solve(mdp)), "ms", "corridor"))
    return lines + placements.results()
