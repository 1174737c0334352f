"""A run's folder: what training leaves on disk.

config.json         the configuration
world.txt           the map, with the tool that was used
episodes.parquet    `Run.episodes`
summary.json        best return, and each run's episodes to convergence
parameters.npz      the networks' parameters, runs along the first axis
"""

import json
import os
import zipfile
from dataclasses import asdict
from pathlib import Path

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


def check_unused(folder: Path) -> None:
    """Refuses a folder that a run cannot be saved in, before any work is done.

    Raises:
        ValueError: it exists and is not an empty folder, or cannot be written.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise ValueError(f"{folder}: exists already; name a new folder, or remove it")
    check_writable(folder)


def check_writable(folder: Path) -> None:
    """Refuses a folder that cannot be made or written.

    Raises:
        ValueError: what exists of its path is no folder, or may not be written to.
    """
    path = folder.absolute()
    existing = next(p for p in (path, *path.parents) if os.path.lexists(p))
    if not existing.is_dir():
        raise ValueError(f"{folder}: {existing} is not a folder; name another place")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise ValueError(f"{folder}: {existing} cannot be written to; name another place")


def save_run(run: Run, folder: Path) -> None:
    """Writes a run into a new folder.

    Raises:
        ValueError: the folder exists and is not empty, or cannot be written.
    """
    check_unused(folder)
    summary = {
        "best_return": run.best_return,
        "converged_at": list(run.converged_at),
        "world": run.world.name,
        "tool": run.world.tool,
    }
    leaves = jax.tree_util.tree_leaves_with_path(run.networks)
    parameters = {jax.tree_util.keystr(path): np.asarray(leaf) for path, leaf in leaves}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "config.json").write_text(json.dumps(asdict(run.config), indent=2) + "\n")
        (folder / "world.txt").write_text(run.world.text())
        (folder / "summary.json").write_text(json.dumps(summary, indent=2) + "\n")
        run.episodes.write_parquet(folder / "episodes.parquet")
        np.savez(folder / "parameters.npz", allow_pickle=False, **parameters)
    except OSError as error:
        raise ValueError(f"{folder}: cannot write the run ({error.strerror})") from error


def load_run(folder: Path) -> Run:
    """Reads a run back.

    Raises:
        ValueError: the folder holds no run, or a damaged one; the message names the file.
    """
    path = folder
    try:
        path = folder / "config.json"
        config = Config.from_dict(json.loads(path.read_text()))
        path = folder / "summary.json"
        summary = json.loads(path.read_text())
        path = folder / "world.txt"
        world = World.parse(path.read_text(), summary["world"]).with_tool(summary["tool"])
        path = folder / "episodes.parquet"
        episodes = pl.read_parquet(path)
        path = folder / "parameters.npz"
        networks = _load_networks(path, config, world)
        return Run(
            config=config,
            world=world,
            best_return=summary["best_return"],
            episodes=episodes,
            converged_at=tuple(summary["converged_at"]),
            networks=networks,
        )
    except FileNotFoundError as error:
        raise ValueError(f"{path}: is missing; name the folder of a finished run") from error
    except (
        OSError,
        ValueError,
        KeyError,
        TypeError,
        zipfile.BadZipFile,
        pl.exceptions.PolarsError,
    ) as error:
        raise ValueError(
            f"{path}: is damaged ({str(error).splitlines()[0]}); train the run again"
        ) from error


def _load_networks(path: Path, config: Config, world: World) -> ActorCritic:
    mdp = tabulate(world)
    task, rows = make_task(mdp)

    def one(key):
        return ActorCritic(rows, task.inputs.shape[1], mdp.next_state.shape[1], config.hidden, key)

    keys = jax.random.split(jax.random.key(0), config.runs)
    like = jax.eval_shape(jax.vmap(one), keys)
    leaves, structure = jax.tree_util.tree_flatten_with_path(like)
    with path.open("rb") as file, np.load(file) as saved:
        loaded = [jnp.asarray(saved[jax.tree_util.keystr(name)]) for name, _ in leaves]
    for (name, leaf), array in zip(leaves, loaded, strict=True):
        if leaf.shape != array.shape:
            raise ValueError(f"{jax.tree_util.keystr(name)} has shape {array.shape}")
    return jax.tree_util.tree_unflatten(structure, loaded)
