"""Tables of environments that carry their own, as Gymnasium's toy-text environments do.

`P[state][action]` is a list of (probability, next state, reward, terminated).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Int32

from habilis.mdp import TabularMDP

Factors = dict[str, Int32[np.ndarray, "S"]]


def table_of_dict(env: Any) -> TabularMDP:
    """The table of an environment from its `P`.

    A state is terminal where some transition into it ends the episode. Its own transitions stay
    those of `P`.

    Raises:
        ValueError: P does not have one distribution for each state and action, or the environment
            does more than P says.
    """
    from scipy.sparse import csr_array

    if getattr(env, "fickle_passenger", False):
        raise ValueError(
            "this Taxi's passengers change their minds, which its P does not say; "
            "make it with fickle_passenger=False"
        )
    states, actions = int(env.observation_space.n), int(env.action_space.n)
    entries = []
    for state in range(states):
        for action in range(actions):
            try:
                outcomes = env.P[state][action]
            except (KeyError, IndexError):
                raise ValueError(
                    f"P has no action {action} in state {state}; "
                    f"give all of {states} states and {actions} actions"
                ) from None
            entries += [(state, action, *outcome) for outcome in outcomes]
    state, action, chance, after, reward, ended = (np.array(c) for c in zip(*entries, strict=True))
    outside = after[(after < 0) | (after >= states)]
    if len(outside):
        raise ValueError(f"P leads to state {outside[0]}; use states 0 to {states - 1}")
    P = [
        csr_array((chance[action == a], (state[action == a], after[action == a])), (states,) * 2)
        for a in range(actions)
    ]
    mean_reward = np.zeros((states, actions))
    np.add.at(mean_reward, (state, action), chance * reward)
    terminal = np.zeros(states, bool)
    terminal[after[ended.astype(bool) & (chance > 0)]] = True
    begins = getattr(env, "initial_state_distrib", None)
    start = 0 if begins is None else int(np.argmax(begins))
    mdp = TabularMDP.stochastic(P, mean_reward, terminal, start)
    known = _KNOWN.get(type(env).__name__)
    if known is None:
        return mdp
    return replace(
        mdp, factors=known.factors(env, states), actions=known.actions, shape=known.shape(env)
    )


@dataclass(frozen=True)
class _Known:
    """What a table does not say of a toy-text environment."""

    actions: tuple[str, ...]
    factors: Callable[[Any, int], Factors]
    shape: Callable[[Any], tuple[int, int] | None]


def _agent(env: Any, states: int) -> Factors:
    """One thing on a grid whose state is its cell, row by row."""
    return {"agent": np.arange(states, dtype=np.int32)}


def _taxi(env: Any, states: int) -> Factors:
    """Where the taxi is (row * 5 + column), the passenger (4: in the taxi), and wants to go."""
    row, column, passenger, destination = np.array([list(env.decode(s)) for s in range(states)]).T
    factors = {"taxi": row * 5 + column, "passenger": passenger, "destination": destination}
    return {name: labels.astype(np.int32) for name, labels in factors.items()}


_KNOWN = {
    "FrozenLakeEnv": _Known(
        ("left", "down", "right", "up"), _agent, lambda env: (env.nrow, env.ncol)
    ),
    "CliffWalkingEnv": _Known(("up", "right", "down", "left"), _agent, lambda env: env.shape),
    "TaxiEnv": _Known(
        ("south", "north", "east", "west", "pick up", "drop off"), _taxi, lambda env: None
    ),
}
