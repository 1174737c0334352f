"""The occupancy of a policy: where an agent is after each of its first T actions.

With P the transition matrix under the policy, the distributions over states are the rows

    d_0 = the start,    d_t = d_(t-1) P,    t = 1 ... T,

of which every measure of visited states is made. What an agent visits over T steps is a state at a
time drawn uniformly, with the distribution (d_1 + ... + d_T) / T: the mixture.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from jaxtyping import Float64
from numpy.typing import ArrayLike

from habilis.empowerment.arguments import at_least_one, checked_policy, chosen_states
from habilis.empowerment.combined import check_single
from habilis.empowerment.initial_beliefs import are_beliefs
from habilis.empowerment.one_step import moves_of
from habilis.empowerment.sensors import Sensor, is_by_action, observation_probabilities
from habilis.mdp import TabularMDP
from habilis.probabilities import as_array, is_sparse, row_stochastic, shape_of

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Policy = ArrayLike | Literal["uniform"]

_BLOCK = 16_000_000  # numbers of the distributions that are worked on at once
_MOST = 2**30  # numbers that are given back at once


def occupancy(
    mdp: TabularMDP,
    policy: Policy,
    steps: int,
    states: Any = None,
    *,
    absorbing: bool = False,
) -> Float64[np.ndarray, "n T S"]:
    """The probability of each state after each of the first T actions of a policy.

        P(S_t = s),   t = 1 ... T

    Args:
        mdp: a table with an action in every state.
        policy: float[S, A], the probabilities of actions in each state, as `run.policy()` gives
            those of a trained agent; or "uniform", over the available ones.
        steps: T, how many actions, 1 or more.
        states: the n states to begin in, as indices or as bool[S], or distributions over them,
            float[n, S]; by default `mdp.start` alone.
        absorbing: whether the agent stays in a terminal state that it has come to. By default the
            dynamics go on there, as they do for empowerment.

    Returns:
        float64[n, T, S]; every [n, t] sums to 1.

    Raises:
        ValueError: a policy that is not one distribution over available actions a state, no steps,
            a state that the MDP does not have, or more than 8 GiB of probabilities.

    Example:
        >>> ring = TabularMDP.deterministic([[(s - 1) % 4, (s + 1) % 4] for s in range(4)])
        >>> occupancy(ring, "uniform", steps=2)
        array([[[0. , 0.5, 0. , 0.5],
                [0.5, 0. , 0.5, 0. ]]])
    """
    steps = at_least_one("steps", steps)
    back, starts = steps_back(mdp, policy, absorbing), starts_of(mdp, states)
    size = shape_of(starts)[0] * steps * mdp.states
    if size > _MOST:
        raise ValueError(
            f"occupancy has {size:,} probabilities, above {_MOST:,}; give fewer states or steps"
        )
    found = np.zeros((shape_of(starts)[0], steps, mdp.states))
    for t, occupied in enumerate(walk(back, starts.toarray().T, steps)):
        found[:, t] = occupied.T
    return found


def steps_back(
    mdp: TabularMDP, policy: Policy, absorbing: bool = False, name: str = "policy"
) -> "csr_array":
    """The transposed transition matrix under a policy, sparse float64[S, S].

    Args:
        mdp, policy, absorbing: as in `occupancy`.
        name: what errors call the policy.

    Raises:
        ValueError: as in `occupancy`.
    """
    from scipy.sparse import csr_array, diags_array

    chosen = checked_policy(mdp, policy, name)
    states, actions = chosen.shape
    first = np.arange(0, states * actions + 1, actions)
    choice = csr_array((chosen.ravel(), np.arange(states * actions), first))
    under: Any = choice @ moves_of(mdp.transitions)
    if absorbing:
        ends = mdp.terminal.astype(np.float64)
        under = diags_array(1 - ends) @ under + diags_array(ends)
    back = csr_array(under.T.tocsr())
    back.eliminate_zeros()
    return back


def starts_of(mdp: TabularMDP, states: Any) -> "csr_array":
    """The distributions over states to begin with, sparse float64[n, S].

    Raises:
        ValueError: as in `occupancy`.
    """
    from scipy.sparse import csr_array

    if states is not None and are_beliefs(states):
        given: Any = states if is_sparse(states) else as_array("states", states)
        if given.shape[1] != mdp.states:
            raise ValueError(
                f"states has shape {given.shape}; as distributions give one probability for each "
                f"of the {mdp.states} states"
            )
        return row_stochastic("states", given, "distribution {}", "distributions")
    chosen = chosen_states(mdp, [mdp.start] if states is None else states)
    count = len(chosen)
    return csr_array((np.ones(count), chosen, np.arange(count + 1)), (count, mdp.states))


def walk(
    back: "csr_array", occupied: Float64[np.ndarray, "S n"], steps: int
) -> Iterator[Float64[np.ndarray, "S n"]]:
    """The distributions after each step, a column for each start."""
    for _ in range(steps):
        occupied = np.asarray(back @ occupied)
        yield occupied


def some_at_a_time(starts: "csr_array") -> Iterator[Float64[np.ndarray, "S k"]]:
    """The starts as columns, so many at once as memory allows."""
    count, states = shape_of(starts)
    width = max(_BLOCK // states, 1)
    for first in range(0, count, width):
        yield np.ascontiguousarray(starts[first : first + width].toarray().T)


def mixtures(
    back: "csr_array", starts: "csr_array", seen: "csr_array", steps: int
) -> Float64[np.ndarray, "O n"]:
    """The mixture over time of what is observed, a column for each start.

    Args:
        back: as of `steps_back`.
        starts: as of `starts_of`.
        seen: float64[S, O], the probabilities of observations.
        steps: T.
    """
    shown = seen.T.tocsr()
    found = [np.zeros((shape_of(shown)[0], 0))]
    for occupied in some_at_a_time(starts):
        total = np.zeros_like(occupied)
        for one in walk(back, occupied, steps):
            total += one
        found.append(np.asarray(shown @ total) / steps)
    return np.concatenate(found, axis=1)


def seen_in_states(mdp: TabularMDP, sensor: Sensor) -> "csr_array":
    """The probabilities of what a single sensor shows in each state, float64[S, O].

    Raises:
        ValueError: several sensors, one that depends on the last action, or as in `empowerment`.
    """
    check_single(mdp, sensor)
    if is_by_action(sensor):
        raise ValueError(
            "the sensor depends on the last action, and visited states have none; give labels or "
            "float[S, O]"
        )
    return observation_probabilities(mdp, sensor)
