"""Many runs on few processors, or on a GPU: batches of lanes, refilled as runs end."""

import heapq
import itertools
import time
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from dataclasses import replace
from numbers import Integral
from pathlib import Path
from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Int

from habilis.cache import cache_folder
from habilis.files import check_folder
from habilis.learning.intrinsic import FOLLOWED
from habilis.learning.jobs import Job
from habilis.learning.lanes import Log, advance
from habilis.learning.runs import Gain, Progress, progress
from habilis.learning.stacks import InStack, Seat, Stack, finite, side_by_side
from habilis.processors import processors

LANES = 5
"""Runs in one compiled batch on a CPU. Always the same number, since XLA's rounding depends on it:
only so is a run the same whatever trains beside it. More lanes are no faster on a CPU."""

MOST_LANES = 512
"""Runs in one batch on another device, at most, unless another number is asked for."""

_COMPILED = "jax_compilation_cache_dir"

_IN_FLIGHT = 2
"""Batches of one GPU at a time: while one computes, the episodes of the other are summed up."""


class NotFiniteError(FloatingPointError):
    """A loss or a parameter was not finite: of `job`, its run at the place `run`."""

    def __init__(self, job: Job, run: int, message: str):
        super().__init__(message)
        self.job, self.run = job, run


def workers() -> int:
    """How many batches advance at once: one for each processor, or two for each other device."""
    devices = jax.devices()
    if devices[0].platform == "cpu":
        return max(processors(), len(devices))
    return _IN_FLIGHT * len(devices)


def room(lanes: int | None = None) -> int:
    """How many runs are worth having at once: twice what advances at once."""
    on_cpu = jax.devices()[0].platform == "cpu"
    return 2 * (lanes or (LANES if on_cpu else MOST_LANES)) * workers()


def check_lanes(lanes: int | None) -> None:
    """Refuses what is no width of a batch.

    Raises:
        ValueError: it is no whole number from 1 to 65,536.
    """
    whole = isinstance(lanes, Integral) and not isinstance(lanes, bool)
    if lanes is not None and not (whole and 1 <= lanes <= 2**16):
        raise ValueError(f"lanes is {lanes!r}; give a whole number from 1 to 65,536, or None")


def train_jobs(
    jobs: Iterable[Job],
    on_progress: Callable[[Progress], None] | None = None,
    on_stretch: Callable[[], None] | None = None,
    stopped: Callable[[], object] = lambda: False,
    at_once: float = float("inf"),
    *,
    lanes: int | None = None,
    stop_job: Callable[[Job], bool] = lambda job: False,
) -> None:
    """Trains all runs of all jobs to their end; what they do goes into the jobs.

    The runs that have come least far advance by a stretch, side by side in a batch, on a thread for
    each processor, or two for each other device. There the episodes are summed up, too; the jobs
    are changed here only, between stretches: whenever `on_stretch` is called, they hold a state
    that training can go on from.

    Args:
        jobs: made ready, or restored; taken one by one, as there is room.
        on_progress: called after every stretch, for the jobs in it.
        on_stretch: called after every stretch.
        stopped: asked after every stretch whether to leave it at that.
        at_once: how many runs there is room for.
        lanes: how many runs wide every batch is, filled up with repetitions. By default five on a
            CPU; on another device the smallest power of two that holds the runs that wait, 512 at
            most, and five if no more than five wait.
        stop_job: asked after every stretch, for each job in it with runs that go on, whether to
            give these up: they end as they are, not converged.

    Raises:
        NotFiniteError: a loss or a parameter was not finite. The jobs can go on without that run.
        ValueError: `lanes` is no number of lanes.
    """
    check_lanes(lanes)
    _keep_compiled()
    source, waiting = iter(jobs), _Waiting()
    devices = jax.devices()
    idle = [devices[i % len(devices)] for i in range(workers())]
    working: dict[Future[_Advanced], tuple[list[Seat], Any]] = {}

    def let_in() -> None:
        there = len(waiting) + sum(len(seats) for seats, _ in working.values())
        while there < at_once:
            job = next(source, None)
            if job is None:
                return
            for run, record in enumerate(job.records):
                if not record.ended:
                    waiting.add(Seat(job, run))
                    there += 1

    let_in()
    with ThreadPoolExecutor(processors()) as helpers, ThreadPoolExecutor(len(idle)) as pool:
        while working or (len(waiting) and not stopped()):
            while len(waiting) and idle and not stopped():
                device = idle.pop()
                seats, width = waiting.take(lanes, device)
                for job, run in seats:
                    job.records[run].began = job.records[run].began or time.perf_counter()
                working[pool.submit(_advance, seats, width, device, helpers)] = seats, device
            for future in wait(working, return_when=FIRST_COMPLETED).done:
                seats, device = working.pop(future)
                idle.append(device)
                changed = _enter(seats, future.result())
                for job in changed:
                    if not all(record.ended for record in job.records) and stop_job(job):
                        for record in job.records:
                            record.stop()
                        waiting.drop(job)
                for seat in seats:
                    if not seat.job.records[seat.run].ended:
                        waiting.add(seat)
                if on_progress is not None:
                    for job in changed:
                        on_progress(progress(job.index, job.records))
                if on_stretch is not None and changed:
                    on_stretch()
            if not stopped():
                let_in()


