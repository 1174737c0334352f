"""A reproduction of which nothing was trained: its curves are drawn, all else is real."""

from pathlib import Path

import numpy as np
import polars as pl

from habilis.learning.runs import Run
from habilis.studies.pace.data import Pace
from habilis.studies.paper.agent_statements import agent_statements
from habilis.studies.paper.numbers import published_numbers, published_statements
from habilis.studies.paper.published import EXPERIMENTS, Experiment, Row
from habilis.studies.paper.settings import FULL, row_config
from habilis.studies.paper.tables import Result
from habilis.studies.reproduction.result import Reproduction
from habilis.worlds.world import load_world


def reproduction(folder: Path, pace: Pace, scale: float = 1.0, seed: int = 0) -> Reproduction:
    """All in which the paper's episodes come out, as many as `scale` says; to be written."""
    random = np.random.default_rng(seed)
    results = {
        e.name: [Result.of(row, _run(e, row, pace, scale, random)) for row in e.rows]
        for e in EXPERIMENTS
    }
    return Reproduction(
        folder=folder,
        numbers=published_numbers(),
        relations=published_statements(),
        learned=agent_statements(results, pace.ensemble),
        results=results,
        pace=pace,
        budget=FULL,
        quick=False,
        seconds=60.0,
    )


def _run(
    experiment: Experiment, row: Row, pace: Pace, scale: float, random: np.random.Generator
) -> Run:
    config = row_config(experiment, row, FULL, pace.best)
    best = -14.0 if experiment.name == "table1" else -12.0
    parts, converged = [], []
    for run in range(FULL["runs"]):
        count = int(scale * row.mean * random.lognormal(0, 0.12))
        done = np.arange(count) / count
        returns = np.maximum(best - 480 * np.exp(-9 * done) * random.random(count), -500).round()
        steps = (1 - returns).astype(int)
        early = 0.0 if row.vanilla else 0.2
        equipped = (steps * np.clip(1.1 * done + early, 0, 0.95)).astype(int)
        parts.append(
            pl.DataFrame({"run": np.full(count, run), "episode": np.arange(count)}).with_columns(
                pl.Series("steps", steps),
                pl.Series("return", returns),
                pl.Series("equipped", equipped),
                pl.Series("attached", (0.6 * equipped * done).astype(int)),
            )
        )
        converged.append(None if row.tool == "broom" and run < 3 else count)
    world = load_world(str(config.world), config.tool)
    return Run(config, world, best, pl.concat(parts), tuple(converged), None)
