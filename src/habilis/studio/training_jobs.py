"""Trainings requested by pages: one trainer process and one folder each."""

import asyncio
import contextlib
import json
import os
import secrets
import traceback
from asyncio.subprocess import PIPE, Process
from collections.abc import AsyncGenerator, AsyncIterator, Iterator
from pathlib import Path
from typing import Any

import msgspec

from habilis.files import write_whole
from habilis.learning.config import Config
from habilis.studio.child_processes import command
from habilis.studio.limits import RELOADED, TRAINING
from habilis.studio.messages import one_line, shown
from habilis.studio.protocol.requests import Settings
from habilis.studio.scenes import Scene
from habilis.studio.training_settings import check_trainable

_NICE = 10
_GRACE = 15  # seconds for a stopped trainer to write its last checkpoint
_NAME = 4  # random bytes
_OF_A_RUN = ("config.json", "world.txt", "summary.json")
_DIED = "the trainer ended unexpectedly; train fewer runs at once, or on a smaller map"


class Training:
    """One training, from its request to its end.

    Attributes:
        name: the name of its result in requests.
        folder: the folder of its run.
        config: its configuration.
        report: the trainer's newest report.
        ended: whether there will be no further ones.
    """

    def __init__(self, name: str, folder: Path, config: Config, places: asyncio.Semaphore):
        self.name, self.folder, self.config = name, folder, config
        self._places = places
        self._process: Process | None = None
        self._stop = False
        self.report: dict[str, Any] = {}
        self.ended = False
        self._followers = 0
        self._told = asyncio.Condition()

    async def train(self) -> None:
        """Trains to the end, whether or not a page follows."""
        try:
            async for report in self.reports():
                self.report = report
                await self._tell()
        except Exception as error:
            traceback.print_exc()
            self.report = {"error": one_line(f"internal error: {error!r}; please report it")}
        finally:
            self.ended = True
            await self._tell()

    async def news(self) -> AsyncGenerator[dict[str, Any], None]:
        """The newest report whenever there is one, until the end.

        A training that nobody has followed for a while, since its page is gone, stops.
        """
        self._followers += 1
        seen = {} if self.report else self.report
        try:
            while True:
                async with self._told:
                    while self.report is seen and not self.ended:
                        await self._told.wait()
                if self.report is not seen:
                    seen = self.report
                    yield seen
                elif self.ended:
                    return
        finally:
            self._followers -= 1
            asyncio.get_running_loop().call_later(RELOADED, self._stop_if_left)

    def _stop_if_left(self) -> None:
        if not self._followers and not self.ended:
            self.stop()

    async def _tell(self) -> None:
        async with self._told:
            self._told.notify_all()

    def stop(self) -> None:
        """Stops, and keeps the progress."""
        self._stop = True
        if self._process is not None:
            _terminate(self._process)

    async def reports(self) -> AsyncIterator[dict[str, Any]]:
        """Trains, and yields the trainer's reports; ends it if the consumer stops."""
        async with self._places:
            if self._stop:
                return
            process = await _started(self.folder, self.config)
            self._process, silent = process, False
            try:
                if self._stop:
                    _terminate(process)
                assert process.stdout is not None
                last: dict[str, Any] = {}
                while line := await process.stdout.readline():
                    last = json.loads(line)
                    yield last
                silent = True  # it is ending by itself
                if not self._stop and not last.keys() & {"ended", "stopped", "error"}:
                    yield {"error": _DIED}
            finally:
                if not silent:
                    _terminate(process)
                await _ended(process)