class _Waiting:
    """Runs that wait, those that have come least far first, by what a batch must share."""

    def __init__(self) -> None:
        self._heaps: dict[tuple, list[tuple[int, int, int, int, Seat]]] = {}
        self._turns = itertools.count()

    def __len__(self) -> int:
        return sum(map(len, self._heaps.values()))

    def add(self, seat: Seat) -> None:
        job, run = seat
        place = job.records[run].steps, job.index, run, next(self._turns), seat
        heapq.heappush(self._heaps.setdefault(job.kind, []), place)

    def take(self, lanes: int | None, device: Any) -> tuple[list[Seat], int]:
        """Takes those that have come least far, all of one kind, and how wide their batch is."""
        kind, heap = min(self._heaps.items(), key=lambda item: item[1][0])
        width = _width(len(heap), device) if lanes is None else int(lanes)
        seats = [heapq.heappop(heap)[-1] for _ in range(min(width, len(heap)))]
        if not heap:
            del self._heaps[kind]
        return seats, width

    def drop(self, job: Job) -> None:
        """Takes out all runs of a job."""
        left = [place for place in self._heaps.pop(job.kind, []) if place[-1].job is not job]
        if left:
            heapq.heapify(left)
            self._heaps[job.kind] = left


def _width(wait: int, device: Any) -> int:
    """The default width of a batch, given how many runs wait."""
    if device.platform == "cpu" or wait <= LANES:
        return LANES
    return min(MOST_LANES, 1 << (wait - 1).bit_length())


class _Advanced(NamedTuple):
    """The result of a chunk: for each run of a batch its place in the stack, and its gain."""

    stack: Stack
    places: list[int]
    gains: list[Gain | NotFiniteError]


