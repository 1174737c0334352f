"""Checkpoints: all that a run needs to go on, in one file that is whole or not there."""

import os
import zipfile
from pathlib import Path

import jax
import numpy as np

from habilis.learning.jobs import Job

KEPT = 2
_PREFIX, _SUFFIX = "checkpoint-", ".npz"


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
    write_whole(path, lambda file: np.savez(file, allow_pickle=False, **_arrays(job)))
    for old in checkpoints(folder)[KEPT:]:
        old.unlink()
    return path


def write_whole(path: Path, write) -> None:
    """Writes a file beside its place, makes sure that it is on the disk, and puts it there.

    Args:
        path: where it goes.
        write: what fills an open binary file.
    """
    temporary = path.with_name(f".{path.name}.partial")
    try:
        with temporary.open("wb") as file:
            write(file)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def restore(job: Job, folder: Path) -> list[str]:
    """Takes a job back to its last checkpoint that is whole, if there is one.

    Returns:
        A line for each that is damaged.

    Raises:
        ValueError: there are checkpoints, and all are damaged.
    """
    told: list[str] = []
    found = checkpoints(folder)
    for path in found:
        try:
            with path.open("rb") as file, np.load(file) as saved:
                arrays = {name: saved[name] for name in saved.files}
            _enter(job, arrays)
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
            reason = (str(error).splitlines() or [type(error).__name__])[0]
            told.append(f"{path}: is damaged ({reason}); going on from the one before")
        else:
            return told
    if found:
        raise ValueError(
            f"{found[0]}: is damaged, as are all checkpoints of {folder}; train the run again"
        )
    return told


def _arrays(job: Job) -> dict[str, np.ndarray]:
    arrays = {}
    for run, record in enumerate(job.records):
        for path, leaf in jax.tree_util.tree_leaves_with_path(job.lanes[run]):
            arrays[f"{run}/lane{jax.tree_util.keystr(path)}"] = np.asarray(leaf)
        arrays[f"{run}/running"] = record.running
        arrays[f"{run}/episodes"] = record.episodes()
        arrays[f"{run}/steps"] = np.int64(record.steps)
    return arrays


def _enter(job: Job, arrays: dict[str, np.ndarray]) -> None:
    """Puts what was saved into a job, all of it or nothing."""
    lanes, entries = {}, []
    for run, record in enumerate(job.records):
        like, structure = jax.tree_util.tree_flatten_with_path(job.start(run))
        leaves = [arrays[f"{run}/lane{jax.tree_util.keystr(path)}"] for path, _ in like]
        running, episodes = arrays[f"{run}/running"], arrays[f"{run}/episodes"]
        wanted = [leaf for _, leaf in like] + [record.running, record.episodes()[:0]]
        for array, model in zip([*leaves, running, episodes[:0]], wanted, strict=True):
            if array.shape != model.shape or array.dtype != model.dtype:
                raise ValueError(f"run {run} has an array {array.dtype}{array.shape}")
        lanes[run] = jax.tree_util.tree_unflatten(structure, leaves)
        entries.append((record, int(arrays[f"{run}/steps"]), running, episodes))
    job.lanes.update(lanes)
    for record, steps, running, episodes in entries:
        record.restore(steps, running, episodes)
