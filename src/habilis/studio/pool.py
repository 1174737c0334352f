"""A pool of worker processes, each of which can be ended at any moment.

python -m habilis.studio.pool MODULE BACKGROUND

is such a process. It runs the `STEPS` of a module, one after the other, until its standard input
ends. It prints a line when it is ready. A request is its length in four bytes and a pickled (name,
arguments); an answer is a line of JSON, `{"answer": ...}` or `{"error": one line}`.
"""

import asyncio
import contextlib
import json
import os
import pickle
import signal
import sys
import warnings
from asyncio.subprocess import PIPE, Process
from collections import deque
from collections.abc import Callable, Coroutine, Mapping
from importlib import import_module
from typing import IO, Any, TypeVar

from msgspec import to_builtins

from habilis.studio.child_processes import command, find_last_in_working_directory
from habilis.studio.limits import SECONDS

_LENGTH = 4  # bytes
_LONGEST_ANSWER = 64 * 2**20
_NICE = 10
Result = TypeVar("Result")
DIED = "the computation ended unexpectedly; make the world or the horizon smaller"
NOT_ENOUGH = "not enough memory; make the world or the horizon smaller"
TOO_LONG = f"the computation takes more than {SECONDS:g} s; make the world or the horizon smaller"


class StepError(ValueError):
    """The error of a step, in one line."""


class Pool:
    """Worker processes.

    A worker is started on first use and kept. If its step is cancelled while it runs, it gets some
    time to finish, since a new process takes longer to start than most steps take; then it is
    ended and replaced.

    Attributes:
        module: the module whose `STEPS` they run.
        size: the largest number of workers.
        patience: seconds that a cancelled step gets to finish.
        background: whether they run at low priority.
    """

    def __init__(self, module: str, size: int, patience: float, background: bool = False):
        self.module, self.size, self.patience = module, size, patience
        self.background = background
        self._idle: deque[Process] = deque()
        self._all: set[Process] = set()
        self._places = asyncio.Semaphore(size)
        self._begun = False
        self._tasks: set[asyncio.Task[Any]] = set()

    def start(self) -> None:
        """Starts all workers in advance."""
        if not self._begun:
            self._begun = True
            for _ in range(self.size):
                self._later(self._fill())

    def processes(self) -> list[int]:
        """The ids of the running processes."""
        return sorted(worker.pid for worker in self._all)

    async def do(self, turn: asyncio.Lock, name: str, **arguments: Any) -> Any:
        """Runs a step.

        Requests are served in order of arrival.

        Args:
            turn: the caller's lock: it runs one step at a time, including a cancelled one.
            name: the name of the step.
            **arguments: its arguments.

        Raises:
            StepError: the step failed; it has the step's own message.
        """
        async with contextlib.AsyncExitStack() as held:
            await held.enter_async_context(turn)
            await held.enter_async_context(self._places)
            worker = await self._next()  # starting one does not count towards the step's time
            exchange = asyncio.create_task(_exchange(worker, name, arguments))
            try:
                async with asyncio.timeout(SECONDS):
                    answer = await asyncio.shield(exchange)
            except asyncio.CancelledError:
                self._later(self._after(worker, exchange, held.pop_all()))
                raise
            except (TimeoutError, OSError, ValueError, EOFError) as error:
                exchange.cancel()
                self._later(self._replace(worker, held.pop_all()))
                raise StepError(TOO_LONG if isinstance(error, TimeoutError) else DIED) from None
            self._idle.append(worker)
        if "error" in answer:
            raise StepError(answer["error"])
        return answer["answer"]

    async def close(self) -> None:
        """Ends all workers, including those that are starting."""
        tasks = list(self._tasks)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        await asyncio.gather(*(self._end(worker) for worker in list(self._all)))

    def _later(self, work: Coroutine[Any, Any, Result]) -> "asyncio.Task[Result]":
        """Runs something in the background, which ends when the pool is closed."""
        task = asyncio.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    async def _after(
        self, worker: Process, exchange: "asyncio.Task[Any]", held: contextlib.AsyncExitStack
    ) -> None:
        """Gives a cancelled step some time to finish."""
        try:
            async with asyncio.timeout(self.patience):
                await exchange
        except (TimeoutError, OSError, ValueError, EOFError):
            await self._replace(worker, held)
        else:
            self._idle.append(worker)
            await held.aclose()

    async def _replace(self, worker: Process, held: contextlib.AsyncExitStack) -> None:
        """Ends a worker and starts another, before its caller's turn is released."""
        async with held:
            await self._end(worker)
            with contextlib.suppress(StepError):
                self._idle.append(await self._started())

    async def _fill(self) -> None:
        async with self._places:
            if len(self._all) < self.size:
                with contextlib.suppress(StepError):  # the next step will report it
                    self._idle.append(await self._started())

    async def _next(self) -> Process:
        """An idle worker. One that is starting is kept even if its step is cancelled."""
        while self._idle:
            worker = self._idle.popleft()
            if worker.returncode is None:
                return worker
            self._all.discard(worker)
        starting = self._later(self._started())
        try:
            return await asyncio.shield(starting)
        except asyncio.CancelledError:
            starting.add_done_callback(self._keep)
            raise

    def _keep(self, starting: "asyncio.Task[Process]") -> None:
        if not starting.cancelled() and starting.exception() is None:
            self._idle.append(starting.result())

    async def _started(self) -> Process:
        """A new worker that is ready.

        Raises:
            StepError: it ended instead.
        """
        # More linear-algebra threads per worker would only compete with each other.
        alone = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        worker = await asyncio.create_subprocess_exec(
            *command("habilis.studio.pool", self.module, str(int(self.background))),
            stdin=PIPE,
            stdout=PIPE,
            limit=_LONGEST_ANSWER,
            env=os.environ | alone,
        )
        self._all.add(worker)
        if self.background:
            with contextlib.suppress(AttributeError, OSError):  # not available everywhere
                os.setpriority(os.PRIO_PROCESS, worker.pid, _NICE)
        assert worker.stdout is not None
        if not await worker.stdout.readline():
            await self._end(worker)
            raise StepError(DIED)
        return worker

    async def _end(self, worker: Process) -> None:
        self._all.discard(worker)
        with contextlib.suppress(ProcessLookupError):
            worker.kill()
        await worker.wait()


