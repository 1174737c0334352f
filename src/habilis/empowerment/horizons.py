"""Empowerment of every horizon up to h at once."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Unpack

import numpy as np
from jaxtyping import Float64, Int64
from numpy.typing import ArrayLike

from habilis.empowerment.api import Options, bits_of, empowerment, question_of
from habilis.empowerment.arguments import chosen_actions, chosen_states, per_bit, whole_number
from habilis.empowerment.limits import (
    MAX_GIB,
    MAX_SECONDS,
    OTHERWISE,
    Limits,
    check_memory,
    unwatched,
    watched,
)
from habilis.empowerment.sensors import Sensor, is_noisy
from habilis.mdp import TabularMDP
from habilis.processors import processors
from habilis.progress import in_percent, progress_bar

if TYPE_CHECKING:
    from habilis.empowerment.tabular.deterministic import Question


def empowerment_by_horizon(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor = "object",
    actions: ArrayLike | None = None,
    states: ArrayLike | None = None,
    **options: Unpack[Options],
) -> Float64[np.ndarray, "{horizon}+1 n"]:
    """Empowerment of 0, 1, ... h actions.

    Where nothing is noisy, the sets of observations pass through every horizon on their way to
    the last: all take as long as that one.

    Args:
        mdp: the table.
        horizon: h, the largest.
        sensor, actions, states: as in `empowerment`.
        **options: of `empowerment`.

    Returns:
        float64[h + 1, n], row k that which `empowerment` gives for k actions.

    Raises:
        ValueError: as in `empowerment`.

    Example:
        >>> line = TabularMDP.deterministic([[0, 1], [0, 2], [1, 2]])
        >>> empowerment_by_horizon(line, 2, "state", states=[0]).round(3)
        array([[0.   ],
               [1.   ],
               [1.585]])
    """
    from habilis.empowerment.tabular.deterministic import counts_by_horizon

    return _counted(counts_by_horizon, mdp, horizon, sensor, actions, states, options)


def empowerment_until_repeated(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor = "object",
    actions: ArrayLike | None = None,
    states: ArrayLike | None = None,
    **options: Unpack[Options],
) -> Float64[np.ndarray, "k n"]:
    """The first k rows of `empowerment_by_horizon`, after which none is new.

    For those who ask when something happens first: of a long horizon these are few.
    """
    from habilis.empowerment.tabular.deterministic import counts_until_repeated

    def rows(question: "Question") -> Int64[np.ndarray, "k n"]:
        return counts_until_repeated(question)[0]

    return _counted(rows, mdp, horizon, sensor, actions, states, options)


def _counted(
    count: "Callable[[Question], Int64[np.ndarray, 'k n']]",
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor,
    actions: ArrayLike | None,
    states: ArrayLike | None,
    options: Options,
) -> Float64[np.ndarray, "k n"]:
    """Rows of empowerment by how they are counted, if nothing is noisy; otherwise all of them."""
    horizon = whole_number("horizon", horizon)
    sampled = options.get("method", "exact") != "exact"
    if mdp.is_stochastic or is_noisy(sensor) or sampled:
        return _each(mdp, horizon, sensor, actions, states, options)
    empowerment(mdp, 0, sensor, actions, [], **options)  # says what is wrong with any option
    starts, used = chosen_states(mdp, states), chosen_actions(mdp, actions)
    threads = options.get("threads") or processors()
    limits = _limits(options)
    with progress_bar("empowerment", options.get("show_progress", False)) as bar:
        tell = in_percent(bar)
        question = question_of(mdp, horizon, sensor, used, starts, threads, limits, tell)
        counts = count(question)
    return bits_of(counts) * per_bit(options.get("unit", "bits"))


def _each(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor,
    actions: ArrayLike | None,
    states: ArrayLike | None,
    options: Options,
) -> Float64[np.ndarray, "{horizon}+1 n"]:
    """Horizon by horizon, the largest first: what takes too long is refused at once."""
    limits = _limits(options)
    row = 8 * max(len(chosen_states(mdp, states)), 1)
    gib = row * (horizon + 1) / 2**30
    watch = watched(horizon, horizon, gib, limits, unwatched)
    found = []
    for h in range(horizon, -1, -1):
        found.append(empowerment(mdp, h, sensor, actions, states, **options))
        check_memory(gib, int(min(limits.gib * 2**30, 2**62)) // row - 1, horizon, limits)
        watch(len(found) / (horizon + 1))
    return np.stack(found[::-1])


def _limits(options: Options) -> Limits:
    return Limits(
        options.get("max_gib", MAX_GIB),
        options.get("max_seconds", MAX_SECONDS),
        OTHERWISE[options.get("method", "exact")],
    )
