"""A folder of tasks: what is finished stays finished, whatever happens to the process."""

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic, TypeVar

from habilis.files import check_folder, check_unused, write_whole, writing
from habilis.interruption import LOCK, Interrupted, locked, stop_signals
from habilis.tasks import store
from habilis.tasks.task import Arrays, Done, Executor, OnProgress, Stopped, Task

T = TypeVar("T", bound=Task)


@dataclass(frozen=True)
class Layout:
    """Where a kind of folder keeps its tasks, and by what it is recognised.

    Attributes:
        kind: its name in messages.
        mark: a file or folder that every such folder has, once it is begun.
        results: the folder of finished tasks in it.
    """

    kind: str
    mark: str
    results: str = "tasks"

    def check(self, folder: Path, resume: bool) -> None:
        """Refuses a folder that cannot be begun, or resumed, before any work is done.

        Raises:
            ValueError: it holds something else, or cannot be written to.
        """
        there = resume and folder.is_dir() and any(folder.iterdir())
        check_folder(folder) if there else check_unused(folder)
        if there and not (folder / self.mark).exists() and not self._is_just_begun(folder):
            raise ValueError(f"{folder}: has no {self.kind} to resume; name another folder")

    def _is_just_begun(self, folder: Path) -> bool:
        """Whether it is as a process leaves it that is killed at once."""
        return {path.name for path in folder.iterdir()} <= {LOCK, self.results}


@dataclass
class Session(Generic[T]):
    """The one process at work in a folder of tasks.

    Attributes:
        folder: the folder.
        place: the folder of results in it.
        executor: runs the tasks.
        stopped: returns the number of the signal that came, or 0.
        results: of the tasks computed, or found finished, so far, by name.
    """

    folder: Path
    place: Path
    executor: Executor[T]
    stopped: Callable[[], int]
    results: dict[str, Arrays] = field(default_factory=dict)

    def compute(
        self,
        tasks: Sequence[T],
        on_progress: OnProgress | None = None,
        on_result: Done | None = None,
    ) -> None:
        """Computes what is not finished yet of some tasks, and keeps each result at once.

        Args:
            tasks: whose results are to be in `results`.
            on_progress: called first, and after each task.
            on_result: called with each result, first with those that are there already.

        Raises:
            Interrupted: by a signal, before all were finished.
            ValueError: a result cannot be written.
        """
        wanted = {task.name: task for task in tasks}
        unknown = [task for name, task in wanted.items() if name not in self.results]
        found, damaged = store.read(unknown, self.place)
        self.results |= found
        for line in damaged:
            print(f"habilis: {line}", file=sys.stderr)

        def finished() -> int:
            return sum(name in self.results for name in wanted)

        def report(name: str | None = None) -> None:
            if on_result is not None and name is not None:
                on_result(name, self.results[name])
            if on_progress is not None:
                on_progress(finished(), len(wanted))

        def done(name: str, result: Arrays) -> None:
            if name not in self.results:
                with writing(self.folder):
                    store.write(name, result, self.place)
                self.results[name] = result
                report(name)

        report()
        if on_result is not None:
            for name in wanted.keys() & self.results.keys():
                on_result(name, self.results[name])
        missing = [task for name, task in wanted.items() if name not in self.results]
        if missing and not self.stopped():
            self.executor(missing, done, self.stopped)
        if finished() < len(wanted):
            raise Interrupted(
                f"stopped; {finished()} of {len(wanted)} tasks are kept in {self.folder}: "
                "continue with --resume",
                self.stopped(),
            )


@contextmanager
def opened(
    folder: Path, layout: Layout, executor: Executor[T], resume: bool
) -> Iterator[Session[T]]:
    """Makes or opens a folder of tasks, for this process alone.

    Args:
        folder: a new one, or with `resume` an existing one.
        layout: what is where in it.
        executor: runs the tasks.
        resume: whether to continue in an existing folder.

    Raises:
        ValueError: it is in use, holds something else, or cannot be written to.
    """
    layout.check(folder, resume)
    place = folder / layout.results
    with writing(folder):
        place.mkdir(parents=True, exist_ok=True)
    with locked(folder), stop_signals() as stopped:
        yield Session(folder, place, executor, stopped)


COMPUTATION = Layout("computation", mark="computation.txt")
"""The layout of `kept_in`."""

_ABOUT = """\
Finished tasks of a computation of Habilis, in files named by a hash of what was asked.
The same command with --resume goes on from here. The folder can be removed at any time.
"""


@contextmanager
def kept_in(
    folder: str | Path, executor: Executor[Any], *, resume: bool = False
) -> Iterator[Executor[Any]]:
    """An executor whose finished tasks are kept in a folder, so that a later one need not run them.

    Tasks are recognised by their contents: a folder may have those of several computations.

    Args:
        folder: a new one, or with `resume` one that was begun this way.
        executor: runs what is not there yet.
        resume: whether to go on in an existing folder.

    Returns:
        A context within which the folder is this process's alone.

    Raises:
        ValueError: the folder is in use, holds something else, or cannot be written to.
        Interrupted: a KeyboardInterrupt, while it is used: by Ctrl-C or SIGTERM; finished tasks
            are kept.
    """
    with opened(Path(folder), COMPUTATION, executor, resume) as session:
        mark = session.folder / COMPUTATION.mark
        with writing(session.folder):
            write_whole(mark, lambda file: file.write(_ABOUT.encode()))

        signalled = session.stopped

        def run(tasks: Sequence[Task], done: Done, stopped: Stopped) -> None:
            session.stopped = lambda: signalled() or stopped()
            try:
                session.compute(tasks, on_result=done)
            except Interrupted:
                if signalled() or not stopped():  # otherwise the caller knows
                    raise

        yield run
