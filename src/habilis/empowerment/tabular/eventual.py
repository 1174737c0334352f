"""How long the sets of what h actions can reach may go on changing, read off the graph.

With enough actions, whether h of them lead from one state to another depends only on h modulo a
period: within a strongly connected component, whose cycles' lengths have the greatest common
divisor p, there are paths of every large enough length in the right residue class
modulo p. So a huge horizon
can be exchanged for a smaller one with exactly the same sets.
"""

from math import lcm

import numpy as np

from habilis.compiled import compiled, part
from habilis.empowerment.tabular.spreading import Graph

_LONGEST = 1 << 20  # periods above are not looked for


def same_horizon(graph: Graph, horizon: int) -> int:
    """A horizon, this or a smaller one, after which exactly the same sets are reached.

    Let d be the largest distances from a component's pivot and to it, added, p its period, and c a
    length from which on the pivot has closed walks of every length that p divides. Then there are
    walks between any two of the component's states of each right length from d + c on. A walk
    through several components takes at most one step from one to the next, and a walk longer
    than the sum, plus a period P = lcm(p, ...) each, can be made P shorter, or longer, in one of
    them.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    ones = np.ones(len(graph.index), np.int8)
    matrix = csr_array((ones, graph.index, graph.first), (graph.nodes,) * 2)
    _, component = connected_components(matrix, directed=True, connection="strong")
    component = component.astype(np.int32)
    around, periods = _components(
        graph.first, graph.index, graph.back_first, graph.back_index, component
    )
    period = lcm(*np.unique(periods[periods > 0]).tolist(), 1)
    if period > min(horizon, _LONGEST):
        return horizon
    lengths = np.where(periods > 0, around + period, 0) + 1
    last = int(_longest(graph.first, graph.index, component, lengths))
    return horizon if horizon <= last else last + (horizon - last) % period


@compiled()
def _components(first, index, back_first, back_index, component):
    """Of each component d + c, and its period; 0 where no state leads back to itself."""
    nodes = len(component)
    count = component.max() + 1
    around, periods = np.zeros(count, np.int64), np.zeros(count, np.int64)
    there, back = np.full(nodes, -1, np.int64), np.full(nodes, -1, np.int64)
    queue = np.empty(nodes, np.int32)
    # A state that leads to itself is the best pivot: from there on walks have every length.
    pivots, leads_to_itself = np.zeros(count, np.int64), np.zeros(count, np.bool_)
    for s in range(nodes):
        if not leads_to_itself[component[s]]:
            pivots[component[s]] = s
            for e in range(first[s], first[s + 1]):
                leads_to_itself[component[s]] |= index[e] == s
    for c in range(count):
        size = _search(back_first, back_index, component, pivots[c], back, queue)
        near = back[queue[size - 1]]
        _search(first, index, component, pivots[c], there, queue)
        far = there[queue[size - 1]]
        period, shortest = np.int64(0), np.int64(2**62)
        for k in range(size):
            s = queue[k]
            for e in range(first[s], first[s + 1]):
                t = index[e]
                if component[t] == c:  # a closed walk at the pivot over this edge
                    length = there[s] + 1 + back[t]
                    period, shortest = _divisor(period, length), min(shortest, length)
        if period > 0:
            periods[c] = period
            around[c] = far + near + _conductor(shortest, far + 1 + near, period)
    return around, periods


@part
def _search(first, index, component, pivot, distance, queue):
    """Distances from a pivot within its component, whose states fill the queue: how many."""
    distance[pivot] = 0
    queue[0] = pivot
    size, k = 1, 0
    while k < size:
        s = queue[k]
        k += 1
        for e in range(first[s], first[s + 1]):
            t = index[e]
            if component[t] == component[pivot] and distance[t] < 0:
                distance[t] = distance[s] + 1
                queue[size] = t
                size += 1
    return size


@part
def _divisor(a, b):
    while b:
        a, b = b, a % b
    return a


@part
def _conductor(shortest, longest, divisor):
    """From where on sums of lengths up to `longest`, of which one is `shortest`, are all there.

    Numbers with greatest common divisor one, the least of which is a and the largest b, have
    every sum from (a - 1)(b - 1) on (Schur; Brauer 1942).
    """
    a, b = shortest // divisor, longest // divisor
    return max(a - 1, 0) * max(b - 1, 0) * divisor


@compiled()
def _longest(first, index, component, lengths):
    """The largest sum of lengths along a path from component to component."""
    nodes, count = len(component), len(lengths)
    members = np.zeros(count + 1, np.int64)
    entering = np.zeros(count, np.int64)
    for s in range(nodes):
        members[component[s] + 1] += 1
        for e in range(first[s], first[s + 1]):
            if component[index[e]] != component[s]:
                entering[component[index[e]]] += 1
    members[1:] = np.cumsum(members[1:])
    filled = members[:-1].copy()
    order = np.empty(nodes, np.int32)
    for s in range(nodes):
        order[filled[component[s]]] = s
        filled[component[s]] += 1
    total = lengths.copy()
    ready = [c for c in range(count) if entering[c] == 0]
    most = np.int64(0)
    while len(ready) > 0:
        c = ready.pop()
        most = max(most, total[c])
        for k in range(members[c], members[c + 1]):
            s = order[k]
            for e in range(first[s], first[s + 1]):
                d = component[index[e]]
                if d != c:
                    total[d] = max(total[d], total[c] + lengths[d])
                    entering[d] -= 1
                    if entering[d] == 0:
                        ready.append(d)
    return most
