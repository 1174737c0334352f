"""Counting: how many outcomes that a sensor distinguishes are found to be within reach."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64, Int64
from numpy.typing import ArrayLike

from habilis.empowerment.arguments import at_least_one, whole_number
from habilis.estimators.actions import (
    ActionBox,
    check_size,
    checked_actions,
    drawn_actions,
    how_many,
)
from habilis.estimators.protocol import (
    Kind,
    SensorOfSimulator,
    Simulator,
    Target,
    checked_simulator,
    checked_states,
    in_jax,
    is_finite,
    is_stochastic,
)
from habilis.estimators.rollouts import compiled_scan, in_double, padded, power_of_two, roll_out
from habilis.estimators.sensors import Reading, checked_reading, reading

_BRANCHES = 4  # actions of a box that are tried from each state
_FINEST = 2.0**52  # cells up to which floating point tells them apart
_ROUNDS = 12  # of the search for a grid
_WIDEST = 2.0**24  # cells of its sides

States = Float64[np.ndarray, "n d"]


@dataclass(frozen=True)
class Counting:
    """The logarithm of the number of cells of the sensor that a search finds sequences to.

        E_h(s) >= log2 |{ round(o(s_h) / resolution) : s_h is reached by a sequence that is tried }|

    It is for deterministic simulators, whose capacity through the rounded sensor is this number
    when all sequences are tried. The search goes forward step by step: it tries every action (of an
    `ActionBox` a few, corners among them) from every different state reached so far; if these are
    too many, it goes on from `sequences` of them, spread over their range. So it is exact where
    no more than `sequences` states can be reached, and a lower bound elsewhere.

    Attributes:
        resolution: the size of the sensor's cells, one number or one for each component, above 0.
        sequences: how many states the search goes on from, from 1 up: each stands for one sequence.

    Raises:
        ValueError: a setting is out of its range.

    Example:
        >>> from habilis import TabularMDP, empowerment
        >>> ring = TabularMDP.deterministic([[(s - 1) % 9, (s + 1) % 9] for s in range(9)])
        >>> empowerment(ring, 3, states=[0, 1], method=Counting())
        array([2., 2.])
    """

    resolution: Any = 1.0
    sequences: int = 1000

    def __post_init__(self) -> None:
        resolution = np.asarray(self.resolution)
        if resolution.dtype.kind not in "iuf" or resolution.ndim > 1 or not resolution.size:
            raise ValueError(f"resolution is {self.resolution!r:.60}; give a number above 0")
        if not ((resolution > 0) & np.isfinite(resolution)).all():
            raise ValueError(f"resolution is {self.resolution!r:.60}; give numbers above 0")
        object.__setattr__(self, "sequences", at_least_one("sequences", self.sequences))

    def fit(
        self,
        simulator: Simulator,
        horizon: int,
        sensor: SensorOfSimulator = "state",
        *,
        seed: int = 0,
    ) -> "FittedCounting":
        """Checks what is to be counted; nothing is learned.

        Args:
            simulator: a deterministic one.
            horizon: h, how many actions.
            sensor: see `habilis.estimators.sensors`.
            seed: of the search.

        Returns:
            Counts on request.

        Raises:
            ValueError: the simulator is stochastic, or an argument is none of its kind.
        """
        if is_stochastic(checked_simulator(simulator)):
            raise ValueError(
                "the simulator is stochastic, or does not say: counting is for deterministic ones; "
                "use hb.MonteCarlo, or set is_stochastic = False if its steps draw nothing"
            )
        horizon, seed = whole_number("horizon", horizon), whole_number("seed", seed)
        actions = checked_actions(simulator.actions)
        check_size(self.sequences, horizon, 1)
        every = how_many(actions, horizon) <= self.sequences
        table = getattr(simulator, "mdp", None)
        every = every or (table is not None and table.states <= self.sequences)
        shown = in_double(simulator, reading(simulator, sensor))
        kind: Kind = "exact" if every else "lower bound"
        compiled = compiled_scan(simulator) if in_jax(simulator) else None
        resolution = np.asarray(self.resolution, np.float64)
        some = simulator, compiled, actions, horizon, shown
        return FittedCounting(*some, resolution, self.sequences, seed, kind)


@dataclass(frozen=True, eq=False)
class FittedCounting:
    """`Counting` of one simulator, horizon and sensor.

    Attributes:
        simulator: the world.
        compiled: its steps, compiled, where it is one of JAX.
        actions: of the simulator.
        horizon: h.
        shown: the sensor.
        resolution: the size of its cells.
        sequences: how many states the search goes on from.
        seed: of the search.
        kind: "exact" where the search surely finds everything, else "lower bound".
        target: "capacity".
    """

    simulator: Simulator
    compiled: Callable[..., Any] | None
    actions: "Float64[np.ndarray, 'm k'] | ActionBox"
    horizon: int
    shown: Reading
    resolution: Float64[np.ndarray, "*components"]
    sequences: int
    seed: int
    kind: Kind
    target: Target = "capacity"

    def bits(self, states: ArrayLike) -> Float64[np.ndarray, "n"]:
        """The logarithms of the numbers of cells that are found.

        Args:
            states: float[n, d].

        Returns:
            float64[n].

        Raises:
            ValueError: the simulator leads to numbers that are not finite, is not deterministic, or
                the resolution is too fine for floating point.
        """
        given = checked_states(states)
        if self.horizon and not in_jax(self.simulator) and not is_finite(self.simulator):
            _check_deterministic(self, given[:1])
        return np.array([np.log2(_cells(self, state[None])) for state in given], np.float64)


def _cells(fitted: FittedCounting, start: States) -> int:
    """How many cells are found from a state."""
    generator = np.random.default_rng(fitted.seed)
    reached = start
    for step in range(fitted.horizon):
        if step:
            reached = _spread(reached, fitted.sequences, generator)
        reached = _expanded(fitted, reached, generator)
        reached = reached[_distinct(reached)]
    values = checked_reading(fitted.shown(_padded(fitted, reached)), _size(fitted, reached))
    if fitted.resolution.ndim and len(fitted.resolution) != values.shape[1]:
        raise ValueError(
            f"resolution has {len(fitted.resolution)} numbers, the sensor {values.shape[1]}; give "
            "one for each, or a single one"
        )
    cells = np.rint(values / fitted.resolution)
    if not (np.abs(cells) < _FINEST).all():
        raise ValueError("resolution is too fine for the sensor's values; give a larger one")
    return len(_distinct(cells))


def _expanded(
    fitted: FittedCounting, states: States, generator: np.random.Generator
) -> Float64[np.ndarray, "N d"]:
    """The states after one action more."""
    actions = fitted.actions
    if isinstance(actions, ActionBox):
        each = max(_BRANCHES, -(-fitted.sequences // len(states)))
        tried = drawn_actions(actions, (len(states), each), generator)
        corner = generator.random((len(states), each, 1)) < 0.5
        upper = generator.random(tried.shape) < 0.5
        tried = np.where(corner, np.where(upper, actions.high, actions.low), tried)
    else:
        each = len(actions)
        tried = np.broadcast_to(actions, (len(states), *actions.shape))
    size = len(states) * each
    starts = _padded(fitted, np.repeat(states, each, axis=0))
    steps = _padded(fitted, np.ascontiguousarray(tried).reshape(size, -1))
    return roll_out(fitted.simulator, starts, steps[:, None], 0, fitted.compiled)[:size]


def _size(fitted: FittedCounting, rows: np.ndarray) -> int:
    """How many rows there are once padded: a power of 2, so that few shapes are compiled."""
    return len(rows) if fitted.compiled is None else power_of_two(len(rows))


def _padded(fitted: FittedCounting, rows: np.ndarray) -> np.ndarray:
    return padded(rows, _size(fitted, rows))


def _distinct(rows: Float64[np.ndarray, "N d"]) -> Int64[np.ndarray, "k"]:
    """The index of the first of all rows that are alike, in the rows' lexical order."""
    order = np.lexsort(rows.T)  # much faster than np.unique of rows
    ordered = rows[order]
    first = np.ones(len(rows), bool)
    first[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    return order[first]


def _spread(
    states: States, most: int, generator: np.random.Generator
) -> Float64[np.ndarray, "most d"]:
    """As many of the states, one in each cell of a grid over their range, the rest at random.

    The grid has about as many occupied cells as states are wanted, whatever the shape of the set.
    """
    if len(states) <= most:
        return states
    shuffled = states[generator.permutation(len(states))]
    low = shuffled.min(axis=0)
    width = np.maximum(shuffled.max(axis=0) - low, np.finfo(np.float64).tiny)
    first = np.zeros(1, np.int64)
    fine, coarse = _WIDEST, 1.0
    for _ in range(_ROUNDS):
        cells = np.sqrt(fine * coarse)
        found = _distinct(np.floor((shuffled - low) / width * cells))
        if len(found) > most:
            fine = cells
        else:
            coarse, first = cells, found
    rest = np.ones(len(shuffled), bool)
    rest[first] = False
    others = np.flatnonzero(rest)
    return shuffled[np.concatenate([first, others[: most - len(first)]])]


def _check_deterministic(fitted: FittedCounting, states: States) -> None:
    """Refuses a simulator that draws although it says that it does not.

    Functions of JAX have nothing to draw from, nor have tables.
    """
    if not len(states):
        return
    once, again = (_expanded(fitted, states, np.random.default_rng(fitted.seed)) for _ in range(2))
    if not np.array_equal(once, again):
        raise ValueError(
            "the simulator says that it is deterministic, but the same step leads elsewhere the "
            "second time; set is_stochastic = True"
        )