def _advance(seats: list[Seat], width: int, device: Any, helpers: Executor) -> _Advanced:
    """A stretch of training, and what it adds to the records. Changes no record."""
    job = seats[0].job
    before, places = side_by_side(seats, width, device)
    if job.program.intrinsic == FOLLOWED:
        before = _following(before, seats, places)
    dynamics = jax.device_put(job.dynamics[0], device)
    lanes, log = advance(dynamics, before.settings, before.lanes, job.program)
    stack = Stack(device, before.settings, lanes)
    sound = finite(stack)
    log = jax.tree.map(np.asarray, log)

    def gains(part: Int[np.ndarray, "n"]) -> list[Gain | NotFiniteError]:
        return [_gain(*seats[i], log, places[i], bool(sound[places[i]])) for i in map(int, part)]

    # A few runs at a time: handing over each of them would cost as much as its sums.
    parts = np.array_split(range(len(seats)), min(-(-len(seats) // LANES), processors()))
    return _Advanced(stack, places, [gain for some in helpers.map(gains, parts) for gain in some])


def _following(stack: Stack, seats: list[Seat], places: list[int]) -> Stack:
    """The stack with the intrinsic values of the policies as they are, where these are due."""
    updates, values = np.asarray(stack.lanes.updates), np.array(stack.lanes.novelty)
    for (job, _), place in zip(seats, places, strict=True):
        if updates[place] % job.config.policy_every == 0:
            values[place] = job.followed(stack.lane(place).train_state)
    lanes = stack.lanes._replace(novelty=jax.device_put(values, stack.device))
    return replace(stack, lanes=lanes)


def _gain(job: Job, run: int, log: Log, place: int, sound: bool) -> Gain | NotFiniteError:
    """A chunk's additions to the record of a run, or the error if the run is not finite."""
    loss, envs = log.loss[place], log.transition.shape[-1]
    made = (np.asarray(log.transition[place]) >= 0).sum(axis=(1, 2))
    if (error := _not_finite(job, run, np.asarray(loss), made, sound)) is not None:
        return error
    did = (np.asarray(part[place]) for part in (log.transition, log.truncated))
    transition, truncated = (part.reshape(-1, envs) for part in did)
    return job.records[run].gain(transition, truncated, float(loss.mean(dtype=np.float64)))


def _enter(seats: list[Seat], advanced: _Advanced) -> list[Job]:
    """Takes in what a stretch gave; the jobs that it has changed.

    Raises:
        NotFiniteError: of a run; those before it have been entered.
    """
    changed: dict[int, Job] = {}
    for (job, run), place, gain in zip(seats, advanced.places, advanced.gains, strict=True):
        record = job.records[run]
        if record.ended:  # stopped while it trained
            continue
        if isinstance(gain, NotFiniteError):
            raise gain
        record.add(gain)
        stack = advanced.stack
        job.lanes[run] = stack.alone(place) if record.ended else InStack(stack, place)
        changed[job.index] = job
    return list(changed.values())


def _not_finite(
    job: Job, run: int, loss: np.ndarray, made: np.ndarray, sound: bool
) -> NotFiniteError | None:
    """The error of a run whose loss or parameters are not finite, if any.

    Args:
        job, run: which.
        loss, made: float[updates] and int[updates], of a stretch: losses and steps.
        sound: whether all that was learned is finite.
    """
    broken = np.flatnonzero(~np.isfinite(loss))
    if len(broken):
        what, updates = "loss", int(broken[0]) + 1
    elif not sound:
        what, updates = "parameters", len(loss)
    else:
        return None
    step = job.records[run].steps + int(made[:updates].sum())
    return NotFiniteError(
        job,
        run,
        f"{job.world.name}: the {what} of run {job.numbers[run]} "
        f"{'is' if what == 'loss' else 'are'} not finite at step {step:,}; lower learning_rate or "
        "reward_scale",
    )


def _keep_compiled() -> None:
    """Enables JAX's compilation cache on disk, unless it is configured already.

    In `$XDG_CACHE_HOME/habilis`, by default `~/.cache/habilis`. JAX's own settings come first:
    `JAX_COMPILATION_CACHE_DIR` names another place, `JAX_ENABLE_COMPILATION_CACHE=false` is none.
    """
    folder = cache_folder()
    if getattr(jax.config, _COMPILED) is None and folder is not None and _can_be_written(folder):
        jax.config.update(_COMPILED, str(folder))


def _can_be_written(folder: Path) -> bool:
    """Where it cannot, JAX would warn of every program."""
    try:
        check_folder(folder)
    except ValueError:
        return False
    return True
