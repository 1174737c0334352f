"""Empowerment: the capacity of the channel from the next h actions to the sensor."""

from collections.abc import Sequence
from typing import Any, Literal, TypedDict, cast, overload

import numpy as np
from jaxtyping import Float64, Int64
from numpy.typing import ArrayLike

from habilis.channels.capacity import warn_of_gap
from habilis.empowerment.arguments import (
    Unit,
    chosen_actions,
    chosen_states,
    per_bit,
    whole_number,
)
from habilis.empowerment.budget import is_budgeted, mean_costs, within_budget
from habilis.empowerment.combined import check_single, combined_with_gaps
from habilis.empowerment.initial_beliefs import are_beliefs, with_beliefs
from habilis.empowerment.methods import Exact, Method, Sampled, checked_method
from habilis.empowerment.noiseless import counted_bits
from habilis.empowerment.old_keywords import takes_old_keywords
from habilis.empowerment.sensors import Sensor, is_noisy
from habilis.estimators.protocol import Estimator, is_estimator
from habilis.mdp import TabularMDP
from habilis.models.explore import AnyModel, explore
from habilis.progress import progress_bar
from habilis.tasks.task import Executor
from habilis.worlds.placements import Placement
from habilis.worlds.reach import reachable
from habilis.worlds.table import whole_table
from habilis.worlds.world import World

States = ArrayLike | Placement | Sequence[Any]
"""Indices, bool[S] or, of a world, placements; of a model, its states."""

SensorAt = Literal["end", "each step"]

Bits = Float64[np.ndarray, "n"]
Curves = Float64[np.ndarray, "n *budgets"]

_EXACT = Exact()


class Options(TypedDict, total=False):
    """Further arguments of `empowerment`, which the measures made of it pass on; see there."""

    unit: Unit
    method: Method
    executor: Executor[Any] | None
    show_progress: bool


@overload
def empowerment(
    model: AnyModel,
    horizon: int,
    sensor: Sensor = ...,
    actions: ArrayLike | None = ...,
    states: States | None = ...,
    *,
    sensor_at: SensorAt = ...,
    cost: ArrayLike | None = ...,
    budget: Any = ...,
    player: str | None = ...,
    others: Any = ...,
    method: Method | Estimator = ...,
    return_gap: Literal[False] = ...,
    unit: Unit = ...,
    executor: Executor[Any] | None = ...,
    show_progress: bool = ...,
) -> Bits: ...


@overload
def empowerment(
    model: AnyModel,
    horizon: int,
    sensor: Sensor = ...,
    actions: ArrayLike | None = ...,
    states: States | None = ...,
    *,
    sensor_at: SensorAt = ...,
    cost: ArrayLike | None = ...,
    budget: Any = ...,
    player: str | None = ...,
    others: Any = ...,
    method: Method = ...,
    return_gap: Literal[True],
    unit: Unit = ...,
    executor: Executor[Any] | None = ...,
    show_progress: bool = ...,
) -> tuple[Bits, Bits]: ...


