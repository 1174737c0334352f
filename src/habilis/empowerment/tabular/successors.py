"""The transitions of a table as flat arrays, and the part of them around one state."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float64, Int32, Int64

from habilis.compiled import compile_now, compiled, part, paths
from habilis.mdp_arguments import UNAVAILABLE

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_SCATTER = 0x9E3779B1  # spreads the numbers of states


@dataclass(frozen=True)
class Successors:
    """The transitions under the chosen actions, as flat arrays for the kernels.

    Row `s * A + a` of a sparse matrix: `state[first[row]:first[row + 1]]` are the next states,
    none where the action is not available. `seen`, if given, is sparse float64[S * A, O]: what is
    observed if the action is the last one (see `outcomes`).
    """

    first: Int64[np.ndarray, "rows_and_one"]
    state: Int32[np.ndarray, "entries"]
    probability: Float64[np.ndarray, "entries"]
    actions: int
    seen: "csr_array | None" = None

    @property
    def states(self) -> int:
        """S, how many states there are."""
        return (len(self.first) - 1) // self.actions

    @cached_property
    def always_available(self) -> bool:
        """Whether every action is available in every state."""
        return bool((np.diff(self.first) > 0).all())

    @cached_property
    def certain(self) -> bool:
        """Whether no action has several outcomes."""
        if len(self.state) == len(self.first) - 1 and self.always_available:
            return True
        return bool((np.diff(self.first) <= 1).all())

    @cached_property
    def next_state(self) -> Int32[np.ndarray, "S A"]:
        """Where actions lead if they are certain, -1 where they are not available."""
        if self.always_available:
            return self.state.reshape(-1, self.actions)
        table = np.full(len(self.first) - 1, UNAVAILABLE, np.int32)
        table[np.diff(self.first) > 0] = self.state
        return table.reshape(-1, self.actions)


def states_within(
    successors: Successors, start: int, horizon: int
) -> Float64[np.ndarray, "horizons"]:
    """How many states 0, 1, ... h actions can touch, float64[h + 1]."""
    first, state, actions = successors.first, successors.state, successors.actions
    return _near(first, state, actions, start, horizon)[1].astype(np.float64)


def compile_around() -> None:
    """Leaves out the time as plain Python: what follows is timed."""
    compile_now(_near, _local)


def around(
    successors: Successors, start: int, horizon: int
) -> tuple[Int32[np.ndarray, "N"], Successors]:
    """The states within h actions of a start (the start first), and the transitions among them."""
    first, state, actions = successors.first, successors.state, successors.actions
    near, counts, slots = _near(first, state, actions, start, horizon)
    # States on the rim are never left within the horizon: they need no successors.
    inner = int(counts[horizon - 1]) if horizon else 0
    local = _local(first, state, successors.probability, actions, near, inner, slots)
    return near, Successors(*local, actions)


def _few_steps(first, state, actions, start, horizon):
    outcomes = len(state) * actions / (len(first) - 1)
    return min(len(state), paths(outcomes, horizon))


@compiled(_few_steps)
def _near(first, state, actions, start, horizon):
    """The states within h actions, how many after 0, 1, ... of them, and their places by a hash."""
    near = np.empty(16, np.int32)
    slots = np.zeros(32, np.int32)  # one more than a place
    near[0], count = start, 1
    slots[_slot(slots, near, near[0])] = 1
    counts = np.empty(horizon + 1, np.int64)
    counts[0] = 1
    begin = 0
    for t in range(horizon):
        end = count
        for i in range(begin, end):
            for k in range(first[near[i] * actions], first[(near[i] + 1) * actions]):
                slot = _slot(slots, near, state[k])
                if slots[slot] > 0:
                    continue
                if count == len(near):
                    longer, slots = np.empty(2 * count, np.int32), np.zeros(4 * count, np.int32)
                    for place in range(count):
                        longer[place] = near[place]
                        slots[_slot(slots, longer, near[place])] = place + 1
                    near = longer
                    slot = _slot(slots, near, state[k])
                near[count] = state[k]
                count += 1
                slots[slot] = count
        begin = end
        counts[t + 1] = count
    return near[:count].copy(), counts, slots


@part
def _slot(slots, near, state):
    """The slot of a state, or the free slot where it belongs."""
    mask = len(slots) - 1
    slot = (np.int64(state) * _SCATTER >> 15) & mask
    while slots[slot] > 0 and near[slots[slot] - 1] != state:
        slot = (slot + 1) & mask
    return slot


def _few_transitions(first, state, probability, actions, near, inner, slots):
    outcomes = len(state) * actions / (len(first) - 1)
    return 2 * len(near) * actions + 6 * inner * outcomes


@compiled(_few_transitions)
def _local(first, state, probability, actions, near, inner, slots):
    """The transitions of the first `inner` states among all that are near, by their places."""
    entries = 0
    for i in range(inner):
        entries += first[(near[i] + 1) * actions] - first[near[i] * actions]
    local_first = np.zeros(len(near) * actions + 1, np.int64)
    local_state = np.empty(entries, np.int32)
    local_probability = np.empty(entries, np.float64)
    filled = 0
    for i in range(len(near)):
        for a in range(actions):
            if i < inner:
                row = near[i] * actions + a
                for k in range(first[row], first[row + 1]):
                    local_state[filled] = slots[_slot(slots, near, state[k])] - 1
                    local_probability[filled] = probability[k]
                    filled += 1
            local_first[i * actions + a + 1] = filled
    return local_first, local_state, local_probability
