"""The open-loop empowerment of one state where outcomes or the sensor are uncertain."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float64, Int32, Int64

from habilis.channels.bounds import information_error
from habilis.channels.capacity_solver import best_inputs
from habilis.empowerment.one_step import last_observations, moves_of
from habilis.empowerment.sensors import Sensor, is_by_action, observation_probabilities
from habilis.empowerment.tabular.beliefs import SAME, Beliefs, distinct, unheard
from habilis.empowerment.tabular.outcomes import followed, outcomes_after, wandered
from habilis.empowerment.tabular.successors import Successors
from habilis.mdp import TabularMDP
from habilis.probabilities import shape_of

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_LN2 = np.log(2)


@dataclass(frozen=True)
class Problem:
    """The data shared by all states.

    Attributes:
        successors: the transitions under the chosen actions.
        sensor: sparse float64[S, O], what is perceived in each state; the identity of the
            observations where the last action leads to these (`Successors.seen`).
        horizon: h, in actions.
        tolerance: the gap to reach, in bits.
        most_entries: how many numbers the beliefs of one state may be.
    """

    successors: Successors
    sensor: "csr_array"
    horizon: int
    tolerance: float
    most_entries: int = 2**62

    @cached_property
    def last(self) -> "csr_array":
        """float64[S * A, O], what is observed after an action if it is the last one."""
        from scipy.sparse import csr_array

        moves = self.successors
        if moves.seen is not None:
            return moves.seen
        some = moves.probability, moves.state, moves.first
        transitions = csr_array(some, shape=(len(moves.first) - 1, moves.states))
        # The product with an identity takes as long as solving a few states of a large table.
        return transitions if _is_identity(self.sensor) else csr_array(transitions @ self.sensor)


def _is_identity(matrix: "csr_array") -> bool:
    rows, columns = shape_of(matrix)
    return (
        rows == columns == matrix.nnz
        and bool((matrix.data == 1).all())
        and np.array_equal(matrix.indices, np.arange(rows))
        and np.array_equal(matrix.indptr, np.arange(rows + 1))
    )


def problem_of(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor,
    actions: Int64[np.ndarray, "A"],
    tolerance: float,
    most_entries: int = 2**62,
) -> Problem:
    """A measure's arguments, made ready."""
    transitions, count = mdp.transitions, len(actions)
    rows = (np.arange(mdp.states)[:, None] * mdp.action_count + actions).ravel()
    if count < mdp.action_count:
        if isinstance(transitions, np.ndarray):
            transitions = np.ascontiguousarray(transitions[:, actions])
        else:
            transitions = transitions[rows]
    successors = successors_of(transitions, count)
    if is_by_action(sensor):
        successors = replace(successors, seen=last_observations(mdp, sensor)[rows])
    return Problem(successors, _at_the_end(mdp, sensor), horizon, tolerance, most_entries)


def _at_the_end(mdp: TabularMDP, sensor: Sensor) -> "csr_array":
    """The sensor; where the last action leads to observations, these themselves."""
    from scipy.sparse import csr_array, eye_array

    seen = observation_probabilities(mdp, sensor)
    return csr_array(eye_array(shape_of(seen)[1])) if is_by_action(sensor) else seen


@dataclass(frozen=True)
class Answer:
    """The empowerment of one state.

    Attributes:
        bits: what `inputs` attain.
        gap: bits, a proven upper bound on what is missing.
        channel: float64[K, O], merged sequences by observations that are possible.
        observations: int64[O], which columns of the sensor these are.
        rows: int64[K], the beliefs that stand for the channel's inputs.
        inputs: float64[K], the distribution over them.
    """

    bits: float
    gap: float
    channel: Float64[np.ndarray, "K O"]
    observations: Int64[np.ndarray, "O"]
    rows: Int64[np.ndarray, "K"]
    inputs: Float64[np.ndarray, "K"]


