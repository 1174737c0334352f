"""Steps about a run's folder, whether its training has ended or not."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from habilis.learning.checkpoints import checkpoints
from habilis.learning.curves import learning_curve
from habilis.learning.folder import (
    is_finished,
    load_latest,
    read_config,
    read_summary,
    read_world,
)
from habilis.learning.replay import best_return_from, learned, play, table_of
from habilis.learning.runs import Run
from habilis.learning.sources import map_of
from habilis.mdp import HELD, LAID
from habilis.studio.drawn_worlds import drawn_of
from habilis.studio.placements import Order, named, placed
from habilis.studio.protocol.hello import RunAbout
from habilis.studio.protocol.scenes import Placement
from habilis.studio.scene_steps import Answer
from habilis.studio.scenes import state_of
from habilis.worlds.rules import NONE

_POINTS = 150  # of a curve, enough for a page
_DIGITS = 5


def summary_of(folder: Path) -> RunAbout:
    """A run's settings and world."""
    run = load_latest(folder)
    return RunAbout(
        name=folder.resolve().name,
        runs=run.config.runs,
        drawn=drawn_of(run.map),
        config=run.config.as_dict(),
    )


def kept(folder: str) -> Answer:
    """A run's settings, world and outcome, without the files that take long to read.

    Raises:
        ValueError: its files are damaged.
    """
    path = Path(folder)
    config, world = read_config(path), read_world(path)
    ended = is_finished(path)
    outcome: Answer = {"converged_at": None, "best_return": None}
    if ended:
        outcome = read_summary(path, config)
    elif not checkpoints(path) and not is_finished(path):  # it may just have ended
        outcome["error"] = "ended before its first checkpoint: there is nothing to watch"
    return outcome | {
        "runs": config.runs,
        "drawn": drawn_of(map_of(world)),
        "config": config.as_dict(),
        "ended": ended,
    }


def curve(folder: str) -> Answer:
    """The average learning curve so far; no curve before every run has finished an episode."""
    return _curve(load_latest(folder))


def view(folder: str, index: int, at: Placement | None = None) -> Answer:
    """The policy, values and a greedy episode of one of the runs.

    Args:
        folder: the folder of the training.
        index: the index of the run.
        at: the placement in which the episode begins, whose tool and object also hold for the
            values of every agent cell; by default the map's.

    Returns:
        The greedy episode; along it, and for every agent cell, the action probabilities and the
        value; the curve, and the best return from the placement.
    """
    run = load_latest(folder)
    mdp = table_of(run)
    order = Order.of(run.map)
    start = mdp.start if at is None else state_of(run.map, mdp, named(run.map, order, at))
    episode = play(run, index, start)
    policy, values = learned(run, mdp, index)
    here = np.ones(mdp.states, bool)
    for name in mdp.factors.keys() - {"agent", HELD, LAID}:
        here &= mdp.factor(name) == mdp.factor(name)[start]
    shape = run.map.height, run.map.width
    grids: Any = [[[None] * shape[1] for _ in range(shape[0])] for _ in range(2)]
    shown = np.flatnonzero(here)
    if LAID in mdp.factors:  # as in a landscape, an adjacent tool is in hand if possible
        shown = shown[np.argsort(mdp.factor(LAID)[shown] != NONE, kind="stable")]
    for state in shown:
        row, column = divmod(int(mdp.factor("agent")[state]), shape[1])
        if grids[0][row][column] is not None:  # with another tool in hand
            continue
        grids[0][row][column] = rounded(policy[state])
        grids[1][row][column] = rounded(values[state])
    return {
        "drawn": drawn_of(run.map),
        "policy": {
            "episode": [rounded(policy[state]) for state in episode.states],
            "cells": grids[0],
        },
        "values": grids[1],
        "episode": {
            "placements": [placed(run.map, order, mdp, state) for state in episode.states],
            "actions": list(episode.actions),
            "values": [rounded(values[state]) for state in episode.states],
            "return": episode.episode_return,
            "finished": episode.finished,
            "best_return": best_return_from(run, start),
        },
    } | _curve(run)


def rounded(values: ArrayLike) -> Any:
    """Numbers, rounded to what is visible."""
    return np.vectorize(lambda value: float(f"{value:.{_DIGITS}g}"))(values).tolist()


def _curve(run: Run) -> Answer:
    try:
        found = learning_curve(run)
    except ValueError:
        points = None
    else:
        shown = np.unique(np.linspace(0, len(found.x) - 1, _POINTS).astype(int))
        points = {"runs": found.runs, "carried_on": found.carried} | {
            name: rounded(part[shown])
            for name, part in {
                "x": found.x,
                "mean": found.middle,
                "low": found.low,
                "high": found.high,
            }.items()
        }
    return {
        "curve": points,
        "best_return": run.best_return,
        "episodes": len(run.episodes),
        "steps": int(run.episodes["steps"].sum()),
        "converged_at": list(run.converged_at),
    }


def prepare(background: bool) -> None:
    """Does nothing: only the imports above take time."""


STEPS = {one.__name__: one for one in (kept, curve, view)}
"""The steps that a worker can run, by name."""
