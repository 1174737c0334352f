"""Whether a bonus in the reward changes the optimal policy: exactly, without training."""

import numpy as np
from jaxtyping import Float, Int

from habilis.mdp import TabularMDP

_DOUBLINGS = 20  # a million steps: what comes later is discounted to nothing


def return_of_the_best_policy(
    mdp: TabularMDP, values: Float[np.ndarray, "S"], beta: float, discount: float
) -> float:
    """The extrinsic return of the policy that is best for `r + beta * M[s']`.

    By policy iteration, that is the policy which is greedy for its own

        V(s) = r(s, a) + beta * M[s'] + discount * V(s'),      V = 0 if terminal

    An agent that has learned all there is to learn from the regularised reward gets this return.

    Args:
        mdp: a deterministic table.
        values: M, in bits.
        beta: its weight.
        discount: below 1.

    Returns:
        Undiscounted and extrinsic, from the table's start; minus infinity if that policy never
        comes to a terminal state.
    """
    reached = np.where(mdp.terminal[:, None], np.arange(mdp.states)[:, None], mdp.next_state)
    reward = mdp.reward + beta * values[reached]
    reward = np.where(mdp.terminal[:, None], 0.0, reward)
    everywhere = np.arange(mdp.states)
    policy = np.zeros(mdp.states, int)
    while True:
        value = _sums(reached[everywhere, policy], reward[everywhere, policy], discount)
        q = reward + discount * value[reached]
        better = q.max(axis=1) > q[everywhere, policy] + 1e-9
        if not better.any():
            break
        policy = np.where(better, q.argmax(axis=1), policy)
    state, total = mdp.start, 0.0
    for _ in range(mdp.states):
        total += float(mdp.reward[state, policy[state]])
        state = int(reached[state, policy[state]])
        if mdp.terminal[state]:
            return total
    return -np.inf


def _sums(
    reached: Int[np.ndarray, "S"], reward: Float[np.ndarray, "S"], discount: float
) -> Float[np.ndarray, "S"]:
    """Discounted sums of rewards where every state has one successor: of 1, 2, 4, ... steps."""
    sums, factor = reward, discount
    for _ in range(_DOUBLINGS):
        sums = sums + factor * sums[reached]
        reached, factor = reached[reached], factor * factor
    return sums
