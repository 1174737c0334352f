"""Cost estimates for computations with noisy transitions or a noisy sensor."""

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64, Int64

from habilis.channels.capacity_solver import best_inputs
from habilis.channels.small_channels import compile_solver
from habilis.empowerment.limits import Limits, takes, too_much
from habilis.empowerment.tabular.beliefs import ENOUGH, FEWER, compile_kernels
from habilis.empowerment.tabular.column_generation import (
    capacity_of,
    is_written_out,
    sequences_from,
)
from habilis.empowerment.tabular.last_actions import compile_last_actions
from habilis.empowerment.tabular.open_loop import Problem, drawn, solve_channel
from habilis.empowerment.tabular.outcomes import outcomes_after
from habilis.empowerment.tabular.successors import states_within
from habilis.probabilities import shape_of

_PROBED, _LEAST_PROBED = 17, 3  # states looked at, from all over ...
_ORDER = (0, 8), (4, 8), (2, 4), (1, 2)  # ... by their first and their distance
_ENTRIES = 200_000  # numbers in the beliefs of a state up to which they are tried out
_BYTES = 8 * 4  # a number of a belief: in an array perhaps just doubled, and what comes of it
_NUMBERS = 4  # for each sequence of which only a number is kept
_POOL = 8 * 4  # bytes for a number in the pool of sequences
_STEP = 300  # bytes that each step takes however few beliefs there are
_TRIAL = 0.3  # seconds that trying out a state may take
_FORESEEN = 2_000  # horizons looked at one by one
_TRIFLE_OF_LAST_ACTIONS = 200_000_000  # as below, where they are followed side by side
_TRIFLE = 20_000_000  # numbers in all states' beliefs, at worst, below which no estimate is needed


@dataclass(frozen=True)
class Effort:
    """The cost of each horizon from 0 to h.

    Attributes:
        gib: float64[h + 1], memory at once.
        seconds: float64[h + 1].
    """

    gib: Float64[np.ndarray, "horizons"]
    seconds: Float64[np.ndarray, "horizons"]


def check_effort(
    problem: Problem,
    starts: Int64[np.ndarray, "n"],
    threads: int,
    limits: Limits,
    listed: bool = False,
) -> None:
    """Refuses what would take more than it may.

    Args:
        problem: what is asked.
        starts: of which states.
        threads: how many work side by side.
        limits: on time and memory.
        listed: whether the distinct outcomes of all sequences are kept, as `open_loop.exact` does.

    Raises:
        TooMuchError: the estimate of memory or time is above its limit; the message has both, and
            the largest horizon that fits.
    """
    successors, horizon = problem.successors, problem.horizon
    actions, listed = successors.actions, listed or is_written_out(problem)
    if successors.certain:  # beliefs are states: so many are gone through, or make a channel
        worst = np.log(
            max(horizon * actions, _width(problem, np.array([float(successors.states)]))[0])
        )
        worst += np.log(_rows(problem))
    else:
        worst = horizon * np.log(actions)
    worst += np.log(max(len(starts), 1))
    trifling = _TRIFLE if listed or successors.certain else _TRIFLE_OF_LAST_ACTIONS
    trifle = np.log(max(min(trifling * min(limits.seconds, 1.0), most_entries(limits, 1)), 1e-300))
    if not len(starts):
        return
    if horizon <= _FORESEEN and worst <= trifle:
        wide = max(states_within(successors, start, horizon)[-1] for start in _probes(starts))
        if worst + np.log(wide) <= trifle:
            return
    effort = estimate(replace(problem, horizon=min(horizon, _FORESEEN)), starts, threads, listed)
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
    raise too_much(horizon, fitting, limits, takes(gib, seconds), estimated=True)


def check_samples(
    problem: Problem, starts: Int64[np.ndarray, "n"], samples: int, threads: int, limits: Limits
) -> None:
    """Refuses samples of sequences that would take more than they may.

    Raises:
        TooMuchError: as above.
    """
    successors, horizon = problem.successors, problem.horizon
    if not len(starts):
        return
    states, first = len(np.unique(starts)), int(starts[0])
    short = replace(problem, horizon=min(horizon, _FORESEEN))
    wide = max(states_within(successors, start, short.horizon)[-1] for start in _probes(starts))
    if wide * horizon * samples * states <= _TRIFLE * min(limits.seconds, 1.0):
        return
    _compile(short, first)
    drawn(replace(short, horizon=min(horizon, 1)), first, 1, 0)
    tried = [_sampling_tried(short, start, samples) for start in _probes(starts)]
    following, solving = np.mean(tried, axis=0) * states / threads
    gib = 8.0 * samples * min(threads, states) * horizon / 2**30
    seconds = following * horizon / max(short.horizon, 1) + solving
    if gib > limits.gib or seconds > limits.seconds:
        fitting = int(horizon * min(limits.gib / gib, limits.seconds / seconds))
        fitting = min(fitting, horizon - 1)
        raise too_much(horizon, fitting, limits, takes(gib, seconds), estimated=True)


