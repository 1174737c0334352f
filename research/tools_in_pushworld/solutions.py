"""What a solution does: its states, and the movables through which it pushes another."""

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from habilis.bridges.puzzles.bodies import STEPS
from habilis.bridges.puzzles.pushworld import PushWorld, State
from habilis.worlds.grid import Cell

_LETTERS = "LRUD"
"""Of the actions, in their order."""


def load_plan(path: Path) -> list[int]:
    """The actions of a reference solution, from its `plan:` line.

    Raises:
        ValueError: there is no such line, or it has other letters than L, R, U and D.
    """
    found = re.search(r"^plan: *([LRUD]+) *$", path.read_text(), re.MULTILINE)
    if found is None:
        raise ValueError(f"{path.name}: there is no line 'plan: ' with letters of {_LETTERS}")
    return [_LETTERS.index(letter) for letter in found[1]]


def replayed(puzzle: PushWorld, plan: Sequence[int]) -> list[State]:
    """The states of a plan, the first and the last among them."""
    states = [puzzle.initial]
    for action in plan:
        states.append(puzzle.step(states[-1], action))
    return states


def used_movables(puzzle: PushWorld, plan: Sequence[int], target: str) -> Counter[str]:
    """In how many steps of a plan the target is pushed through each other movable.

    A step pushes the target through X if the target moves, the agent does not touch it, and X is on
    a way from the agent to the target on which each body pushes the next.

    Args:
        puzzle: where the plan begins.
        plan: indices of actions.
        target: a movable's name, as in `puzzle.objects`.

    Returns:
        A count for each movable that is used at all.
    """
    place, states = puzzle.place(target), replayed(puzzle, plan)
    counts: Counter[str] = Counter()
    for before, after, action in zip(states, states[1:], plan, strict=False):
        if before[place] != after[place]:
            counts.update(puzzle.objects[x - 1] for x in _between(puzzle, before, action, place))
    return counts


def _between(puzzle: PushWorld, before: State, action: int, place: int) -> Iterator[int]:
    pushes = _pushes(puzzle, before, action)
    if place in pushes[0]:
        return
    without = {body: others - {place} for body, others in pushes.items()}
    for body in _reached(without, 0) - {0}:
        if place in _reached(pushes, body):
            yield body


def _pushes(puzzle: PushWorld, before: State, action: int) -> dict[int, set[int]]:
    """For each body the others that it would overlap, were it alone to move."""
    down, right = STEPS[action]
    covered = [{*cells} for cells in covered_cells(puzzle, before)]
    moved = [{(row + down, column + right) for row, column in cells} for cells in covered]
    bodies = range(len(covered))
    return {i: {j for j in bodies if j != i and moved[i] & covered[j]} for i in bodies}


def covered_cells(puzzle: PushWorld, state: State) -> list[list[Cell]]:
    """The cells that each body covers in a state."""
    corners = (divmod(cell, puzzle.width) for cell in state)
    return [body.covered(corner) for body, corner in zip(puzzle.bodies, corners, strict=True)]


def _reached(pushes: Mapping[int, set[int]], start: int) -> set[int]:
    """The bodies that are pushed by one, by those that it pushes, and so on, and itself."""
    found, new = {start}, {start}
    while new:
        new = set().union(*(pushes[body] for body in new)) - found
        found |= new
    return found
