"""Empowerment of many states as independent tasks, for executors.

A state's value does not depend on which others are asked about. The states are split into ranges,
by the question alone and not by the executor, so that whatever has kept the finished tasks finds
them again on a cluster of another size.
"""

import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from jaxtyping import Float64, Int32, Int64

from habilis.cache import fingerprint
from habilis.channels.capacity import ConvergenceWarning, warn_of_gap
from habilis.empowerment.arguments import chosen_states, per_bit
from habilis.empowerment.combined import check_names, combined_with_gaps, terms_of
from habilis.empowerment.methods import Exact
from habilis.empowerment.sensors import STATE, Sensor, factor_of, is_noisy
from habilis.mdp import TabularMDP
from habilis.probabilities import as_array, is_sparse, shape_of
from habilis.progress import progress_bar
from habilis.tasks.shared import Shared
from habilis.tasks.task import Arrays, Executor, results_of

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Name = Literal["empowerment", "empowerment_by_horizon"]
Values = Float64[np.ndarray, "n *more"]

MOST_TASKS = 512
"""Tasks of one measure, at most."""

COUNTED = 64, 1024
"""Tasks at most, and states at least in each, where nothing is noisy: what their states can reach
overlaps, and is gone through in every task again."""

_POSITION = re.compile(r"states\[(\d+)\]")  # as errors name one of the states asked about
_EDITION = 1  # of the results, which are kept
_ARRAYS = "actions", "cost", "budget"
_LIMITS = ("max_gib", "max_seconds", "threads")  # no value depends on them


@dataclass(frozen=True, eq=False)
class Table:
    """The parts of a table that empowerment depends on."""

    transitions: "Int32[np.ndarray, 'S A'] | csr_array"
    actions: int
    factors: Mapping[str, Int32[np.ndarray, "S"]]
    shape: tuple[int, int] | None
    cells: frozenset[str] | None
    players: Mapping[str, int]

    @classmethod
    def of(cls, mdp: TabularMDP, sensors: Sequence[Sensor]) -> "Table":
        """Those that these sensors need, each a single one."""
        names = set[str]()
        for sensor in sensors:
            if isinstance(sensor, str) and sensor != STATE:
                factor = factor_of(mdp, sensor)
                names |= set(mdp.factors) if factor is None else {factor}
        factors = {name: labels for name, labels in mdp.factors.items() if name in names}
        some = mdp.transitions, mdp.action_count, factors, mdp.shape, mdp.cells, mdp.players
        return cls(*some)

    @property
    def digest(self) -> str:
        """A hash of all of it."""
        cells = None if self.cells is None else sorted(self.cells)
        named = chain(*self.factors.items())
        players = dict(self.players)
        return fingerprint(self.transitions, self.actions, self.shape, cells, players, *named)

    @cached_property
    def mdp(self) -> TabularMDP:
        """The table, without rewards and ends."""
        rows = shape_of(self.transitions)[0]
        states = rows if isinstance(self.transitions, np.ndarray) else rows // self.actions
        return TabularMDP(
            self.transitions,
            np.broadcast_to(np.float32(0), (states, self.actions)),
            np.broadcast_to(np.False_, (states,)),
            self.factors,
            shape=self.shape,
            cells=self.cells,
            players=self.players,
        )

    def __getstate__(self) -> dict[str, Any]:
        """For pickles: without what is made of it."""
        return {name: value for name, value in vars(self).items() if name != "mdp"}


@dataclass(frozen=True)
class StatesTask:
    """A measure of some states (a `habilis.tasks.task.Task`).

    Attributes:
        name: a hash of all that the result depends on.
        measure: the function.
        table: what it is of.
        arguments: all of the function's but the table and the states.
        states: those asked about.
        is_counted: whether memory is needed for all states together, not for one by one.
    """

    name: str
    measure: Name
    table: Shared[Table]
    arguments: Shared[dict[str, Any]]
    states: Int64[np.ndarray, "n"]
    is_counted: bool

    @property
    def label(self) -> str:
        return f"states {self.states[0]} to {self.states[-1]}"

    @property
    def size(self) -> float:
        return len(self.states)

    def run(self) -> Arrays:
        """Values, and their gaps."""
        return self._of(self.states)

    def rehearse(self) -> None:
        """Computes one state; where all take memory at once, all of them."""
        self._of(self.states if self.is_counted else self.states[:1])

    def check(self, result: Arrays) -> None:
        if not np.array_equal(result["states"], self.states):
            raise ValueError("holds other states")
        for name in ("values", "gap"):
            if result[name].dtype != np.float64 or len(result[name]) != len(self.states):
                raise ValueError(f"{name} is {result[name].dtype}[{len(result[name])}]")

    def _of(self, states: Int64[np.ndarray, "n"]) -> Arrays:
        table, arguments = self.table.value.mdp, self.arguments.value
        try:
            values, gap = measured(self.measure, table, states, arguments)
        except ValueError as error:
            if _POSITION.search(str(error)) is None:
                raise
            # Positions in a task mean nothing to a caller who asked about other states too.
            named = _POSITION.sub(lambda found: f"state {states[int(found[1])]}", str(error))
            raise ValueError(named) from None
        return {"states": states, "values": values, "gap": gap}


