"""The folder of a sweep.

points.json         the configurations, with their maps
tasks/*.npz         finished tasks, by their names
search.json         the search, if it is one
search.db           its trials, as Optuna keeps them
lock                held by the process that drives the sweep
results.parquet     `results`; written last
results.csv         the same, without the learning curves
"""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import polars as pl

from habilis.files import write_whole
from habilis.learning.config import Config
from habilis.learning.folder import check_same_table
from habilis.learning.jobs import digest_of_own_tool
from habilis.learning.sources import NamedTable, Source
from habilis.mdp import TabularMDP
from habilis.sweeps.training import (
    COLUMNS,
    CURVE,
    RunMeasure,
    TrainingTask,
    outcomes,
    plain,
    tasks_of,
)
from habilis.tasks.session import Layout
from habilis.tasks.store import DAMAGE, first_line, read
from habilis.tasks.task import Arrays
from habilis.worlds.own_tools import OwnToolError
from habilis.worlds.world import World

LAYOUT = Layout("sweep", mark="points.json")

Point = tuple[Config, Source]
"""One configuration of a sweep, and its world or table."""

TABLES = "tables"
"""The folder of the tables in a sweep's."""


def write_points(points: Sequence[Point], folder: Path) -> None:
    """Writes the points of a sweep, and the tables that no map was made of."""
    for table in {world for _, world in points if isinstance(world, NamedTable)}:
        path = folder / TABLES / f"{table.digest}.npz"
        if not path.exists():
            path.parent.mkdir(exist_ok=True)
            table.mdp.save(path)
    write_json(
        folder / LAYOUT.mark,
        [config.as_dict() | {"map": _map(world)} for config, world in points],
    )


def _map(world: Source) -> dict[str, str]:
    if isinstance(world, NamedTable):
        return {"name": world.name, "digest": world.digest}
    digest, world = digest_of_own_tool(world), world.located()
    noted = {} if digest is None else {"table": digest}
    return {"name": world.name, "tool": world.tool, "text": world.text()} | noted


def read_points(folder: Path) -> list[Point]:
    """The points of a sweep.

    Raises:
        ValueError: the folder holds no sweep, or a damaged one, or a custom tool has changed.
    """
    path = folder / LAYOUT.mark
    points, digests = _points(path)
    for (_, world), digest in zip(points, digests, strict=True):
        check_same_table(world, digest, folder)
    return points


def _points(path: Path) -> tuple[list[Point], list[str | None]]:
    try:
        listed = json.loads(path.read_text())
        maps = [values.pop("map") for values in listed]
        worlds = [_source(m, path.parent) for m in maps]
        points = list(zip(map(Config.from_dict, listed), worlds, strict=True))
        return points, [m.get("table") for m in maps]
    except FileNotFoundError:
        raise ValueError(f"{path}: is missing; name the folder of a sweep") from None
    except OwnToolError as error:
        raise ValueError(f"{path}: {error}") from None
    except (*DAMAGE, AttributeError) as error:
        raise ValueError(
            f"{path}: is damaged ({first_line(error)}); sweep into a new folder"
        ) from None


def _source(named: dict[str, str], folder: Path) -> Source:
    if "digest" not in named:
        return World.parse(named["text"], named["name"])
    table = TabularMDP.load(folder / TABLES / f"{named['digest']}.npz")
    return NamedTable(named["name"], named["digest"], table)


def tasks_of_points(
    points: Sequence[Point], measures: tuple[RunMeasure, ...] = ()
) -> list[TrainingTask]:
    """The tasks of all points, in their order."""
    return [task for config, world in points for task in tasks_of(config, world, measures)]


def results(folder: str | Path, measures: Sequence[RunMeasure] = ()) -> pl.DataFrame:
    """The runs of a sweep that are finished, whether or not the sweep itself is.

    Args:
        folder: of the sweep.
        measures: those with which it was made.

    Returns:
        One row a run of each point, in their order: "point" (from 0), the fields of its
        configuration, and its outcome: "run" (from 0), "converged_at" (episodes to convergence,
        null if it did not converge), "episodes_had" and "steps_had" (episodes and environment
        steps that it took), "best_return" (of a shortest plan in its world), "final_return" (mean
        return of its last 100 episodes, NaN if it had none), "finite" (false if it diverged: its
        loss or parameters became infinite or NaN, which ended it), "seconds" (from its first step
        to its last, while others trained beside it), its measurements (null for a run that
        diverged), and "curve" (mean return over each 100 episodes).

    Raises:
        ValueError: the folder holds no sweep, or a damaged one.
    """
    folder = Path(folder)
    points, every = read_points(folder), tuple(measures)
    found, _ = read(tasks_of_points(points, every), folder / LAYOUT.results)
    return table(points, found, every)


def table(
    points: Sequence[Point], found: Mapping[str, Arrays], measures: tuple[RunMeasure, ...] = ()
) -> pl.DataFrame:
    """`results` from the results of tasks in memory."""
    rows: list[dict[str, Any]] = []
    for number, (config, world) in enumerate(points):
        settings = plain(config)
        if "hidden" in settings:
            settings["hidden"] = ",".join(map(str, settings["hidden"]))
        for task in tasks_of(config, world, measures):
            if task.name in found:
                rows += [{"point": number} | settings | row for row in outcomes(found[task.name])]
    own = dict.fromkeys(name for result in found.values() for name in result)
    own = [*COLUMNS, *(name for name in own if name not in (*COLUMNS, *CURVE)), "curve"]
    names = dict.fromkeys(name for row in rows for name in row if name not in own)
    columns = {name: [row.get(name) for row in rows] for name in (*names, *own)}
    types = {"converged_at": pl.Int64, "curve": pl.List(pl.Float32)}
    return pl.DataFrame(columns, schema_overrides=types, infer_schema_length=None)


def write_results(frame: pl.DataFrame, folder: Path) -> None:
    """Writes the table, for people and for programs."""
    write_whole(folder / "results.csv", frame.drop("curve").write_csv)
    write_whole(folder / "results.parquet", frame.write_parquet)


def remove_results(folder: Path) -> None:
    """Removes the table of earlier points, so that nothing looks finished that is not."""
    for name in ("results.csv", "results.parquet"):
        (folder / name).unlink(missing_ok=True)


def write_json(path: Path, value: Any) -> None:
    write_whole(path, lambda file: file.write((json.dumps(value, indent=1) + "\n").encode()))
