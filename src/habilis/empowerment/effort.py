"""What a stochastic computation will cost, known before it starts."""

import time
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64

from habilis.empowerment.beliefs import beliefs_after, states_within
from habilis.empowerment.limits import Limits, TooMuchError, takes, too_much
from habilis.empowerment.open_loop import Problem, solve_channel
from habilis.probabilities import shape_of

_PROBED = 3  # states looked at
_ENTRIES = 200_000  # numbers in the beliefs of a state up to which they are tried out
_BYTES = 8 * 4  # a number of a belief: in an array perhaps just doubled, and what comes of it
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
    if successors.certain or not len(starts) or worst <= np.log(_TRIFLE):
        return
    effort = estimate(problem, starts, threads)
    fits = (effort.gib <= limits.gib) & (effort.seconds <= limits.seconds)
    if not fits.all():
        cost = takes(effort.gib[-1], effort.seconds[-1])
        raise too_much(horizon, int(np.argmin(fits)) - 1, limits, cost)


def check_samples(
    problem: Problem, starts: Int64[np.ndarray, "n"], samples: int, threads: int, limits: Limits
) -> None:
    pass


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
    entries = beliefs * reached
    memory = _BYTES * entries + 20 * beliefs * successors.actions
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
    depth, counts, took = 0, [1.0], 0.0
    beliefs = beliefs_after(successors, start, 0)
    while depth < problem.horizon:
        if depth > 0 and counts[-1] * successors.actions * reached[depth + 1] > _ENTRIES:
            break
        depth += 1
        began = time.thread_time()
        beliefs = beliefs_after(successors, start, depth)
        took = time.thread_time() - began
        counts.append(float(len(beliefs.steps[-1][0])))
    began = time.thread_time()
    solve_channel(problem, beliefs.states, beliefs.matrix)
    return np.array(counts), took, time.thread_time() - began
