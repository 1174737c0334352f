"""Many runs on few processors: batches of lanes, refilled as runs end."""

import time
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Float, Int

from habilis.learning.compilation import keep_compiled
from habilis.learning.jobs import Job
from habilis.learning.lanes import Lane, Log, advance
from habilis.learning.runs import Progress, progress
from habilis.processors import processors

LANES = 5
"""Runs in one compiled batch. Always the same number, since XLA's rounding depends on it: only
so is a run the same whatever trains beside it. More lanes are no faster on a CPU."""


class Seat(NamedTuple):
    """A run, by its job and its number there."""

    job: Job
    run: int


class NotFiniteError(FloatingPointError):
    """A loss or a parameter was not finite: of `job`, its run at the place `run`."""

    def __init__(self, job: Job, run: int, message: str):
        super().__init__(message)
        self.job, self.run = job, run


def workers() -> int:
    """How many batches advance at once: one for each processor, or device."""
    devices = jax.devices()
    return max(processors() if devices[0].platform == "cpu" else 1, len(devices))


def train_jobs(
    jobs: Iterable[Job],
    on_progress: Callable[[Progress], None] | None = None,
    on_stretch: Callable[[], None] | None = None,
    stopped: Callable[[], object] = lambda: False,
    at_once: float = float("inf"),
) -> None:
    """Trains all runs of all jobs to their end; what they do goes into the jobs.

    The runs that have come least far advance by a stretch, five at a time, on a thread for each
    processor or device. All bookkeeping is done here, between stretches: whenever `on_stretch` is
    called, the jobs hold a state that training can go on from.

    Args:
        jobs: made ready, or restored; taken one by one, as there is room.
        on_progress: called after every stretch, for the jobs in it.
        on_stretch: called after every stretch.
        stopped: asked after every stretch whether to leave it at that.
        at_once: how many runs there is room for.

    Raises:
        NotFiniteError: a loss or a parameter was not finite. The jobs can go on without that run.
    """
    keep_compiled()
    source, waiting = iter(jobs), list[Seat]()
    devices = jax.devices()
    idle = [devices[i % len(devices)] for i in range(workers())]
    working: dict[Future[tuple[list[Lane], Log]], tuple[list[Seat], Any]] = {}

    def let_in() -> None:
        while len(waiting) + sum(len(seats) for seats, _ in working.values()) < at_once:
            job = next(source, None)
            if job is None:
                return
            for run, record in enumerate(job.records):
                if run not in job.lanes:
                    job.lanes[run] = job.start(run)
                if not record.ended:
                    waiting.append(Seat(job, run))

    let_in()
    with ThreadPoolExecutor(len(idle)) as pool:
        while working or (waiting and not stopped()):
            while waiting and idle and not stopped():
                seats = _next_batch(waiting)
                device = idle.pop()
                for job, run in seats:
                    job.records[run].began = job.records[run].began or time.perf_counter()
                working[pool.submit(_advance, seats, device)] = seats, device
            for future in wait(working, return_when=FIRST_COMPLETED).done:
                seats, device = working.pop(future)
                idle.append(device)
                _enter(seats, *future.result())
                waiting += [seat for seat in seats if not seat.job.records[seat.run].ended]
                if on_progress is not None:
                    for job in {seat.job.index: seat.job for seat in seats}.values():
                        on_progress(progress(job.index, job.records))
                if on_stretch is not None:
                    on_stretch()
            if not stopped():
                let_in()


def _next_batch(waiting: list[Seat]) -> list[Seat]:
    """Takes those that have come least far, all of one program and world."""
    waiting.sort(key=lambda seat: (seat.job.records[seat.run].steps, seat.job.index, seat.run))

    def kind(job: Job) -> tuple:
        return job.world, job.conditions, job.config.observation, job.program

    same = [seat for seat in waiting if kind(seat.job) == kind(waiting[0].job)]
    batch = same[:LANES]
    for seat in batch:
        waiting.remove(seat)
    return batch


def _advance(seats: list[Seat], device: Any) -> tuple[list[Lane], Log]:
    """A stretch of training of at most five runs."""
    full = (seats * LANES)[:LANES]  # a batch that is not full repeats its runs, unseen
    job = seats[0].job
    settings, lanes = (
        jax.tree.map(lambda *leaves: np.stack(leaves), *parts)
        for parts in ([s.job.settings for s in full], [s.job.lanes[s.run] for s in full])
    )
    task, settings, lanes = jax.device_put((job.task[0], settings, lanes), device)
    lanes, log = jax.tree.map(np.asarray, advance(task, settings, lanes, job.program))
    return [jax.tree.map(lambda leaf, i=i: leaf[i], lanes) for i in range(len(seats))], log


def _enter(seats: list[Seat], lanes: list[Lane], log: Log) -> None:
    """Takes in what a stretch gave."""
    for place, ((job, run), lane) in enumerate(zip(seats, lanes, strict=True)):
        record = job.records[run]
        envs = log.transition.shape[-1]
        made = np.asarray(log.transition[place] >= 0).sum(axis=(1, 2))
        _check_finite(job, run, np.asarray(log.loss[place]), made, (lane.learner, lane.novelty))
        did = (np.asarray(part[place]) for part in (log.transition, log.truncated))
        transition, truncated = (part.reshape(-1, envs) for part in did)
        record.add(transition, truncated, float(log.loss[place].mean(dtype=np.float64)))
        job.lanes[run] = lane


def _check_finite(
    job: Job,
    run: int,
    loss: Float[np.ndarray, "updates"],
    made: Int[np.ndarray, "updates"],
    learned: object,
) -> None:
    """Refuses what a run has come to, if it is no numbers.

    Args:
        job, run: which run.
        loss, made: of each update, its loss and how many steps it had.
        learned: what the run has learned at the end of the stretch.

    Raises:
        NotFiniteError: a loss is not finite, or what was learned at the end of the stretch.
    """
    broken = np.flatnonzero(~np.isfinite(loss))
    if len(broken):
        what, updates = "loss", int(broken[0]) + 1
    elif not all(bool(np.isfinite(leaf).all()) for leaf in jax.tree.leaves(learned)):
        what, updates = "parameters", len(loss)
    else:
        return
    step = job.records[run].steps + int(made[:updates].sum())
    raise NotFiniteError(
        job,
        run,
        f"{job.world.name}: the {what} of run {job.numbers[run]} "
        f"{'is' if what == 'loss' else 'are'} not finite at step {step:,}; lower learning_rate or "
        "reward_scale",
    )
