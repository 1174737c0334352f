"""`habilis solve`: a shortest plan."""

import argparse
from collections.abc import Sequence

import habilis
from habilis.cli.arguments import Args, add_most, add_world, max_states
from habilis.cli.output import print_json, shows_progress
from habilis.cli.puzzles import puzzle_of
from habilis.progress import progress_bar
from habilis.worlds.plans import Plan, check_certain
from habilis.worlds.world import load_world

HELP: str = "find a shortest plan"
EXAMPLE: str = "habilis solve corridor --tool none"
COMMON: tuple[str, ...] = ("--tool", "--max-states")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_world(parser)
    add_most(parser)


def run(args: Args) -> int:
    puzzle = puzzle_of(args, args.world)
    if puzzle is not None:
        limits = {"max_states": max_states(args), "show_progress": shows_progress(args)}
        return _print(args, habilis.solve(puzzle, **limits), puzzle.actions)
    world = check_certain(load_world(args.world, args.tool))
    mdp = habilis.tabulate(world, max_states=max_states(args), show_progress=shows_progress(args))
    with progress_bar("solving", shows_progress(args)):
        plan = habilis.solve(mdp)
    return _print(args, plan, mdp.actions)


def _print(args: Args, plan: Plan | None, names: Sequence[str]) -> int:
    if args.json:
        print_json(
            {"steps": None, "return": None, "actions": None}
            if plan is None
            else {
                "steps": len(plan.actions),
                "return": plan.best_return,
                "actions": list(plan.actions),
            }
        )
    elif plan is None:
        print("the goal is unreachable")
    else:
        print(f"{len(plan.actions)} steps, return {plan.best_return:g}")
        print(", ".join(names[action] for action in plan.actions))
    return 1 if plan is None else 0
