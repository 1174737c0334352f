"""A sweep's folder: what is finished stays finished.

points.json         the configurations, with their maps
tasks/*.npz         finished tasks, by their names
search.json         what is searched, if it is a search
search.db           its trials, as Optuna keeps them
lock                held by the process that drives the sweep
results.parquet     `results`; written last
results.csv         the same, without the learning curves
"""

import json
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from habilis.files import write_whole
from habilis.learning.config import Config
from habilis.learning.folder import check_same_table
from habilis.learning.jobs import digest_of_own_tool
from habilis.sweeps.tasks import Outcome, Outcomes, Task, plain, tasks_of
from habilis.worlds.own_tools import OwnToolError
from habilis.worlds.world import World

POINTS, TASKS = "points.json", "tasks"

Point = tuple[Config, World]
"""One configuration of a sweep, and its world."""

_DAMAGE = (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile)


def is_sweep(folder: Path) -> bool:
    """Whether a sweep was begun in a folder."""
    return (folder / POINTS).is_file()


def write_points(points: Sequence[Point], folder: Path) -> None:
    """Writes what the sweep is made of."""
    (folder / TASKS).mkdir(exist_ok=True)
    write_json(
        folder / POINTS,
        [config.as_dict() | {"map": _map(world)} for config, world in points],
    )


def _map(world: World) -> dict[str, str]:
    digest, world = digest_of_own_tool(world), world.located()
    noted = {} if digest is None else {"table": digest}
    return {"name": world.name, "tool": world.tool, "text": world.text()} | noted


def read_points(folder: Path) -> list[Point]:
    """Reads it back.

    Raises:
        ValueError: the folder holds no sweep, or a damaged one, or a tool of one's own is not what
            it was.
    """
    path = folder / POINTS
    points, digests = _points(path)
    for (_, world), digest in zip(points, digests, strict=True):
        check_same_table(world, digest, folder)
    return points


def _points(path: Path) -> tuple[list[Point], list[str | None]]:
    try:
        listed = json.loads(path.read_text())
        maps = [values.pop("map") for values in listed]
        worlds = [World.read_back(m["text"], m["name"], m["tool"]) for m in maps]
        points = list(zip(map(Config.from_dict, listed), worlds, strict=True))
        return points, [m.get("table") for m in maps]
    except FileNotFoundError:
        raise ValueError(f"{path}: is missing; name the folder of a sweep") from None
    except OwnToolError as error:
        raise ValueError(f"{path}: {error}") from None
    except (*_DAMAGE, AttributeError) as error:
        raise ValueError(
            f"{path}: is damaged ({_reason(error)}); sweep into a new folder"
        ) from None


def write(task: Task, outcomes: Outcomes, folder: Path) -> None:
    """Keeps what a task came to."""
    columns = {name: [getattr(o, name) for o in outcomes] for name in _COLUMNS}
    columns["converged_at"] = [-1 if at is None else at for at in columns["converged_at"]]
    arrays = {name: np.array(columns[name], kind) for name, kind in _COLUMNS.items()}
    arrays["curve"] = np.concatenate([o.curve for o in outcomes])
    arrays["curve_lengths"] = np.array([len(o.curve) for o in outcomes])
    path = folder / TASKS / f"{task.name}.npz"
    write_whole(path, lambda file: np.savez(file, allow_pickle=False, **arrays))


def read(tasks: Sequence[Task], folder: Path) -> tuple[dict[str, Outcomes], list[str]]:
    """Those of some tasks that are finished.

    Returns:
        What they came to, by their names; and a line for each file that is damaged.
    """
    found: dict[str, Outcomes] = {}
    told: list[str] = []
    for task in tasks:
        path = folder / TASKS / f"{task.name}.npz"
        try:
            found[task.name] = _outcomes(path, task)
        except FileNotFoundError:
            continue
        except _DAMAGE as error:
            told.append(f"{path}: is damaged ({_reason(error)}); its runs are trained again")
    return found, told


def results(folder: str | Path) -> pl.DataFrame:
    """What the tasks of a sweep that are finished came to, be the sweep itself or not.

    Args:
        folder: of the sweep.

    Returns:
        One row a run of each point, in their order: "point" (from 0), the fields of its
        configuration, and those of its `Outcome`.

    Raises:
        ValueError: the folder holds no sweep, or a damaged one.
    """
    folder = Path(folder)
    points = read_points(folder)
    tasks = [task for config, world in points for task in tasks_of(config, world)]
    return table(points, read(tasks, folder)[0])


def table(points: Sequence[Point], outcomes: Mapping[str, Outcomes]) -> pl.DataFrame:
    """`results` of outcomes in memory."""
    rows: list[dict[str, Any]] = []
    for number, (config, world) in enumerate(points):
        settings = plain(config)
        if "hidden" in settings:
            settings["hidden"] = ",".join(map(str, settings["hidden"]))
        for task in tasks_of(config, world):
            for outcome in outcomes.get(task.name, ()):
                came_to = {name: getattr(outcome, name) for name in (*_COLUMNS, "curve")}
                rows.append({"point": number} | settings | came_to)
    own = [*_COLUMNS, "curve"]
    settings = dict.fromkeys(name for row in rows for name in row if name not in own)
    columns = {name: [row.get(name) for row in rows] for name in (*settings, *own)}
    return pl.DataFrame(columns, schema_overrides=_TYPES, infer_schema_length=None)


def write_results(frame: pl.DataFrame, folder: Path) -> None:
    """Writes the table, for people and for programs."""
    write_whole(folder / "results.csv", frame.drop("curve").write_csv)
    write_whole(folder / "results.parquet", frame.write_parquet)


def remove_results(folder: Path) -> None:
    """Of earlier points, so that nothing looks finished that is not."""
    for name in ("results.csv", "results.parquet"):
        (folder / name).unlink(missing_ok=True)


def write_json(path: Path, value: Any) -> None:
    write_whole(path, lambda file: file.write((json.dumps(value, indent=1) + "\n").encode()))


_COLUMNS: dict[str, type] = {
    "run": np.int64,
    "converged_at": np.int64,  # -1 in a file: it did not
    "episodes_had": np.int64,
    "steps_had": np.int64,
    "best_return": np.float64,
    "final_return": np.float64,
    "finite": np.bool_,
    "seconds": np.float64,
}

_TYPES = {"converged_at": pl.Int64, "curve": pl.List(pl.Float32)}


def _outcomes(path: Path, task: Task) -> Outcomes:
    with path.open("rb") as file, np.load(file) as saved:
        columns = {name: saved[name].tolist() for name in _COLUMNS}
        curves = np.split(saved["curve"], np.cumsum(saved["curve_lengths"])[:-1])
    if tuple(columns["run"]) != task.runs:
        raise ValueError(f"holds runs {columns['run']}")
    columns["converged_at"] = [None if at < 0 else at for at in columns["converged_at"]]
    each = zip(*columns.values(), curves, strict=True)
    return tuple(Outcome(**dict(zip((*columns, "curve"), values, strict=True))) for values in each)


def _reason(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]
