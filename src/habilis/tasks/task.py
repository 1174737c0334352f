"""Tasks, and the executors that run them."""

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol, TypeVar, runtime_checkable

import numpy as np

Arrays = Mapping[str, np.ndarray]
"""The result of a task: arrays by name, of types that NumPy saves without pickle."""
Done = Callable[[str, Arrays], None]
"""Called with the name of each finished task and its result."""
Stopped = Callable[[], int]
"""Returns 0, or a reason to stop, such as the number of a signal."""
OnProgress = Callable[[int, int], None]
"""Called with the number of finished tasks and the number of all tasks."""


@runtime_checkable
class Task(Protocol):
    """One of many independent computations, deterministic and picklable."""

    @property
    def name(self) -> str:
        """Its identity, by which the result is kept: a file name, equal for equal computations."""
        ...

    @property
    def label(self) -> str:
        """Its description in messages."""
        ...

    @property
    def size(self) -> float:
        """A number that grows with the memory it needs."""
        ...

    def run(self) -> Arrays:
        """Computes the result, here and now."""
        ...

    def rehearse(self) -> None:
        """Computes enough of it to need as much memory as all of it."""
        ...

    def check(self, result: Arrays) -> None:
        """Refuses a result that is not of this task, read from a damaged or exchanged file.

        Raises:
            ValueError, KeyError: what is wrong with it.
        """
        ...


T_contra = TypeVar("T_contra", bound=Task, contravariant=True)


@runtime_checkable
class Executor(Protocol[T_contra]):
    """Runs tasks, in any order.

    Calls `done` in this process for each task, possibly more than once, and returns early if
    `stopped` says so.
    """

    def __call__(self, tasks: Sequence[T_contra], done: Done, stopped: Stopped, /) -> None: ...


def in_turn(tasks: Sequence[Task], done: Done, stopped: Stopped = lambda: 0) -> None:
    """The plainest executor: one task after another, in this process."""
    for task in tasks:
        if stopped():
            return
        done(task.name, task.run())