async def _exchange(worker: Process, name: str, arguments: dict[str, Any]) -> dict[str, Any]:
    """Sends a request, and waits for its answer."""
    assert worker.stdin is not None
    assert worker.stdout is not None
    request = pickle.dumps((name, arguments))
    worker.stdin.write(len(request).to_bytes(_LENGTH) + request)
    await worker.stdin.drain()
    line = await worker.stdout.readline()
    if not line:
        raise EOFError
    return json.loads(line)


def work(steps: Mapping[str, Callable[..., Any]], requests: IO[bytes], answers: IO[str]) -> None:
    """Answers requests until there are no more."""
    while length := requests.read(_LENGTH):
        print(_answer(steps, requests.read(int.from_bytes(length))), file=answers, flush=True)


def _answer(steps: Mapping[str, Callable[..., Any]], request: bytes) -> str:
    try:
        name, arguments = pickle.loads(request)
        answer = steps[name](**arguments)
        return json.dumps({"answer": answer}, allow_nan=False, default=to_builtins)
    except MemoryError:
        return json.dumps({"error": NOT_ENOUGH})
    except Exception as error:  # of any kind: it is reported to the caller, and the worker goes on
        return json.dumps({"error": str(error) or type(error).__name__})


def main(module: str, background: str) -> None:
    """Runs a worker process."""
    # Ctrl-C reaches all processes of a terminal, but only the parent decides when to end.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    warnings.simplefilter("ignore")  # the answers contain the uncertainty
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "w")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # a custom tool may print
    find_last_in_working_directory()
    steps = import_module(module)
    steps.prepare(bool(int(background)))
    print(json.dumps("ready"), file=answers, flush=True)
    with contextlib.suppress(BrokenPipeError):
        work(steps.STEPS, sys.stdin.buffer, answers)


if __name__ == "__main__":
    main(*sys.argv[1:])
