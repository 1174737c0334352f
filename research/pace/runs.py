"""Trains the agents of the calibration; what they did goes into a file of comma-separated values.

    python -m research.pace.runs screen --out screen.csv                 # everything: many hours
    python -m research.pace.runs screen --parts 0 --out screen-0.csv     # one structure
    python -m research.pace.runs confirm --settings 3,14 --out confirm.csv
    python -m research.pace.runs ensemble --out ensemble.csv
    python -m research.pace.runs thirty --out thirty.csv

The first two train vanilla agents alone; the others need the frozen pairs of `ranking.py`, whose
agents they train, those with a bonus too. Results are added to the file, and those in it are not
trained again; work that does not fit into `--seconds` is left for another call.
"""

import argparse
import csv
import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import jax
import numpy as np

from habilis.files import write_whole
from habilis.learning.config import Config
from habilis.learning.runs import Run
from habilis.studies.maps import MAPS, world_source
from habilis.studies.pace.data import BLOCK, Pair, first_success, load_pace
from habilis.studies.paper.published import EXPERIMENTS, FIRST_WORLD, REWARDS
from habilis.studies.paper.settings import FAST_MAPS, row_config
from habilis.sweeps.training import outcomes, tasks_of, train_tasks
from habilis.tasks.task import Arrays
from research.pace.design import Setting, parts, settings

SCREEN: Setting = {"runs": 5, "seed": 31_001, "episodes": 1_000_000, "steps": 15_000_000}
CONFIRM: Setting = {"runs": 10, "seed": 32_001, "episodes": 1_000_000, "steps": 15_000_000}
ELSEWHERE: Setting = CONFIRM | {"steps": 8_000_000}
"""On the other maps. Of 283 converged runs of the screen, two took more than 6 M steps."""
ENSEMBLE: Setting = {"runs": 10, "seed": 33_001, "episodes": 1_000_000, "steps": 15_000_000}
THIRTY: Setting = {"runs": 30, "seed": 34_001, "episodes": 1_000_000, "steps": 15_000_000}
GOES_ON = 0.5
"""The share of runs that must converge in a row before the setting's next row is trained."""

CORRIDOR, YARD = FIRST_WORLD, FAST_MAPS["table2"]
"""Not the second world of the statements, in which no agent learns: `research/README.md`."""

ROWS = ((CORRIDOR, "picker"), (YARD, "broom"), (YARD, "picker"))
"""World and tool of the vanilla rows, those in which agents most often fail first."""

Line = dict[str, Any]
Where = tuple[str, str]  # a world and a tool
Done = dict[tuple[int, str, str], Line]


def main() -> None:
    args = _arguments()
    args.out.parent.mkdir(parents=True, exist_ok=True)
    began = time.perf_counter()

    def stopped() -> bool:
        return time.perf_counter() - began > args.seconds

    chosen = [n for part in args.parts for n in parts()[part]] if args.parts else args.settings
    groups = [chosen[i : i + args.together] for i in range(0, len(chosen), args.together)]
    if args.stage == "screen":
        for group in groups:
            in_turn(group, ROWS, SCREEN, args.out, stopped, args.lanes)
    elif args.stage in ("ensemble", "thirty"):
        pairs = load_pace().pairs
        if not pairs:
            raise SystemExit("no pairs are frozen; write data/pace/pairs.toml with ranking.py")
        if args.stage == "ensemble":
            for number, pair in enumerate(pairs, 1):
                if args.pairs and number not in args.pairs:
                    continue
                ensemble(number, pair, ENSEMBLE, args.out, stopped, args.lanes)
        else:
            ensemble(1, pairs[0], THIRTY, args.out, stopped, args.lanes)
    else:
        for rows in [*((row,) for row in ROWS), *other_maps()]:
            if args.maps is None or rows[0][0] in args.maps:
                budget = CONFIRM if rows[0] in ROWS else ELSEWHERE
                for group in groups:
                    in_turn(group, rows, budget, args.out, stopped, args.lanes)


def in_turn(
    numbers: Sequence[int],
    rows: Sequence[Where],
    budget: Setting,
    out: Path,
    stopped: Any,
    lanes: int | None = None,
) -> None:
    """Trains vanilla rows one after the other, each for the settings that did not fail before.

    The rank is that of the worst row, so a setting goes on where enough of its runs converged.
    """
    left = list(numbers)
    for world, tool in rows:
        done = trained(left, world, tool, budget, out, stopped, lanes)
        enough = GOES_ON * budget["runs"]
        left = [n for n in left if _converged(done.get((n, world, tool))) >= enough]


def trained(
    numbers: Iterable[int],
    world: str,
    tool: str,
    budget: Setting,
    out: Path,
    stopped: Any,
    lanes: int | None = None,
) -> Done:
    """The lines of a file after what is missing in it was trained, as far as time allows."""
    done = read(out)
    todo = [n for n in numbers if (n, world, tool) not in done]
    if not todo or stopped():
        return done
    place = world_source(world)
    every = settings()
    began, steps = time.perf_counter(), 0
    configs = [Config.from_dict(every[n] | budget | {"world": place, "tool": tool}) for n in todo]
    for number, runs in zip(todo, _runs(configs, stopped, lanes), strict=True):
        if runs is not None:
            done[number, world, tool] = _line(number, world, tool, every[number], runs)
            steps += sum(run["steps_had"] for run in runs)
    _write(out, done)
    seconds = time.perf_counter() - began
    print(f"{world} {tool} {todo}: {steps / 1e6:.0f} M steps, {seconds:.0f} s", flush=True)
    return done


