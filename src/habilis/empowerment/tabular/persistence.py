"""Persistence: the empowerment that remains as the horizon grows without bound.

States that can be reached from each other form a component, and the components of a table have an
order: who leaves one never comes back to it. So the agent ends up in one of them for ever.
"""

import numpy as np
from jaxtyping import Float64, Int32, Int64, Integer
from numpy.typing import ArrayLike
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from habilis.compiled import compiled
from habilis.empowerment.arguments import Unit, chosen_actions, chosen_states, per_bit
from habilis.empowerment.combined import combined
from habilis.empowerment.sensors import Sensor, is_noisy, observations
from habilis.mdp import TabularMDP
from habilis.models.explore import AnyModel
from habilis.progress import progress_bar
from habilis.worlds.table import whole_table


def persistence(
    model: AnyModel,
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
        model: a deterministic table; or any other model, which is explored whole.
        sensor: a factor's name, "state", or int[S] labels; or several names, of whose values it is
            the sum or the product, as in `empowerment`.
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
    mdp = whole_table(model, show_progress)
    starts = chosen_states(mdp, states)
    table = _certain_table(mdp, sensor, actions)
    with progress_bar("components", show_progress):
        component = _components(table)
        closed = np.argsort(component, kind="stable")

    def through(one: Sensor) -> Float64[np.ndarray, "n"]:
        labels, label_count = observations(mdp, one)
        most = _most_in_reach(table, labels, label_count, component, closed)
        return np.log2(most[component[starts]]) * scale

    return combined(mdp, sensor, through)


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


def _components(table: Int32[np.ndarray, "S A"]) -> Int32[np.ndarray, "S"]:
    """The strongly connected component of each state.

    Returns:
        Their numbers from 0 up, in reverse topological order: actions lead to a state's own
        component and to components of lower numbers.
    """
    states, actions = table.shape
    rows = np.arange(0, table.size + 1, actions)
    graph = csr_array((np.ones(table.size, np.int8), table.ravel(), rows), (states, states))
    _, component = connected_components(graph, connection="strong")
    assert (component[table] <= component[:, None]).all(), (
        "SciPy numbers components as it closes them"
    )
    return component


@compiled(lambda table, *rest: table.size)
def _most_in_reach(
    table: Int32[np.ndarray, "S A"],
    labels: Int32[np.ndarray, "S"],
    label_count: int,
    component: Int32[np.ndarray, "S"],
    closed: Integer[np.ndarray, "S"],
) -> Int64[np.ndarray, "components"]:
    """For each component the most observations in one that it leads to, itself among them.

    `closed` lists the states component by component.
    """
    components = component[closed[-1]] + 1
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
