"""The learners that the ensemble is compared with: the fast default, and those of the multiverse.

    python -m research.pace.compared --out compared.csv --work compared

trains the rows of the paper's tables with each of them: the fast learner with the settings of
`data/settings.toml` and the seeds of its tables, the others with those of the multiverse, whose
grid has horizons and weights near the paper's. These are runs that the repository has had before,
to the same episodes; what `docs/multiverse` does not keep of them is when they first succeeded.
"""

import argparse
import sys
from collections.abc import Iterable, Iterator, Sequence
from math import log
from pathlib import Path
from typing import Any

import polars as pl

from habilis.files import write_whole
from habilis.progress import progress_bar
from habilis.studies.paper.published import EXPERIMENTS, REWARDS
from habilis.studies.paper.settings import FAST_MAPS, FULL, row_config
from habilis.sweeps import sweep
from research.multiverse import claims
from research.multiverse.settings import BETAS, HORIZONS, LEARNERS, Condition, agents

FAST = "fast default"
"""The name of the learner of `data/settings.toml`."""


def compared_agents() -> list[Condition]:
    """Every row of both tables, by the fast learner and by each of the multiverse's.

    Example:
        >>> len(compared_agents()), {agent.learner for agent in compared_agents()} >= {FAST, "PPO"}
        (42, True)
    """
    return [*_fast(), *_of_the_multiverse()]


def _fast() -> Iterator[Condition]:
    for experiment in EXPERIMENTS:
        for row in experiment.rows:
            config = row_config(experiment, row, FULL)
            where = (str(config.world), row.tool, REWARDS[row.intrinsic])
            yield Condition("fast", FAST, *where, row.horizon, row.beta, "plain", config)


def _of_the_multiverse() -> Iterator[Condition]:
    grid = {
        (a.learner, a.map, a.tool, a.reward, a.horizon, a.beta): a
        for a in agents({})
        if a.part == "multiverse"
    }
    for learner in LEARNERS:
        for experiment in EXPERIMENTS:
            for row in experiment.rows:
                horizon, beta = nearest(row.horizon, HORIZONS), nearest(row.beta, BETAS)
                reward = REWARDS[row.intrinsic]
                world = FAST_MAPS[experiment.name]
                yield grid[learner, world, row.tool, reward, horizon, beta]


def nearest(value: float, grid: Sequence[float]) -> Any:
    """The value of a grid whose ratio to another one is nearest to 1; 0 stays 0.

    Example:
        >>> nearest(5, (1, 3, 6, 8)), nearest(0.09, (0.04, 0.08, 0.15))
        (6, 0.08)
    """
    return value and min(grid, key=lambda one: abs(log(one / value)))


def as_rows(everyone: Sequence[Condition], results: pl.DataFrame) -> pl.DataFrame:
    """The results of a sweep, a row per condition, as `load_pace` reads them."""
    rows = []
    for point, agent in enumerate(everyone):
        runs = results.filter(point=point).sort("run")
        first = claims.counts(runs, "first success")
        rows.append(
            {name: getattr(agent, name) for name in ("learner", "map", "tool", "reward")}
            | {"horizon": agent.horizon, "beta": agent.beta, "runs": len(runs)}
            | {"converged": len(runs) - runs["converged_at"].null_count()}
            | {"episodes": _counts(runs["converged_at"]), "had": _counts(runs["episodes_had"])}
            | {"first_success": _counts(int(n) if n < float("inf") else None for n in first)}
            | {"steps": _counts(runs["steps_had"])}
        )
    return pl.DataFrame(rows)


def _counts(values: "Iterable[int | None]") -> str:
    return " ".join("-" if n is None else str(n) for n in values)


def main() -> int:
    parser = argparse.ArgumentParser(prog="research.pace.compared", description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="the CSV file to write")
    parser.add_argument("--work", type=Path, required=True, help="where finished runs are kept")
    args = parser.parse_args()
    everyone = compared_agents()
    with progress_bar("tasks", sys.stderr.isatty()) as on_progress:
        configs = [agent.config for agent in everyone]
        results = sweep(configs, args.work, resume=True, on_progress=on_progress)
    write_whole(args.out, as_rows(everyone, results).write_csv)
    return 0


if __name__ == "__main__":
    sys.exit(main())
