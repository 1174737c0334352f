"""Tasks, and the executors that run them."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol, TypeVar, runtime_checkable

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
    """One of many independent computations, deterministic and picklable.

    What it has in common with many others, such as a large table, it holds as
    `habilis.tasks.shared.Shared`, so that it travels once.
    """

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

        Args:
            result: as it was read.

        Raises:
            ValueError, KeyError: what is wrong with it.
        """
        ...


T_contra = TypeVar("T_contra", bound=Task, contravariant=True)


@runtime_checkable
class Executor(Protocol[T_contra]):
    """Runs tasks, in any order.

    A function of the tasks, of `done` and of `stopped`: it calls `done` in this process with the
    name and the result of each task, possibly more than once, and returns early if `stopped()` is
    not 0.
    """

    def __call__(self, tasks: Sequence[T_contra], done: Done, stopped: Stopped, /) -> None: ...


def in_turn(tasks: Sequence[Task], done: Done, stopped: Stopped = lambda: 0) -> None:
    """The plainest executor: one task after another, in this process.

    Args:
        tasks: to be run.
        done: called with the name and the result of each.
        stopped: returns something else than 0 to leave out the rest.
    """
    for task in tasks:
        if stopped():
            return
        done(task.name, task.run())


def results_of(
    tasks: Sequence[Task], executor: Executor[Any], on_progress: OnProgress | None = None
) -> dict[str, Arrays]:
    """The results of some tasks, by name.

    Args:
        tasks: to be run, each once, however often it is among them.
        executor: runs them.
        on_progress: called first, and after each.

    Raises:
        ValueError: a task fails, or the executor left some out, or hands over something else.
    """
    wanted = {task.name: task for task in tasks}
    results: dict[str, Arrays] = {}

    def report() -> None:
        if on_progress is not None:
            on_progress(len(results), len(wanted))

    def done(name: str, result: Arrays) -> None:
        if name not in wanted:
            raise ValueError(f"{name}: the executor was given no such task; let it pass task.name")
        try:
            wanted[name].check(result)
        except (ValueError, KeyError, TypeError) as error:
            raise ValueError(
                f"{wanted[name].label}: the executor's result is not the task's ({error}); let it "
                "hand over what task.run() returns"
            ) from None
        results[name] = result
        report()

    if wanted:
        report()
        executor(list(wanted.values()), done, lambda: 0)
    missing = [task.label for name, task in wanted.items() if name not in results]
    if missing:
        raise ValueError(
            f"{missing[0]}: the executor did not run it, nor {len(missing) - 1} others; let it "
            "call done for every task"
        )
    return results
