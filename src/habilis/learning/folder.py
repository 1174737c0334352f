"""A run's folder: what training leaves on disk.

config.json         the configuration
world.txt           the map, with the tool that was used (of one's own: where its file is)
table.npz           or the table, of a run that was trained on one
checkpoint-*.npz    what to go on from, while it trains
lock                held by the process that trains
tensorboard/run-K   event files of run K
episodes.parquet    `Run.episodes`
parameters.npz      what was learned, runs along the first axis
summary.json        best return, and each run's episodes to convergence; written last
"""

import json
import shutil
import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import jax
import numpy as np
import polars as pl

from habilis.files import check_path, check_unused, write_whole, writing
from habilis.learning import checkpoints
from habilis.learning.config import NO_INTRINSIC, Config, without_ignored
from habilis.learning.jobs import Job, digest_of_own_tool
from habilis.learning.runs import Run
from habilis.learning.sources import NamedTable, Source
from habilis.mdp import TabularMDP
from habilis.worlds.own_tools import OwnToolError
from habilis.worlds.world import World

TABLE = "table.npz"


def save_run(run: Run, folder: str | Path) -> None:
    """Writes a run into a new folder, all of it or nothing.

    Raises:
        ValueError: the folder exists and is not empty, or cannot be written.
    """
    folder = Path(folder).absolute()
    check_unused(folder)
    with writing(folder):
        folder.parent.mkdir(parents=True, exist_ok=True)
        temporary = Path(tempfile.mkdtemp(dir=folder.parent, prefix=f".{folder.name}-"))
        try:
            _write_inputs(run.config, run.world, temporary)
            finish(run, temporary)
            temporary.chmod(0o755)
            temporary.rename(folder)
        finally:
            shutil.rmtree(temporary, ignore_errors=True)


def begin(job: Job, folder: Path) -> None:
    """Writes what a run starts from."""
    if not has_begun(folder):
        _write_inputs(job.config, job.world, folder)


def has_begun(folder: Path) -> bool:
    """Whether what a run starts from is in a folder."""
    return (folder / "world.txt").exists() or (folder / TABLE).exists()


def finish(run: Run, folder: Path) -> None:
    """Writes what came of a run, and removes what it was to go on from."""
    summary = {
        "best_return": run.best_return,
        "converged_at": list(run.converged_at),
    }
    leaves = jax.tree_util.tree_leaves_with_path(run.parameters)
    parameters = {f"parameters{jax.tree_util.keystr(p)}": np.asarray(leaf) for p, leaf in leaves}
    write_whole(folder / "episodes.parquet", run.episodes.write_parquet)
    write_whole(
        folder / "parameters.npz", lambda file: np.savez(file, allow_pickle=False, **parameters)
    )
    _write_json(folder / "summary.json", summary)
    tidy(folder)


def tidy(folder: Path) -> None:
    """Removes what a finished run needs no more."""
    checkpoints.remove_all(folder)
    (folder / "lock").unlink(missing_ok=True)


def is_finished(folder: Path) -> bool:
    """Whether a run in a folder has come to its end."""
    return (folder / "summary.json").exists()


def _write_inputs(config: Config, world: Source, folder: Path) -> None:
    if isinstance(world, NamedTable):
        named = {"name": world.name, "tool": "none", "digest": world.digest}
        _write_json(folder / "config.json", config.as_dict() | {"map": named})
        return world.mdp.save(folder / TABLE)
    digest = digest_of_own_tool(world)
    world = world.located()
    named = {"name": world.name, "tool": world.tool}
    if digest is not None:
        named["table"] = digest
    _write_json(folder / "config.json", config.as_dict() | {"map": named})
    write_whole(folder / "world.txt", lambda file: file.write(world.text().encode()))


def _write_json(path: Path, value: Any) -> None:
    write_whole(path, lambda file: file.write((json.dumps(value, indent=2) + "\n").encode()))


def read_config(folder: Path) -> Config:
    """The configuration of a run.

    Raises:
        ValueError: it is missing or damaged.
    """
    return _read(folder / "config.json", lambda path: _config(path)[0])


def read_world(folder: Path) -> Source:
    """The world of a run, with the tool that was used; or its table.

    Raises:
        ValueError: it is missing or damaged, or a tool of one's own is not what it was.
    """
    named = _read(folder / "config.json", lambda path: _config(path)[1])
    if "digest" in named:
        table = _read(folder / TABLE, lambda path: TabularMDP.load(path))
        return NamedTable(named["name"], named["digest"], table)
    world = _read(
        folder / "world.txt",
        lambda path: World.parse(path.read_text(), named["name"]),
    )
    check_same_table(world, named.get("table"), folder)
    return world


def read_summary(folder: Path, config: Config) -> dict[str, Any]:
    """The outcome of a run: `best_return` and `converged_at`.

    Raises:
        ValueError: it is missing or damaged.
    """
    return _read(folder / "summary.json", lambda path: _summary(path, config))


