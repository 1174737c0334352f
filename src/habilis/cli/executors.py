"""Where the tasks of a measure run: options of several verbs."""

import argparse
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from habilis.cli.arguments import Args
from habilis.empowerment.kinds import OPEN_LOOP
from habilis.extras import import_from
from habilis.files import FOLDER
from habilis.tasks.task import Arrays, Done, Executor, Stopped, Task, in_turn

OPTIONS = ("ray", "processes", "work")
"""The arguments that ask for tasks."""


def add_executor(parser: argparse.ArgumentParser) -> None:
    """Adds the options; to be called after all other files and folders are known."""
    ray = "compute on a Ray cluster: HOST:PORT, auto, or local to start one here"
    parser.add_argument("--ray", metavar="ADDRESS", help=ray)
    text = "number of processes, at most as many as memory allows (default: this process)"
    parser.add_argument("--processes", type=int, metavar="N", help=text)
    text = "a new folder, where finished parts of the computation are kept"
    parser.add_argument("--work", type=Path, metavar="DIR", help=text)
    text = "continue the interrupted computation in --work DIR"
    parser.add_argument("--resume", action="store_true", help=text)
    writes = {**(parser.get_default("writes") or {}), "work": FOLDER}
    parser.set_defaults(writes=writes, splits=True)


@contextmanager
def executor_opened(args: Args) -> Iterator[None]:
    """Sets `args.executor`, which is opened when the first tasks are there, and closes it.

    So what is wrong with the arguments of the measure is found before a cluster is started.

    Raises:
        ValueError: options that exclude each other, or a folder that cannot be begun or resumed.
    """
    args.executor = None
    if not getattr(args, "splits", False) or not _is_wanted(args):
        yield
        return
    with ExitStack() as stack:
        args.executor = _Later(args, stack)
        yield


def _is_wanted(args: Args) -> bool:
    if args.ray is not None and args.processes is not None:
        raise ValueError("--ray and --processes exclude each other; give one of them")
    if args.resume and args.work is None:
        raise ValueError("--resume is given without --work; name the folder to continue in")
    given = [args.flags[name] for name in OPTIONS if getattr(args, name) is not None]
    if given and getattr(args, "kind", OPEN_LOOP) != OPEN_LOOP:
        raise ValueError(
            f"--kind {args.kind} is computed for all states at once; leave out {given[0]}"
        )
    if args.work is not None:
        session = import_from("habilis.tasks.session", "learn")
        session.COMPUTATION.check(args.work, args.resume)
    return bool(given)


@dataclass(eq=False)
class _Later:
    """An executor that is opened at its first use, and runs no task twice.

    Attributes:
        args: the options.
        stack: closes what is opened.
        executor: once it is open.
        results: of the tasks so far, by name.
    """

    args: Args
    stack: ExitStack
    executor: Executor[Any] | None = None
    results: dict[str, Arrays] = field(default_factory=dict)

    def __call__(self, tasks: Sequence[Task], done: Done, stopped: Stopped) -> None:
        def keep(name: str, result: Arrays) -> None:
            self.results[name] = result
            done(name, result)

        for task in tasks:
            if task.name in self.results:
                done(task.name, self.results[task.name])
        left = [task for task in tasks if task.name not in self.results]
        if left:
            self.executor = self._open() if self.executor is None else self.executor
            self.executor(left, keep, stopped)

    def _open(self) -> Executor[Any]:
        enter, args = self.stack.enter_context, self.args
        executor: Executor[Any] = in_turn
        if args.ray is not None:
            executor = enter(import_from("habilis.tasks.cluster", "sweep").on_ray(args.ray))
        elif args.processes is not None:
            executor = enter(import_from("habilis.tasks.local", "learn").processes(args.processes))
        if args.work is None:
            return executor
        session = import_from("habilis.tasks.session", "learn")
        return enter(session.kept_in(args.work, executor, resume=args.resume))
