"""What is left of empowerment as the horizon grows: what can be reached again and again.

States that can be reached from each other form a component, and the components of a table have an
order: who leaves one never comes back to it. So the agent ends up in one of them for ever.
"""

import numpy as np
from jaxtyping import Float64, Int32, Int64
from numpy.typing import ArrayLike

from habilis.compiled import compiled
from habilis.empowerment.arguments import Unit, chosen_actions, chosen_states, per_bit
from habilis.empowerment.sensors import Sensor, is_noisy, observations
from habilis.mdp import TabularMDP
from habilis.progress import progress_bar
from habilis.worlds.table import tabulate
from habilis.worlds.world import World


def persistence(
    mdp: TabularMDP | World,
    sensor: Sensor = "object",
    actions: ArrayLike | None = None,
    states: ArrayLike | None = None,
    *,
    unit: Unit = "bits",
    show_progress: bool = False,
) -> Float64[np.ndarray, "n"]:
    """How many observations the agent can reach again and again, in bits.

    The measure is ours, what is left of empowerment as h grows without bound:

        P(s) = max over C of log2 |{o(t) : t in C}|

    where C are the strongly connected components of the table that can be reached from s, and
    o(t) is what the sensor shows in t; only available actions lead anywhere. It is at most log2 of
    all observations that can be reached from s, some of which can be reached only once. Where C
    holds a state in which some action changes nothing, or its cycles have for another reason no
    common divisor but 1, empowerment is not less for any horizon that is long enough; otherwise so
    many observations are there in as many horizons, one after the other, as that divisor says.

    Args:
        mdp: a deterministic table, or a world, which is tabulated.
        sensor: a factor's name, "state", or int[S] labels.
        actions: the action indices that the agent may use; by default all.
        states: the n states asked about, as indices or as bool[S]; by default all, in order.
        unit: "bits" or "nats".
        show_progress: whether to draw a progress bar on standard error.

    Returns:
        float64[n], 0 where the agent is left with a single observation.

    Raises:
        ValueError: the table is stochastic or the sensor noisy, or as in `empowerment`.

    Example:
        >>> line = TabularMDP.deterministic([[0, 1], [1, 2], [3, 2], [2, 3], [4, 0]])
        >>> persistence(line, "state")
        array([1., 1., 1., 1., 1.])
        >>> persistence(line, "state", actions=[0])
        array([0., 0., 1., 1., 0.])
    """
    scale = per_bit(unit)
    if isinstance(mdp, World):
        mdp = tabulate(mdp, show_progress=show_progress)
    table = _certain_table(mdp, sensor, actions)
    labels, label_count = observations(mdp, sensor)
    starts = chosen_states(mdp, states)
    with progress_bar("components", show_progress):
        component, closed = _components(table, starts.astype(np.int32))
        most = _most_in_reach(table, labels, label_count, component, closed)
    return np.log2(most[component[starts]]) * scale


def _certain_table(
    mdp: TabularMDP, sensor: Sensor, actions: ArrayLike | None
) -> Int32[np.ndarray, "S A"]:
    """Where the chosen actions lead, if they lead to one state each.

    Raises:
        ValueError: the table is stochastic or the sensor noisy, or there are no such actions.
    """
    used = chosen_actions(mdp, actions)
    if mdp.is_stochastic:
        raise ValueError(
            "this table is stochastic, and persistence is defined for deterministic tables only; "
            "leave out slip, that of the world's tool too"
        )
    if is_noisy(sensor):
        raise ValueError("the sensor is noisy; give a factor's name, 'state' or int[S] labels")
    table = mdp.next_state
    if len(used) < mdp.action_count:
        table = np.ascontiguousarray(table[:, used])
    if table.min() >= 0:
        return table
    # To stay where one is changes neither what can be reached nor the components.
    return np.where(table < 0, np.arange(mdp.states, dtype=np.int32)[:, None], table)


@compiled
def _components(
    table: Int32[np.ndarray, "S A"], starts: Int32[np.ndarray, "n"]
) -> tuple[Int32[np.ndarray, "S"], Int32[np.ndarray, "reached"]]:
    """The strongly connected components of what can be reached (Tarjan 1972).

    Returns:
        For each state its component, -1 where it cannot be reached. They are numbered as they are
        closed: actions lead to a component's own states and to components of lower numbers. And
        the states reached, component by component in that order.
    """
    states, actions = table.shape
    component = np.full(states, -1, np.int32)
    met = np.full(states, -1, np.int32)  # when the state was first met
    earliest = np.empty(states, np.int32)  # of those met that it leads back to
    following = np.zeros(states, np.int32)  # the action to be followed next
    path, waiting = np.empty(states, np.int32), np.empty(states, np.int32)
    closed = np.empty(states, np.int32)
    time = components = waits = done = 0
    for start in starts:
        if met[start] >= 0:
            continue
        path[0], depth = start, 1
        while depth:
            s = path[depth - 1]
            if met[s] < 0:
                met[s] = earliest[s] = time
                time += 1
                waiting[waits] = s
                waits += 1
            if following[s] < actions:
                t = table[s, following[s]]
                following[s] += 1
                if met[t] < 0:
                    path[depth] = t
                    depth += 1
                elif component[t] < 0:
                    earliest[s] = min(earliest[s], met[t])
                continue
            depth -= 1
            if depth:
                before = path[depth - 1]
                earliest[before] = min(earliest[before], earliest[s])
            if earliest[s] == met[s]:
                while component[s] < 0:
                    waits -= 1
                    component[waiting[waits]] = components
                    closed[done] = waiting[waits]
                    done += 1
                components += 1
    return component, closed[:done]


@compiled
def _most_in_reach(
    table: Int32[np.ndarray, "S A"],
    labels: Int32[np.ndarray, "S"],
    label_count: int,
    component: Int32[np.ndarray, "S"],
    closed: Int32[np.ndarray, "reached"],
) -> Int64[np.ndarray, "components"]:
    """For each component the most observations in one that it leads to, itself among them."""
    components = component[closed[-1]] + 1 if len(closed) else 0
    own, beyond = np.zeros(components, np.int64), np.zeros(components, np.int64)
    counted_for = np.full(label_count, -1, np.int32)
    for s in closed:
        c = component[s]
        if counted_for[labels[s]] != c:
            counted_for[labels[s]] = c
            own[c] += 1
        for a in range(table.shape[1]):
            other = component[table[s, a]]
            if other != c:  # closed before: what it leads to is known
                beyond[c] = max(beyond[c], own[other], beyond[other])
    return np.maximum(own, beyond)
