"""Training: environment steps a second, learning included."""

import time
from dataclasses import replace

from habilis.benchmarks import Result
from habilis.learning.config import Config
from habilis.learning.train import train


def results() -> list[Result]:
    config = Config(world="corridor", runs=10, episodes=1_000_000, steps=20_000)
    began = time.perf_counter()
    train(config)
    first = time.perf_counter() - began
    rates: list[float] = []
    train(replace(config, steps=1_000_000), lambda p: rates.append(p.steps_per_second))
    note = "corridor, 10 runs x 16 environments x 5 steps, MLP 64-64, all cores"
    return [
        Result("training, first call", first, "s", "compilation included"),
        Result("training", rates[-1] / 1e6, "M steps/s", note),
    ]
