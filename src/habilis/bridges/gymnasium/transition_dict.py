"""Tables of environments that carry their own, as Gymnasium's toy-text environments do.

`P[state][action]` is a list of (probability, next state, reward, terminated).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Bool, Float32, Float64, Int32, Int64

from habilis.mdp import TabularMDP

Factors = dict[str, Int32[np.ndarray, "S"]]

_OUTCOME = "(probability, next state, reward, terminated)"


def has_table(inner: Any) -> bool:
    """Whether an environment has lists `P[state][action]`; all else of this name is no table."""
    first = getattr(inner, "P", None)
    for _ in range(2):
        if not isinstance(first, Mapping | list | tuple) or not len(first):
            return False
        first = next(iter(first.values())) if isinstance(first, Mapping) else first[0]
    return isinstance(first, list | tuple) and all(isinstance(one, list | tuple) for one in first)


@dataclass(frozen=True)
class Outcomes:
    """The outcomes in a `P`, as flat arrays of one entry an outcome.

    Attributes:
        state, action: int64[N], of which transition it is an outcome.
        probability, reward: float64[N].
        after: int64[N], the next state.
        ended: bool[N], whether the episode ends.
        states, actions: how many there are.
    """

    state: Int64[np.ndarray, "N"]
    action: Int64[np.ndarray, "N"]
    probability: Float64[np.ndarray, "N"]
    after: Int64[np.ndarray, "N"]
    reward: Float64[np.ndarray, "N"]
    ended: Bool[np.ndarray, "N"]
    states: int
    actions: int

    @classmethod
    def of(cls, P: Any, actions: int) -> "Outcomes":
        """The outcomes in a `P`.

        Raises:
            ValueError: it has not one list of outcomes for each state and action.
        """
        states = len(P)
        rows = [_rows(P, state, action) for state in range(states) for action in range(actions)]
        counts = [len(row) for row in rows]
        if not sum(counts):
            raise ValueError(f"P lists no outcome at all; give P[state][action] = [{_OUTCOME}]")
        place = np.repeat(np.arange(states * actions), counts)
        flat = [outcome for row in rows for outcome in row]
        probability, after, reward, ended = (np.array(column) for column in zip(*flat, strict=True))
        negative = np.flatnonzero(~((probability >= 0) & (probability < np.inf)))
        if len(negative):
            at, wrong = divmod(int(place[negative[0]]), actions), probability[negative[0]]
            raise ValueError(f"P[{at[0]}][{at[1]}] has probability {wrong:g}; give 0 to 1")
        outside = np.flatnonzero((after < 0) | (after >= states))
        if len(outside):
            raise ValueError(f"P leads to state {after[outside[0]]}; use states 0 to {states - 1}")
        state, action = np.divmod(place, actions)
        return cls(state, action, probability, after, reward, ended.astype(bool), states, actions)


def _rows(P: Any, state: int, action: int) -> list[tuple[float, int, float, bool]]:
    try:
        listed = list(P[state][action])
    except (KeyError, IndexError, TypeError):
        raise ValueError(
            f"P has no list of outcomes for state {state} and action {action}; give "
            f"P[state][action] = [{_OUTCOME}] for each, or state=(save, load) if P is not a table"
        ) from None
    try:
        return [(float(p), _whole(after), float(r), bool(end)) for p, after, r, end in listed]
    except (OverflowError, TypeError, ValueError):
        raise ValueError(
            f"P[{state}][{action}] is {str(listed)[:80]}; give a list of {_OUTCOME}"
        ) from None


def _whole(value: Any) -> int:
    if int(value) != value:
        raise ValueError("not a whole number")
    return int(value)


@dataclass(frozen=True)
class Listed:
    """The table of a `P`.

    Attributes:
        mdp: the table. A state in which episodes end, and which is also reached without an end,
            is there twice: its twin, after all others, is the ended one.
        rewards: by state, action, next state (of the table), the rewards listed.
        twin: the state of the table for each state of P where an episode has ended.
    """

    mdp: TabularMDP
    rewards: Mapping[tuple[int, int, int], set[float]]
    twin: Int64[np.ndarray, "P"]


def listed_table(inner: Any, actions: int, max_states: int, begun: int | None) -> Listed:
    """The table of an environment from its `P`.

    Args:
        inner: the (unwrapped) environment.
        actions: how many it has.
        max_states: how many states to accept.
        begun: the row in which a reset began an episode, if that can be seen.

    A state is terminal where some transition into it ends the episode. Its own transitions stay
    those of `P`.

    Raises:
        ValueError: P does not have one distribution for each state and action, or the environment
            does more than P says.
    """
    if len(inner.P) > max_states:
        raise ValueError(
            f"the table P has {len(inner.P):,} states, more than {max_states:,}; raise max_states"
        )
    if getattr(inner, "fickle_passenger", False):
        raise ValueError(
            "this Taxi's passengers change their minds, which its P does not model; "
            "make it with fickle_passenger=False"
        )
    found = Outcomes.of(inner.P, actions)
    begins = np.asarray(getattr(inner, "initial_state_distrib", 0))
    here = 0 if begun is None or not 0 <= begun < found.states else begun
    if begins.shape != (found.states,) or not begins[here] > 0:
        begins = np.arange(found.states) == here
    twin = _twins(found, np.flatnonzero(begins))
    after = np.where(found.ended, twin[found.after], found.after)
    mdp = replace(
        _mdp(found, after, twin, int(np.argmax(begins))), **_known(inner, found.states, twin)
    )
    rewards: dict[tuple[int, int, int], set[float]] = {}
    for i in np.flatnonzero(found.probability > 0):
        key = int(found.state[i]), int(found.action[i]), int(after[i])
        rewards.setdefault(key, set()).add(float(found.reward[i]))
    return Listed(mdp, rewards, twin)


def _twins(found: Outcomes, starts: Int64[np.ndarray, "n"]) -> Int64[np.ndarray, "P"]:
    """For each state, itself or, where it is reached with and without an end, one state more."""
    possible = found.probability > 0
    going_on = np.zeros(found.states, bool)
    going_on[starts] = True
    while True:
        steps = possible & going_on[found.state]
        reached = going_on.copy()
        reached[found.after[steps & ~found.ended]] = True
        if (reached == going_on).all():
            break
        going_on = reached
    ended = np.zeros(found.states, bool)
    ended[found.after[steps & found.ended]] = True
    both = np.flatnonzero(going_on & ended)
    twin = np.arange(found.states)
    twin[both] = found.states + np.arange(len(both))
    return twin


def _mdp(
    found: Outcomes, after: Int64[np.ndarray, "N"], twin: Int64[np.ndarray, "P"], start: int
) -> TabularMDP:
    from scipy.sparse import csr_array

    twins = np.arange(found.states, int(twin.max()) + 1)
    states = found.states + len(twins)
    matrices = []
    for action in range(found.actions):
        of_it = found.action == action
        rows = np.append(found.state[of_it], twins)
        columns = np.append(after[of_it], twins)
        entries = np.append(found.probability[of_it], np.ones(len(twins)))
        matrices.append(csr_array((entries, (rows, columns)), (states, states)))
    reward = np.zeros((states, found.actions))
    np.add.at(reward, (found.state, found.action), found.probability * found.reward)
    terminal = np.zeros(states, bool)
    terminal[after[found.ended & (found.probability > 0)]] = True
    mdp = TabularMDP.stochastic(matrices, reward, terminal, start)
    return replace(mdp, entry_reward=_entry_rewards(found, after, states))


def _entry_rewards(
    found: Outcomes, after: Int64[np.ndarray, "N"], states: int
) -> Float32[np.ndarray, "S"]:
    """The reward listed with each state, of several the largest.

    The loops that P has after the end of an episode earn 0, beside what its end has earned.
    """
    order = np.argsort(np.abs(found.reward), kind="stable")
    order = order[found.probability[order] > 0]
    reward = np.zeros(states, np.float32)
    reward[after[order]] = found.reward[order]
    return reward


@dataclass(frozen=True)
class _Known:
    """What is known of a toy-text environment besides its table."""

    actions: tuple[str, ...]
    factors: Callable[[Any, int], Factors]
    shape: Callable[[Any], tuple[int, int] | None]


def _known(inner: Any, states: int, twin: Int64[np.ndarray, "P"]) -> dict[str, Any]:
    """Factors, names of actions and shape of an environment built like one of toy-text's."""
    names = [cls.__name__ for cls in type(inner).__mro__]
    known = next((_KNOWN[name] for name in names if name in _KNOWN), None)
    if known is None or int(inner.action_space.n) != len(known.actions):
        return {}
    try:
        factors, shape = known.factors(inner, states), known.shape(inner)
    except (AttributeError, TypeError, ValueError):  # of the same name, but built otherwise
        return {}
    if shape is not None and shape[0] * shape[1] != states:
        return {}
    original = np.append(np.arange(states), np.flatnonzero(twin >= states))
    labels = {name: values[original] for name, values in factors.items()}
    return {"factors": labels, "actions": known.actions, "shape": shape}


def _agent(env: Any, states: int) -> Factors:
    """One thing on a grid whose state is its cell, row by row."""
    return {"agent": np.arange(states, dtype=np.int32)}


def _taxi(env: Any, states: int) -> Factors:
    """Where the taxi is (row * columns + column), the passenger (4: in the taxi), and its goal."""
    row, column, passenger, destination = np.array([list(env.decode(s)) for s in range(states)]).T
    cell = row * (column.max() + 1) + column
    factors = {"taxi": cell, "passenger": passenger, "destination": destination}
    return {name: labels.astype(np.int32) for name, labels in factors.items()}


def _cells(env: Any) -> tuple[int, int]:
    rows, columns = env.shape if hasattr(env, "shape") else (env.nrow, env.ncol)
    return int(rows), int(columns)


_KNOWN = {
    "FrozenLakeEnv": _Known(("left", "down", "right", "up"), _agent, _cells),
    "CliffWalkingEnv": _Known(("up", "right", "down", "left"), _agent, _cells),
    "TaxiEnv": _Known(
        ("south", "north", "east", "west", "pick up", "drop off"), _taxi, lambda env: None
    ),
}
