"""A run's folder: what training leaves on disk.

config.json         the configuration
world.txt           the map, with the tool that was used
episodes.parquet    `Run.episodes`
summary.json        best return, and each run's episodes to convergence
parameters.npz      the networks' parameters, runs along the first axis
"""

import json
import os
import shutil
import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
import polars as pl

from habilis.learning.config import Config
from habilis.learning.networks import ActorCritic
from habilis.learning.runs import Run
from habilis.learning.train import make_task
from habilis.worlds.table import tabulate
from habilis.worlds.world import World

_LONGEST_NAME = 240  # bytes: what file systems allow, less what a temporary name adds


def check_unused(folder: str | Path) -> None:
    """Refuses a folder that a run cannot be saved in, before any work is done.

    Raises:
        ValueError: it exists and is not an empty folder, or cannot be written.
    """
    folder = Path(folder)
    check_writable(folder)
    if folder.exists() and any(folder.iterdir()):
        raise ValueError(f"{folder}: exists already; name a new folder, or remove it")


def check_writable(folder: Path) -> None:
    """Refuses a folder that cannot be made or written.

    Raises:
        ValueError: what exists of its path is no folder, or may not be written to.
    """
    path = folder.absolute()
    if max(len(os.fsencode(part)) for part in path.parts) > _LONGEST_NAME:
        raise ValueError(f"{folder.name[:40]}...: the name is too long; give a shorter one")
    try:
        existing = next(p for p in (path, *path.parents) if os.path.lexists(p))
    except ValueError as error:
        raise ValueError(f"{str(folder)!r}: is no path ({error}); name another place") from None
    if not existing.is_dir():
        raise ValueError(f"{folder}: {existing} is not a folder; name another place")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise ValueError(f"{folder}: {existing} cannot be written to; name another place")


def save_run(run: Run, folder: str | Path) -> None:
    """Writes a run into a new folder, all of it or nothing.

    Raises:
        ValueError: the folder exists and is not empty, or cannot be written.
    """
    folder = Path(folder).absolute()
    check_unused(folder)
    summary = {
        "best_return": run.best_return,
        "converged_at": list(run.converged_at),
        "world": run.world.name,
        "tool": run.world.tool,
    }
    leaves = jax.tree_util.tree_leaves_with_path(run.networks)
    parameters = {jax.tree_util.keystr(path): np.asarray(leaf) for path, leaf in leaves}
    temporary = None
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        temporary = Path(tempfile.mkdtemp(dir=folder.parent, prefix=f".{folder.name}-"))
        (temporary / "config.json").write_text(json.dumps(asdict(run.config), indent=2) + "\n")
        (temporary / "world.txt").write_text(run.world.text())
        (temporary / "summary.json").write_text(json.dumps(summary, indent=2) + "\n")
        run.episodes.write_parquet(temporary / "episodes.parquet")
        np.savez(temporary / "parameters.npz", allow_pickle=False, **parameters)
        temporary.chmod(0o755)
        temporary.rename(folder)
    except (OSError, pl.exceptions.PolarsError) as error:
        if temporary is not None:
            shutil.rmtree(temporary, ignore_errors=True)
        raise ValueError(f"{folder}: cannot write the run ({_first_line(error)})") from error


def load_run(folder: str | Path) -> Run:
    """Reads a run back.

    Raises:
        ValueError: the folder holds no run, or a damaged one; the message names the file.
    """
    folder = Path(folder)
    config = _read(folder / "config.json", lambda p: Config.from_dict(json.loads(p.read_text())))
    summary = _read(folder / "summary.json", lambda path: _summary(path, config))
    world = _read(
        folder / "world.txt",
        lambda path: World.parse(path.read_text(), summary["world"]).with_tool(summary["tool"]),
    )
    return Run(
        config=config,
        world=world,
        best_return=summary["best_return"],
        episodes=_read(folder / "episodes.parquet", _episodes),
        converged_at=tuple(summary["converged_at"]),
        networks=_read(folder / "parameters.npz", lambda path: _load_networks(path, config, world)),
    )


Value = TypeVar("Value")


def _read(path: Path, read: Callable[[Path], Value]) -> Value:
    """Reads one file of a run.

    Raises:
        ValueError: it is missing or damaged.
    """
    try:
        return read(path)
    except FileNotFoundError as error:
        raise ValueError(f"{path}: is missing; name the folder of a finished run") from error
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
    if not isinstance(summary["best_return"], int | float):
        raise ValueError("best_return is no number")
    if not all(isinstance(summary[name], str) for name in ("world", "tool")):
        raise ValueError("world or tool is no name")
    return summary


def _episodes(path: Path) -> pl.DataFrame:
    episodes = pl.read_parquet(path)
    missing = {"run", "episode", "steps", "return"} - set(episodes.columns)
    if missing:
        raise ValueError(f"column {min(missing)} is missing")
    return episodes


def _load_networks(path: Path, config: Config, world: World) -> ActorCritic:
    mdp = tabulate(world)
    task, rows = make_task(mdp)

    def one(key):
        return ActorCritic(rows, task.inputs.shape[1], mdp.action_count, config.hidden, key)

    keys = jax.random.split(jax.random.key(0), config.runs)
    like = jax.eval_shape(jax.vmap(one), keys)
    leaves, structure = jax.tree_util.tree_flatten_with_path(like)
    with path.open("rb") as file, np.load(file) as saved:
        loaded = [jnp.asarray(saved[jax.tree_util.keystr(name)]) for name, _ in leaves]
    for (name, leaf), array in zip(leaves, loaded, strict=True):
        if leaf.shape != array.shape or leaf.dtype != array.dtype:
            raise ValueError(f"{jax.tree_util.keystr(name)} is {array.dtype}{array.shape}")
        if not jnp.isfinite(array).all():
            raise ValueError(f"{jax.tree_util.keystr(name)} has entries that are not finite")
    return jax.tree_util.tree_unflatten(structure, loaded)
