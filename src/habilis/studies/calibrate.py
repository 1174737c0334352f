"""Choosing the A2C settings, which the paper does not give, on the vanilla rows alone.

First every setting of the grid trains a few agents without intrinsic reward, on a small budget.
Then, for each experiment, the settings whose counts came closest to the published ones (by the
runs that converged, at least one a row) train as many agents as the paper on a large budget, one
after the other until all runs of all rows converge. That setting, or the one that comes nearest to
it, is written to `data/settings.toml` before any regularised agent is trained with it. The seeds
are not those of the paper's tables.

    python -m habilis.studies.calibrate      # an hour or two; goes on where it was stopped
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from random import Random

import polars as pl

from habilis.learning.config import Config
from habilis.learning.train import train
from habilis.studies.published import EXPERIMENTS, Experiment

DATA = Path(__file__).parent / "data"
RESULTS = DATA / "calibration.csv"
SETTINGS = DATA / "settings.toml"

GRID: dict[str, tuple] = {
    "envs, rollout": ((8, 20), (16, 5)),
    "learning_rate": (1e-3, 2e-3),
    "discount": (0.97, 0.99),
    "optimizer": ("rmsprop",),
    "reward_scale": (1.0,),
    "entropy": (0.02, 0.05),
}
"""What is tried: every combination. The rest of `Config` stays as it is there.

Adam with a tenth of the reward was tried first, in nine settings that are in the results too: it
converged in far fewer episodes than published (entropy 0.02) or not at all (0.05), and was left
out before the rest of the grid was run."""

SCREEN = {"runs": 5, "seed": 1001, "episodes": 120_000, "steps": 10_000_000}
"""First, every setting, with few runs and steps."""
CONFIRM = {"runs": 10, "seed": 2001, "episodes": 160_000, "steps": 40_000_000}
"""Then the settings that came closest, with as many runs as the paper."""
CONFIRMED = 2  # settings an experiment, at most


def settings_grid() -> list[dict]:
    """All combinations of the grid, in a fixed shuffled order."""
    settings = []
    for values in product(*GRID.values()):
        setting = {}
        for names, value in zip(GRID, values, strict=True):
            parts = value if isinstance(value, tuple) else (value,)
            setting |= dict(zip(names.split(", "), parts, strict=True))
        settings.append(setting)
    Random(0).shuffle(settings)
    return settings


def vanilla_configs(experiment: Experiment, setting: dict, stage: dict) -> list[Config]:
    """One configuration for each vanilla row of an experiment."""
    return [
        replace(Config(world=experiment.world, tool=row.tool), **setting, **stage)
        for row in experiment.rows
        if row.vanilla
    ]


def distance(counts: Iterable[float], published: Iterable[float]) -> float:
    """Mean over the rows of |log(ours / published)|."""
    ratios = [abs(math.log(a / b)) for a, b in zip(counts, published, strict=True)]
    return sum(ratios) / len(ratios)


def _key(stage: str, experiment: str, setting: dict) -> tuple:
    return (stage, experiment, *(str(value) for value in setting.values()))


def run_stage(stage: str, budget: dict, todo: list[tuple[Experiment, dict]]) -> None:
    """Trains what is not yet in the results, and adds it there row by row."""
    done = set()
    if RESULTS.exists():
        for row in pl.read_csv(RESULTS).iter_rows(named=True):
            setting = {name: row[name] for name in settings_grid()[0]}
            done.add(_key(row["stage"], row["experiment"], setting))
    todo = [(e, s) for e, s in todo if _key(stage, e.name, s) not in done]
    for first in range(0, len(todo), 4):
        some = todo[first : first + 4]
        configs = [vanilla_configs(e, s, budget) for e, s in some]
        runs = iter(train([c for group in configs for c in group]))
        rows = []
        for (experiment, setting), group in zip(some, configs, strict=True):
            for config in group:
                at = next(runs).converged_at
                finished = [n for n in at if n is not None]
                rows.append(
                    {"stage": stage, "experiment": experiment.name, "tool": config.tool}
                    | setting
                    | {
                        "runs": len(at),
                        "converged": len(finished),
                        "mean": sum(finished) / len(finished) if finished else None,
                        "counts": " ".join("-" if n is None else str(n) for n in at),
                    }
                )
        table = pl.DataFrame(rows)
        if RESULTS.exists():
            earlier = pl.read_csv(RESULTS)
            table = pl.concat([earlier, table.select(earlier.columns)], how="vertical_relaxed")
        table.write_csv(RESULTS)
        for row in rows:
            print(*row.values(), flush=True)


@dataclass(frozen=True)
class Score:
    """How a setting did in one stage of one experiment.

    Attributes:
        setting: the fields of `Config`.
        converged: the least share of converged runs in a row.
        distance: of the converged runs' means to the published ones.
    """

    setting: dict
    converged: float
    distance: float


def scores(stage: str, experiment: Experiment) -> list[Score]:
    """The settings in which each row has a converged run, closest to the published first."""
    results = pl.read_csv(RESULTS).filter(stage=stage, experiment=experiment.name)
    names = list(settings_grid()[0])
    vanilla = [row for row in experiment.rows if row.vanilla]
    found = []
    for _, rows in results.group_by(names, maintain_order=True):
        setting = {name: rows[name][0] for name in names}
        counts = dict(zip(rows["tool"], rows["mean"], strict=True))
        share = min(c / n for c, n in zip(rows["converged"], rows["runs"], strict=True))
        if share > 0 and setting in settings_grid():
            off = distance([counts[row.tool] for row in vanilla], [row.mean for row in vanilla])
            found.append(Score(setting, share, off))
    return sorted(found, key=lambda score: score.distance)


def main() -> None:
    grid = settings_grid()
    run_stage("screen", SCREEN, [(e, s) for s in grid for e in EXPERIMENTS])
    closest = {e.name: scores("screen", e)[:CONFIRMED] for e in EXPERIMENTS}
    for place in range(CONFIRMED):
        unsettled = [
            e for e in EXPERIMENTS if not any(s.converged == 1 for s in scores("confirm", e))
        ]
        run_stage("confirm", CONFIRM, [(e, closest[e.name][place].setting) for e in unsettled])
    lines = ["# Written by habilis.studies.calibrate, on the vanilla rows alone."]
    for experiment in EXPERIMENTS:
        best = max(scores("confirm", experiment), key=lambda s: (s.converged, -s.distance))
        lines += [
            "",
            f"# All rows: at least {best.converged:.0%} of the runs converged; mean |log ratio| to "
            f"the published counts {best.distance:.3f}.",
            f"[{experiment.name}]",
        ]
        lines += [f"{k} = {v!r}".replace("'", '"') for k, v in best.setting.items()]
    SETTINGS.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