def _runs(configs: Sequence[Config], stopped: Any, lanes: int | None) -> list[list[Line] | None]:
    """The outcomes of the runs of each configuration; `None` where time did not suffice.

    A run that diverges is one that has not converged; it does not stop the others.
    """
    tasks = [tasks_of(config, measures=(first_success_of,)) for config in configs]
    found: dict[str, Arrays] = {}
    every = [task for some in tasks for task in some]
    train_tasks(every, found.__setitem__, stopped, lanes=lanes)
    return [
        [run for task in some for run in outcomes(found[task.name])]
        if all(task.name in found for task in some)
        else None
        for some in tasks
    ]


def ensemble(
    number: int, pair: Pair, budget: Setting, out: Path, stopped: Any, lanes: int | None = None
) -> None:
    """Adds what a frozen pair's agents do in the rows of both tables to a file."""
    done = read(out, ("pair", "map", "tool", "reward"))
    for experiment in EXPERIMENTS:
        world = pair.maps[experiment.name]
        todo = [
            row
            for row in experiment.rows
            if (number, world, row.tool, REWARDS[row.intrinsic]) not in done
        ]
        if not todo or stopped():
            continue
        configs = [row_config(experiment, row, budget, pair) for row in todo]
        for row, runs in zip(todo, _runs(configs, stopped, lanes), strict=True):
            if runs is None:
                continue
            key = number, world, row.tool, REWARDS[row.intrinsic]
            names = ("pair", "map", "tool", "reward")
            maps = {"corridor": pair.maps["table1"], "yard": pair.maps["table2"]}
            done[key] = (
                dict(zip(names, key, strict=True))
                | {"setting": pair.setting, "horizon": row.horizon, "beta": row.beta}
                | maps
                | outcome(runs)
            )
        _write(out, done)


def other_maps() -> list[list[Where]]:
    """The vanilla rows of every other map, in the order of `ROWS`."""
    kinds: dict[str, list[str]] = {}
    for world, tool in ROWS:
        kinds.setdefault(world.partition("-")[0], []).append(tool)
    names = sorted(path.stem for path in MAPS.glob("*.txt"))
    return [[(name, tool) for tool in kinds[name.partition("-")[0]]] for name in names]


def read(path: Path, by: Sequence[str] = ("setting", "map", "tool")) -> dict[Any, Line]:
    """The lines of a file by some of its columns, the first a number; none without a file."""
    if not path.exists():
        return {}
    with path.open(newline="") as file:
        return {(int(r[by[0]]), *(r[name] for name in by[1:])): r for r in csv.DictReader(file)}


def _write(path: Path, done: dict[Any, Line]) -> None:
    lines = [done[key] for key in sorted(done)]
    if not lines:
        return
    names = list(dict.fromkeys(name for line in lines for name in line))
    text = [names] + [[str(line.get(name, "")) for name in names] for line in lines]
    rows = "".join(",".join(row) + "\n" for row in text)
    write_whole(path, lambda file: file.write(rows.encode()))


def _line(number: int, world: str, tool: str, setting: Setting, runs: list[Line]) -> Line:
    fields = Config.from_dict(setting).as_dict()
    names = sorted(name for name in fields if name in setting)
    shown = {n: "-".join(map(str, v)) if isinstance(v := fields[n], tuple) else v for n in names}
    return {"setting": number, **shown, "map": world, "tool": tool, **outcome(runs)}


def outcome(runs: list[Line]) -> Line:
    """The results of an agent's runs."""
    return {
        "runs": len(runs),
        "converged": sum(run["converged_at"] is not None for run in runs),
        "episodes": _words(run["converged_at"] for run in runs),
        "first_success": _words(run.get("first_success") for run in runs),
        "had": _words(run["episodes_had"] for run in runs),
        "steps": _words(run["steps_had"] for run in runs),
        "device": jax.devices()[0].device_kind,
    }


def first_success_of(run: Run, index: int) -> dict[str, float | None]:
    """`first_success` of a run."""
    curve = learning_curve(run.episodes.filter(run=index)["return"].to_numpy())
    first = first_success(curve, run.best_return)
    return {"first_success": None if np.isinf(first) else float(first)}


def learning_curve(returns: np.ndarray) -> np.ndarray:
    """The mean return over each `BLOCK` episodes."""
    return returns[: len(returns) // BLOCK * BLOCK].reshape(-1, BLOCK).mean(axis=1)


def _converged(line: Line | None) -> int:
    return 0 if line is None else int(line["converged"])


def _words(numbers: Iterable[float | None]) -> str:
    return " ".join("-" if n is None else f"{n:.0f}" for n in numbers)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("stage", choices=("screen", "confirm", "ensemble", "thirty"))
    parser.add_argument("--parts", type=_numbers, default=[], help="structures, by number")
    parser.add_argument("--settings", type=_numbers, default=list(range(len(settings()))))
    parser.add_argument("--maps", type=lambda text: text.split(","), help="of confirm, by name")
    parser.add_argument("--pairs", type=_numbers, help="of the ensemble, by number, from 1")
    parser.add_argument("--together", type=int, default=6, help="settings trained side by side")
    parser.add_argument("--lanes", type=int, help="runs side by side in a batch")
    parser.add_argument("--seconds", type=float, default=float("inf"))
    parser.add_argument("--out", type=Path, required=True)
    return parser.parse_args()


def _numbers(text: str) -> list[int]:
    return [int(part) for part in text.split(",")]


if __name__ == "__main__":
    main()