def _sampling_tried(
    problem: Problem, start: int, samples: int
) -> Float64[np.ndarray, "following_and_solving"]:
    """Seconds for following the sequences of a state, and for their channel.

    Both have a part that is the same for any number of sequences: what more of them take follows
    from the last two numbers tried.
    """
    tried, took = min(samples, 10), []
    while True:
        began = time.thread_time()
        states, matrix = drawn(problem, start, tried, 0)
        followed = time.thread_time()
        solve_channel(problem, states, matrix)
        ended = time.thread_time()
        took.append(np.array([followed - began, ended - followed]))
        if tried == samples:
            return took[-1]
        if len(took) > 1 and 2 * (ended - began) > _TRIAL:
            more = np.maximum(took[-1] - took[-2], 0) / (tried - tried // 2)
            return took[-1] + more * (samples - tried)
        tried = min(samples, 2 * tried)


def most_entries(limits: Limits, at_once: int) -> int:
    """How many numbers the beliefs of one of so many states at once may be."""
    return int(min(limits.gib * 2**30 / (_BYTES * at_once), 2**62))


def estimate(
    problem: Problem, starts: Int64[np.ndarray, "n"], threads: int, listed: bool = False
) -> Effort:
    """Memory and time of every horizon up to the problem's, from a look at a few states.

    In these, beliefs are followed as far as that is cheap, and timed. From there on each step
    multiplies them as the last one did, which merging seldom exceeds.
    """
    _compile(problem, int(starts[0]), listed)
    probe = _probe if listed or problem.successors.certain else _probe_of_last_actions
    probed = [probe(problem, start) for start in _probes(starts)]
    gib = np.max([memory for memory, _ in probed], axis=0)
    seconds = np.mean([taken for _, taken in probed], axis=0)
    return Effort(gib * min(threads, len(starts)), seconds * len(np.unique(starts)) / threads)


def _probes(starts: Int64[np.ndarray, "n"]) -> Iterator[int]:
    """The states that are looked at, from all over: a few, and more while they take no time."""
    began = time.thread_time()
    spread = starts[np.linspace(0, len(starts) - 1, _PROBED).astype(int)]
    order = [place for first, step in _ORDER for place in range(first, _PROBED, step)]
    for count, start in enumerate(dict.fromkeys(spread[order].tolist())):
        if count >= _LEAST_PROBED and time.thread_time() - began > _TRIAL:
            return
        yield start


def _probe(
    problem: Problem, start: int
) -> tuple[Float64[np.ndarray, "horizons"], Float64[np.ndarray, "horizons"]]:
    """GiB and seconds of one state, by horizon."""
    successors, horizon = problem.successors, problem.horizon
    reached = states_within(successors, start, horizon)
    wide = _width(problem, reached)
    counts, took, solving = _tried(problem, start, wide)
    known = len(counts) - 1
    beliefs = _continued(counts, horizon)
    if successors.certain:
        beliefs = np.minimum(beliefs, reached * _rows(problem))
    entries = beliefs * wide
    followed = beliefs if successors.certain else entries
    parents = np.cumsum(8 * beliefs + _STEP)  # how each belief came about
    memory = _BYTES * entries + 20 * beliefs * successors.actions + parents
    worked = np.cumsum(followed) * successors.actions
    seconds = worked * took / max(worked[known], 1) + entries * solving / max(entries[known], 1)
    return memory / 2**30, seconds


def _continued(
    counts: Float64[np.ndarray, "known"], horizon: int
) -> Float64[np.ndarray, "horizons"]:
    """The number of beliefs of every horizon from the first ones."""
    known = len(counts) - 1
    factor = counts[-1] / counts[-2] if known else 1.0
    # Past this many nothing fits anyway, and products of it are still numbers.
    steps = np.minimum(np.arange(1.0, horizon - known + 1), 200 / np.log10(max(factor, 1.01)))
    return np.concatenate([counts, counts[-1] * factor**steps])


def _probe_of_last_actions(
    problem: Problem, start: int
) -> tuple[Float64[np.ndarray, "horizons"], Float64[np.ndarray, "horizons"]]:
    """GiB and seconds of one state, by horizon, where the last actions are followed side by side.

    Of every sequence one number is kept, and two more come of it.
    """
    horizon, actions = problem.horizon, problem.successors.actions
    wide = _width(problem, states_within(problem.successors, start, horizon))
    counts, following, solving = [1.0], 0.0, 0.0
    while len(counts) <= horizon and counts[-1]:
        depth = len(counts)
        if depth > 1 and counts[-1] * actions * wide[depth] > _ENTRIES:
            break
        began = time.thread_time()
        sequences, merged = sequences_from(replace(problem, horizon=depth), start)
        neg_entropies = sequences.neg_entropies()
        followed = time.thread_time()
        capacity_of(sequences, neg_entropies, problem.tolerance, merged)
        following, solving = followed - began, time.thread_time() - followed
        counts.append(float(sequences.sequences))
        if following + solving > _TRIAL:
            break
    known = len(counts) - 1
    leaves = _continued(np.array(counts), horizon)
    entries = leaves * wide
    before = np.concatenate([[0.0], entries[:-1]])
    held = np.minimum(before, ENOUGH * actions) if _grows(counts, actions) else before
    memory = _BYTES * held + 8 * _NUMBERS * leaves + _POOL * wide * np.minimum(leaves, 8 * wide)
    relative = np.maximum(entries / max(entries[known], 1.0), 1e-3)
    # The divergences of all sequences, of a few rounds, are a part of following them.
    seconds = following * 1.3 * relative + solving * (wide / wide[known]) ** 2
    return memory / 2**30, np.maximum.accumulate(seconds)


def _grows(counts: list[float], actions: int) -> bool:
    """Whether beliefs are no longer merged after a while."""
    return len(counts) > 1 and counts[-1] >= FEWER * actions * counts[-2]


def _compile(problem: Problem, start: int, listed: bool = False) -> None:
    """Does once what is timed later: the first time, it is compiled, for many seconds."""
    compile_kernels()
    if not listed:
        compile_last_actions()
        compile_solver()
    beliefs = outcomes_after(problem.successors, start, min(1, problem.horizon))
    solve_channel(problem, beliefs.states, beliefs.matrix)
    best_inputs(np.array([[0.9, 0.1], [0.2, 0.8]]), 1e-6)


def _width(
    problem: Problem, reached: Float64[np.ndarray, "horizons"]
) -> Float64[np.ndarray, "horizons"]:
    """Numbers in a row at most: of a belief or, where it is one state, of its channel."""
    if problem.successors.seen is not None:
        seen = np.full_like(reached, shape_of(problem.sensor)[1])
        return seen if problem.successors.certain else np.maximum(reached, seen)
    if not problem.successors.certain:
        return reached
    seen = int(np.diff(problem.sensor.indptr).max(initial=1))
    return np.minimum(reached * seen, shape_of(problem.sensor)[1])


def _rows(problem: Problem) -> int:
    """Rows of a channel at most for each belief that is one state."""
    return 1 if problem.successors.seen is None else problem.successors.actions


def _tried(
    problem: Problem, start: int, wide: Float64[np.ndarray, "horizons"]
) -> tuple[Float64[np.ndarray, "known"], float, float]:
    """How many beliefs 0, 1, ... actions make, and the seconds for them and for a channel.

    Those of the processor: what else runs on a machine makes nothing cost more.
    """
    successors = problem.successors
    depth, counts, took, spent = 0, [1.0], 0.0, 0.0
    beliefs = outcomes_after(successors, start, 0)
    while depth < problem.horizon and counts[-1]:
        entries = counts[-1] * successors.actions * wide[depth + 1]
        if depth > 0 and (entries > _ENTRIES or spent > _TRIAL):
            break
        depth += 1
        began = time.thread_time()
        beliefs = outcomes_after(successors, start, depth)
        took = time.thread_time() - began
        spent += took
        counts.append(float(len(beliefs.steps[-1][0])))
    began = time.thread_time()
    solve_channel(problem, beliefs.states, beliefs.matrix)
    return np.array(counts), took, time.thread_time() - began