def successors_of(transitions: "Int32[np.ndarray, 'S A'] | csr_array", actions: int) -> Successors:
    """A table's transitions as the kernels read them."""
    moves = moves_of(transitions)
    return Successors(
        moves.indptr.astype(np.int64), moves.indices.astype(np.int32), moves.data, actions
    )


def exact(
    problem: Problem, start: int, report: Callable[[int, int], None] = unheard
) -> tuple[Beliefs, Answer]:
    """The empowerment of a state over all sequences of actions.

    Args:
        problem: what is asked.
        start: the state.
        report: receives how many actions are done, and how many there are.

    Raises:
        TooManyBeliefsError: there are more beliefs than `most_entries` allows.
    """
    beliefs = outcomes_after(
        problem.successors, start, problem.horizon, problem.most_entries, report
    )
    answer = solve_channel(problem, beliefs.states, beliefs.matrix)
    return beliefs, answer


def drawn(
    problem: Problem, start: int, samples: int, seed: int
) -> tuple[Int32[np.ndarray, "N"], Float64[np.ndarray, "k N"]]:
    """The beliefs, over which states, that random sequences lead to; see `sampled`."""
    actions, horizon = problem.successors.actions, problem.horizon
    rng = np.random.default_rng([seed, start])
    if problem.successors.always_available:
        sequences = rng.integers(actions, size=(samples, horizon), dtype=np.int32)
        return followed(problem.successors, start, sequences)
    return wandered(problem.successors, start, rng.random((samples, horizon)))


def solve_channel(
    problem: Problem,
    states: Int32[np.ndarray, "N"],
    matrix: "Float64[np.ndarray, 'K N'] | csr_array",
) -> Answer:
    """The capacity of the channel from rows of beliefs through the sensor; 0 without any row."""
    channel, observations, rows = channel_of(problem, states, matrix)
    inputs = np.full(len(channel), 1 / max(len(channel), 1))
    hidden = 0 if problem.successors.seen is None else problem.successors.states
    merged = merging_error(len(states) + hidden, problem.horizon, len(observations))
    if len(channel) <= 1 or len(observations) == 1:
        return Answer(0.0, 0.0, channel, observations, rows, inputs)
    if (channel.max(axis=1) == 1).all():  # no noise is left: all inputs alike
        bits = float(np.log2(len(channel)))
        return Answer(bits, merged, channel, observations, rows, inputs)
    inputs, found = best_inputs(channel, max(problem.tolerance - merged, 0) * _LN2)
    bits, gap = float(found.lower / _LN2), float(found.gap / _LN2) + merged
    return Answer(bits, gap, channel, observations, rows, inputs)


def channel_of_ends(problem: Problem, start: int) -> tuple[int, Float64[np.ndarray, "K O"]]:
    """How many states and the distinct rows of the channel, where no action is uncertain.

    Raises:
        TooManyBeliefsError: there are more beliefs than `most_entries` allows.
    """
    beliefs = outcomes_after(problem.successors, start, problem.horizon, problem.most_entries)
    return len(beliefs.states), channel_of(problem, beliefs.states, beliefs.matrix)[0]


def channel_of(
    problem: Problem,
    states: Int32[np.ndarray, "N"],
    matrix: "Float64[np.ndarray, 'K N'] | csr_array",
) -> tuple[Float64[np.ndarray, "k O"], Int64[np.ndarray, "O"], Int64[np.ndarray, "k"]]:
    """Distinct rows over the observations that are possible, these, and where the rows were."""
    seen = problem.sensor[states]
    observations = np.unique(seen.indices).astype(np.int64)
    channel, rows = distinct(np.ascontiguousarray(matrix @ seen[:, observations].toarray()))
    possible = channel.any(axis=0)
    channel = np.ascontiguousarray(channel[:, possible])
    return channel, observations[possible], rows.astype(np.int64)


def merging_error(states: int, horizon: int, observations: int) -> float:
    """By how many bits merging beliefs that differ by rounding can change a capacity.

    A row changes by at most `SAME * states * (horizon + 1) / 2` in total variation.
    """
    return information_error(SAME * states * (horizon + 1) / 2, observations) if horizon else 0.0
