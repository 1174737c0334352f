"""Agents that do not know where they are: a distribution over states as one more state.

From a belief b the first action leads where it leads from the states that b holds possible,
P(s' | b, a) = sum over s of b(s) P(s' | s, a), and is available where it is in all of them. With
such rows added to a table, the belief is a state like any other, which none leads to.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Int64
from numpy.typing import ArrayLike

from habilis.empowerment.one_step import moves_of
from habilis.empowerment.sensors import Sensor, is_by_action, is_noisy, observations
from habilis.mdp import TabularMDP
from habilis.probabilities import as_array, is_sparse, row_stochastic, shape_of


def are_beliefs(states: Any) -> bool:
    """Whether states are given as distributions over all of them, float[n, S]."""
    if is_sparse(states):
        return True
    if isinstance(states, list):
        return bool(states) and all(
            isinstance(one, list | np.ndarray) and any(isinstance(p, float) for p in one)
            for one in states
        )
    return getattr(states, "ndim", 0) == 2 and np.dtype(states.dtype).kind == "f"


def with_beliefs(
    mdp: TabularMDP, sensor: Sensor, beliefs: ArrayLike
) -> tuple[TabularMDP, Any, Int64[np.ndarray, "n"]]:
    """A table with beliefs as further states, the sensor for it, and these states.

    Args:
        mdp: the table.
        sensor: as in `empowerment`, one alone.
        beliefs: float[n, S], dense or scipy.sparse, each a distribution over states.

    Raises:
        ValueError: rows that are not one distribution over the states.
    """
    from scipy.sparse import csr_array, vstack

    given: Any = beliefs if is_sparse(beliefs) else as_array("states", beliefs)
    if given.shape[1] != mdp.states:
        raise ValueError(
            f"states has shape {given.shape}; as distributions give one probability for each of "
            f"the {mdp.states} states"
        )
    rows = row_stochastic("states", given, "belief {}", "beliefs")
    count, actions = shape_of(rows)[0], mdp.action_count
    moves, missing = moves_of(mdp.transitions), csr_array(~mdp.available, dtype=np.float64)
    lacking: Any = rows @ missing
    possible = lacking.toarray() == 0  # [n, A], in every state that is held possible
    mixed = [rows @ moves[action::actions] for action in range(actions)]
    order = np.arange(count * actions).reshape(actions, count).T.ravel()
    added = csr_array(vstack(mixed, format="csr"))[order]
    added = csr_array(added.multiply(possible.ravel()[:, None]))
    added.eliminate_zeros()
    table = csr_array(vstack([moves, added], format="csr"))
    table.resize(((mdp.states + count) * actions, mdp.states + count))  # none leads to a belief
    still = np.zeros((count, actions), np.float32)
    larger = replace(
        mdp,
        transitions=table,
        reward=np.concatenate([mdp.reward, still]),
        terminal=np.concatenate([mdp.terminal, np.zeros(count, bool)]),
        factors={},
        flags={},
        entry_reward=None,
        origin=None,
        model_states=None,
        drawn=None,
    )
    return larger, _for_more_states(mdp, sensor, count), mdp.states + np.arange(count)


def _for_more_states(mdp: TabularMDP, sensor: Sensor, count: int) -> Any:
    """The sensor, with something for states that are never observed."""
    from scipy.sparse import csr_array, vstack

    if not is_noisy(sensor):
        labels, _ = observations(mdp, sensor)
        return np.concatenate([labels, np.zeros(count, labels.dtype)])
    if is_by_action(sensor):
        given = np.asarray(sensor, np.float64)
        return np.concatenate([given, np.repeat(given[:, :1], count, axis=1)], axis=1)
    given: Any = sensor if is_sparse(sensor) else csr_array(np.asarray(sensor, np.float64))
    return csr_array(vstack([given, *[given[:1]] * count], format="csr"))
