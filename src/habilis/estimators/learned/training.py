"""Rounds of training: early stopping on a bound of data not trained on, resumed from a file."""

import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax
import numpy as np
from jaxtyping import Float64

from habilis.cache import fingerprint
from habilis.checksums import read_arrays, write_arrays
from habilis.estimators.actions import checked_actions, drawn_actions
from habilis.estimators.protocol import Simulator, checked_states
from habilis.estimators.rollouts import roll_out
from habilis.estimators.sensors import Reading
from habilis.files import write_whole
from habilis.progress import progress_bar

_SAVE_AFTER = 20.0  # seconds of training
_SMOOTHED = 4  # rounds

Round = Callable[[Any, int], tuple[Any, float]]
"""From the trained arrays and the number of the round to those after it, and the bound on the
round's data, which were not trained on before, in bits."""


@dataclass(frozen=True, eq=False)
class Trained:
    """What training found.

    Attributes:
        best: the arrays with the largest bound.
        bounds: float64[rounds], on each round's data, in bits.
    """

    best: Any
    bounds: Float64[np.ndarray, "rounds"]


def train(
    first: Any,
    one_round: Round,
    rounds: int,
    patience: int,
    path: Path | None,
    show_progress: bool,
) -> Trained:
    """Trains until the bound, averaged over four rounds, has not grown for so many rounds.

    Args:
        first: a tree of arrays.
        one_round: trains.
        rounds: at most.
        patience: rounds.
        path: where progress is kept; `None` for nowhere. What is there already is gone on with.
        show_progress: whether to draw a bar.

    Returns:
        The best arrays.
    """
    leaves, shape = jax.tree.flatten(first)
    now, best, bounds = first, first, np.empty(0)
    if path is not None:
        with suppress(OSError, ValueError, EOFError, KeyError):
            kept = read_arrays(path)
            fits = all(kept[f"now{i}"].shape == np.shape(leaf) for i, leaf in enumerate(leaves))
            if fits:
                read = [
                    [jax.numpy.asarray(kept[f"{name}{i}"]) for i in range(len(leaves))]
                    for name in ("now", "best")
                ]
                now, best = (jax.tree.unflatten(shape, one) for one in read)
                bounds = kept["bounds"]

    def save() -> None:
        if path is None:
            return
        arrays = {"bounds": bounds}
        for name, tree in (("now", now), ("best", best)):
            arrays |= {f"{name}{i}": np.asarray(x) for i, x in enumerate(jax.tree.leaves(tree))}
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, lambda file: write_arrays(file, arrays))

    saved = time.monotonic()
    with progress_bar("training", show_progress) as report:
        while len(bounds) < rounds and not _stalled(bounds, patience):
            report(len(bounds), rounds)
            before = now
            now, bound = one_round(now, len(bounds))
            bounds = np.append(bounds, bound)
            if not np.isfinite(bound):
                raise ValueError(
                    f"training diverged in round {len(bounds)}; give a smaller learning_rate"
                )
            means = _smoothed(bounds)
            if means[-1] >= means.max():
                best = before
            if time.monotonic() - saved > _SAVE_AFTER:
                save()
                saved = time.monotonic()
    save()
    return Trained(best, bounds)


def _smoothed(bounds: Float64[np.ndarray, "rounds"]) -> Float64[np.ndarray, "rounds"]:
    ends = np.cumsum([0.0, *bounds])
    last = np.arange(1, len(bounds) + 1)
    first = np.maximum(last - _SMOOTHED, 0)
    return (ends[last] - ends[first]) / (last - first)


def _stalled(bounds: Float64[np.ndarray, "rounds"], patience: int) -> bool:
    if len(bounds) <= patience + _SMOOTHED:
        return False
    means = _smoothed(bounds)
    return bool(means[-patience:].max() <= means[:-patience].max() + 1e-3)


def random_starts(
    simulator: Simulator, count: int, generator: np.random.Generator, states: Any = None
) -> Float64[np.ndarray, "n d"]:
    """States to train on, drawn from those that are given, or by the simulator.

    Raises:
        ValueError: there are none.
    """
    if states is not None:
        return states[generator.integers(len(states), size=count)]
    draw = getattr(simulator, "random_states", None)
    if draw is None:
        raise ValueError(
            "the simulator has no random_states(count, generator), and learning needs states; give "
            "it one, or the estimator states="
        )
    return checked_states(draw(count, generator))


def checkpoint_path(
    folder: Any, settings: Any, simulator: Simulator, shown: Reading, horizon: int, seed: int
) -> Path | None:
    """Where the progress of one fit is kept: another for every setting, seed and simulator.

    Simulators are told apart by what they do with a few states.
    """
    if folder is None:
        return None
    generator = np.random.default_rng(0)
    starts = random_starts(simulator, 16, generator, settings.states)
    actions = checked_actions(simulator.actions)
    with suppress(ValueError):  # of an unbounded box
        drawn = drawn_actions(actions, (len(starts), horizon), generator)
        starts = np.concatenate([starts, roll_out(simulator, starts, drawn)])
    readings = np.asarray(shown(starts), np.float64).round(4)
    given = () if settings.states is None else (settings.states,)
    name = fingerprint(type(settings).__name__, repr(settings), readings, horizon, seed, *given)
    return Path(folder) / f"{type(settings).__name__.lower()}-{name[:32]}.npz"
