"""Empowerment of every horizon up to h at once."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Unpack

import numpy as np
from jaxtyping import Float64, Int64
from numpy.typing import ArrayLike

from habilis.empowerment.api import Options, empowerment
from habilis.empowerment.arguments import chosen_actions, chosen_states, per_bit, whole_number
from habilis.empowerment.combined import combined, is_combined
from habilis.empowerment.limits import (
    check_memory,
    unwatched,
    watched,
)
from habilis.empowerment.methods import Exact, checked_method
from habilis.empowerment.noiseless import bits_of, question_of
from habilis.empowerment.old_keywords import takes_old_keywords
from habilis.empowerment.sensors import Sensor, is_noisy
from habilis.empowerment.splitting import in_parts
from habilis.mdp import TabularMDP
from habilis.progress import in_percent, progress_bar

if TYPE_CHECKING:
    from habilis.empowerment.tabular.deterministic import Question


@takes_old_keywords
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
        **options: `method`, `unit`, `executor` and `show_progress`, as in `empowerment`.

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

    For those who ask when something happens first: of a long horizon these are few. Of a sum or a
    product all are given, because its parts repeat at different horizons.
    """
    from habilis.empowerment.tabular.deterministic import counts_by_horizon, counts_until_repeated

    def rows(question: "Question") -> Int64[np.ndarray, "k n"]:
        if is_combined(mdp, sensor):
            return counts_by_horizon(question)
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
    method = checked_method(options.get("method", Exact()))

    def through(one: Sensor) -> Float64[np.ndarray, "k n"]:
        if mdp.is_stochastic or is_noisy(one) or not isinstance(method, Exact):
            return _each(mdp, horizon, one, actions, states, options)
        empowerment(mdp, 0, one, actions, [], **options)  # says what is wrong with any option
        if (executor := options.get("executor")) is not None:
            unit, show = options.get("unit", "bits"), options.get("show_progress", False)
            given = {"horizon": horizon, "actions": actions, "method": method, "unit": unit}
            some = mdp, one, states, given, executor, show
            rows, _ = in_parts("empowerment_by_horizon", *some)
            return np.ascontiguousarray(rows.T)
        starts, used = chosen_states(mdp, states), chosen_actions(mdp, actions)
        with progress_bar("empowerment", options.get("show_progress", False)) as bar:
            question = question_of(mdp, horizon, one, used, starts, method, in_percent(bar))
            counts = count(question)
        return bits_of(counts) * per_bit(options.get("unit", "bits"))

    return combined(mdp, sensor, through)


def _each(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor,
    actions: ArrayLike | None,
    states: ArrayLike | None,
    options: Options,
) -> Float64[np.ndarray, "{horizon}+1 n"]:
    """Horizon by horizon, the largest first: what takes too long is refused at once."""
    limits = options.get("method", Exact()).limits
    row = 8 * max(len(chosen_states(mdp, states)), 1)
    gib = row * (horizon + 1) / 2**30
    watch = watched(horizon, horizon, gib, limits, unwatched)
    found = []
    for h in range(horizon, -1, -1):
        found.append(empowerment(mdp, h, sensor, actions, states, **options))
        check_memory(gib, int(min(limits.gib * 2**30, 2**62)) // row - 1, horizon, limits)
        watch(len(found) / (horizon + 1))
    return np.stack(found[::-1])
