"""The empowerment of many states where outcomes or the sensor are uncertain."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
from jaxtyping import Float64, Int64

from habilis.empowerment.availability import with_nowhere
from habilis.empowerment.limits import Limits, too_much
from habilis.empowerment.tabular.beliefs import TooManyBeliefsError, unheard
from habilis.empowerment.tabular.cost import check_effort, check_samples, most_entries
from habilis.empowerment.tabular.open_loop import Answer, Problem, exact, sampled

Bits = Float64[np.ndarray, "n"]
_LONG = 64  # actions above which fewer with the same outcomes are looked for
Tell = Callable[[int, int], None]
"""Receives how many states are done, and how many there are."""


def certified_bits(
    problem: Problem,
    starts: Int64[np.ndarray, "n"],
    threads: int,
    limits: Limits,
    report: Tell = unheard,
) -> tuple[Bits, Bits]:
    """Empowerment and gap of states, float64[n] bits each.

    Raises:
        ValueError: it would take more than the limits; see `effort.check_effort`.
    """
    problem = _soonest(problem)
    check_effort(problem, starts, threads, limits)
    at_once = min(threads, len(starts)) or 1
    problem = replace(problem, most_entries=most_entries(limits, at_once))

    def answer(start: int) -> Answer:
        try:
            return exact(problem, start)[1]
        except TooManyBeliefsError as error:
            raise too_much(problem.horizon, error.horizon, limits) from None

    return _for_all(answer, starts, threads, report)


def _soonest(problem: Problem) -> Problem:
    """The problem with the least known horizon of the same outcomes, where these are certain."""
    if not problem.successors.certain or problem.horizon <= _LONG:
        return problem
    from habilis.empowerment.tabular.eventual import same_horizon
    from habilis.empowerment.tabular.spreading import Graph

    table = problem.successors.next_state
    table, _ = with_nowhere(table, np.zeros(len(table), np.int32))
    apart = 0 if problem.successors.seen is None else 1  # the last action, to observations
    horizon = same_horizon(Graph.of(table), problem.horizon - apart) + apart
    return replace(problem, horizon=horizon)


def lower_bounds(
    problem: Problem,
    starts: Int64[np.ndarray, "n"],
    samples: int,
    seed: int,
    threads: int,
    limits: Limits,
    report: Tell = unheard,
) -> tuple[Bits, Bits]:
    """Bits that some sequences attain, and how much more there could be at the very most.

    Raises:
        ValueError: it would take more than the limits; see `effort.check_samples`.
    """
    check_samples(problem, starts, samples, threads, limits)
    return _for_all(lambda start: sampled(problem, start, samples, seed), starts, threads, report)


def _for_all(
    answer: Callable[[int], Answer],
    starts: Int64[np.ndarray, "n"],
    threads: int,
    report: Tell,
) -> tuple[Bits, Bits]:
    """Bits and gaps; a state's are the same whatever thread works on it."""
    asked, place = np.unique(starts, return_inverse=True)

    def both(start: int) -> tuple[float, float]:
        found = answer(start)
        return found.bits, found.gap

    pairs = []
    if threads == 1 or len(asked) < 2:
        for start in asked.tolist():
            pairs.append(both(start))
            report(len(pairs), len(asked))
    else:
        with ThreadPoolExecutor(threads) as pool:
            for pair in pool.map(both, asked.tolist()):
                pairs.append(pair)
                report(len(pairs), len(asked))
    values = np.array(pairs).reshape(-1, 2)
    return values[place, 0], values[place, 1]
