"""Tasks in several processes on this machine, as many as there is memory for."""

import os
import pickle
import resource
import signal
import sys
import tempfile
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import lru_cache
from multiprocessing import current_process, get_context, parent_process, resource_tracker
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from secrets import token_hex
from typing import Any

from habilis.files import writing
from habilis.tasks import shared
from habilis.tasks.shared import packed, unpacked
from habilis.tasks.task import Arrays, Done, Executor, Stopped, Task

MARGIN = 1.25
"""Memory allowed for each further process, relative to what the first one needed."""

_GUARD = 'in a script, start processes under `if __name__ == "__main__":`'
_PATIENCE = 3  # processes that may be lost to one task
_LOOK = 0.5  # seconds between two looks at whether to stop
_CGROUP = Path("/sys/fs/cgroup")  # where Linux states what a container may use


@dataclass(eq=False)
class _Worker:
    """A process that runs one task after another, and our end of the pipe to it."""

    process: BaseProcess
    pipe: Any  # a connection, whose class depends on the system
    task: Task | None = None


@contextmanager
def processes(
    count: int, warn: Callable[[str], None] = lambda line: print(line, file=sys.stderr)
) -> Iterator[Executor[Task]]:
    """An executor with processes of its own, each with one task at a time.

    The first process rehearses the largest task; the memory that this needs decides how many
    others fit into what is available. A task whose process is lost is run again. What tasks share
    is written to a temporary file, which all processes map. A process imports the script that
    started it, so a script calls this under `if __name__ == "__main__":`.

    Args:
        count: of processes, at most.
        warn: called with a line if fewer are started.

    Returns:
        A context within which the processes exist.

    Raises:
        ValueError: `count` is below 1, or this process is one that is just being started; or, when
            the executor is used, a task fails, or its processes are lost again and again.
    """
    if count < 1:
        raise ValueError(f"processes is {count}; give at least 1")
    if getattr(current_process(), "_inheriting", False):
        raise ValueError(f"a process that is being started cannot start others; {_GUARD}")
    workers: list[_Worker] = []
    room: list[int] = []
    written = _Written(tempfile.TemporaryDirectory(prefix="habilis-"))

    def run(tasks: Sequence[Task], done: Done, stopped: Stopped) -> None:
        try:
            finish(tasks, done, stopped)
        finally:  # those still at work would hand over their results to the next call
            _end([worker for worker in workers if worker.task is not None])
            workers[:] = [worker for worker in workers if worker.task is None]

    def finish(tasks: Sequence[Task], done: Done, stopped: Stopped) -> None:
        written.begin()
        if not room:
            workers.append(_start())
            room.append(_how_many(count, workers[0], tasks, written, warn, stopped))
        waiting, lost = deque(tasks), dict[str, int]()
        while not stopped():
            while waiting and len(workers) < min(room[0], len(waiting) + _busy(workers)):
                workers.append(_start())
            for worker in workers:
                if worker.task is None and waiting:
                    _give(worker, waiting.popleft(), written)
            if not _busy(workers):
                return
            for pipe in wait([w.pipe for w in workers], _LOOK):
                worker = next(w for w in workers if w.pipe is pipe)
                task, worker.task = worker.task, None
                answer = _answer(worker)
                if answer is None:
                    workers.remove(worker)
                    if task is not None:
                        lost[task.name] = lost.get(task.name, 0) + 1
                        _check_patience(task, lost[task.name])
                        waiting.appendleft(task)
                elif task is not None:
                    done(task.name, answer)

    try:
        yield run
    finally:
        _end(workers)
        written.folder.cleanup()


@dataclass(eq=False)
class _Written:
    """Files of what tasks share, for all processes of this machine to map.

    Attributes:
        folder: of the files.
        files: by the keys of the values, of this call of the executor and of the one before.
        used: the keys of this call.
    """

    folder: tempfile.TemporaryDirectory[str]
    files: dict[str, Path] = field(default_factory=dict)
    used: set[str] = field(default_factory=set)

    def begin(self) -> None:
        """A call of the executor begins: what the last one did not use is removed."""
        for key in self.files.keys() - self.used:
            self.files.pop(key).unlink()
        self.used.clear()

    def pack(self, task: Task) -> tuple[bytes, dict[str, Path]]:
        """A task, and the files of what it shares with others."""
        content, values = packed(task)
        for key, one in values.items():
            if key not in self.files:
                path = Path(self.folder.name) / f"{len(self.files)}-{token_hex(4)}"
                fix = "make room there, or let TMPDIR name another folder"
                with writing(path, fix), path.open("wb") as file:
                    shared.write(one.value, file)
                self.files[key] = path
        self.used |= values.keys()
        return content, {key: self.files[key] for key in values}


