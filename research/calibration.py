"""Choosing the A2C settings, which the paper does not give, on the vanilla rows alone.

First every setting of the grid trains a few agents without intrinsic reward in both worlds, on a
small budget. The settings with which all of these converge are ranked by the environment steps that
the slowest runs needed (the geometric mean over the rows, so that each weighs alike). In that
order, a few at a time, they train twice as many agents as the paper, with other seeds, until all
of these converge. That setting is written to `data/settings.toml`, for all rows of both tables. The
seeds are not those of the tables.

The weight of entropy stays as it is for twice as long as the slowest of these runs took, then
falls to nothing in as long again. For the vanilla agents this changes nothing. The others need
it: where a bonus leaves a step's cost at 0.4 instead of 1, the policy that balances it with
entropy is a noisy one, for ever three steps from the best return on average, though its greedy
plan is a shortest one. And it must not fall sooner: runs whose entropy is gone too early stay on
a plan a step or two too long (`docs/learning.md`).

    python -m research.calibration      # half an hour; goes on where it was stopped
"""

import math
import sys
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import polars as pl

from habilis.files import write_whole
from habilis.learning.config import Config
from habilis.learning.runs import Run
from habilis.progress import progress_bar
from habilis.studies.paper.published import EXPERIMENTS
from habilis.studies.paper.settings import FAST_MAPS, SETTINGS
from habilis.sweeps import sweep

RESULTS = Path(__file__).parent / "results" / "calibration.csv"
WORK = Path("calibration")
"""Where finished runs are kept until their stage is in the results."""

GRID: dict[str, tuple] = {
    "envs, rollout": ((16, 5),),
    "learning_rate": (1e-3, 2e-3),
    "entropy, entropy_end, entropy_steps": (
        (0.01, 0.01, 0),
        (0.02, 0.02, 0),
        (0.03, 0.03, 0),
    ),
    "gae_lambda": (1.0, 0.95),
}
"""The grid: every combination.

The file of results has those of earlier grids, too: a larger step size, and entropy that falls from
the start, with which one vanilla run in sixty, or more, stayed on a plan too long."""

FIXED = {"optimizer": "adam", "reward_scale": 0.1, "discount": 0.99}
"""The same in all. Earlier grids had RMSprop too, which took ten times as long in the corridor, and
8 environments by 20 steps, with which the broom more often stayed on a plan a step too long."""

SCREEN = {"runs": 5, "seed": 1001, "episodes": 60_000, "steps": 3_000_000}
"""First, every setting, with few runs and steps."""
CONFIRM = {"runs": 20, "seed": 2001, "episodes": 200_000, "steps": 4_000_000}
"""Then those that came first, until one is dependable."""
_CONFIRMED_TOGETHER = 4

VANILLA = [(e, row) for e in EXPERIMENTS for row in e.rows if row.vanilla]


def settings_grid() -> list[dict]:
    """All combinations of the grid."""
    settings = []
    for values in product(*GRID.values()):
        setting = {}
        for names, value in zip(GRID, values, strict=True):
            parts = value if isinstance(value, tuple) else (value,)
            setting |= dict(zip(names.split(", "), parts, strict=True))
        settings.append(setting)
    return settings


def vanilla_configs(setting: dict, stage: dict) -> list[Config]:
    """One configuration for each vanilla row of the paper."""
    return [
        Config(world=FAST_MAPS[e.name], tool=row.tool).changed(**FIXED, **setting, **stage)
        for e, row in VANILLA
    ]


