"""The certified empowerment of one state without a channel that is written out.

A few sequences attain the capacity, and one number for each of all the others shows that they do
not exceed it: with q the observations that the few lead to,

    C <= max over all sequences x of D(P_x || q)         (Blahut 1972, theorem 3; Arimoto 1972).

So the best distribution over a pool of sequences is found, the divergence of all sequences from its
q, those of the largest divergence come into the pool, and again until the two bounds meet: column
generation (Dantzig and Wolfe 1960). The pool begins with the sequences that make one observation
after the other as likely as possible, and two or three rounds are enough.

Nothing here calls BLAS as long as there are few observations, so that threads work side by side.
"""

import numpy as np
from jaxtyping import Float64, Int64

from habilis.channels.bounds import LEAST, Inputs
from habilis.channels.capacity_solver import best_inputs
from habilis.channels.small_channels import MOST_OUTPUTS, inputs_of_few_outputs
from habilis.empowerment.tabular.beliefs import (
    TooManyBeliefsError,
    beliefs_before_last,
    distinct,
)
from habilis.empowerment.tabular.last_actions import LANES, LastActions, side_by_side
from habilis.empowerment.tabular.open_loop import (
    Problem,
    channel_of,
    channel_of_ends,
    drawn,
    exact,
    merging_error,
)

_ROUNDS = 100  # of sequences that are added
_ADDED = 8  # sequences in a round, at most, for each observation
_ALL = 512  # sequences up to which all are in the pool
_UNUSED = 1e-9  # inputs with less leave the pool
_LN2 = float(np.log(2))


def certified(problem: Problem, start: int) -> tuple[float, float]:
    """The empowerment of a state over all sequences of actions, and its gap, in bits.

    Raises:
        TooManyBeliefsError: there are more sequences left than `most_entries` allows.
    """
    if problem.horizon == 0:
        return 0.0, 0.0
    if is_written_out(problem):
        _, answer = exact(problem, start)
        return answer.bits, answer.gap
    return generated(problem, start)


def generated(problem: Problem, start: int) -> tuple[float, float]:
    """`certified` by column generation, of 1 or more actions."""
    sequences, merged = sequences_from(problem, start)
    return capacity_of(sequences, sequences.neg_entropies(), problem.tolerance, merged)


def is_written_out(problem: Problem) -> bool:
    """Whether there are so few sequences that all are in the pool.

    Their channel costs no more to write out; and nothing has to be compiled, or read, for it.
    """
    return bool(problem.horizon * np.log(problem.successors.actions) <= np.log(_ALL) + 1e-9)


def sampled(problem: Problem, start: int, samples: int, seed: int) -> tuple[float, float]:
    """A lower bound from some sequences of actions, drawn uniformly, and its gap, in bits.

    Where actions are not available everywhere, each step is drawn uniformly from those that surely
    are; sequences that end before h actions are left out. The gap is to the least of what is known
    of the whole without looking at all sequences: the logarithms of the number of sequences and of
    the number of possible observations.
    """
    actions, horizon = problem.successors.actions, problem.horizon
    states, matrix = drawn(problem, start, samples, seed)
    sequences = _of_rows(channel_of(problem, states, matrix)[0])
    merged = _merged(problem, len(states), sequences)
    bits, gap = capacity_of(sequences, sequences.neg_entropies(), problem.tolerance, merged)
    possible = problem.sensor[states].sum(axis=0).astype(bool).sum()
    most = min(np.log2(max(possible, 1)), horizon * np.log2(actions))
    return bits, max(float(most) - bits, gap)


def sequences_from(problem: Problem, start: int) -> tuple[LastActions, float]:
    """The sequences of 1 or more actions, and the part of the gap that merging beliefs makes up.

    Raises:
        TooManyBeliefsError: as above.
    """
    if problem.successors.certain:
        states, channel = channel_of_ends(problem, start)
        sequences = _of_rows(channel)
    else:
        states, sequences = _of_beliefs(problem, start)
    return sequences, _merged(problem, states, sequences)


def _merged(problem: Problem, states: int, sequences: LastActions) -> float:
    hidden = 0 if problem.successors.seen is None else problem.successors.states
    return merging_error(states + hidden, problem.horizon, sequences.observations)


def _of_beliefs(problem: Problem, start: int) -> tuple[int, LastActions]:
    """The number of states that matter, and all sequences."""
    successors, horizon = problem.successors, problem.horizon
    actions = successors.actions
    states, local, matrix, done = beliefs_before_last(
        successors, start, horizon, problem.most_entries
    )
    remaining = horizon - done
    if len(matrix) * actions**remaining > problem.most_entries:
        fitting = int(np.log(max(problem.most_entries / max(len(matrix), 1), 1)) / np.log(actions))
        raise TooManyBeliefsError(min(done + fitting, horizon - 1))
    chosen = (states.astype(np.int64)[:, None] * actions + np.arange(actions)).ravel()
    last = problem.last[chosen]
    observations, observation = np.unique(last.indices, return_inverse=True)
    sequences = LastActions(
        side_by_side(matrix),
        len(matrix),
        remaining,
        actions,
        local.first,
        local.state,
        local.probability,
        last.indptr.astype(np.int64),
        observation.astype(np.int32),
        last.data,
        len(observations),
        successors.always_available,
    )
    return len(states), sequences


