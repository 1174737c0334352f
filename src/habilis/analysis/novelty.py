"""The count-based bonus that a policy leaves: what is new after T steps, and what is not."""

from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float64, Int64

from habilis.analysis.occupancy import (
    Policy,
    seen_in_states,
    starts_of,
    steps_back,
)
from habilis.empowerment.arguments import at_least_one
from habilis.empowerment.sensors import Sensor
from habilis.mdp import TabularMDP
from habilis.probabilities import shape_of

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_BLOCK = 8_000_000  # numbers of the joint distributions that are worked on at once
_MOST = 10**11  # products of numbers, at most: minutes


def count_novelty(
    mdp: TabularMDP,
    policy: Policy,
    steps: int,
    sensor: Sensor = "state",
    states: Any = None,
    *,
    absorbing: bool = False,
) -> Float64[np.ndarray, "n S"]:
    """The expected count-based bonus of entering each state, after T steps of a policy.

        B(s) = E[(1 + N(O_s))^(-1/2)],   N(o) = the number of t = 1 ... T with O_t = o,

    with O_s what is observed in s: the bonus 1 / sqrt(visits) of count-based exploration (Strehl
    and Littman 2008; Bellemare et al. 2016), the entering counted. Its expectation after T steps
    is ours. It is exact: the joint distribution of state and count is followed for each
    observation, as B is not a function of the expected count, but never less than
    (1 + E[N(o)])^(-1/2). The trainer's `intrinsic="count"` is this bonus, in one run.

    Args:
        mdp, policy, steps, states, absorbing: as in `occupancy`. In a terminal state that absorbs,
            every further step is a visit.
        sensor: as in `occupancy_entropy`; what is counted.

    Returns:
        float64[n, S], from 1 / sqrt(1 + T) to 1, where nothing of the kind was seen. No bits.

    Raises:
        ValueError: as in `occupancy`, what `empowerment` refuses of a sensor, or more than 10^11
            products, which are too many observations or steps for the table.

    Example:
        >>> ring = TabularMDP.deterministic([[(s - 1) % 4, (s + 1) % 4] for s in range(4)])
        >>> count_novelty(ring, "uniform", steps=2).round(3)
        array([[0.854, 0.854, 0.854, 0.854]])
    """
    steps = at_least_one("steps", steps)
    seen = seen_in_states(mdp, sensor)
    back, starts = steps_back(mdp, policy, absorbing), starts_of(mdp, states)
    inside = _reached(back, starts, steps)
    back, starts, shown = back[inside][:, inside], starts[:, inside], seen[inside].toarray()
    visible = np.flatnonzero(shown.any(axis=0))
    effort = shape_of(starts)[0] * len(visible) * steps * (steps + 1) // 2 * back.nnz
    if effort > _MOST:
        raise ValueError(
            f"the visits of {len(visible):,} observations over {steps} steps take {effort:.1e} "
            f"products, above {_MOST:.0e}; give fewer steps or states, or a coarser sensor"
        )
    bonus = np.ones((shape_of(starts)[0], shape_of(seen)[1]))
    width = max(_BLOCK // (len(inside) * (steps + 1)), 1)
    for number, start in enumerate(starts.toarray()):
        for first in range(0, len(visible), width):
            some = visible[first : first + width]
            counts = _counts(back, start, np.ascontiguousarray(shown[:, some]), steps)
            bonus[number, some] = (1 + np.arange(steps + 1)) ** -0.5 @ counts
    return np.asarray((seen @ bonus.T).T)


def _reached(back: "csr_array", starts: "csr_array", steps: int) -> Int64[np.ndarray, "R"]:
    """The states that can be visited, or begun in."""
    inside = np.asarray(starts.sum(axis=0)) > 0
    for _ in range(steps):
        after = inside | (np.asarray(back @ inside.astype(np.float64)) > 0)
        if (after == inside).all():
            break
        inside = after
    return np.flatnonzero(inside)


def _counts(
    back: "csr_array",
    start: Float64[np.ndarray, "R"],
    shown: Float64[np.ndarray, "R k"],
    steps: int,
) -> Float64[np.ndarray, "C k"]:
    """The distribution of how often each of k observations is made, from 0 to T times."""
    states, several = shown.shape
    joint = np.repeat(start[:, None, None], several, axis=2)  # [state, count, observation]
    hit = shown[:, None]
    for _ in range(steps):
        moved = np.asarray(back @ joint.reshape(states, -1)).reshape(joint.shape)
        joint = np.zeros((states, joint.shape[1] + 1, several))
        joint[:, :-1] = moved * (1 - hit)
        joint[:, 1:] += moved * hit
    return joint.sum(axis=0)