def run_stage(stage: str, budget: dict, settings: list[dict]) -> None:
    """Trains what is not yet in the results, and adds it there."""
    done = [setting for setting, _ in _results(stage)] if RESULTS.exists() else []
    points = [
        (setting, config)
        for setting in settings
        if setting not in done
        for config in vanilla_configs(setting, budget)
    ]
    if not points:
        return
    with progress_bar("tasks", sys.stderr.isatty()) as on_progress:
        how: dict[str, Any] = {"resume": True, "measures": (episode_steps,)}
        configs = [config for _, config in points]
        runs = sweep(configs, WORK / stage, on_progress=on_progress, **how)
    rows = [
        {"stage": stage, "world": config.world, "tool": config.tool}
        | setting
        | {
            "runs": config.runs,
            "converged": part["converged_at"].count(),
            "slowest": int(part.select(pl.coalesce("steps_of_episodes", "steps_had").max()).item()),
            "episodes": " ".join("-" if n is None else str(n) for n in part["converged_at"]),
        }
        for (setting, config), part in zip(points, runs.partition_by("point"), strict=True)
    ]
    table = pl.DataFrame(rows)
    if RESULTS.exists():
        table = pl.concat([pl.read_csv(RESULTS), table], how="vertical_relaxed")
    write_whole(RESULTS, table.write_csv)
    for row in rows:
        print(*row.values(), flush=True)


def episode_steps(run: Run, index: int) -> dict[str, float]:
    """The steps of a run's episodes, without those of its last stretch after it converged."""
    return {"steps_of_episodes": float(run.episodes.filter(run=index)["steps"].sum())}


@dataclass(frozen=True)
class Score:
    """The result of a setting in one stage.

    Attributes:
        setting: the fields of the algorithm that the grid varies.
        converged: whether all runs of all rows did.
        steps: environment steps of a row's slowest run, the geometric mean over the rows.
        slowest: environment steps of the slowest run of all.
    """

    setting: dict
    converged: bool
    steps: float
    slowest: int


def scores(stage: str) -> list[Score]:
    """The settings of a stage: those in which all runs converged first, then the soonest."""
    found = [
        Score(
            setting,
            bool((rows["converged"] == rows["runs"]).all()) and len(rows) == len(VANILLA),
            math.exp(rows["slowest"].log().mean()),  # pyright: ignore[reportArgumentType]
            int(rows["slowest"].max()),  # pyright: ignore[reportArgumentType]
        )
        for setting, rows in _results(stage)
    ]
    return sorted(found, key=lambda score: (not score.converged, score.steps))


def _results(stage: str) -> list[tuple[dict, pl.DataFrame]]:
    """The results of the settings of the grid; the file has those of earlier grids, too."""
    grid = settings_grid()
    names = list(grid[0])
    results = pl.read_csv(RESULTS).filter(stage=stage)
    groups = results.group_by(names, maintain_order=True)
    found = [({name: rows[name][0] for name in names}, rows) for _, rows in groups]
    return [(setting, rows) for setting, rows in found if setting in grid]


def frozen(best: Score) -> dict:
    """The settings of the tables: as they were confirmed, until entropy begins to fall."""
    hold = 2 * best.slowest
    falling = {"entropy_hold": hold, "entropy_steps": hold, "entropy_end": 0.0}
    return FIXED | best.setting | falling


def main() -> None:
    run_stage("screen", SCREEN, settings_grid())
    ranked = [score.setting for score in scores("screen") if score.converged]
    for first in range(0, len(ranked), _CONFIRMED_TOGETHER):
        run_stage("confirm", CONFIRM, ranked[first : first + _CONFIRMED_TOGETHER])
        if scores("confirm")[0].converged:
            break
    best = scores("confirm")[0]
    if not best.converged:
        raise SystemExit("no setting converged in all vanilla runs; widen the grid")
    runs = len(VANILLA) * CONFIRM["runs"]
    lines = [
        "# Written by research/calibration.py, on the vanilla rows alone.",
        f"# All of their {runs} runs converged, a row's "
        f"slowest after {best.steps:,.0f} environment steps (geometric mean).",
    ]
    lines += [f"{k} = {v!r}".replace("'", '"') for k, v in frozen(best).items()]
    write_whole(SETTINGS, lambda file: file.write(("\n".join(lines) + "\n").encode()))


if __name__ == "__main__":
    main()
