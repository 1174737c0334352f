"""Training in a folder: interrupted at any moment, it goes on where it was."""

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path

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
from habilis.learning.interruption import Interrupted, alone, stop_signals
from habilis.learning.jobs import Job
from habilis.learning.runs import Progress, Run


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
    with alone(folder):
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

    with stop_signals() as stopped:
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
