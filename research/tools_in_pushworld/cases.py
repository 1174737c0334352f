"""The cases of the study: a puzzle, a target, and what every other movable is to it."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from habilis.bridges.puzzles.pushworld import PushWorld, State, load_pushworld
from habilis.worlds.grid import Cell
from research.tools_in_pushworld.losses import chosen_states
from research.tools_in_pushworld.solutions import (
    covered_cells,
    load_plan,
    replayed,
    used_movables,
)

SHOWN = {
    "Pick A Tool": "m0",
    "J Tool": "m0",
    "Hockey Stick": "m1",
    "Archery": "m0",
    "Go Fishing": "m1",
    "S Tool": "m1",
}
"""The puzzles of the picture, with the target of each; it need not be a case of the study."""


def puzzle_files(folder: Path) -> list[tuple[str, Path, Path]]:
    """The level, the puzzle and the solution of each puzzle below a folder.

    Raises:
        ValueError: there is none.
    """
    files = sorted(folder.glob("puzzles/*/*.pwp"))
    if not files:
        raise ValueError(f"{folder}: there are no puzzles/*/*.pwp; give PushWorld's folder")
    solutions = folder / "solutions"
    return [(f.parent.name, f, solutions / f.parent.name / f"{f.stem}.yaml") for f in files]


def cases_of(level: str, puzzle_file: Path, solution: Path) -> list[dict[str, Any]]:
    """A row for each target of a puzzle, with each other movable.

    Targets are the movables that have a goal, and the one that the picture shows.

    Returns:
        Rows of `level`, `puzzle`, `target`, `goal` (whether the target has one), `object`;
        `steps_through`, in how many steps the
        solution pushes the target through the object; `cells`, how many it covers; `distance`, of
        the target where the solution begins, and `distance_along`, the mean in the states in which
        losses are measured.
    """
    puzzle, plan = load_pushworld(puzzle_file), load_plan(solution)
    states = chosen_states(replayed(puzzle, plan))
    targets, rows = targets_of(puzzle), []
    for target in dict.fromkeys([*targets, SHOWN.get(puzzle_file.stem, targets[0])]):
        used = used_movables(puzzle, plan, target)
        for place, other in enumerate(puzzle.objects, 1):
            if other == target:
                continue
            far = [distance(puzzle, state, puzzle.place(target), place) for state in states]
            rows.append(
                {
                    "level": level,
                    "puzzle": puzzle_file.stem,
                    "target": target,
                    "goal": target in targets,
                    "object": other,
                    "steps_through": used[other],
                    "cells": len(puzzle.bodies[place].cells),
                    "distance": far[0],
                    "distance_along": round(sum(far) / len(far), 4),
                }
            )
    return rows


def targets_of(puzzle: PushWorld) -> list[str]:
    """The movables that have a goal, in the order of `objects`."""
    with_goal = {name for goal in puzzle.goals for name in goal.bodies}
    return [name for name in puzzle.objects if name in with_goal]


def distance(puzzle: PushWorld, state: State, one: int, other: int) -> int:
    """The least Manhattan distance between the cells of two bodies, by their places in a state."""
    covered = covered_cells(puzzle, state)
    return min(_manhattan(a, b) for a in covered[one] for b in covered[other])


def _manhattan(a: Cell, b: Cell) -> int:
    return abs(a[0] - b[0]) + abs(a[1] - b[1])


def asks(rows: Sequence[Mapping[str, Any]]) -> bool:
    """Whether the rows of a target ask which other movable is its tool.

    They do if it has a goal, and the solution uses some of the other movables but not all.
    """
    steps = [row["steps_through"] for row in rows]
    return rows[0]["goal"] and any(steps) and not all(steps)


def measured_targets(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """The targets of a puzzle of which losses are measured: those that ask, and the one shown."""
    of: dict[str, list[Mapping[str, Any]]] = {}
    for row in rows:
        of.setdefault(row["target"], []).append(row)
    return [t for t, its in of.items() if asks(its) or SHOWN.get(its[0]["puzzle"]) == t]
