"""Sensors: what the agent perceives of a state, as one label or with probabilities."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Int32
from numpy.typing import ArrayLike

from habilis.mdp import TabularMDP
from habilis.probabilities import as_array, is_sparse, row_stochastic, shape_of

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Sensor = str | ArrayLike | Any
"""A factor's name, "state" for all of it, "rest" for all factors but the agent's, int[S] or bool[S]
labels, float[S, O] probabilities, or float[A, S, O], those of what is observed after an action in
the state that it led to.
"""

STATE, REST, AGENT = "state", "rest", "agent"

_SPREAD = 4  # times as many labels as states, up to which a place for each label is cheap


def is_noisy(sensor: Sensor) -> bool:
    """Whether a sensor is given as probabilities of observations."""
    return is_sparse(sensor) or _dimensions(sensor) in (2, 3)


def is_by_action(sensor: Sensor) -> bool:
    """Whether what is observed depends on the last action too."""
    return not is_sparse(sensor) and _dimensions(sensor) == 3


def _dimensions(sensor: Sensor) -> int:
    return 0 if isinstance(sensor, str) else as_array("sensor", sensor).ndim


def observation_probabilities(mdp: TabularMDP, sensor: Sensor) -> "csr_array":
    """The observation probabilities of each state.

    Args:
        mdp: the table.
        sensor: as in `observations`, or float[S, O], dense or scipy.sparse, the probability of
            each observation in each state; or float[A, S, O], after each action.

    Returns:
        sparse float64[S, O]; of a sensor that depends on the last action float64[A * S, O], in row
        `a * S + s` what is observed in state s after action a.

    Raises:
        ValueError: as in `observations`, or rows that are not one distribution a state.
    """
    from scipy.sparse import csr_array

    if not is_noisy(sensor):
        labels, count = observations(mdp, sensor)
        ones = np.ones(mdp.states)
        return csr_array((ones, labels, np.arange(mdp.states + 1)), (mdp.states, count))
    given: Any = sensor if is_sparse(sensor) else as_array("sensor", sensor)
    if given.ndim == 3:
        return _after_actions(mdp, given)
    rows, columns = shape_of(given)
    if columns == 1 and given.dtype.kind in "biu":
        raise ValueError(
            f"sensor has shape {tuple(given.shape)} and type {given.dtype}; give labels of shape "
            f"({mdp.states},), one for each state, as .ravel() has them"
        )
    if rows != mdp.states:
        turned = columns == mdp.states and given.dtype.kind in "biuf"
        raise ValueError(
            f"sensor has {rows} rows; give one integer label, or a row of "
            f"probabilities, for each of the {mdp.states} states"
            + ("; its columns sum to 1: transpose it" if turned and _adds_up(given) else "")
        )
    return row_stochastic("sensor", given, "state {}", "states")


def _after_actions(mdp: TabularMDP, given: np.ndarray) -> "csr_array":
    from scipy.sparse import csr_array, vstack

    wanted = mdp.action_count, mdp.states
    if given.shape[:2] != wanted:
        turned = given.shape[1::-1] == wanted
        raise ValueError(
            f"sensor has shape {given.shape}; give [actions, states, observations], here "
            f"({mdp.action_count}, {mdp.states}, observations)"
            + (", as .swapaxes(0, 1) has them" if turned else "")
        )
    each = [
        row_stochastic(f"sensor, action {action}", one, "state {}", "states")
        for action, one in enumerate(given)
    ]
    return csr_array(vstack(each, format="csr"))


def _adds_up(matrix: Any) -> bool:
    """Whether every column sums to 1."""
    return np.allclose(np.asarray(matrix.sum(axis=0)), 1)


def observations(mdp: TabularMDP, sensor: Sensor) -> tuple[Int32[np.ndarray, "S"], int]:
    """The observation of each state.

    Args:
        mdp: the table.
        sensor: "state", the name of a factor ("object" stands for "object:can" where that is the
            only object), "rest", or an int[S] or bool[S] array of labels. Labels need not be
            consecutive: states with equal labels look alike, and nothing else matters.

    Returns:
        Labels renumbered from 0 without gaps, and how many there are.

    Raises:
        ValueError: no such factor, or an array that is not one integer a state.
    """
    if isinstance(sensor, str):
        if sensor == STATE:
            return np.arange(mdp.states, dtype=np.int32), mdp.states
        factor = factor_of(mdp, sensor)
        if factor is None:
            return joint_labels(mdp, rest_of(mdp))
        labels = mdp.factors[factor]
    else:
        labels = as_array("sensor", sensor)
        if labels.shape != (mdp.states,) or labels.dtype.kind not in "biu":
            raise ValueError(
                f"sensor has shape {labels.shape} and type {labels.dtype}; give one integer label "
                f"for each of the {mdp.states} states, as np.unique(labels, return_inverse=True)[1]"
            )
    if labels.min(initial=0) >= 0 and labels.max(initial=0) <= _SPREAD * len(labels):
        used = np.zeros(int(labels.max(initial=0)) + 1, np.bool_)
        labels = labels.astype(np.int64, copy=False)
        used[labels] = True  # sorting millions of labels takes longer than all that follows
        number = np.cumsum(used, dtype=np.int32) - np.int32(1)
        return number[labels], int(used.sum())
    values, renumbered = np.unique(labels, return_inverse=True)
    return renumbered.astype(np.int32), len(values)


def factor_of(
    mdp: TabularMDP, sensor: str, argument: str = "sensor", besides: Sequence[str] = ()
) -> str | None:
    """The factor that a name stands for; `None` of "state" and "rest", which are no factors.

    Args:
        mdp: the table. A factor of it that is called "rest" is meant by that name.
        sensor: a single name.
        argument: what the error calls it.
        besides: what else the argument may be.

    Raises:
        ValueError: no such factor, several that could be meant, or there is no rest.
    """
    if sensor == STATE:
        return None
    if sensor == REST and REST not in mdp.factors:
        rest_of(mdp)
        return None
    return mdp.factor_named(sensor, argument, [*besides, STATE])


def rest_of(mdp: TabularMDP, agent: Sequence[str] | None = None) -> list[str]:
    """The factors of an agent's surroundings: all but its own.

    Args:
        mdp: the table.
        agent: the agent's factors; by default "agent", or in the table of one player that player,
            where it is a factor.

    Raises:
        ValueError: there is no such factor, or no other.
    """
    if agent is None:
        agent = [name for name in mdp.players if len(mdp.players) == 1 and name in mdp.factors]
    own = {mdp.factor_named(name, "the agent's factor") for name in agent or [AGENT]}
    rest = [name for name in mdp.factors if name not in own]
    if not rest:
        raise ValueError(
            f"there is no rest, as the only factors are {', '.join(mdp.factors)}; use 'state'"
        )
    return rest


def joint_labels(mdp: TabularMDP, names: Sequence[str]) -> tuple[Int32[np.ndarray, "S"], int]:
    """One label for the values of several factors together, and how many there are.

    Labels are from 0 up without gaps, in the order of the values, those of the first factor first.
    """
    joint, count = np.zeros(mdp.states, np.int64), 1
    for name in names:
        values, own = np.unique(mdp.factors[name], return_inverse=True)
        found, joint = np.unique(joint * len(values) + own, return_inverse=True)
        count = len(found)
    return joint.astype(np.int32), count