def _of_rows(channel: Float64[np.ndarray, "K O"]) -> LastActions:
    """The rows of a channel as sequences of which nothing remains to be done."""
    blocks = side_by_side(channel)
    outputs = np.arange(channel.shape[1] + 1)
    none = np.zeros(1, np.int64), np.zeros(0, np.int32), np.zeros(0)
    end = outputs, outputs[:-1].astype(np.int32), np.ones(len(outputs) - 1)
    return LastActions(blocks, len(channel), 1, 1, *none, *end, len(outputs) - 1, True)


def capacity_of(
    sequences: LastActions,
    numbers: tuple[Float64[np.ndarray, "n"], Int64[np.ndarray, "O"]],
    tolerance: float,
    merged: float,
) -> tuple[float, float]:
    """Bits and gap.

    Args:
        sequences: all of them.
        numbers: as `LastActions.neg_entropies` gives them.
        tolerance: the gap to reach, in bits.
        merged: the part of the gap that merging beliefs is responsible for.
    """
    neg_entropy, likeliest = numbers
    possible = np.flatnonzero(neg_entropy > -np.inf)
    if len(possible) <= 1 or sequences.observations == 1:
        return 0.0, 0.0
    if (neg_entropy[possible] == 0).all():  # no noise is left: all inputs alike
        labels = -np.arange(sequences.observations, dtype=np.float64)
        led = sequences.divergences(np.zeros(len(neg_entropy)), labels)[possible]
        return float(np.log2(len(np.unique(led)))), merged
    sought = max(tolerance - merged, 0) * _LN2
    pool = possible
    if len(possible) > _ALL:  # the likeliest, and whatever else their last action could be
        last = np.arange(sequences.actions)
        pool = np.unique((likeliest // sequences.actions * sequences.actions)[:, None] + last)
        pool = pool[neg_entropy[pool] > -np.inf]
    rows, first = distinct(sequences.rows(pool))
    pool = pool[first]
    lower, upper = _bounded(sequences, neg_entropy, pool, rows, sought)
    return lower / _LN2, max(upper - lower, 0.0) / _LN2 + merged


def _bounded(
    sequences: LastActions,
    neg_entropy: Float64[np.ndarray, "n"],
    pool: Int64[np.ndarray, "k"],
    rows: Float64[np.ndarray, "k O"],
    tolerance: float,
) -> tuple[float, float]:
    """Bounds on the capacity, in nats, that differ by the tolerance if rounding permits."""
    lower, upper, sought = 0.0, np.inf, tolerance / 2
    inputs = np.full(len(pool), 1 / len(pool))
    for _ in range(_ROUNDS):
        inputs = _inputs(rows, neg_entropy[pool], inputs, sought)
        outputs = np.maximum(np.einsum("xy,x->y", rows, inputs), LEAST)
        logs = np.log(outputs)
        divergence = sequences.divergences(neg_entropy, logs)
        terms = len(outputs) + len(pool) + LANES
        largest = 1 + np.abs(logs).max() - neg_entropy[neg_entropy > -np.inf].min()
        rounding = terms * np.finfo(np.float64).eps * largest
        attained = float(np.einsum("x,x->", inputs, divergence[pool]))
        lower, upper = max(lower, attained), min(upper, float(divergence.max()) + rounding)
        if upper - lower <= tolerance:
            break
        divergence[pool] = -np.inf
        added = np.flatnonzero(divergence > attained + tolerance / 4)
        most = max(_ADDED * len(outputs), 1)
        if len(added) > most:
            added = added[np.argpartition(-divergence[added], most)[:most]]
        if not len(added):
            if sought <= tolerance / 64:
                break
            sought /= 4
        used = inputs > _UNUSED
        pool = np.concatenate([pool[used], added])
        rows, first = distinct(np.concatenate([rows[used], sequences.rows(added)]))
        inputs = np.concatenate([inputs[used], np.zeros(len(added))])[first]
        pool = pool[first]
    return lower, upper


def _inputs(
    rows: Float64[np.ndarray, "k O"], neg_entropy: Inputs, inputs: Inputs, tolerance: float
) -> Inputs:
    """The best distribution over the rows of a channel."""
    if len(rows) == 1:
        return np.ones(1)
    if rows.shape[1] > MOST_OUTPUTS:
        return best_inputs(rows, tolerance)[0]
    return inputs_of_few_outputs(rows, neg_entropy, inputs, tolerance)
