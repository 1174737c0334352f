"""Training in a folder: interrupted at any moment, it goes on where it was."""

import json
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

from habilis.learning import checkpoints
from habilis.learning.batches import train_jobs
from habilis.learning.config import Config
from habilis.learning.folder import (
    begin,
    check_unused,
    check_writable,
    finish,
    is_finished,
    load_run,
    read_config,
    read_world,
    saving,
)
from habilis.learning.jobs import Job
from habilis.learning.runs import Progress, Run

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Interrupted(KeyboardInterrupt):
    """Training was stopped from outside; the message says how to go on."""


def train_in_folder(
    config: Config,
    on_progress: Callable[[Progress], None] | None,
    folder: Path,
    resume: bool,
    seconds: float,
) -> Run:
    """Trains one configuration and keeps checkpoints; see `train`.

    Raises:
        Interrupted: by Ctrl-C or SIGTERM, after a last checkpoint.
        ValueError: the folder is in use, is another run's, or cannot be written.
        FloatingPointError: a loss or a parameter was not finite; names the last checkpoint.
    """
    if not seconds >= 0:
        raise ValueError(f"checkpoint_seconds is {seconds!r}; give a number from 0 up")
    there = resume and folder.is_dir() and any(folder.iterdir())
    check_writable(folder) if there else check_unused(folder)
    job = _job_of(config, folder) if there else Job.of(0, config)
    if is_finished(folder):
        return load_run(folder)
    with saving(folder):
        folder.mkdir(parents=True, exist_ok=True)
    with _alone(folder):
        if there:
            for line in checkpoints.restore(job, folder):
                print(f"habilis: {line}", file=sys.stderr)
        with saving(folder):
            begin(job, folder)
        return _train(job, on_progress, folder, seconds)


def _job_of(config: Config, folder: Path) -> Job:
    """What a folder was begun with, if that is what is asked for."""
    began, wanted = read_config(folder).as_dict(), config.as_dict()
    for name, value in wanted.items():
        if json.loads(json.dumps(value)) != json.loads(json.dumps(began.get(name))):
            raise ValueError(
                f"{folder}: was begun with {name} {began.get(name)!r}, not {value!r}; "
                "give the same settings, or another folder"
            )
    return Job.of(0, config, read_world(folder))


def _train(
    job: Job, on_progress: Callable[[Progress], None] | None, folder: Path, seconds: float
) -> Run:
    saved = time.monotonic()

    def look(over: bool = False) -> None:
        nonlocal saved
        if over or time.monotonic() - saved >= seconds:
            with saving(folder):
                checkpoints.save(job, folder)
            saved = time.monotonic()

    with _stop_signals() as stopped:
        try:
            train_jobs([job], on_progress, look, stopped)
        except FloatingPointError as error:
            kept = checkpoints.checkpoints(folder)
            last = f"the last good checkpoint is {kept[0]}" if kept else "no checkpoint was made"
            raise FloatingPointError(f"{error}; {last}") from None
        if stopped() and not all(record.ended for record in job.records):
            look(over=True)
            raise Interrupted(f"stopped; all is kept in {folder}: go on with --resume")
    run = job.result()
    with saving(folder):
        finish(run, folder)
    return run


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Holds the folder's lock, which the system lets go when the process ends, however it does."""
    lock = FileLock(folder / "lock")
    try:
        lock.acquire(timeout=0)
    except Timeout:
        raise ValueError(
            f"{folder}: another process trains in it; wait for it, or name another folder"
        ) from None
    except OSError as error:
        raise ValueError(f"{folder}: cannot be written ({error.strerror or error})") from None
    try:
        yield
    finally:
        lock.release()


@contextmanager
def _stop_signals() -> Iterator[Callable[[], bool]]:
    """Whether Ctrl-C or SIGTERM has come. A second one ends the process as it always does."""
    asked = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield asked.is_set
        return
    before = {number: signal.getsignal(number) for number in _SIGNALS}

    def restore() -> None:
        for number, handler in before.items():
            signal.signal(number, handler)

    def stop(number: int, frame: object) -> None:
        asked.set()
        restore()

    for number in _SIGNALS:
        signal.signal(number, stop)
    try:
        yield asked.is_set
    finally:
        restore()
