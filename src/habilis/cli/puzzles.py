"""Puzzle files, which stand where the command line takes a world."""

from collections.abc import Sequence
from typing import Any

from habilis.bridges.puzzles.pushworld import PushWorld
from habilis.bridges.puzzles.sokoban import puzzle_named
from habilis.cli.arguments import Args
from habilis.worlds.grid import Cell


def puzzle_of(args: Args, name: str, without: Sequence[str] = ("tool",)) -> PushWorld | None:
    """The puzzle that a verb is given; `None` if the name is not that of a puzzle's file.

    Args:
        args: the arguments.
        name: what is given for the world.
        without: arguments that are for worlds only.

    Raises:
        ValueError: the file is no puzzle, or one of these arguments is given.
    """
    puzzle = puzzle_named(name)
    if puzzle is not None:
        for other in without:
            if getattr(args, other, None):
                flag = args.flags[other]
                raise ValueError(
                    f"{flag} is for worlds, and {puzzle.name} is a puzzle; leave it out"
                )
    return puzzle


def placed(puzzle: PushWorld, agent: Cell | None, objects: Any) -> PushWorld:
    """The puzzle with bodies where options put them.

    Args:
        puzzle: the puzzle.
        agent: the cell of the agent's corner, if given.
        objects: names and cells of movables, if given.

    Raises:
        ValueError: it is not said which movable, or twice, or there is no room.
    """
    cells: dict[str, Cell] = {}
    for name, cell in objects or []:
        if not name:
            known = ", ".join(puzzle.objects)
            raise ValueError(
                f"--object-at has {cell[0]},{cell[1]} without a name; specify which of {known}, as "
                f"{puzzle.objects[0] if puzzle.objects else 'm0'}={cell[0]},{cell[1]}"
            )
        if name in cells:
            raise ValueError(f"--object-at has {name} twice; give it one cell")
        cells[name] = cell
    return puzzle.with_cells(agent=agent, objects=cells)
