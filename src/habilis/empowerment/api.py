"""Empowerment: the capacity of the channel from the next h actions to the sensor."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal, TypedDict, Unpack, overload

import numpy as np
from jaxtyping import Float64, Int64
from numpy.typing import ArrayLike

from habilis.channels.capacity import checked_tolerance, warn_of_gap
from habilis.empowerment.arguments import (
    Unit,
    at_least_one,
    chosen_actions,
    chosen_states,
    per_bit,
    positive,
    whole_number,
)
from habilis.empowerment.availability import with_nowhere
from habilis.empowerment.limits import MAX_GIB, MAX_SECONDS, OTHERWISE, Limits, Progress
from habilis.empowerment.sensors import Sensor, is_noisy, observations
from habilis.mdp import TabularMDP
from habilis.processors import processors
from habilis.progress import in_percent, progress_bar
from habilis.worlds.placements import Placement
from habilis.worlds.reach import reachable
from habilis.worlds.table import tabulate
from habilis.worlds.world import World

if TYPE_CHECKING:
    from habilis.empowerment.tabular.deterministic import Question

States = ArrayLike | Placement | Sequence[Placement]
"""Indices, bool[S] or, of a world, placements."""

Bits = Float64[np.ndarray, "n"]
Method = Literal["exact", "sampled"]


class Options(TypedDict, total=False):
    """What else `empowerment` and the measures made of it may be told; see there."""

    unit: Unit
    tolerance: float
    method: Method
    samples: int
    seed: int
    threads: int | None
    max_gib: float
    max_seconds: float
    show_progress: bool


@overload
def empowerment(
    mdp: TabularMDP | World,
    horizon: int,
    sensor: Sensor = ...,
    actions: ArrayLike | None = ...,
    states: States | None = ...,
    *,
    return_gap: Literal[False] = ...,
    **options: Unpack[Options],
) -> Bits: ...


@overload
def empowerment(
    mdp: TabularMDP | World,
    horizon: int,
    sensor: Sensor = ...,
    actions: ArrayLike | None = ...,
    states: States | None = ...,
    *,
    return_gap: Literal[True],
    **options: Unpack[Options],
) -> tuple[Bits, Bits]: ...


def empowerment(
    mdp: TabularMDP | World,
    horizon: int,
    sensor: Sensor = "state",
    actions: ArrayLike | None = None,
    states: States | None = None,
    *,
    return_gap: bool = False,
    unit: Unit = "bits",
    tolerance: float = 1e-6,
    method: Method = "exact",
    samples: int = 1000,
    seed: int = 0,
    threads: int | None = None,
    max_gib: float = MAX_GIB,
    max_seconds: float = MAX_SECONDS,
    show_progress: bool = False,
) -> Bits | tuple[Bits, Bits]:
    """The h-step empowerment of states, in bits.

    The capacity of the channel from sequences of h actions, chosen without looking in between
    (open loop), to what the sensor shows afterwards,

        E_h(s) = max over p(a_1 ... a_h) of I(A_1 ... A_h; O_h | s)

    (Klyubin, Polani and Nehaniv 2005; Salge, Glackin and Polani 2014; equation 2 of Rasheed,
    Polani and Catenacci Volpi 2023). In a deterministic MDP with a sensor of labels the channel
    is noiseless, and this is log2 of the number of observations that some sequence leads to:
    exact, without listing sequences. Otherwise sequences that lead to the same belief are
    merged, and the capacity of the channel that is left is certified. Terminal states do not
    stop the counted sequences.

    Where actions are not available everywhere, p ranges over the sequences that can surely be
    carried out: each action is available in every state that is possible at its step,

        A_h(s) = {a_1 ... a_h : a_t in A(x) for all t and all x with P(S_(t-1) = x | s, a_1 ...
        a_(t-1)) > 0}

    Where there is no such sequence, empowerment is 0, and so is the gap.

    Args:
        mdp: the table; or a world, of which then only so much is tabulated as h actions can reach
            from the states asked about.
        horizon: h, how many actions, 0 or more.
        sensor: "state" (fully observable empowerment), a factor's name ("object" for object
            empowerment, "object:can" where there are several), int[S] or bool[S] labels, or
            float[S, O] probabilities of observations (also scipy.sparse).
        actions: the action indices that sequences are made of; by default all.
        states: the n states asked about, as indices or as bool[S]; of a world, as placements such
            as `{"agent": (0, 0), "tool": (1, 0), "object": (2, 2)}`. By default all, in order.
        return_gap: whether to return the certificate too.
        unit: "bits" or "nats", of values, gaps and tolerance.
        tolerance: the gap at which to stop, where the channel is noisy.
        method: "exact", or "sampled": only some sequences are tried, so that the value is a lower
            bound; its gap then reaches up to what no sequences could exceed.
        samples: how many sequences of a state "sampled" draws, uniformly and with replacement.
        seed: of the sampling; a state's sequences do not depend on which others are asked about.
        threads: how many work side by side; the values are the same for any number. By default
            as many as there are processors; one where channels are noisy, because there the
            linear algebra uses the processors by itself.
        max_gib: memory in GiB that it may take besides the table, foreseen before the start.
        max_seconds: time in seconds that it may take, by an estimate made before the start: of
            noisy channels from a few states, of counting from its first moments. A fixed point or
            a period of what can be reached, which ends long horizons early, is part of it.
        show_progress: whether to draw a progress bar on standard error, once it takes two seconds.

    Returns:
        float64[n]; with `return_gap` also float64[n], for each state a proven upper bound on how
        much larger the true value is (0 where it is a count).

    Raises:
        ValueError: a horizon that is not a whole number from 0 up, an unknown sensor, no
            actions, an action or state that the MDP does not have, another argument that is none
            of its kind, or a computation above max_gib or max_seconds: the message then names the
            largest horizon that fits, "about" where it is estimated from a time.

    Warns:
        ConvergenceWarning: a gap is above the tolerance (never for "sampled").

    Example:
        >>> mdp = TabularMDP.deterministic([[0, 1], [1, 0]])
        >>> empowerment(mdp, horizon=3)
        array([1., 1.])
        >>> empowerment(mdp.slippery(0.2), horizon=1).round(3)
        array([0.531, 0.531])
    """
    horizon = whole_number("horizon", horizon)
    scale = per_bit(unit)
    if method not in ("exact", "sampled"):
        raise ValueError(f"method is {method!r}; use 'exact' or 'sampled'")
    if threads is not None:
        threads = at_least_one("threads", threads)
    tolerance = checked_tolerance(tolerance) / scale
    samples, seed = at_least_one("samples", samples), whole_number("seed", seed)
    max_gib, max_seconds = positive("max_gib", max_gib), positive("max_seconds", max_seconds)
    if isinstance(mdp, World):
        mdp, states = _around(mdp, horizon, sensor, states, show_progress)
    used, starts = chosen_actions(mdp, actions), chosen_states(mdp, states)
    limits = Limits(max_gib, max_seconds, OTHERWISE[method])
    if not mdp.is_stochastic and not is_noisy(sensor) and method == "exact":
        counters = threads or processors()
        some = None if states is None else starts
        with progress_bar("empowerment", show_progress) as bar:
            tell = in_percent(bar)
            bits = _counted(mdp, horizon, sensor, used, some, counters, limits, tell)
        gap = np.zeros(len(bits))
    else:
        from habilis.empowerment.tabular import stochastic
        from habilis.empowerment.tabular.open_loop import problem_of

        problem = problem_of(mdp, horizon, sensor, used, tolerance)
        threads = threads or 1
        with progress_bar("states", show_progress) as tell:
            if method == "sampled":
                bits, gap = stochastic.lower_bounds(
                    problem, starts, samples, seed, threads, limits, tell
                )
            else:
                bits, gap = stochastic.certified_bits(problem, starts, threads, limits, tell)
        if method == "exact" and (gap > tolerance).any():
            warn_of_gap(float(gap.max()), tolerance)
    return (bits * scale, gap * scale) if return_gap else bits * scale


def _around(
    world: World, horizon: int, sensor: Sensor, states: States | None, show_progress: bool
) -> tuple[TabularMDP, Int64[np.ndarray, "n"] | None]:
    """As much of a world's table as is needed, and the asked states in it."""
    if not isinstance(sensor, str):
        raise ValueError(
            "a world's states have no numbers yet; give the name of a factor or 'state' as sensor, "
            "or tabulate the world"
        )
    if states is None:
        return tabulate(world, show_progress=show_progress), None
    return reachable(world, states, horizon, show_progress=show_progress)


