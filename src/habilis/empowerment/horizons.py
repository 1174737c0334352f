"""Empowerment of every horizon up to h at once."""

from collections.abc import Sequence
from typing import Unpack

import numpy as np
from jaxtyping import Float64
from numpy.typing import ArrayLike

from habilis.empowerment.arguments import chosen_actions, chosen_states, per_bit, whole_number
from habilis.empowerment.availability import with_nowhere
from habilis.empowerment.core import (
    MOST_PACKED_LABELS,
    Options,
    empowerment,
    log2_of,
    neighbourhood,
)
from habilis.empowerment.sensors import Sensor, is_noisy, observations
from habilis.mdp import TabularMDP
from habilis.processors import processors


def empowerment_by_horizon(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor = "object",
    actions: Sequence[int] | None = None,
    states: ArrayLike | None = None,
    **options: Unpack[Options],
) -> Float64[np.ndarray, "h+1 n"]:
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
    horizon = whole_number("horizon", horizon)
    sampled = options.get("method", "exact") != "exact"
    labels, label_count = (None, 0) if is_noisy(sensor) else observations(mdp, sensor)
    if mdp.is_stochastic or labels is None or sampled or label_count > MOST_PACKED_LABELS:
        asked = range(horizon, -1, -1)  # the largest first: what takes too long is refused at once
        found = [empowerment(mdp, h, sensor, actions, states, **options) for h in asked]
        return np.stack(found[::-1])
    empowerment(mdp, 0, sensor, actions, [], **options)  # says what is wrong with any option
    from habilis.empowerment.counting import sets_backward, sizes

    starts = chosen_states(mdp, states)
    table = np.ascontiguousarray(mdp.next_state[:, chosen_actions(mdp, actions)])
    table, labels = with_nowhere(table, labels)
    near, nearby, place = neighbourhood(table, starts, horizon)
    threads = options.get("threads") or processors()
    scale = per_bit(options.get("unit", "bits"))
    rows = [
        log2_of(sizes(sets[place])) * scale
        for sets in sets_backward(nearby, labels[near], label_count, horizon, threads)
    ]
    return np.stack(rows + rows[-1:] * (horizon + 1 - len(rows)))