def measured(
    measure: Name, mdp: TabularMDP, states: Int64[np.ndarray, "n"], arguments: dict[str, Any]
) -> tuple[Values, Values]:
    """A measure of some states, one a row, and its gaps, of which no warning is given."""
    from habilis.empowerment.api import empowerment
    from habilis.empowerment.horizons import empowerment_by_horizon

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        if measure == "empowerment":
            return empowerment(mdp, states=states, return_gap=True, **arguments)
        rows = empowerment_by_horizon(mdp, states=states, **arguments)
        return np.ascontiguousarray(rows.T), np.zeros(rows.shape[::-1])


def in_parts(
    measure: Name,
    mdp: TabularMDP,
    sensor: Sensor,
    states: Any,
    arguments: Mapping[str, Any],
    executor: Executor[Any],
    show_progress: bool,
) -> tuple[Values, Values]:
    """A measure of states, split into tasks: the values that it has without an executor.

    Args:
        measure: the function's name.
        mdp: the table.
        sensor, states: the function's arguments; no distributions over states.
        arguments: all others, checked or not.
        executor: runs the tasks.
        show_progress: whether to draw a progress bar on standard error.

    Returns:
        Values, one state a row, and gaps, in the unit asked for.

    Raises:
        ValueError: as the measure does, before any task is run; or what the executor raises.

    Warns:
        ConvergenceWarning: a gap is above the tolerance (never of `Sampled`).
    """
    terms = terms_of(mdp, sensor)
    several = len(terms) > 1 or len(terms[0]) > 1
    if several:
        check_names(mdp, str(sensor))
    sensors = [*chain(*terms)] if several else [_plain(sensor)]
    first = {**arguments, "horizon": 0, "sensor": sensor}
    measured(measure, mdp, np.empty(0, np.int64), first)  # says what is wrong with any argument
    arguments = {name: _plain_argument(name, value) for name, value in arguments.items()}
    chosen = chosen_states(mdp, states)
    asked, place = np.unique(chosen, return_inverse=True)
    table = _shared_table(mdp, sensors)
    tasks = {
        _key(one): [*_tasks(measure, mdp, table, {**arguments, "sensor": one}, asked)]
        for one in sensors
    }
    with progress_bar("tasks", show_progress, time_left=True) as report:
        results = results_of([*chain(*tasks.values())], executor, report)

    def through(one: Sensor) -> tuple[Values, Values]:
        found = [results[task.name] for task in tasks[_key(one)]]
        if not found:  # of no states
            return measured(measure, mdp, asked, {**arguments, "sensor": one})
        values, gap = (np.concatenate([each[name] for each in found]) for name in ("values", "gap"))
        _warn(gap, arguments)
        return values[place], gap[place]

    return combined_with_gaps(mdp, sensor if several else sensors[0], through)


def _plain(sensor: Sensor) -> Sensor:
    """A sensor as a hash can be made of it."""
    from scipy.sparse import csr_array

    if isinstance(sensor, str):
        return sensor
    return csr_array(sensor) if is_sparse(sensor) else as_array("sensor", sensor)


def _plain_argument(name: str, value: Any) -> Any:
    """The same of another argument: what may be an array is one."""
    is_array = name in _ARRAYS and value is not None and not np.isscalar(value)
    return as_array(name, value) if is_array else value


def _key(sensor: Sensor) -> str:
    return sensor if isinstance(sensor, str) else ""


def _shared_table(mdp: TabularMDP, sensors: Sequence[Sensor]) -> Shared[Table]:
    table = Table.of(mdp, sensors)
    return Shared(table.digest, table)


def _tasks(
    measure: Name,
    mdp: TabularMDP,
    table: Shared[Table],
    arguments: Mapping[str, Any],
    asked: Int64[np.ndarray, "n"],
) -> Iterator[StatesTask]:
    """The tasks of a single sensor."""
    method = arguments["method"]
    threads = method.threads or 1  # an executor has a processor for each task
    given = {**arguments, "method": replace(method, threads=threads)}
    value = [_EDITION, measure, given["method"], *_contents(given)]
    free = dict.fromkeys(_LIMITS, 1)
    identity = [_EDITION, measure, replace(method, **free), *_contents(arguments)]
    shared = Shared(fingerprint(*value), given)
    same = fingerprint(table.key, *identity)
    counted = _is_counted(mdp, arguments)
    most, least = COUNTED if counted else (MOST_TASKS, 1)
    size = max(-(-len(asked) // most), least)
    for begin in range(0, len(asked), size):
        part = asked[begin : begin + size]
        name = fingerprint(same, part)[:32]
        yield StatesTask(name, measure, table, shared, part, counted)


def _contents(arguments: Mapping[str, Any]) -> list[Any]:
    """The arguments by name, but the method, for a hash."""
    rest = sorted((name, value) for name, value in arguments.items() if name != "method")
    return [*chain(*rest)]


def _is_counted(mdp: TabularMDP, arguments: Mapping[str, Any]) -> bool:
    """Whether all states are counted together, without any noise."""
    plain = arguments.get("sensor_at", "end") == "end"
    plain &= all(arguments.get(name) is None for name in ("cost", "player"))
    noisy = mdp.is_stochastic or is_noisy(arguments["sensor"])
    return plain and not noisy and isinstance(arguments["method"], Exact)


def _warn(gap: Values, arguments: Mapping[str, Any]) -> None:
    method, scale = arguments["method"], per_bit(arguments["unit"])
    if isinstance(method, Exact) and (gap > method.tolerance).any():
        warn_of_gap(float(gap.max()) / scale, method.tolerance / scale)