def _counted(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor,
    actions: Int64[np.ndarray, "A"],
    starts: Int64[np.ndarray, "n"] | None,
    threads: int,
    limits: Limits,
    tell: Progress,
) -> Bits:
    """The logarithms of how many observations can be brought about, where nothing is noisy."""
    # Numba takes as long to import as everything else together: only who computes pays.
    from habilis.empowerment.tabular.deterministic import counts

    question = question_of(mdp, horizon, sensor, actions, starts, threads, limits, tell)
    return bits_of(counts(question))


def question_of(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor,
    actions: Int64[np.ndarray, "A"],
    starts: Int64[np.ndarray, "n"] | None,
    threads: int,
    limits: Limits,
    tell: Progress,
) -> "Question":
    """What is to be counted for a measure of a deterministic table."""
    from habilis.empowerment.tabular.deterministic import Question

    labels, label_count = observations(mdp, sensor)
    named = isinstance(sensor, str) and sensor != "state"
    cells = named and mdp.is_cell(mdp.factor_named(str(sensor)))
    table = mdp.next_state
    if len(actions) < mdp.action_count:
        table = np.ascontiguousarray(table[:, actions])
    table, labels = with_nowhere(table, labels)
    if len(labels) > mdp.states:  # the state added is not asked about, and has no cell
        cells, starts = False, np.arange(mdp.states) if starts is None else starts
    return Question(
        table,
        labels,
        label_count,
        horizon,
        starts,
        mdp.factor(str(sensor)) if cells else None,
        mdp.shape,
        threads,
        limits,
        tell,
    )


def bits_of(counts: Int64[np.ndarray, "*any"]) -> Float64[np.ndarray, "*any"]:
    """The capacity of noiseless channels to so many observations; of none it is 0."""
    return np.log2(np.maximum(counts, 1))