class Trainings:
    """All trainings of a server, of which a limited number run in parallel.

    Attributes:
        folder: contains a folder for each, by its name, and beside it its map. It is created on
            first use.
        under_way: those that are training or queued, by their names.
    """

    def __init__(self, folder: Path):
        self.folder = folder
        self._places = asyncio.Semaphore(TRAINING["at_once"])
        self.under_way: dict[str, Training] = {}
        self._tasks: set[asyncio.Task[None]] = set()

    def names(self) -> list[str]:
        """The names of the folders that have a run, or the remains of one; newest first.

        Raises:
            ValueError: the folder cannot be read.
        """
        try:
            folders = [path for path in self.folder.iterdir() if not path.name.startswith(".")]
        except FileNotFoundError:  # no training yet
            return []
        except OSError as error:
            raise ValueError(f"{self.folder}: cannot be read ({error.strerror})") from None
        began = {path.name: _began(path) for path in folders}
        return sorted(
            (name for name in began if began[name]), key=lambda name: (-began[name], name)
        )

    def path(self, name: str) -> Path:
        """The folder of a training's run.

        Raises:
            ValueError: there is no training with that name.
        """
        if name not in self.names():  # a name from a page must never become a path
            raise ValueError(f"no training has the name {shown(name)}; use one of those listed")
        return self.folder / name

    @contextlib.contextmanager
    def one(self, scene: Scene, settings: Settings) -> Iterator[Training]:
        """A new training, which is under way until it is left.

        Raises:
            ValueError: its settings are invalid, with the trainer's message; or the queue is full.
        """
        if len(self.under_way) >= TRAINING["at_once"] + TRAINING["waiting"]:
            raise ValueError(f"{TRAINING['waiting']} trainings are queued already; try again later")
        check_trainable(scene)
        name = secrets.token_hex(_NAME)
        drawn = self.folder / f"{name}.txt"
        given = msgspec.to_builtins(settings)  # those that the message has
        config = Config.from_dict(given | {"world": str(drawn), "slip": scene.slip})
        with _writing(self.folder):
            self.folder.mkdir(parents=True, exist_ok=True)
            text = scene.world.located().text().encode()
            write_whole(drawn, lambda file: file.write(text))
        training = self.under_way[name] = Training(name, self.folder / name, config, self._places)
        try:
            yield training
        finally:
            del self.under_way[name]
            if not training.folder.exists():  # it did not start
                drawn.unlink(missing_ok=True)

    def begin(self, scene: Scene, settings: Settings) -> Training:
        """Begins a training, which goes on while a page follows it.

        Raises:
            ValueError: as `one`.
        """
        with contextlib.ExitStack() as stack:
            training = stack.enter_context(self.one(scene, settings))
            task = asyncio.create_task(_trained(training, stack.pop_all()))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return training

    async def close(self) -> None:
        """Ends all trainings, and waits until what there is has been kept."""
        tasks = [*self._tasks]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


async def _trained(training: Training, under_way: contextlib.ExitStack) -> None:
    with under_way:
        await training.train()


def _began(folder: Path) -> float:
    """The time at which a run was started in a folder; 0 if there is none."""
    for name in _OF_A_RUN:
        with contextlib.suppress(OSError):
            return (folder / name).stat().st_mtime
    return 0.0


@contextlib.contextmanager
def _writing(folder: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise ValueError(
            f"{folder}: cannot be written to ({error.strerror}); make room there, or start the "
            "studio with another --out"
        ) from None


async def _started(folder: Path, config: Config) -> Process:
    process = await asyncio.create_subprocess_exec(
        *command("habilis.studio.training_process", str(folder)),
        stdin=PIPE,
        stdout=PIPE,
    )
    with contextlib.suppress(AttributeError, OSError):  # not available everywhere
        os.setpriority(os.PRIO_PROCESS, process.pid, _NICE)
    assert process.stdin is not None
    with contextlib.suppress(BrokenPipeError, ConnectionResetError):
        process.stdin.write((json.dumps(config.as_dict()) + "\n").encode())
        await process.stdin.drain()
        process.stdin.close()
    return process


async def _ended(process: Process) -> None:
    """Waits until a stopping trainer has written its last checkpoint and ended."""
    try:
        async with asyncio.timeout(_GRACE):
            await process.wait()
    except TimeoutError:
        process.kill()
        await process.wait()


def _terminate(process: Process) -> None:
    if process.returncode is None:
        with contextlib.suppress(ProcessLookupError):
            process.terminate()
