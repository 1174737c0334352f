"""Informations of what a policy visits: intrinsic motivations of the literature, exactly.

The literature estimates these from samples, with networks. Of a finite table and a policy all are
functions of its occupancy (`occupancy`), over T steps from a start.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float64
from numpy.typing import ArrayLike

from habilis.analysis.occupancy import (
    Policy,
    mixtures,
    seen_in_states,
    some_at_a_time,
    starts_of,
    steps_back,
    walk,
)
from habilis.empowerment.arguments import at_least_one
from habilis.empowerment.sensors import AGENT, Sensor, joint_labels, rest_of
from habilis.mdp import TabularMDP
from habilis.probabilities import as_array, row_stochastic, shape_of

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Bits = Float64[np.ndarray, "n"]

_LN2 = float(np.log(2))


def occupancy_entropy(
    mdp: TabularMDP,
    policy: Policy,
    steps: int,
    sensor: Sensor = "state",
    states: Any = None,
    *,
    absorbing: bool = False,
) -> Bits:
    """The entropy of what a policy visits.

        H(O),   P(o) = 1/T sum over t = 1 ... T of P(O_t = o)

    the objective of maximum entropy exploration (Hazan, Kakade, Singh and Van Soest 2019, who
    discount time; over T steps with equal weights it is ours).

    Args:
        mdp, policy, steps, states, absorbing: as in `occupancy`.
        sensor: as in `empowerment`, one alone that does not depend on the last action.

    Returns:
        float64[n], bits, at most log2 of the number of observations.

    Raises:
        ValueError: as in `occupancy`, or what `empowerment` refuses of a sensor.

    Example:
        >>> ring = TabularMDP.deterministic([[(s - 1) % 4, (s + 1) % 4] for s in range(4)])
        >>> occupancy_entropy(ring, "uniform", steps=2)
        array([2.])
    """
    steps = at_least_one("steps", steps)
    back, starts = steps_back(mdp, policy, absorbing), starts_of(mdp, states)
    return _entropies(mixtures(back, starts, seen_in_states(mdp, sensor), steps))


def music(
    mdp: TabularMDP,
    policy: Policy,
    steps: int,
    agent: str | Sequence[str] = AGENT,
    states: Any = None,
    *,
    each_step: bool = False,
    absorbing: bool = False,
) -> Bits:
    """The mutual information between the agent and its surroundings under a policy.

        I(S^A; S^R),   P(a, r) = 1/T sum over t = 1 ... T of P(S^A_t = a, S^R_t = r)

    with S^A the agent's factors and S^R all others: what mutual information state intrinsic control
    maximises (MUSIC; Zhao, Gao, Abbeel, Tresp and Xu 2021, who estimate it within sampled
    trajectories). That time is drawn uniformly from T steps is ours. It is large where the
    surroundings, when visited, are known from where the agent is: to push a thing, or to carry it.

    Args:
        mdp, policy, steps, states, absorbing: as in `occupancy`; with factors.
        agent: the agent's factor, or several of them, as `["agent", "tool"]`.
        each_step: whether to return the mean over t of the information at time t instead,
            I(S^A_t; S^R_t). It may be more than that of the mixture, to which a common drift in
            time contributes too, but is at most log2 T less.

    Returns:
        float64[n], bits.

    Raises:
        ValueError: as in `occupancy`; no such factor, or no other.

    Example:
        >>> from dataclasses import replace
        >>> cart = TabularMDP.deterministic([[1, 2], [1, 1], [2, 2]])
        >>> places = {name: np.array([0, 1, 2], np.int32) for name in ("agent", "load")}
        >>> music(replace(cart, factors=places), "uniform", steps=1)
        array([1.])
    """
    steps = at_least_one("steps", steps)
    own = [mdp.factor_named(name) for name in ([agent] if isinstance(agent, str) else agent)]
    if not own:
        raise ValueError("agent names no factor; give at least one")
    of_agent, of_rest, of_both = _indicators(mdp, own)
    back, starts = steps_back(mdp, policy, absorbing), starts_of(mdp, states)

    def information(occupied: Float64[np.ndarray, "S n"]) -> Bits:
        each = (np.asarray(one @ occupied) for one in (of_agent, of_rest, of_both))
        agents, rests, both = map(_entropies, each)
        return np.maximum(agents + rests - both, 0)

    found = [np.zeros(0)]
    for occupied in some_at_a_time(starts):
        total, bits = np.zeros_like(occupied), np.zeros(occupied.shape[1])
        for one in walk(back, occupied, steps):
            if each_step:
                bits += information(one) / steps
            else:
                total += one / steps
        found.append(bits if each_step else information(total))
    return np.concatenate(found)


def skill_discriminability(
    mdp: TabularMDP,
    policies: ArrayLike,
    steps: int,
    prior: ArrayLike | None = None,
    states: Any = None,
    sensor: Sensor = "state",
    *,
    absorbing: bool = False,
) -> Bits:
    """How well one knows from a visited state which of several policies the agent follows.

        I(Z; O),   P(o | z) = 1/T sum over t = 1 ... T of P(O_t = o | z)

    the first term of the objective of DIAYN (Eysenbach, Gupta, Ibarz and Levine 2018), whose
    discriminator q(z | s) bounds it from below; that visited states are those of T steps, with
    equal weights, is ours. It is positive where paths differ on the way and merge later, so that it
    is no lower bound of T-step closed-loop empowerment; but it is at most the mean over t of the
    closed-loop empowerments of 1 ... T steps.

    Args:
        mdp, steps, states, absorbing: as in `occupancy`.
        policies: float[Z, S, A], the skills, each as `policy` in `occupancy`.
        prior: float[Z], the probability of each skill; by default all are as likely.
        sensor: as in `occupancy_entropy`.

    Returns:
        float64[n], bits, at most the entropy of the prior.

    Raises:
        ValueError: as in `occupancy`, or what `empowerment` refuses of a sensor; or no policies,
            or a prior that is not one distribution over them.

    Example:
        >>> diamond = TabularMDP.deterministic([[1, 2], [3, 3], [3, 3], [3, 3]])
        >>> left, right = np.eye(2)[[0] * 4], np.eye(2)[[1] * 4]
        >>> skill_discriminability(diamond, [left, right], steps=2)
        array([0.5])
    """
    steps = at_least_one("steps", steps)
    skills = as_array("policies", policies)
    wanted = mdp.states, mdp.action_count
    if skills.ndim != 3 or skills.shape[1:] != wanted or not len(skills):
        raise ValueError(
            f"policies has shape {skills.shape}; give float[skills, states, actions], here "
            f"(skills, {wanted[0]}, {wanted[1]})"
        )
    weights = _prior(prior, len(skills))
    seen, starts = seen_in_states(mdp, sensor), starts_of(mdp, states)
    outputs, count = shape_of(seen)[1], shape_of(starts)[0]
    mean, within = np.zeros((outputs, count)), np.zeros(count)
    for number, (skill, weight) in enumerate(zip(skills, weights.tolist(), strict=True)):
        back = steps_back(mdp, skill, absorbing, f"policy {number}")
        shown = mixtures(back, starts, seen, steps)
        mean += weight * shown
        within += weight * _entropies(shown)
    return np.maximum(_entropies(mean) - within, 0)


def _prior(prior: ArrayLike | None, count: int) -> Float64[np.ndarray, "Z"]:
    if prior is None:
        return np.full(count, 1 / count)
    given = as_array("prior", prior)
    if given.shape != (count,):
        raise ValueError(
            f"prior has shape {given.shape}; give one probability for each of {count} policies"
        )
    return row_stochastic("prior", given[None], "the row", "policies").toarray()[0]


def _indicators(mdp: TabularMDP, agent: Sequence[str]) -> "tuple[csr_array, csr_array, csr_array]":
    """Which states have each value of the agent's factors, of the others, and of both together."""
    from scipy.sparse import csr_array

    def of(names: Sequence[str]) -> "csr_array":
        labels, count = joint_labels(mdp, names)
        which = (labels, np.arange(mdp.states))
        return csr_array((np.ones(mdp.states), which), (count, mdp.states))

    rest = rest_of(mdp, agent)
    return of(agent), of(rest), of([*agent, *rest])


def _entropies(occupied: Float64[np.ndarray, "O n"]) -> Bits:
    """The entropy of each column, in bits."""
    from scipy.special import entr

    return entr(np.maximum(occupied, 0)).sum(axis=0) / _LN2
