"""Tasks on this machine: in this process, or in several."""

import os
import signal
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import get_context, parent_process, resource_tracker
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any

from habilis.learning.batches import train_jobs
from habilis.learning.jobs import Job
from habilis.sweeps.memory import available_memory, peak_memory
from habilis.sweeps.sweep import Executor, Stopped
from habilis.sweeps.tasks import Done, Task, run_task

MARGIN = 1.25
"""How much more memory than the first process took another one is given."""

_PATIENCE = 3  # processes that may be lost to one task
_LOOK = 0.5  # seconds between two looks at whether to stop


@dataclass(eq=False)
class _Worker:
    """A process that trains one task after another, and our end of the line to it."""

    process: BaseProcess
    line: Any  # a connection, whose class depends on the system
    task: Task | None = None


@contextmanager
def processes(
    count: int, tell: Callable[[str], None] = lambda line: print(line, file=sys.stderr)
) -> Iterator[Executor]:
    """An executor with processes of its own, each with one task at a time.

    The first one tries the largest world for a stretch; how much memory that took decides how many
    of the others fit into what is available. A task whose process is lost is run again.

    Args:
        count: how many processes to start at most.
        tell: told in a line if fewer are started.

    Raises:
        ValueError: there are to be less than one; or, when it is used, a task that cannot be
            trained, or whose processes are lost again and again.
    """
    if count < 1:
        raise ValueError(f"processes is {count}; give at least 1")
    workers: list[_Worker] = []
    room: list[int] = []

    def run(tasks: Sequence[Task], done: Done, stopped: Stopped) -> None:
        if not room:
            workers.append(_start())
            room.append(_how_many(count, workers[0], tasks, tell, stopped))
        waiting, lost = deque(tasks), dict[str, int]()
        while not stopped():
            while waiting and len(workers) < min(room[0], len(waiting) + _busy(workers)):
                workers.append(_start())
            for worker in workers:
                if worker.task is None and waiting:
                    _give(worker, waiting.popleft())
            if not _busy(workers):
                return
            for line in wait([w.line for w in workers], _LOOK):
                worker = next(w for w in workers if w.line is line)
                task, answer = worker.task, _answer(worker)
                worker.task = None
                if answer is None:
                    workers.remove(worker)
                    if task is not None:
                        lost[task.name] = lost.get(task.name, 0) + 1
                        _check_patience(task, lost[task.name])
                        waiting.appendleft(task)
                elif task is not None:
                    done(task, answer)

    try:
        yield run
    finally:
        for worker in workers:
            worker.process.kill()
        for worker in workers:
            worker.process.join()
            worker.line.close()


def _how_many(
    count: int,
    first: _Worker,
    tasks: Sequence[Task],
    tell: Callable[[str], None],
    stopped: Stopped,
) -> int:
    """How many processes there is memory for."""
    if count == 1:
        return 1
    largest = max(tasks, key=lambda task: task.world.height * task.world.width)
    first.line.send((_try, largest))
    while not first.line.poll(_LOOK):
        if stopped():
            return 1
    took = _answer(first)
    if took is None:
        raise ValueError("a process to train in was lost at once; free some memory")
    each = MARGIN * took
    room = 1 + int(available_memory() // each)
    if room < count:
        tell(
            f"habilis: {room} of {count} processes fit into memory, at {each / 2**20:,.0f} MiB each"
        )
    return min(count, room)


def _busy(workers: Sequence[_Worker]) -> int:
    return sum(worker.task is not None for worker in workers)


def _check_patience(task: Task, times: int) -> None:
    if times >= _PATIENCE:
        raise ValueError(
            f"{task.world.name}: {times} processes were lost while they trained runs "
            f"{task.runs[0]} to {task.runs[-1]}; give fewer --processes, or free some memory"
        )


def _start() -> _Worker:
    # A new interpreter, not a copy of this one, whose threads (JAX's) a copy would not have.
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_work, args=(theirs,), daemon=True)
    resource_tracker.ensure_running()  # which lets signals through again that are held back
    # Ctrl-C goes to all processes of a terminal, and is for us alone to answer.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        process.start()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    theirs.close()
    return _Worker(process, ours)


def _give(worker: _Worker, task: Task) -> None:
    worker.task = task
    with suppress(OSError):  # it is lost, as will be seen when its answer is looked for
        worker.line.send((run_task, task))


def _answer(worker: _Worker) -> Any:
    """What a worker has to say; `None` if it is lost."""
    try:
        answer = worker.line.recv()
    except (EOFError, OSError):
        worker.process.kill()
        worker.process.join()
        worker.line.close()
        return None
    if isinstance(answer, Exception):
        raise answer
    return answer


def _work(line: Connection) -> None:
    """What a worker does until it is ended."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    while True:
        work, task = line.recv()
        try:
            answer = work(task)
        except Exception as error:
            answer = error
        line.send(answer)


def _try(task: Task) -> int:
    """Trains a task for a stretch; what this process took at most."""
    over = threading.Event()
    job = Job.of(0, task.config, task.world, task.runs)
    train_jobs([job], on_stretch=over.set, stopped=over.is_set)
    return peak_memory()


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
