"""Which reading of the rules meets most of what the paper states: a search under each, alike long.

A reading is what rules 3 to 5 mean (`Reading`) and the states over which averages go (`OVER`).
Under each of them one attempt is made at a map of either experiment, from random walls and from the
built-in map that meets most under our own reading, all of the same number of changes. What is
searched for is all that the paper states of a map (`corridor-all.toml`, `yard-all.toml`); then the
map that came closest is held against the paper's statements in words.

    python -m research.readings      # goes on where it was stopped; see --help
"""

import argparse
from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path
from random import Random
from typing import Any

import polars as pl

from habilis.files import write_whole
from habilis.studies.paper import corridor_statements, yard_statements
from habilis.studies.paper.published import EXPERIMENTS, Experiment
from habilis.studies.paper.targets import TargetMap, load_targets
from habilis.studies.paper.worlds import OVER, CachedWorld, PaperWorlds
from habilis.studies.reconstruction.annealing import Schedule, anneal
from habilis.worlds.tools import Reading
from habilis.worlds.world import World, load_world

RESULTS = Path(__file__).parent / "results" / "readings.csv"
KEYS = ("over", "reading", "experiment", "start", "seed")
RANDOM = "random walls"
CHANGES, SEED = 500, 0
_HOT = {RANDOM: 1.0}  # temperatures at the beginning
_WARM = 0.3  # from a map that is known

READINGS = tuple(
    Reading(pushes, shoves, sweeps, sticky)
    for sticky, sweeps, shoves, pushes in product((False, True), repeat=4)
    if not (sticky and pushes)
)
"""A sticky picker holds whatever it could be carried into, so that it never pushes."""


def tasks() -> Iterator[dict[str, Any]]:
    """All attempts, those with averages over equipped placements first."""
    for over, reading, experiment in product(OVER, READINGS, EXPERIMENTS):
        for start in (RANDOM, experiment.world):
            words = reading.words or "ours"
            yield dict(zip(KEYS, (over, words, experiment.targets, start, SEED), strict=True))


def attempt(task: dict[str, Any], changes: int) -> dict[str, Any]:
    """One attempt, and the targets that its best map meets."""
    experiment = next(e for e in EXPERIMENTS if e.targets == task["experiment"])
    reading = Reading.of(f" {task['reading']}")[1]
    stated = replace(load_targets(f"{experiment.targets}-all"), reading=reading, over=task["over"])
    begin = None if task["start"] == RANDOM else load_world(task["start"])
    schedule = Schedule(changes, _HOT.get(task["start"], _WARM))
    random = Random("-".join(map(str, task.values())))
    best, found = anneal(stated, random, schedule, lambda change, energy: None, begin)
    missed = [s.text for s, part in zip(stated.numbers, best.parts, strict=True) if part]
    holding, lost = held(best.world, experiment, stated)
    return task | {
        "changes": changes,
        "found": found,
        "energy": round(best.energy, 4),
        "numbers_met": len(stated.numbers) - len(missed),
        "numbers": len(stated.numbers),
        "statements_hold": holding,
        "statements": holding + len(lost),
        "numbers_missed": "; ".join(missed),
        "statements_missed": "; ".join(lost),
        "map": "/".join(best.world.rows),
    }


def held(world: World, experiment: Experiment, stated: TargetMap) -> tuple[int, list[str]]:
    """The number of the paper's statements that hold in a map, and the names of the others."""
    worlds = {
        e.targets: CachedWorld(load_world(e.world).with_reading(stated.reading), stated.over)
        for e in EXPERIMENTS
    }
    worlds[experiment.targets] = CachedWorld(world, stated.over)
    module = {"corridor": corridor_statements, "yard": yard_statements}[experiment.targets]
    lost = [check.__name__ for check in module.CHECKS if not check(PaperWorlds(**worlds)).holds]
    return len(module.CHECKS) - len(lost), lost


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--changes", type=int, default=CHANGES, help="of each attempt")
    parser.add_argument("--out", type=Path, default=RESULTS, help="the file to go on with")
    args = parser.parse_args()
    rows = pl.read_csv(args.out).to_dicts() if args.out.exists() else []
    done = {tuple(row[key] for key in KEYS) for row in rows}
    for task in tasks():
        if tuple(task.values()) in done:
            continue
        row = attempt(task, args.changes)
        rows.append({name: value if value != "" else None for name, value in row.items()})
        args.out.parent.mkdir(parents=True, exist_ok=True)
        write_whole(args.out, pl.DataFrame(rows, infer_schema_length=None).write_csv)
        print(*[row[key] for key in KEYS], row["energy"], row["numbers_met"], flush=True)


if __name__ == "__main__":
    main()
