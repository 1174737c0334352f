"""Empowerment from logged transitions, with an interval."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float64, Int64
from numpy.typing import ArrayLike

from habilis.checks import is_number
from habilis.empowerment.api import empowerment
from habilis.empowerment.arguments import at_least_one, chosen_actions, chosen_states, whole_number
from habilis.empowerment.combined import check_single
from habilis.empowerment.methods import Exact
from habilis.empowerment.sensors import Sensor
from habilis.mdp import TabularMDP
from habilis.mdp_arguments import moves_of
from habilis.probabilities import shape_of
from habilis.progress import progress_bar

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_LEAST = 40  # resamples: the 2.5 % quantiles of fewer are none
_TOLERANCE = 1e-4  # bits, far below what sampling does to them
_ROUNDING = 1e-9
_SETS = 10_000  # sets of states that are looked at in search of one sequence

Values = Float64[np.ndarray, "n"]


@dataclass(frozen=True, eq=False)
class PlugInInterval:
    """Empowerment from logged transitions.

    Attributes:
        bits: float64[n], bias-corrected: the plug-in value less its mean error in resampled logs,
            within the interval. NaN where no sequence of actions is known to the end.
        low, high: float64[n], the ends of the interval; NaN likewise.
        plug_in: float64[n], the empowerment of the table of relative frequencies.
        unknown: float64[n], the probability that a uniformly random sequence comes to an action
            that was never tried: 0 where everything is known, 1 where nothing is.
        confidence: how often the interval is meant to hold the true value.
    """

    bits: Values
    low: Values
    high: Values
    plug_in: Values
    unknown: Values
    confidence: float


def plug_in_interval(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor = "state",
    actions: ArrayLike | None = None,
    states: Any = None,
    *,
    confidence: float = 0.95,
    resamples: int = 200,
    seed: int = 0,
    show_progress: bool = False,
) -> PlugInInterval:
    """The empowerment of the world that transitions were logged in, and an interval for it.

    The plug-in value is too large where outcomes are random: actions that do the same look
    different in few samples; and it is too certain of outcomes that were seen only once. So the
    interval has two parts, and reaches from the lesser of their lower ends to the greater of the
    upper ones. Both are of the basic bootstrap's kind, which reflects or shifts the quantiles to
    undo the bias.

    - Logs are resampled, with the same number of transitions from each state by each action. With
      E the plug-in value and q the quantiles of the resampled ones: from 2 E - q_high to
      2 E - q_low.
    - Probabilities are drawn from Dirichlet distributions, with one further transition shared
      between all outcomes that any action has had in the state. Their quantiles about their mean
      are put about the value of the mean probabilities below, and about E above, both less the bias
      of the draws.

    The true value is that of the known sequences: with what was never tried, empowerment may be
    larger.

    Args:
        mdp: made by `TabularMDP.from_transitions`.
        horizon, sensor, actions, states: as in `empowerment`, one sensor; states are indices.
        confidence: how often the interval is meant to hold the true value, above 0 and below 1.
        resamples: of each kind, from 40 up.
        seed: of the draws.
        show_progress: whether to draw a progress bar on standard error.

    Returns:
        The interval of each state, and how much of what could be done is unknown.

    Raises:
        ValueError: the table was not made of logged transitions, or was changed since; or an
            argument is none of its kind.

    Example:
        >>> generator = np.random.default_rng(0)
        >>> actions = generator.integers(2, size=200)
        >>> reached = np.where(generator.random(200) < 0.9, actions, 1 - actions)
        >>> mdp = TabularMDP.from_transitions(np.zeros(200, int), actions, reached)
        >>> found = plug_in_interval(mdp, 1, states=[0, 1], resamples=40)
        >>> # The truth is 0.53 in state 0; of state 1 nothing is known.
        >>> found.bits.round(2), found.low.round(2), found.high.round(2), found.unknown
        (array([0.44,  nan]), array([0.28,  nan]), array([0.6, nan]), array([0., 1.]))
    """
    counts = _checked_counts(mdp)
    horizon, seed = whole_number("horizon", horizon), whole_number("seed", seed)
    check_single(mdp, sensor, "an interval")
    if not is_number(confidence) or not 0 < confidence < 1:
        raise ValueError(f"confidence is {confidence!r}; give a number between 0 and 1")
    if at_least_one("resamples", resamples) < _LEAST:
        raise ValueError(f"resamples is {resamples}; give at least {_LEAST}")
    used, starts = chosen_actions(mdp, actions), chosen_states(mdp, states)

    def bits_of(moves: "csr_array") -> Values:
        table = replace(mdp, transitions=moves, counts=None)
        method = Exact(tolerance=_TOLERANCE)
        return np.asarray(empowerment(table, horizon, sensor, used, starts, method=method))

    generator = np.random.default_rng(seed)
    prior = _with_prior(counts, mdp.action_count)
    tables = chain(
        (_shares(counts), _shares(prior)),
        (_shares(_resampled(counts, generator)) for _ in range(resamples)),
        (_shares(_dirichlet(prior, generator)) for _ in range(resamples)),
    )
    with progress_bar("resamples", show_progress) as report:
        values = np.stack(list(_reported(map(bits_of, tables), 2 + 2 * resamples, report)))
    plug_in, smooth = values[0], values[1]
    again, drawn = values[2 : 2 + resamples], values[2 + resamples :]

    tail = (1 - confidence) / 2
    low, high = np.quantile(again, [tail, 1 - tail], axis=0)
    least, most = np.quantile(drawn, [tail, 1 - tail], axis=0) - drawn.mean(axis=0)
    bias = np.maximum(drawn.mean(axis=0) - smooth, 0)
    largest = min(horizon * np.log2(len(used)), np.log2(mdp.states))
    below = np.clip(np.minimum(2 * plug_in - high, smooth - bias + least), 0, largest)
    above = np.clip(np.maximum(2 * plug_in - low, plug_in - bias + most), 0, largest)
    bits = np.clip(2 * plug_in - again.mean(axis=0), below, above)

    unknown = _unknown(mdp, horizon, used)[starts]
    blind = [
        index
        for index, start in enumerate(starts)
        if unknown[index] > 0 and plug_in[index] <= 0 and not _known(mdp, horizon, used, int(start))
    ]
    for one in (bits, below, above):
        one[blind] = np.nan
    return PlugInInterval(bits, below, above, plug_in, unknown, float(confidence))


def _checked_counts(mdp: TabularMDP) -> "csr_array":
    """The counts of a table, if its transitions are their relative frequencies."""
    if mdp.counts is None:
        raise ValueError(
            "the table was not made of logged transitions; TabularMDP.from_transitions makes one "
            "that keeps their counts"
        )
    moves, logged = moves_of(mdp.transitions), _shares(mdp.counts)
    if shape_of(moves) != shape_of(logged) or abs(moves - logged).max() > _ROUNDING:
        raise ValueError(
            "the table's transitions are no longer those that were logged; give the table that "
            "TabularMDP.from_transitions made"
        )
    return mdp.counts


def _shares(weights: "csr_array") -> "csr_array":
    """Each row divided by its sum, without zeros."""
    from scipy.sparse import csr_array

    total = np.asarray(weights.sum(axis=1), np.float64).ravel()
    shares = csr_array(weights.astype(np.float64))
    shares.data /= np.repeat(total, np.diff(weights.indptr))
    shares.eliminate_zeros()
    return shares


def _with_prior(counts: "csr_array", actions: int) -> "csr_array":
    """Counts with one transition more for each action that was tried in a state.

    It is divided equally between the outcomes that any action has had there.
    """
    from scipy.sparse import csr_array

    choices, states = shape_of(counts)
    rows = np.repeat(np.arange(choices), np.diff(counts.indptr))
    seen = csr_array((np.ones(len(rows)), (rows // actions, counts.indices)), (states, states))
    seen.data[:] = 1
    prior = _shares(seen)
    tried = np.flatnonzero(np.diff(counts.indptr))
    spread = csr_array((np.ones(len(tried)), (tried, tried // actions)), (choices, states))
    return csr_array(counts + spread @ prior)


def _resampled(counts: "csr_array", generator: np.random.Generator) -> "csr_array":
    """As many transitions of each row, drawn with its frequencies."""
    drawn = counts.copy()
    for first, last in zip(counts.indptr[:-1], counts.indptr[1:], strict=True):
        if last - first > 1:
            row = counts.data[first:last]
            drawn.data[first:last] = generator.multinomial(row.sum(), row / row.sum())
    return drawn


def _dirichlet(weights: "csr_array", generator: np.random.Generator) -> "csr_array":
    drawn = weights.copy()
    drawn.data = np.maximum(generator.gamma(weights.data), np.finfo(np.float64).tiny)
    return drawn


def _reported(values: Iterator[Values], known: int, report: Any) -> Iterator[Values]:
    for done, value in enumerate(values):
        report(done, known)
        yield value


def _unknown(
    mdp: TabularMDP, horizon: int, used: Int64[np.ndarray, "A"]
) -> Float64[np.ndarray, "S"]:
    """The probability that a random sequence comes to an action that was never tried."""
    known = np.ones(mdp.states)
    moves = [mdp.transition(action) for action in used]
    for _ in range(horizon):
        before = known
        known = np.stack([move @ known for move in moves]).mean(axis=0)
        if np.array_equal(known, before):
            break
    return np.where(known < 1 - _ROUNDING, 1 - known, 0.0)


def _known(mdp: TabularMDP, horizon: int, used: Int64[np.ndarray, "A"], start: int) -> bool:
    """Whether some sequence surely meets only actions that were tried, as far as is looked."""
    moves, available = moves_of(mdp.transitions), mdp.available
    sets = {frozenset((start,))}
    for _ in range(horizon):
        further = set()
        for some in sets:
            states = np.fromiter(some, np.int64)
            for action in used[available[np.ix_(states, used)].all(axis=0)]:
                rows = moves[states * mdp.action_count + action]
                further.add(frozenset(rows.indices.tolist()))
        if not further:
            return False
        sets = further
        if len(sets) > _SETS:
            return True
    return True
