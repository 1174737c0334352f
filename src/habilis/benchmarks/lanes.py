"""Training on one device: environment steps a second by how many runs learn side by side.

`habilis bench lanes` measures JAX's default device: the compiled loop alone, all of `train` with
batches that wide, two of them at once, and what the books of one lane cost. On a processor more
lanes than fit its caches cost as much each, and `train` has five; a GPU needs thousands to be busy.
"""

import time

import jax
import numpy as np

from habilis.benchmarks import Result, time_of
from habilis.benchmarks.learning import A2C, CONFIG, UPDATES, Loop, steps_a_second
from habilis.learning.batches import LANES
from habilis.learning.convergence import Averages
from habilis.learning.jobs import Job
from habilis.learning.lanes import advance

_ON_A_PROCESSOR = (1, 5, 16, 64)
_ON_A_GPU = (1, 5, 16, 64, 256, 512, 1024, 2048, 4096)
_STEPS = 200_000
"""Of each run, where all of `train` is measured."""


def results() -> list[Result]:
    """The rate of each number of lanes, compiled before, and what compiling took."""
    device = jax.devices()[0]
    on_cpu = device.platform == "cpu"
    kind = device.device_kind
    loops = [
        line
        for lanes in (_ON_A_PROCESSOR if on_cpu else _ON_A_GPU)
        for line in _measured(lanes, kind)
    ]
    trains = [_all_of_train(lanes, kind) for lanes in ((LANES,) if on_cpu else _ON_A_GPU)]
    return [*loops, *trains, *_books()]


def _measured(lanes: int, device: str) -> list[Result]:
    loop = Loop.of(CONFIG.changed(runs=lanes))
    began = time.perf_counter()
    loop.train()
    first = time.perf_counter() - began
    seconds = time_of(loop.train)
    steps = lanes * UPDATES * A2C.envs * A2C.rollout
    return [
        Result.of(f"training, {lanes:,} lanes", steps / seconds / 1e6, "M steps/s", device),
        Result(f"training, {lanes:,} lanes, first call", first, "s", "compiling included"),
    ]


def _all_of_train(lanes: int, device: str) -> Result:
    rate = steps_a_second(2 * lanes, lanes, _STEPS)
    note = f"{device}; {2 * lanes:,} runs, bookkeeping included"
    return Result(f"all of train(), {lanes:,} lanes", rate / 1e6, "M steps/s", note)


def _books() -> list[Result]:
    """The bookkeeping in Python and Numba per lane and chunk, on one processor."""
    job, loop = Job.of(0, CONFIG), Loop.of(CONFIG.changed(runs=LANES))
    _, log = advance(loop.dynamics, loop.settings, loop.lanes, loop.program)
    transition = np.asarray(log.transition)[0].reshape(-1, A2C.envs)
    truncated = np.asarray(log.truncated)[0].reshape(-1, A2C.envs)
    ledger, before = job.records[0].ledger, Averages.of()
    running = ledger.nothing(A2C.envs)
    episodes, _ = ledger.entries(running, transition, truncated)
    returns = np.tile(episodes[:, 1], -(-1_000 // max(1, len(episodes))))[:1_000]
    before, _ = before.after(returns, job.best_return)  # it is compiled here
    summing = time_of(lambda: ledger.entries(running, transition, truncated), 50)
    looking = time_of(lambda: before.after(returns, job.best_return), 50)
    return [
        Result.of(
            "summing up episodes", summing * 1e3, "ms", f"{transition.size:,} steps of a lane"
        ),
        Result.of("looking for convergence", looking * 1e3, "ms", "1,000 more episodes of a run"),
    ]
