"""Ranks what was calibrated, and freezes the best pairs of a learner and maps.

    python -m research.pace.ranking screen.csv
    python -m research.pace.ranking confirm.csv --freeze pairs.toml

First comes the number of runs that converged in the worst of the three vanilla rows, then how near
the rows come to the published ones,

    sum over rows of (log mean - log published mean)^2 + (log sd - log published sd)^2 / 4,

in which a run that did not converge counts with its budget of episodes, a million: those that it
had are few where each of them was cut off late. A pair is a setting, a
corridor and a yard; the five best have five different settings, so that no learner decides alone.
"""

import argparse
import math
from collections.abc import Iterable
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from habilis.files import write_whole
from habilis.studies.paper.published import EXPERIMENTS
from research.pace.design import settings
from research.pace.runs import SCREEN, Done, Line, read

PAIRS = 5
_LEAST = 1.0  # episodes of deviation, where all runs are alike

PUBLISHED = {
    ("corridor", "picker"): EXPERIMENTS[0].rows[0],
    ("yard", "picker"): EXPERIMENTS[1].rows[0],
    ("yard", "broom"): EXPERIMENTS[1].rows[2],
}


class Ranked(NamedTuple):
    """A setting on two maps.

    Attributes:
        worst: runs that converged in the worst row.
        distance: from the published means and deviations, in the units of the module's formula.
    """

    worst: int
    distance: float
    setting: int
    corridor: str
    yard: str


def ranked(done: Done) -> list[Ranked]:
    """All settings on all pairs of maps of which the three rows were trained, the best first."""
    maps = {
        world: sorted({m for _, m, _ in done if m.startswith(world)})
        for world in ("corridor", "yard")
    }
    found = []
    for number in sorted({n for n, _, _ in done}):
        for corridor, yard in product(*maps.values()):
            where = {"corridor": corridor, "yard": yard}
            rows = {key: done.get((number, where[key[0]], key[1])) for key in PUBLISHED}
            if all(rows.values()):
                there = {key: row for key, row in rows.items() if row is not None}
                worst = min(int(row["converged"]) for row in there.values())
                away = sum(distance(row, *_published(key)) for key, row in there.items())
                found.append(Ranked(worst, away, number, corridor, yard))
    return sorted(found, key=lambda r: (-r.worst, r.distance, r.setting, r.corridor, r.yard))


def best_pairs(order: Iterable[Ranked], count: int = PAIRS) -> list[Ranked]:
    """The best pair of each setting, of the best settings."""
    chosen: dict[int, Ranked] = {}
    for one in order:
        chosen.setdefault(one.setting, one)
    return list(chosen.values())[:count]


def distance(line: Line, mean: float, deviation: float) -> float:
    """The distance of a row's runs from a published mean and deviation."""
    counts = budgeted(line)
    spread = max(float(counts.std(ddof=1)), _LEAST)
    of_means = math.log(counts.mean() / mean)
    return of_means**2 + math.log(spread / deviation) ** 2 / 4


def budgeted(line: Line) -> np.ndarray:
    """Episodes to convergence of each run; of one that did not converge, its budget."""
    counts = line["episodes"].split()
    return np.array([float(SCREEN["episodes"] if at == "-" else at) for at in counts])


def frozen(pairs: list[Ranked]) -> str:
    """The text of `pairs.toml`."""
    every, lines = settings(), ["# Written by research/pace/ranking.py, on vanilla rows alone."]
    for one in pairs:
        learner = {name: _toml(value) for name, value in every[one.setting].items()}
        lines += [
            "",
            "[[pair]]",
            f"# {one.worst} runs of the worst row converged; distance {one.distance:.2f}",
        ]
        lines += [f"setting = {one.setting}"]
        lines += [f'corridor = "{one.corridor}"', f'yard = "{one.yard}"', "[pair.learner]"]
        lines += [f"{name} = {value}" for name, value in learner.items()]
    return "\n".join(lines) + "\n"


def _published(key: tuple[str, str]) -> tuple[float, float]:
    return PUBLISHED[key].mean, PUBLISHED[key].deviation


def _toml(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return str(list(value))
    return f'"{value}"' if isinstance(value, str) else repr(value)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("results", type=Path, nargs="+")
    parser.add_argument("--freeze", type=Path, help="the file of the best pairs to write")
    args = parser.parse_args()
    done: Done = {}
    for path in args.results:
        done |= read(path)
    order = ranked(done)
    for one in order[:40]:
        print(
            f"{one.worst:3} {one.distance:8.2f}  setting {one.setting}, {one.corridor}, {one.yard}"
        )
    if args.freeze is not None:
        text = frozen(best_pairs(order))
        write_whole(args.freeze, lambda file: file.write(text.encode()))


if __name__ == "__main__":
    main()