@takes_old_keywords
def empowerment(
    model: AnyModel,
    horizon: int,
    sensor: Sensor = "state",
    actions: ArrayLike | None = None,
    states: States | None = None,
    *,
    sensor_at: SensorAt = "end",
    cost: ArrayLike | None = None,
    budget: Any = None,
    player: str | None = None,
    others: Any = None,
    method: Method | Estimator = _EXACT,
    return_gap: bool = False,
    unit: Unit = "bits",
    executor: Executor[Any] | None = None,
    show_progress: bool = False,
) -> Curves | tuple[Curves, Curves]:
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
        model: a table; or a `World`, a `Model` or a `VectorModel`, of which only so much is
            explored as h actions can reach from the states asked about; or a Gymnasium environment.
            With an estimator as method a `Simulator`, or a table.
        horizon: h, how many actions, 0 or more.
        sensor: "state" (fully observable empowerment), a factor's name ("object" for object
            empowerment, "object:can" where there are several), "rest" for all factors but "agent",
            or but the `player`, together (empowerment of the surroundings; Dai et al. 2023),
            int[S] or bool[S] labels,
            float[S, O] probabilities of observations (also scipy.sparse), or float[A, S, O], where
            the observation depends on the last action a too, and on the state that it led to (the
            next state's, as in a POMDP; no action, no observation). Or several names, as in
            "object:can + object:ball" and "object:can * object:ball": the sum or the product of
            the values through each, which are in `unit`. That is not a joint sensor.
        actions: the action indices that sequences are made of; by default all.
        states: the n states asked about, as indices or as bool[S]; of a world, as placements such
            as `{"agent": (0, 0), "tool": (1, 0), "object": (2, 2)}`; of a model, a list of its
            states. By default all, in order, those of `explore`. Or float[n, S], distributions
            over states: the agent does not know where it is, and the channel is the mean of those
            of the states. (The mean of their capacities is another number, never less: that of an
            agent that knows.)
        sensor_at: "end", or "each step": the output is the sequence of observations, one after each
            action. Without noise they are counted; with noise the channel is written out, which
            is for short horizons.
        cost, budget: float[S, A], 0 or more, what each action costs in each state, and what a
            sequence may cost in the mean: the capacity subject to that (Blahut 1972). Several
            budgets, in a sequence, give the curve: float64[n, budgets].
        player: of a table of several players, whose empowerment it is; `actions`, `cost` and a
            sensor by action are then the player's. Without it the inputs are the joint actions.
        others: what the other players do: a policy, as in `TabularMDP.of_player`, by default
            "uniform"; or "best" or "worst", the sequence of theirs, chosen in advance, against
            which the value is the largest or the least.
        method: `Exact` or `Sampled`, with their settings, such as `Exact(max_seconds=60)`; what it
            may cost, and the gap to reach, are those of each sensor. Or an estimator, such as
            `Gaussian`, fitted with seed 0: sensor and states are then a simulator's (see
            `habilis.estimators.sensors`), and the value is what the estimator's `kind` says.
        return_gap: whether to return the certificate too.
        unit: "bits" or "nats", of values, gaps and tolerance.
        executor: runs ranges of the states as tasks elsewhere, with the same values: in processes
            (`habilis.tasks.processes`), on a Ray cluster (`on_ray`), kept on disk (`kept_in`). The
            limits of the method and its threads, by default one, are then those of each task. What
            is counted, without noise, is seldom worth it: states share most of that work.
        show_progress: whether to draw a progress bar on standard error, once it takes two seconds.

    Returns:
        float64[n]; with `return_gap` also float64[n], for each state a proven upper bound on how
        much larger the true value is (0 where it is a count). Of a sum it is the sum of the gaps;
        of a product the difference of the two bounds, (m_1 + g_1)(m_2 + g_2) - m_1 m_2.

    Raises:
        ValueError: a horizon that is not a whole number from 0 up, an unknown sensor, no
            actions, an action or state that the MDP does not have, another argument that is none
            of its kind, or a computation above max_gib or max_seconds: the message then names the
            largest horizon that fits, "about" where it is estimated from a time.

    Warns:
        ConvergenceWarning: a gap is above the tolerance (never of `Sampled`).

    Example:
        >>> mdp = TabularMDP.deterministic([[0, 1], [1, 0]])
        >>> empowerment(mdp, horizon=3)
        array([1., 1.])
        >>> empowerment(mdp.slippery(0.2), horizon=1).round(3)
        array([0.531, 0.531])
    """
    horizon = whole_number("horizon", horizon)
    if is_estimator(method) and not isinstance(method, type):
        foreign = (actions, cost, budget, player, others, return_gap, sensor_at != "end", executor)
        return _estimated(model, horizon, sensor, states, method, foreign, unit, show_progress)
    scale, method = per_bit(unit), cast("Method", checked_method(method))
    if isinstance(model, TabularMDP):
        mdp = model
    else:
        mdp, states = _around(model, horizon, sensor, states, show_progress)
    if player is not None or others is not None:
        from habilis.empowerment.players import against_others, played_by

        mdp, against = played_by(mdp, player, others, isinstance(model, TabularMDP))
        player, others = against or (None, None)
        if against is not None and executor is None:
            plain = sensor_at == "end" and cost is None and budget is None
            one = mdp, *against, horizon, sensor, actions, states, method, scale, plain
            bits, gap = against_others(*one)
            return (bits, gap) if return_gap else bits
    if executor is not None and not are_beliefs(states):
        from habilis.empowerment.splitting import in_parts

        output = {"sensor_at": sensor_at, "cost": cost, "budget": budget}
        who = {"player": player, "others": others, "actions": actions}
        given = {"horizon": horizon, "method": method, "unit": unit, **output, **who}
        where = executor, show_progress
        bits, gap = in_parts("empowerment", mdp, sensor, states, given, *where)
        return (bits, gap) if return_gap else bits
    used = chosen_actions(mdp, actions)
    if sensor_at not in ("end", "each step"):
        raise ValueError(f"sensor_at is {sensor_at!r}; use 'end' or 'each step'")
    budgeted = is_budgeted(cost, budget)
    what = "" if sensor_at == "end" else "the observations of each step"
    what = "a budget" if budgeted else what
    if what:
        check_single(mdp, sensor, what)
        if not isinstance(method, Exact):
            raise ValueError(f"{what} needs every sequence; use method=hb.Exact()")
    if are_beliefs(states):
        options: Options = {"method": method, "unit": unit, "show_progress": show_progress}
        options |= {"executor": executor}
        output = sensor_at, cost, budget
        bits, gap = _from_beliefs(mdp, horizon, sensor, used, states, output, options)
        return (bits, gap) if return_gap else bits
    if what:
        some = mdp, horizon, sensor, used, states, sensor_at, cost, budget, method, scale
        bits, gap = _written_out(*some, show_progress)
        return (bits, gap) if return_gap else bits
    starts = chosen_states(mdp, states)

    def through(one: Sensor) -> tuple[Bits, Bits]:
        if not mdp.is_stochastic and not is_noisy(one) and isinstance(method, Exact):
            some = None if states is None else starts
            bits = counted_bits(mdp, horizon, one, used, some, method, show_progress)
            return bits * scale, np.zeros(len(bits))
        bits, gap = _solved(mdp, horizon, one, used, starts, method, scale, show_progress)
        return bits * scale, gap * scale

    bits, gap = combined_with_gaps(mdp, sensor, through)
    return (bits, gap) if return_gap else bits


def _estimated(
    model: Any,
    horizon: int,
    sensor: Any,
    states: Any,
    method: Any,
    foreign: tuple[Any, ...],
    unit: Unit,
    show_progress: bool,
) -> Bits:
    """Empowerment by an estimator."""
    from habilis.estimators.measure import estimated_bits

    if any(one is not None and one is not False for one in foreign):
        raise ValueError(
            "an estimator takes no actions, sensor_at, cost, budget, player, others, return_gap or "
            "executor; leave them out"
        )
    some = model, horizon, sensor, states, method
    return estimated_bits(*some, show_progress=show_progress) * per_bit(unit)


def _written_out(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor,
    actions: Int64[np.ndarray, "A"],
    states: Any,
    sensor_at: SensorAt,
    cost: ArrayLike | None,
    budget: Any,
    method: Method,
    scale: float,
    show_progress: bool,
) -> tuple[Curves, Curves]:
    """Empowerment within a budget, or over the observations of every step, of one sensor."""
    from habilis.empowerment.each_step import of_trajectories

    each_step = sensor_at == "each step"
    tolerance, starts = method.tolerance / scale, chosen_states(mdp, states)
    asked = mdp, horizon, sensor, actions, starts
    with progress_bar("empowerment", show_progress) as report:
        if cost is not None:
            found = within_budget(*asked, each_step, cost, budget, tolerance, method.limits, report)
        else:
            found = of_trajectories(*asked, tolerance, method.limits, report)
    bits, gap = found
    if (gap > tolerance).any():
        warn_of_gap(float(gap.max()), tolerance)
    return bits * scale, gap * scale


def _from_beliefs(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor,
    actions: Int64[np.ndarray, "A"],
    beliefs: Any,
    output: tuple[SensorAt, ArrayLike | None, Any],
    options: Options,
) -> tuple[Curves, Curves]:
    """Empowerment where the agent only has a distribution over states."""
    sensor_at, cost, budget = output

    def through(one: Sensor) -> tuple[Curves, Curves]:
        larger, seen, states = with_beliefs(mdp, one, beliefs)
        costs = None if cost is None else mean_costs(mdp, cost, beliefs)
        kept: Any = {"sensor_at": sensor_at, "cost": costs, "budget": budget, **options}
        return empowerment(larger, horizon, seen, actions, states, return_gap=True, **kept)

    return combined_with_gaps(mdp, sensor, through)


def _around(
    model: AnyModel, horizon: int, sensor: Sensor, states: Any, show_progress: bool
) -> tuple[TabularMDP, Int64[np.ndarray, "n"] | None]:
    """As much of a model's table as is needed, and the asked states in it."""
    is_world = isinstance(model, World)
    if not isinstance(sensor, str):
        kind, otherwise = ("world", "tabulate") if is_world else ("model", "explore")
        raise ValueError(
            f"a {kind}'s states have no numbers yet; give the name of a factor or 'state' as "
            f"sensor, or {otherwise} it"
        )
    if states is None:
        return whole_table(model, show_progress), None
    if is_world:
        return reachable(model, states, horizon, show_progress=show_progress)
    mdp = explore(model, states, horizon, show_progress=show_progress)
    return mdp, np.array([mdp.index(state) for state in states])


def _solved(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor,
    actions: Int64[np.ndarray, "A"],
    starts: Int64[np.ndarray, "n"],
    method: Method,
    scale: float,
    show_progress: bool,
) -> tuple[Bits, Bits]:
    """Capacities of noisy channels or of sampled ones, and their gaps, in bits."""
    from habilis.empowerment.tabular import stochastic
    from habilis.empowerment.tabular.open_loop import problem_of

    tolerance, limits = method.tolerance / scale, method.limits
    problem = problem_of(mdp, horizon, sensor, actions, tolerance)
    with progress_bar("states", show_progress) as report:
        if isinstance(method, Sampled):
            return stochastic.lower_bounds(
                problem, starts, method.samples, method.seed, method.threads, limits, report
            )
        bits, gap = stochastic.certified_bits(problem, starts, method.threads, limits, report)
    if (gap > tolerance).any():
        warn_of_gap(float(gap.max()), tolerance)
    return bits, gap
