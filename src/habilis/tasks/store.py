"""Results of finished tasks on disk: a file for each, by the task's name."""

import zipfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from habilis.files import write_whole
from habilis.tasks.task import Arrays, Task

DAMAGE = (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile)
"""Errors of reading a damaged file."""


def write(name: str, result: Arrays, folder: Path) -> None:
    """Keeps the result of a task.

    Raises:
        OSError: it cannot be written.
    """
    write_whole(_path(name, folder), lambda file: np.savez(file, allow_pickle=False, **result))


def read(tasks: Sequence[Task], folder: Path) -> tuple[dict[str, Arrays], list[str]]:
    """The results of those of some tasks that are finished.

    Returns:
        The results by the tasks' names, and a line for each damaged file.
    """
    found: dict[str, Arrays] = {}
    damaged: list[str] = []
    for task in tasks:
        path = _path(task.name, folder)
        try:
            with path.open("rb") as file, np.load(file, allow_pickle=False) as saved:
                result = {name: saved[name] for name in saved.files}
            task.check(result)
        except FileNotFoundError:
            continue
        except DAMAGE as error:
            damaged.append(f"{path}: is damaged ({first_line(error)}); it is computed again")
        else:
            found[task.name] = result
    return found, damaged


def first_line(error: Exception) -> str:
    """The first line of an error's message, or its type if it has none."""
    return (str(error).splitlines() or [type(error).__name__])[0]


def _path(name: str, folder: Path) -> Path:
    return folder / f"{name}.npz"
