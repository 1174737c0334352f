"""Checkpoints: all that a run needs to go on, in one file that is whole or not there.

A checkpoint is an .npz with a checksum of all its bytes (`habilis.checksums`).
"""

import zipfile
from pathlib import Path

import jax
import numpy as np

from habilis.checksums import read_arrays, write_arrays
from habilis.files import remove_partial, write_whole
from habilis.learning.jobs import Job

KEPT = 2
_PREFIX, _SUFFIX = "checkpoint-", ".npz"
_ASIDE = "damaged-"
_RENAMED = {
    "/lane.learner": "/lane.train_state",
    "/lane.place": "/lane.env_state",
    "/lane.done": "/lane.counts",
    "/points": "/metrics",
}


def checkpoints(folder: Path) -> list[Path]:
    """The checkpoints of a folder, the latest first."""
    return sorted(folder.glob(f"{_PREFIX}*{_SUFFIX}"), reverse=True)


def save(job: Job, folder: Path) -> Path:
    """Writes the next checkpoint, and removes all but the last two.

    Raises:
        OSError: the disk is full, or the folder cannot be written; earlier ones are untouched.
    """
    earlier = checkpoints(folder)
    number = 1 + (int(earlier[0].stem.removeprefix(_PREFIX)) if earlier else 0)
    path = folder / f"{_PREFIX}{number:08}{_SUFFIX}"
    write_whole(path, lambda file: write_arrays(file, _arrays(job)))
    for old in checkpoints(folder)[KEPT:]:
        old.unlink()
    return path


def remove_all(folder: Path) -> None:
    """Removes a folder's checkpoints, those set aside too, and what a kill left half written."""
    for pattern in (f"{_PREFIX}*{_SUFFIX}", f"{_ASIDE}*{_SUFFIX}"):
        for path in folder.glob(pattern):
            path.unlink()
    remove_partial(folder)


def restore(job: Job, folder: Path) -> tuple[Path | None, dict[Path, str]]:
    """Takes a job back to the last checkpoint that is whole, if there is one; writes nothing.

    Returns:
        That checkpoint, or `None`, and the later ones, which are damaged, each with what is wrong.

    Raises:
        ValueError: there are checkpoints, and all are damaged.
    """
    damaged: dict[Path, str] = {}
    found = checkpoints(folder)
    for path in found:
        try:
            _enter(job, _read(path))
        except FileNotFoundError:
            return restore(job, folder)  # the process that trains has put a later one in its place
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
            damaged[path] = (str(error).splitlines() or [type(error).__name__])[0]
        else:
            return path, damaged
    if found:
        raise ValueError(
            f"{found[0]}: is damaged, as are all checkpoints of {folder} ({damaged[found[0]]}); "
            "train the run again in a new folder"
        )
    return None, damaged


def set_aside(path: Path) -> None:
    """Has a damaged checkpoint out of the way, so that the last two are whole ones."""
    path.rename(path.with_name(_ASIDE + path.name))


def _read(path: Path) -> dict[str, np.ndarray]:
    """The arrays of a checkpoint.

    Raises:
        ValueError: its bytes are not those that were written.
    """
    return {_name(name): array for name, array in read_arrays(path).items()}


def _name(saved: str) -> str:
    """The name of an array, as it is now; earlier editions had others for some parts."""
    for before, now in _RENAMED.items():
        saved = saved.replace(before, now)
    return saved


def _arrays(job: Job) -> dict[str, np.ndarray]:
    arrays = {}
    for run, record in enumerate(job.records):
        for path, leaf in jax.tree_util.tree_leaves_with_path(job.lane(run)):
            arrays[f"{run}/lane{jax.tree_util.keystr(path)}"] = np.asarray(leaf)
        arrays[f"{run}/running"] = record.running
        arrays[f"{run}/episodes"] = record.episodes()
        arrays[f"{run}/metrics"] = record.metrics()
        arrays[f"{run}/steps"] = np.int64(record.steps)
    return arrays


def _enter(job: Job, arrays: dict[str, np.ndarray]) -> None:
    """Puts what was saved into a job, all of it or nothing."""
    lanes, entries = {}, []
    for run, record in enumerate(job.records):
        like, structure = jax.tree_util.tree_flatten_with_path(job.start(run))
        leaves = [arrays[f"{run}/lane{jax.tree_util.keystr(path)}"] for path, _ in like]
        parts = [arrays[f"{run}/{name}"] for name in ("running", "episodes", "metrics")]
        running, episodes, metrics = parts
        wanted = [record.running, record.episodes()[:0], record.metrics()[:0]]
        there = [*leaves, running, episodes[:0], metrics[:0]]
        for array, model in zip(there, [leaf for _, leaf in like] + wanted, strict=True):
            if array.shape != model.shape or array.dtype != model.dtype:
                raise ValueError(f"run {run} has an array {array.dtype}{array.shape}")
        lanes[run] = jax.tree_util.tree_unflatten(structure, leaves)
        entries.append((record, int(arrays[f"{run}/steps"]), *parts))
    job.lanes.update(lanes)
    for record, steps, running, episodes, metrics in entries:
        record.restore(steps, running, episodes, metrics)
