"""Goal-directed empowerment: the futures that are left on the way to a goal.

The definition is ours. A sequence of n actions from s stays within the slack if it ends in a state
from which the goal can still be reached in time:

    n + d(s_n) <= d(s) + slack,     d the shortest distance to the goal, which absorbs.

A step from x to y uses 1 + d(y) - d(x) of the slack, never less than 0, so the sequences that count
are the paths of a table over states and what is left of the slack.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64, Int64, Integer
from numpy.typing import ArrayLike

from habilis.empowerment.api import Options, empowerment
from habilis.empowerment.arguments import check_table, chosen_states, whole_number
from habilis.empowerment.limits import check_memory
from habilis.empowerment.methods import Exact, Method
from habilis.empowerment.sensors import Sensor, is_noisy, observations
from habilis.mdp import TabularMDP
from habilis.progress import progress_bar

_EXACT = Exact()
_FAR = 2**40  # a distance that no table has, and that floats hold exactly


def goal_directed_empowerment(
    mdp: TabularMDP,
    horizon: int,
    goal: ArrayLike | None = None,
    slack: int = 0,
    sensor: Sensor = "state",
    states: Any = None,
    *,
    method: Method = _EXACT,
    show_progress: bool = False,
) -> Float64[np.ndarray, "n"]:
    """How many futures there are on the way to the goal, in bits.

    With d(s) the shortest distance to the goal and n = min(h, d(s) + slack), it is log2 of the
    number of observations of states s_n that n actions lead to with n + d(s_n) <= d(s) + slack,
    that is, from which the goal is still reached in time; 0 where it cannot be reached. Goal states
    absorb. With slack 0 these are the shortest paths alone. The definition is ours; another, of the
    same aim, is in Volpi and Polani (2020), which we could not read.

    Args:
        mdp: a deterministic table.
        horizon: h, how many actions at most, 0 or more.
        goal: the goal states, as indices or as bool[S]; by default the terminal states.
        slack: how many steps longer than a shortest one the way to the goal may be.
        sensor: as in `empowerment`, labels only, one alone.
        states: the n states asked about, as indices or as bool[S]; by default all.
        method: as in `empowerment`.
        show_progress: whether to draw a progress bar on standard error, once it takes two seconds.

    Returns:
        float64[n], in bits.

    Raises:
        ValueError: a stochastic table, a noisy sensor, no goal, a slack that takes more memory
            than the method's limit, or what `empowerment` refuses.

    Example:
        >>> ring = TabularMDP.deterministic([[(s - 1) % 6, (s + 1) % 6] for s in range(6)])
        >>> goal_directed_empowerment(ring, horizon=2, goal=[0]).round(2)
        array([0., 0., 0., 1., 0., 0.])
        >>> goal_directed_empowerment(ring, horizon=2, goal=[0], slack=2).round(2)
        array([0.  , 1.  , 1.58, 1.58, 1.58, 1.  ])
    """
    check_table(mdp)
    horizon, slack = whole_number("horizon", horizon), whole_number("slack", slack)
    if mdp.is_stochastic or is_noisy(sensor):
        what = "table is stochastic" if mdp.is_stochastic else "sensor is noisy"
        raise ValueError(
            f"the {what}; goal-directed empowerment is defined without noise only: "
            "leave out the noise, or use another kind"
        )
    goals, starts = goal_states(mdp, goal), chosen_states(mdp, states)
    labels, _ = observations(mdp, sensor)
    next_state = mdp.next_state.copy()
    next_state[goals] = np.flatnonzero(goals)[:, None]
    distance = distances(next_state, goals)
    reach = np.minimum(distance[starts] + slack, horizon)
    reach[distance[starts] == _FAR] = 0
    slack = min(slack, int(distance[distance < _FAR].max()) + horizon)  # more forbids nothing
    bits, lengths = np.zeros(len(starts)), np.unique(reach[reach > 0]).tolist()
    gib = 4 * 8 * next_state.size * (slack + 1) / 2**30  # four tables at once while it is made
    check_memory(gib, -1, horizon, replace(method.limits, otherwise="give less slack"))
    with progress_bar("lengths", show_progress) as report:
        product = TabularMDP.deterministic(_with_slack(next_state, goals, distance, slack))
        seen = np.repeat(labels, slack + 1)
        for number, steps in enumerate(lengths):
            report(number, len(lengths))
            those = np.flatnonzero(reach == steps)
            nodes = starts[those] * (slack + 1) + slack
            some: Options = {"method": method, "show_progress": show_progress}
            bits[those] = empowerment(product, steps, seen, states=nodes, **some)
    return bits


def goal_states(mdp: TabularMDP, goal: ArrayLike | None) -> Bool[np.ndarray, "S"]:
    """The goal as a mask; by default the terminal states.

    Raises:
        ValueError: no state is one, or the table does not have it.
    """
    if goal is None:
        found = np.asarray(mdp.terminal)
        if not found.any():
            raise ValueError("the table has no terminal state; give goal=, some of its states")
        return found
    found = np.zeros(mdp.states, bool)
    found[chosen_states(mdp, goal, "goal")] = True
    if not found.any():
        raise ValueError("goal is empty; give at least one state")
    return found


def distances(
    next_state: Integer[np.ndarray, "S A"], goals: Bool[np.ndarray, "S"]
) -> Int64[np.ndarray, "S"]:
    """The least number of actions to a goal; `_FAR` where none leads there."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import dijkstra

    states = len(next_state)
    source, action = np.nonzero(next_state >= 0)
    ones = np.ones(len(source))
    backwards = csr_array((ones, (next_state[source, action], source)), (states, states))
    found = dijkstra(backwards, indices=np.flatnonzero(goals), unweighted=True, min_only=True)
    return np.where(np.isfinite(found), found, _FAR).astype(np.int64)


def _with_slack(
    next_state: Integer[np.ndarray, "S A"],
    goals: Bool[np.ndarray, "S"],
    distance: Int64[np.ndarray, "S"],
    slack: int,
) -> Int64[np.ndarray, "N A"]:
    """The table over states and what is left of the slack; -1 where a step uses more than that."""
    there = next_state >= 0
    used = 1 + distance[np.maximum(next_state, 0)] - distance[:, None]
    used[goals] = 0
    used[~there | (distance[:, None] == _FAR)] = _FAR
    left = np.arange(slack + 1)[None, :, None] - used[:, None, :]
    after = next_state[:, None, :].astype(np.int64) * (slack + 1) + left
    return np.where(left >= 0, after, -1).reshape(-1, next_state.shape[1])
