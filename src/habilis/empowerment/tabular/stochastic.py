"""The empowerment of many states where outcomes or the sensor are uncertain."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from jaxtyping import Float64, Int64

from habilis.channels.small_channels import MOST_OUTPUTS
from habilis.empowerment.availability import with_nowhere
from habilis.empowerment.limits import Limits, Progress, too_much
from habilis.empowerment.tabular.beliefs import TooManyBeliefsError, unheard
from habilis.empowerment.tabular.blocks import in_turn
from habilis.empowerment.tabular.column_generation import certified, is_written_out, sampled
from habilis.empowerment.tabular.cost import check_effort, check_samples, most_entries
from habilis.empowerment.tabular.open_loop import Problem
from habilis.empowerment.tabular.successors import states_within
from habilis.probabilities import shape_of
from habilis.processors import processors

Bits = Float64[np.ndarray, "n"]
_LITTLE = 10_000  # sequences, of all states, for which a thread costs more than it does
_LONG = 64  # actions above which fewer with the same outcomes are looked for
Report = Callable[[int, int], None]
"""Receives how many states are done, and how many there are."""


def certified_bits(
    problem: Problem,
    starts: Int64[np.ndarray, "n"],
    threads: int | None,
    limits: Limits,
    report: Report = unheard,
) -> tuple[Bits, Bits]:
    """Empowerment and gap of states, float64[n] bits each; without `threads` as many as pay.

    Raises:
        ValueError: it would take more than the limits; see `cost.check_effort`.
    """
    problem = _soonest(problem)
    threads = threads or _worthwhile(problem, starts)
    check_effort(problem, starts, threads, limits)
    at_once = min(threads, len(starts)) or 1
    problem = replace(problem, most_entries=most_entries(limits, at_once))

    _ = problem.last  # once, before there are threads

    def answer(start: int) -> tuple[float, float]:
        try:
            return certified(problem, start)
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


def _worthwhile(problem: Problem, starts: Int64[np.ndarray, "n"]) -> int:
    """As many threads as processors, unless there is little to do, or NumPy and BLAS do it."""
    horizon, actions = problem.horizon, problem.successors.actions
    if is_written_out(problem):
        return 1
    if not len(starts) or horizon * np.log(actions) + np.log(len(starts)) < np.log(_LITTLE):
        return 1
    if shape_of(problem.sensor)[1] > MOST_OUTPUTS:
        widest = [starts[0], starts[len(starts) // 2], starts[-1]]
        near = [states_within(problem.successors, int(start), horizon)[-1] for start in widest]
        if max(near) > MOST_OUTPUTS:
            return 1
    return processors()


def lower_bounds(
    problem: Problem,
    starts: Int64[np.ndarray, "n"],
    samples: int,
    seed: int,
    threads: int | None,
    limits: Limits,
    report: Report = unheard,
) -> tuple[Bits, Bits]:
    """Bits that some sequences attain, and how much more there could be at the very most.

    Raises:
        ValueError: it would take more than the limits; see `cost.check_samples`.
    """
    threads = threads or _worthwhile(problem, starts)
    check_samples(problem, starts, samples, threads, limits)
    return _for_all(lambda start: sampled(problem, start, samples, seed), starts, threads, report)


def _for_all(
    answer: Callable[[int], tuple[float, float]],
    starts: Int64[np.ndarray, "n"],
    threads: int,
    report: Report,
) -> tuple[Bits, Bits]:
    """Bits and gaps; a state's are the same whatever thread works on it."""
    asked, place = np.unique(starts, return_inverse=True)
    found = np.zeros((len(asked), 2))

    def work(part: int, watch: Progress) -> None:
        found[part] = answer(int(asked[part]))

    in_turn(work, len(asked), threads, lambda share: report(round(share * len(asked)), len(asked)))
    return found[place, 0], found[place, 1]
