"""What a stochastic computation will cost, known before it starts."""

import time
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64, Int64

from habilis.empowerment.beliefs import beliefs_after, followed, states_within
from habilis.empowerment.limits import Limits, takes, too_much
from habilis.empowerment.open_loop import Problem, solve_channel
from habilis.probabilities import shape_of

_PROBED = 3  # states looked at
_ENTRIES = 200_000  # numbers in the beliefs of a state up to which they are tried out
_BYTES = 8 * 4  # a number of a belief: in an array perhaps just doubled, and what comes of it
_STEP = 300  # bytes that each step takes however few beliefs there are
_TRIAL = 0.3  # seconds that trying out a state may take
_FORESEEN = 2_000  # horizons looked at one by one
_TRIFLE = 20_000_000  # numbers in all states' beliefs, at worst, below which nobody waits


@dataclass(frozen=True)
class Effort:
    """What each horizon from 0 to h costs.

    Attributes:
        gib: float64[h + 1], memory at once.
        seconds: float64[h + 1].
    """

    gib: Float64[np.ndarray, "horizons"]
    seconds: Float64[np.ndarray, "horizons"]


def check_effort(
    problem: Problem, starts: Int64[np.ndarray, "n"], threads: int, limits: Limits
) -> None:
    """Refuses what would take more than it may.

    Raises:
        TooMuchError: the estimate of memory or time is above its limit; the message has both, and
            the largest horizon that fits.
    """
    successors, horizon = problem.successors, problem.horizon
    everything = shape_of(problem.sensor)[0] * max(len(starts), 1)
    worst = horizon * np.log(successors.actions) + np.log(everything)
    few = horizon <= _FORESEEN and worst <= np.log(_TRIFLE)
    if not len(starts) or few or (successors.certain and horizon <= _FORESEEN):
        return
    effort = estimate(replace(problem, horizon=min(horizon, _FORESEEN)), starts, threads)
    fits = (effort.gib <= limits.gib) & (effort.seconds <= limits.seconds)
    fitting = int(np.argmin(fits)) - 1
    gib, seconds = effort.gib[-1], effort.seconds[-1]
    if fits.all():
        # The least that each further action can add is what the last one added.
        more = horizon - len(fits) + 1
        each = np.array([gib - effort.gib[-2], seconds - effort.seconds[-2]])
        left = np.array([limits.gib - gib, limits.seconds - seconds])
        gib, seconds = np.array([gib, seconds]) + more * each
        if gib <= limits.gib and seconds <= limits.seconds:
            return
        fitting = len(fits) - 1 + int((left / np.maximum(each, 1e-300)).min())
    raise too_much(horizon, fitting, limits, takes(gib, seconds))


def check_samples(
    problem: Problem, starts: Int64[np.ndarray, "n"], samples: int, threads: int, limits: Limits
) -> None:
    """Refuses samples of sequences that would take more than they may.

    Raises:
        TooMuchError: as above.
    """
    horizon = problem.horizon
    if not len(starts) or horizon * samples <= _TRIFLE:
        return
    start, tried = int(starts[0]), min(samples, 10)
    drawn = np.zeros((tried, min(horizon, _FORESEEN)), np.int32)
    followed(problem.successors, start, drawn[:, :1])  # compiled, if it is the first time
    began = time.thread_time()
    followed(problem.successors, start, drawn)
    each = (time.thread_time() - began) / drawn.size
    states = len(np.unique(starts))
    one = np.array(
        [8.0 * samples * min(threads, states) / 2**30, each * samples * states / threads]
    )
    gib, seconds = horizon * one
    if gib > limits.gib or seconds > limits.seconds:
        fitting = int((np.array([limits.gib, limits.seconds]) / np.maximum(one, 1e-300)).min())
        raise too_much(horizon, fitting, limits, takes(gib, seconds))


def most_entries(limits: Limits, at_once: int) -> int:
    """How many numbers the beliefs of one of so many states at once may be."""
    return int(min(limits.gib * 2**30 / (_BYTES * at_once), 2**62))


def estimate(problem: Problem, starts: Int64[np.ndarray, "n"], threads: int) -> Effort:
    """Memory and time of every horizon up to the problem's, from a look at a few states.

    In these, beliefs are followed as far as that is cheap, and timed. From there on each step
    multiplies them as the last one did, which merging seldom exceeds.
    """
    horizon = problem.horizon
    probes = np.unique(starts[np.linspace(0, len(starts) - 1, _PROBED).astype(int)])
    _compile(problem, int(probes[0]))
    gib, seconds = np.zeros(horizon + 1), np.zeros(horizon + 1)
    for start in probes:
        memory, time_taken = _probe(problem, int(start))
        gib = np.maximum(gib, memory)
        seconds += time_taken / len(probes)
    return Effort(gib * min(threads, len(starts)), seconds * len(np.unique(starts)) / threads)


def _probe(
    problem: Problem, start: int
) -> tuple[Float64[np.ndarray, "horizons"], Float64[np.ndarray, "horizons"]]:
    """GiB and seconds of one state, by horizon."""
    successors, horizon = problem.successors, problem.horizon
    reached = states_within(successors, start, horizon)
    counts, took, solving = _tried(problem, start, reached)
    known = len(counts) - 1
    factor = counts[-1] / counts[-2] if known else 1.0
    # Past this many nothing fits anyway, and products of it are still numbers.
    steps = np.minimum(np.arange(1.0, horizon - known + 1), 200 / np.log10(max(factor, 1.01)))
    beliefs = np.concatenate([counts, counts[-1] * factor**steps])
    entries = beliefs if successors.certain else beliefs * reached
    parents = np.cumsum(8 * beliefs + _STEP)  # how each belief came about
    memory = _BYTES * entries + 20 * beliefs * successors.actions + parents
    worked = np.cumsum(entries) * successors.actions
    seconds = worked * took / max(worked[known], 1) + entries * solving / max(entries[known], 1)
    return memory / 2**30, seconds


def _compile(problem: Problem, start: int) -> None:
    """Does once what is timed later: the first time, it is compiled, for many seconds."""
    beliefs = beliefs_after(problem.successors, start, min(1, problem.horizon))
    solve_channel(problem, beliefs.states, beliefs.matrix)


def _tried(
    problem: Problem, start: int, reached: Float64[np.ndarray, "horizons"]
) -> tuple[Float64[np.ndarray, "known"], float, float]:
    """How many beliefs 0, 1, ... actions make, and the seconds for them and for a channel.

    Those of the processor: what else runs on a machine makes nothing cost more.
    """
    successors = problem.successors
    depth, counts, took, spent = 0, [1.0], 0.0, 0.0
    beliefs = beliefs_after(successors, start, 0)
    while depth < problem.horizon and counts[-1]:
        wide = 1 if successors.certain else reached[depth + 1]
        if depth > 0 and (counts[-1] * successors.actions * wide > _ENTRIES or spent > _TRIAL):
            break
        depth += 1
        began = time.thread_time()
        beliefs = beliefs_after(successors, start, depth)
        took = time.thread_time() - began
        spent += took
        counts.append(float(len(beliefs.steps[-1][0])))
    began = time.thread_time()
    solve_channel(problem, beliefs.states, beliefs.matrix)
    return np.array(counts), took, time.thread_time() - began
