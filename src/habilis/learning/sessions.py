"""Training in a folder: interrupted at any moment, it goes on where it was."""

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path

from habilis.files import check_folder, check_unused, writing
from habilis.interruption import LOCK, Interrupted, locked, stop_signals
from habilis.learning import checkpoints
from habilis.learning.batches import train_jobs
from habilis.learning.config import Config
from habilis.learning.folder import (
    TABLE,
    begin,
    finish,
    has_begun,
    is_finished,
    load_run,
    read_config,
    read_world,
    tidy,
)
from habilis.learning.jobs import Job
from habilis.learning.metrics import note_metrics
from habilis.learning.runs import Progress, Run
from habilis.learning.sources import Source, names_table
from habilis.learning.tensorboard import EventFiles
from habilis.learning.training_problem import prepared

_GO_ON = "make room there, and continue with resume"


def train_in_folder(
    config: Config,
    on_progress: Callable[[Progress], None] | None,
    folder: Path,
    resume: bool,
    seconds: float,
    lanes: int | None = None,
) -> Run:
    """Trains one configuration and keeps checkpoints; see `train`.

    Raises:
        Interrupted: by Ctrl-C or SIGTERM, after a last checkpoint.
        ValueError: the folder is in use, is another run's, or cannot be written.
        FloatingPointError: a loss or a parameter was not finite; names the last checkpoint.
    """
    if not seconds >= 0:
        raise ValueError(f"checkpoint_seconds is {seconds!r}; give a number from 0 up")
    source = None
    if names_table(config.world):
        config, source = prepared(config)
    if not resume:
        check_unused(folder)
    elif is_finished(folder):
        return _finished(config, folder)
    check_folder(folder)
    job = _job_of(config, source, folder)
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
    with locked(folder):
        if is_finished(folder):  # by a process that had the folder until now
            return _finished(config, folder)
        if has_begun(folder):  # or begun, with who knows what settings
            _check_same(config, folder)
        _restore(job, folder)
        with writing(folder, _GO_ON):
            begin(job, folder)
            events = EventFiles(job, folder)
        return _train(job, on_progress, folder, seconds, events, lanes)


def _finished(config: Config, folder: Path) -> Run:
    _check_same(config, folder)
    run = load_run(folder)
    with writing(folder):
        tidy(folder)
    return run


def _job_of(config: Config, source: Source | None, folder: Path) -> Job:
    """The settings of an existing folder, if they match, or new ones.

    A process that is killed before it has written what a run starts from leaves its lock, parts of
    that, and nothing to go on from.
    """
    if not has_begun(folder):
        ours = (LOCK, "config.json", "world.txt", TABLE) if (folder / LOCK).exists() else ()
        check_unused(folder, but=ours)
        return Job.of(0, config, source)
    _check_same(config, folder)
    return Job.of(0, config, read_world(folder))


def _restore(job: Job, folder: Path) -> None:
    """Restores a job from the last intact checkpoint, and reports damaged ones."""
    good, damaged = checkpoints.restore(job, folder)
    for path, reason in damaged.items():
        print(
            f"habilis: {path}: is damaged ({reason}); continuing from the previous one, {good}",
            file=sys.stderr,
        )
        with writing(folder):
            checkpoints.set_aside(path)


def _check_same(config: Config, folder: Path) -> None:
    """Refuses to resume a folder with other settings."""
    began, wanted = read_config(folder).as_dict(), config.as_dict()
    for name, value in wanted.items():
        if json.loads(json.dumps(value)) != json.loads(json.dumps(began.get(name))):
            raise ValueError(
                f"{folder}: was started with {name} {began.get(name)!r}, not {value!r}; "
                "give the same settings, or another folder"
            )


def _train(
    job: Job,
    on_progress: Callable[[Progress], None] | None,
    folder: Path,
    seconds: float,
    events: EventFiles,
    lanes: int | None,
) -> Run:
    saved = time.monotonic()

    def look(over: bool = False) -> None:
        nonlocal saved
        note_metrics(job)
        if over or time.monotonic() - saved >= seconds:
            with writing(folder, _GO_ON):
                checkpoints.save(job, folder)
                events.add()
            saved = time.monotonic()

    with stop_signals() as stopped:
        try:
            train_jobs([job], on_progress, look, stopped, lanes=lanes)
        except FloatingPointError as error:
            kept = checkpoints.checkpoints(folder)
            last = f"the last good checkpoint is {kept[0]}" if kept else "no checkpoint was made"
            raise FloatingPointError(f"{error}; {last}") from None
        if stopped() and not all(record.ended for record in job.records):
            look(over=True)
            raise Interrupted(f"stopped; all is kept in {folder}; continue with resume", stopped())
        run = job.result()
        with writing(folder, _GO_ON):
            events.add()
            finish(run, folder)
    return run
