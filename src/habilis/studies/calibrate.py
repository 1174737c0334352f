"""Choosing the A2C settings, which the paper does not give, on the vanilla rows alone.

First every setting of the grid trains a few agents without intrinsic reward, on a small budget.
Then, for each experiment, the setting whose counts came closest to the published ones trains as
many agents as the paper on a large budget. If some of these do not converge, the settings that
converged in all runs of the first stage are tried so, the closest first, until one converges in
all runs of all rows. It is written to `data/settings.toml` before any regularised agent is trained
with it. The seeds are not those of the paper's tables.

    python -m habilis.studies.calibrate      # an hour or two; goes on where it was stopped
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
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
    "optimizer, reward_scale, entropy": (
        ("rmsprop", 1.0, 0.02),
        ("rmsprop", 1.0, 0.05),
        ("adam", 0.1, 0.02),  # a tenth of the reward: entropy weighs ten times as much
    ),
}
"""What is tried: every combination. The rest of `Config` stays as it is there.

Adam with entropy 0.05 was tried too, in three settings: nothing converged, and it was left out."""

SCREEN = {"runs": 5, "seed": 1001, "episodes": 120_000, "steps": 10_000_000}
"""First, every setting, with few runs and steps."""
CONFIRM = {"runs": 10, "seed": 2001, "episodes": 160_000, "steps": 40_000_000}
"""Then the settings that came closest, with as many runs as the paper."""
CONFIRMED = 4  # settings an experiment, at most


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
        Config(world=experiment.world, tool=row.tool).changed(**setting, **stage)
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


def candidates(experiment: Experiment) -> list[dict]:
    """The settings to confirm, in order: the closest, then the closest of the dependable."""
    screened = scores("screen", experiment)
    dependable = [score for score in screened if score.converged == 1]
    settings = [score.setting for score in [screened[0], *dependable]]
    return [s for i, s in enumerate(settings) if s not in settings[:i]][:CONFIRMED]


def settled(experiment: Experiment) -> bool:
    return any(score.converged == 1 for score in scores("confirm", experiment))


def main() -> None:
    run_stage("screen", SCREEN, [(e, s) for s in settings_grid() for e in EXPERIMENTS])
    tried = {experiment.name: candidates(experiment) for experiment in EXPERIMENTS}
    for place in range(CONFIRMED):
        todo = [e for e in EXPERIMENTS if not settled(e) and place < len(tried[e.name])]
        run_stage("confirm", CONFIRM, [(e, tried[e.name][place]) for e in todo])
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