def check_same_table(world: Source, digest: str | None, folder: Path) -> None:
    """Refuses tools of one's own that have changed.

    Args:
        world: with the tools as they are now.
        digest: of its table as it was; `None` if it was not noted.
        folder: what was trained with it.

    Raises:
        ValueError: it does something else by now.
    """
    if isinstance(world, World) and digest is not None and digest_of_own_tool(world) != digest:
        raise ValueError(
            f"{folder}: was started with another rule of the tool "
            f"{' or '.join(map(repr, world.own_tools))}; restore the tool's file, or train into a "
            "new folder"
        )


def load_run(folder: str | Path) -> Run:
    """Reads a run back; see `load_latest` for runs that have not ended.

    Args:
        folder: where `train` or `habilis train` kept it.

    Returns:
        The run as `train` returned it.

    Raises:
        ValueError: the folder holds no run, one that has not ended, or a damaged one; the message
            names the file.
    """
    folder = Path(folder)
    check_path(folder)
    config, world = read_config(folder), read_world(folder)
    if checkpoints.checkpoints(folder) and not is_finished(folder):
        raise ValueError(f"{folder}: the run has not ended; continue it with train --resume")
    summary = read_summary(folder, config)
    return Run(
        config=config,
        world=world,
        best_return=summary["best_return"],
        episodes=_read(folder / "episodes.parquet", _episodes),
        converged_at=tuple(summary["converged_at"]),
        parameters=_read(folder / "parameters.npz", lambda path: _parameters(path, config, world)),
    )


def load_latest(folder: str | Path) -> Run:
    """Reads a run back that may not have ended: as its last checkpoint has it.

    Raises:
        ValueError: the folder holds no run, one without a checkpoint, or a damaged one.
    """
    folder = Path(folder)
    check_path(folder)
    if folder.is_file():
        raise ValueError(f"{folder}: is a file; name the folder of a run")
    config, world = read_config(folder), read_world(folder)
    if not is_finished(folder):
        job = Job.of(0, config, world)
        if checkpoints.restore(job, folder)[0] is not None:
            return job.result()
        if not is_finished(folder):  # it may have come to its end in the meantime
            raise ValueError(f"{folder}: has no checkpoint yet; train on, or wait for one")
    return load_run(folder)


def _config(path: Path) -> tuple[Config, dict[str, str]]:
    values = json.loads(path.read_text())
    named = values.pop("map", {})
    config = Config.from_dict(without_ignored(values))
    if not all(isinstance(named.get(key), str) for key in ("name", "tool")):
        raise ValueError("map has no name or tool")
    return config, named


Value = TypeVar("Value")


def _read(path: Path, read: Callable[[Path], Value]) -> Value:
    """Reads one file of a run.

    Raises:
        ValueError: it is missing or damaged.
    """
    try:
        return read(path)
    except FileNotFoundError as error:
        raise ValueError(f"{path}: is missing; name the folder of a run") from error
    except OwnToolError as error:
        raise ValueError(f"{path}: {error}") from None
    except (*_DAMAGE, pl.exceptions.PolarsError) as error:
        raise ValueError(
            f"{path}: is damaged ({_first_line(error)}); train the run again"
        ) from error


_DAMAGE = (
    *(OSError, ValueError, KeyError, TypeError, AttributeError),
    *(EOFError, RecursionError, zipfile.BadZipFile),
)


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]


def _summary(path: Path, config: Config) -> dict[str, Any]:
    summary = json.loads(path.read_text())
    counts = summary["converged_at"]
    if len(counts) != config.runs or not all(n is None or isinstance(n, int) for n in counts):
        raise ValueError(f"converged_at has no entry for each of the {config.runs} runs")
    best = summary["best_return"]
    if not isinstance(best, int | float) or not np.isfinite(best):
        raise ValueError("best_return is not a finite number")
    return summary


def _episodes(path: Path) -> pl.DataFrame:
    episodes = pl.read_parquet(path)
    missing = {"run", "episode", "steps", "return"} - set(episodes.columns)
    if missing:
        raise ValueError(f"column {min(missing)} is missing")
    return episodes


def _parameters(path: Path, config: Config, world: Source) -> Any:
    model = Job.of(0, replace(config, intrinsic=NO_INTRINSIC, horizon=0, beta=0.0), world).start(0)
    like, structure = jax.tree_util.tree_flatten_with_path(model.train_state.parameters)
    with path.open("rb") as file, np.load(file) as saved:
        leaves = [saved[f"parameters{jax.tree_util.keystr(name)}"] for name, _ in like]
    for (name, leaf), array in zip(like, leaves, strict=True):
        if array.shape != (config.runs, *leaf.shape) or array.dtype != leaf.dtype:
            raise ValueError(f"{jax.tree_util.keystr(name)} is {array.dtype}{array.shape}")
        if not np.isfinite(array).all():
            raise ValueError(f"{jax.tree_util.keystr(name)} has entries that are not finite")
    return jax.tree_util.tree_unflatten(structure, leaves)
