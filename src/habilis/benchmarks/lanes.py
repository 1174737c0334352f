"""Training on one device: environment steps a second by how many runs learn side by side.

`habilis bench lanes` measures JAX's default device. On a processor more lanes than fit its caches
cost as much each; a GPU needs thousands to be busy.
"""

import time

import jax

from habilis.benchmarks import Result
from habilis.benchmarks.learning import A2C, CONFIG, UPDATES, Loop

_ON_A_PROCESSOR = (1, 5, 16, 64)
_ON_A_GPU = (1, 5, 16, 64, 256, 1024, 2048, 4096)


def results() -> list[Result]:
    """The rate of each number of lanes, compiled before, and what compiling took."""
    device = jax.devices()[0]
    widths = _ON_A_PROCESSOR if device.platform == "cpu" else _ON_A_GPU
    return [line for lanes in widths for line in _measured(lanes, device.device_kind)]


def _measured(lanes: int, device: str) -> list[Result]:
    loop = Loop.of(CONFIG.changed(runs=lanes))
    began = time.perf_counter()
    loop.train()
    first = time.perf_counter() - began
    best = float("inf")
    for _ in range(3):
        began = time.perf_counter()
        loop.train()
        best = min(best, time.perf_counter() - began)
    steps = lanes * UPDATES * A2C.envs * A2C.rollout
    return [
        Result(f"training, {lanes:,} lanes", steps / best / 1e6, "M steps/s", device),
        Result(f"training, {lanes:,} lanes, first call", first, "s", "compiling included"),
    ]