def _how_many(
    count: int,
    first: _Worker,
    tasks: Sequence[Task],
    written: _Written,
    warn: Callable[[str], None],
    stopped: Stopped,
) -> int:
    """The number of processes that there is memory for."""
    if count == 1:
        return 1
    first.task = max(tasks, key=lambda task: task.size)
    first.pipe.send((_needed_memory, *written.pack(first.task)))
    while not first.pipe.poll(_LOOK):
        if stopped():
            return 1
    needed = _answer(first)
    if needed is None:
        raise ValueError(
            f"the first process was lost at its first task; free some memory, or, {_GUARD}"
        )
    first.task = None
    each = MARGIN * needed
    room = 1 + int(available_memory() // each)
    if room < count:
        warn(
            f"habilis: {room} of {count} processes fit into memory, at {each / 2**20:,.0f} MiB each"
        )
    return min(count, room)


def _busy(workers: Sequence[_Worker]) -> int:
    return sum(worker.task is not None for worker in workers)


def _check_patience(task: Task, times: int) -> None:
    if times >= _PATIENCE:
        raise ValueError(
            f"{task.label}: {times} processes were lost at this task; give fewer --processes, "
            f"or free some memory; {_GUARD}"
        )


def _start() -> _Worker:
    # A new interpreter, not a copy of this one, whose threads (JAX's) a copy would not have.
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_work, args=(theirs,), daemon=True)
    resource_tracker.ensure_running()  # which unblocks signals that are blocked
    # Ctrl-C goes to all processes of a terminal; this one alone answers it.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        process.start()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    theirs.close()
    return _Worker(process, ours)


def _end(workers: Sequence[_Worker]) -> None:
    for worker in workers:
        worker.process.kill()
    for worker in workers:
        worker.process.join()
        worker.pipe.close()


def _give(worker: _Worker, task: Task, written: _Written) -> None:
    worker.task = task
    message = _run, *written.pack(task)
    with suppress(OSError):  # it is lost, which shows when its answer is read
        worker.pipe.send(message)


def _answer(worker: _Worker) -> Any:
    """The answer of a worker; `None` if it is lost."""
    try:
        answer = worker.pipe.recv()
    except (EOFError, OSError):
        worker.process.kill()
        worker.process.join()
        worker.pipe.close()
        return None
    if isinstance(answer, Exception):
        raise answer
    return answer


def _work(pipe: Connection) -> None:
    """The loop of a worker, until it is killed."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    while True:
        function, content, files = pipe.recv()
        try:
            answer = function(unpacked(content, lambda key: _value(files[key])))  # noqa: B023
        except Exception as error:
            answer = _portable(error)
        pipe.send(answer)


def _portable(error: Exception) -> Exception:
    """An error as it can be sent: itself, or if that is impossible what it says."""
    try:
        return pickle.loads(pickle.dumps(error))
    except Exception:
        return RuntimeError(f"{type(error).__name__}: {error}")


@lru_cache(2)
def _value(path: Path) -> Any:
    return shared.read(path)


def _run(task: Task) -> Arrays:
    return task.run()


def _needed_memory(task: Task) -> int:
    task.rehearse()
    return peak_memory()


def available_memory() -> int:
    """Bytes that new processes can use without pushing others out."""
    free = os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    meminfo = Path("/proc/meminfo")
    if meminfo.exists():  # it counts what the system frees as soon as someone needs the room
        sizes = dict(line.split(":") for line in meminfo.read_text().splitlines())
        free = int(sizes["MemAvailable"].split()[0]) * 1024
    limit, used = _CGROUP / "memory.max", _CGROUP / "memory.current"
    if limit.exists() and used.exists() and limit.read_text().strip() != "max":
        free = min(free, int(limit.read_text()) - int(used.read_text()))
    return max(0, free)


def peak_memory() -> int:
    """The most bytes that this process has used."""
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
