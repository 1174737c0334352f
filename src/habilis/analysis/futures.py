"""The futures that an agent could choose among: the inputs that attain a state's empowerment."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int32, Int64
from numpy.typing import ArrayLike

from habilis.channels.capacity import checked_tolerance, warn_of_gap
from habilis.empowerment.arguments import (
    Unit,
    chosen_actions,
    chosen_states,
    per_bit,
    positive,
    whole_number,
)
from habilis.empowerment.limits import MAX_GIB, MAX_SECONDS, Limits, too_much
from habilis.empowerment.sensors import Sensor, is_noisy
from habilis.mdp import TabularMDP
from habilis.probabilities import as_array
from habilis.progress import progress_bar

_UNUSED = 1e-9  # sequences with less probability are left out


@dataclass(frozen=True)
class Futures:
    """What an agent would do to have the greatest choice of observations, and what it would see.

    Attributes:
        empowerment: of the state, in `unit`; to within `gap`.
        gap: a proven upper bound on what is missing.
        unit: "bits" or "nats".
        sequences: int32[k, h], action indices: the sequences worth choosing, the most probable
            first; one stands for all that lead to the same observations.
        probability: float64[k], with which each would be chosen; their sum is 1.
        observations: int64[m], what could be seen: states, labels of a factor, or columns of a
            noisy sensor.
        channel: float64[k, m], the probability of each observation after each sequence.
    """

    empowerment: float
    gap: float
    unit: Unit
    sequences: Int32[np.ndarray, "k h"]
    probability: Float64[np.ndarray, "k"]
    observations: Int64[np.ndarray, "m"]
    channel: Float64[np.ndarray, "k m"]

    @property
    def seen(self) -> Float64[np.ndarray, "m"]:
        """The probability of each observation when sequences are chosen so."""
        return self.probability @ self.channel


def futures(
    mdp: TabularMDP,
    state: int,
    horizon: int,
    sensor: Sensor = "state",
    actions: ArrayLike | None = None,
    *,
    unit: Unit = "bits",
    tolerance: float = 1e-6,
    max_gib: float = MAX_GIB,
    max_seconds: float = MAX_SECONDS,
    show_progress: bool = False,
) -> Futures:
    """The capacity-achieving distribution over action sequences of one state.

    Of the distributions that attain the empowerment it is one; where every sequence has one
    outcome, the uniform one over the outcomes. It is the maximising p in

        E_h(s) = max over p(a_1 ... a_h) of I(A_1 ... A_h; O_h | s)

    (Klyubin, Polani and Nehaniv 2005), found as in `capacity`.

    Args:
        mdp, horizon, sensor, actions, unit, tolerance, max_gib, max_seconds, show_progress: as in
            `empowerment`.
        state: the state's index.

    Returns:
        The sequences worth choosing among, with their probabilities, and what they lead to; none
        where no sequence can surely be carried out.

    Raises:
        ValueError: as in `empowerment`.

    Warns:
        ConvergenceWarning: the gap is above the tolerance.

    Example:
        >>> ring = TabularMDP.deterministic([[(s - 1) % 9, (s + 1) % 9] for s in range(9)])
        >>> choice = futures(ring, state=4, horizon=2)
        >>> choice.observations, choice.seen.round(3)
        (array([2, 4, 6]), array([0.333, 0.333, 0.333]))
    """
    from habilis.empowerment.tabular.beliefs import TooManyBeliefsError
    from habilis.empowerment.tabular.cost import check_effort, most_entries
    from habilis.empowerment.tabular.open_loop import exact, problem_of

    horizon, scale = whole_number("horizon", horizon), per_bit(unit)
    tolerance = checked_tolerance(tolerance) / scale
    limits = Limits(positive("max_gib", max_gib), positive("max_seconds", max_seconds))
    used = chosen_actions(mdp, actions)
    start = int(chosen_states(mdp, [state])[0])
    most = most_entries(limits, 1)
    problem = problem_of(mdp, horizon, sensor, used, tolerance, most)
    check_effort(problem, np.array([start]), 1, limits)
    try:
        with progress_bar("actions", show_progress) as tell:
            beliefs, answer = exact(problem, start, tell)
    except TooManyBeliefsError as error:
        raise too_much(horizon, error.horizon, limits) from None
    if answer.gap > tolerance:
        warn_of_gap(answer.gap, tolerance)
    order = np.argsort(-answer.inputs, kind="stable")
    order = order[answer.inputs[order] > _UNUSED]
    probability = answer.inputs[order]
    return Futures(
        answer.bits * scale,
        answer.gap * scale,
        unit,
        used.astype(np.int32)[beliefs.sequences(answer.rows[order])],
        probability / probability.sum(),
        _named(mdp, sensor, answer.observations),
        answer.channel[order],
    )


def _named(
    mdp: TabularMDP, sensor: Sensor, observations: Int64[np.ndarray, "m"]
) -> Int64[np.ndarray, "m"]:
    """Observations by the sensor's own labels."""
    if is_noisy(sensor) or (isinstance(sensor, str) and sensor == "state"):
        return observations
    labels = mdp.factor(sensor) if isinstance(sensor, str) else as_array("sensor", sensor)
    return np.unique(labels)[observations].astype(np.int64)
