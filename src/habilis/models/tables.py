"""The table of the states that were reached: where they lead, and what the model says of them."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float32, Float64, Int, Int32

from habilis.mdp import ModelStates, TabularMDP
from habilis.models.protocol import Model, VectorModel

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Outcomes = Mapping[int, Sequence[tuple[float, int]]]
"""(probability, next state) by the number of the transition, `state * actions + action`."""

_BLOCK = 1 << 14  # states or transitions described at once
_CELL = 2  # numbers of a cell: row and column
_AGAIN = 1000  # states or transitions of which a function is asked twice
_LEAST, _MOST = np.iinfo(np.int32).min, np.iinfo(np.int32).max


@runtime_checkable
class Reached(ModelStates, Protocol):
    """States in the order in which they were met."""

    @property
    def next_state(self) -> Int32[np.ndarray, "expanded A"]:
        """Where the first of them lead; -1 where an action is not available."""
        ...

    def take(self, states: Int[np.ndarray, "n"]) -> Any:
        """Some states as one argument of `factors_many` and its like."""
        ...


def table_of(
    model: Model | VectorModel,
    found: Reached,
    count: int,
    actions: tuple[str, ...],
    outcomes: Outcomes | None = None,
) -> TabularMDP:
    """The table of `count` states that were reached; those not expanded stay where they are.

    Raises:
        ValueError: the model says something of a state that no table can have.
    """
    expanded = found.next_state
    next_state = np.empty((count, expanded.shape[1]), np.int32)
    next_state[: len(expanded)] = expanded
    next_state[len(expanded) :] = np.arange(len(expanded), count, dtype=np.int32)[:, None]
    terminal = _terminal(model, found, count)
    if outcomes:
        stacked = _with_outcomes(next_state, outcomes)
        rows = np.repeat(np.arange(next_state.size), np.diff(stacked.indptr))
        led, weights = stacked.indices, stacked.data
        by_action = [stacked[a :: next_state.shape[1]] for a in range(next_state.shape[1])]
        mdp = TabularMDP.stochastic(by_action, terminal=terminal)
    else:
        rows = np.flatnonzero(next_state >= 0)
        led, weights = next_state.ravel()[rows], np.ones(1)
        mdp = TabularMDP.deterministic(next_state, terminal=terminal)
    earned = _rewards(model, found, rows, led, next_state.shape, len(expanded))
    if earned is not None:
        mean = np.bincount(rows, earned * weights, next_state.size)
        entry_reward = _by_next_state(earned, led, count)
        mdp = replace(mdp, reward=mean.reshape(next_state.shape).astype(np.float32))
        mdp = replace(mdp, entry_reward=entry_reward)
    labels, shape, cells = _factors(model, found, count)
    return replace(
        mdp,
        factors=labels,
        shape=shape,
        cells=cells,
        actions=actions,
        model_states=found,
        players=getattr(model, "players", {}),
        drawn=model if hasattr(model, "drawings") and hasattr(model, "at") else None,
    )


def _with_outcomes(next_state: Int32[np.ndarray, "S A"], outcomes: Outcomes) -> "csr_array":
    """float64[S * A, S], the probabilities of the next states."""
    from scipy.sparse import csr_array

    sure = np.flatnonzero(next_state >= 0)
    several = [(row, to, p) for row, ways in outcomes.items() for p, to in ways]
    rows, columns, weights = (np.array(part) for part in zip(*several, strict=True))
    rows, columns = (
        np.concatenate([one, other])
        for one, other in ((sure, rows), (next_state.ravel()[sure], columns))
    )
    weights = np.concatenate([np.ones(len(sure)), weights])
    return csr_array((weights, (rows, columns)), (next_state.size, len(next_state)))


def _rewards(
    model: Model | VectorModel,
    found: Reached,
    rows: Int[np.ndarray, "n"],
    led: Int[np.ndarray, "n"],
    shape: tuple[int, int],
    expanded: int,
) -> Float64[np.ndarray, "n"] | None:
    """The rewards of outcomes, given transition and next state; 0 where a state only stays."""
    reward = many(model, "reward")
    if reward is None:
        return None
    earned = np.zeros(len(rows))
    made = int(np.searchsorted(rows, expanded * shape[1]))

    def asked(places: Any) -> np.ndarray:
        states, chosen = np.divmod(rows[places], shape[1])
        values = _array("reward", reward(found.take(states), chosen, found.take(led[places])))
        if values.dtype.kind not in "biuf" or values.shape != states.shape:
            raise ValueError(
                f"reward returns {_first(values)}, or not one value for each transition; return a "
                "number"
            )
        return values

    for block in _blocks(made):
        values = asked(block)
        bad = np.flatnonzero(~(abs(values) <= np.finfo(np.float32).max))
        if len(bad):
            state, action = divmod(int(rows[block][bad[0]]), shape[1])
            where = f"action {action} in state {found.state(state)!r:.80}"
            raise ValueError(f"reward of {where} is {values[bad[0]]}; give a finite number")
        earned[block] = values
    again = _sample(made)
    if len(again):
        _check_same("reward", earned[again], asked(again))
    return earned


def _by_next_state(
    earned: Float64[np.ndarray, "n"], led: Int[np.ndarray, "n"], count: int
) -> Float32[np.ndarray, "S"] | None:
    """The reward of entering each state, if it depends on nothing else."""
    entered = np.zeros(count)
    entered[led] = earned
    return entered.astype(np.float32) if (entered[led] == earned).all() else None


def _terminal(
    model: Model | VectorModel, found: Reached, count: int
) -> Bool[np.ndarray, "S"] | None:
    terminal = many(model, "terminal")
    if terminal is None:
        return None

    def asked(places: Int[np.ndarray, "n"]) -> np.ndarray:
        values = _array("terminal", terminal(found.take(places)))
        if values.dtype.kind != "b" or values.shape != places.shape:
            raise ValueError(
                f"terminal returns {_first(values)}, or not one value for each state; return True "
                "or False"
            )
        return values

    flags = np.concatenate([asked(np.arange(count)[block]) for block in _blocks(count)])
    again = _sample(count)
    _check_same("terminal", flags[again], asked(again))
    return flags


def _factors(
    model: Model | VectorModel, found: Reached, count: int
) -> tuple[dict[str, Int32[np.ndarray, "S"]], tuple[int, int] | None, frozenset[str]]:
    """The labels of all states, the shape of the map, and which labels are cells of it."""
    factors = many(model, "factors")
    if factors is None:
        return {}, None, frozenset()
    parts = [_asked_factors(factors, found, np.arange(count)[block]) for block in _blocks(count)]
    names = [*parts[0]]
    for part in parts:
        if [*part] != names:
            raise ValueError(f"factors has {[*part]} in some states, and {names} in others")
    try:
        whole = {name: np.concatenate([part[name] for part in parts]) for name in names}
    except ValueError:  # cells in one block of states, numbers in another
        raise ValueError("a factor is a number in some states and a cell in others") from None
    again = _sample(count)
    for name, labels in _asked_factors(factors, found, again).items():
        _check_same("factors", whole[name][again], labels)
    cells = {name: labels for name, labels in whole.items() if labels.ndim == _CELL}
    shape = _shape_of(model, cells)
    for name, cell in cells.items():
        assert shape is not None
        outside = ((cell < 0) | (cell >= np.array(shape))).any(axis=1)
        if outside.any():
            first = int(np.flatnonzero(outside)[0])
            raise ValueError(
                f"factor {name!r} is the cell {tuple(cell[first].tolist())} in state "
                f"{found.state(first)!r:.80}, which is outside the {shape[0]} x {shape[1]} cells"
            )
        whole[name] = cell[:, 0] * shape[1] + cell[:, 1]
    for name, labels in whole.items():
        wide = np.flatnonzero((labels < _LEAST) | (labels > _MOST))
        if len(wide):
            raise ValueError(
                f"factor {name!r} is {labels[wide[0]]} in state {found.state(int(wide[0]))!r:.80}; "
                "labels are int32: use smaller numbers"
            )
    return {n: v.astype(np.int32) for n, v in whole.items()}, shape, frozenset(cells)


def _asked_factors(
    factors: Callable[[Any], Any], found: Reached, places: Int[np.ndarray, "n"]
) -> dict[str, np.ndarray]:
    """The factors of some states, by name: numbers, or cells."""
    given = factors(found.take(places))
    columns = given if isinstance(given, Mapping) else _columns(given, found, places)
    labels = {name: _array(f"factor {name!r}", values) for name, values in columns.items()}
    for name, one in labels.items():
        right = one.shape in ((len(places),), (len(places), _CELL))
        if not right or one.dtype.kind not in "biu":
            raise ValueError(
                f"factor {name!r} is {_first(one)} in state "
                f"{found.state(int(places[0]))!r:.80}; give a whole number or (row, column), the "
                "same in every state"
            )
    return labels


def _shape_of(model: Any, cells: Mapping[str, np.ndarray]) -> tuple[int, int] | None:
    """Rows and columns of the map that cells are on, as large as they need by default."""
    shape = getattr(model, "shape", None)
    if not cells:
        return None
    if shape is None:
        height, width = (np.concatenate([*cells.values()]).max(axis=0) + 1).tolist()
        return height, width
    sides = tuple(shape) if isinstance(shape, Iterable) else (shape,)
    if len(sides) != _CELL or not all(isinstance(side, int | np.integer) for side in sides):
        raise ValueError(f"the model's shape is {shape!r:.80}; give (rows, columns)")
    return int(sides[0]), int(sides[1])


def _array(name: str, values: Any) -> np.ndarray:
    try:
        return np.asarray(values)
    except ValueError:
        raise ValueError(
            f"{name} has values of different kinds or lengths; give the same kind in every state"
        ) from None


def _first(values: np.ndarray) -> str:
    listed = values.tolist()
    return f"{(listed[0] if values.size and values.ndim else listed)!r:.80}"


def _sample(count: int) -> Int[np.ndarray, "n"]:
    """Places at which a function is called a second time."""
    return np.random.default_rng(0).permutation(count)[:_AGAIN]


def _check_same(name: str, before: np.ndarray, after: np.ndarray) -> None:
    """Refuses a function that returns something else when it is called again.

    Raises:
        ValueError: it does.
    """
    if not np.array_equal(before, after):
        raise ValueError(
            f"{name} returns something else the second time; let it depend on its arguments alone"
        )


def _columns(given: Any, found: Reached, places: Int[np.ndarray, "n"]) -> dict[str, list[Any]]:
    """The factors of some states, by name."""
    if not isinstance(given, list):
        raise ValueError(f"factors_many returns {given!r:.80}; return a dict of arrays")
    for place, one in zip(places.tolist(), given, strict=True):
        if not isinstance(one, Mapping) or one.keys() != given[0].keys():
            state = found.state(place)
            raise ValueError(
                f"factors({state!r:.80}) returns {one!r:.80}; return a dict with the same names in "
                "every state"
            )
    return {name: [one[name] for one in given] for name in given[0]}


def many(model: Any, name: str) -> Callable[..., Any] | None:
    """What a model says of many states at once, by calling it for each if it must be."""
    vectorised = getattr(model, f"{name}_many", None)
    if vectorised is not None:
        return vectorised
    one = getattr(model, name, None)
    if one is None:
        return None
    return lambda *columns: [one(*row) for row in zip(*map(_listed, columns), strict=True)]


def _listed(column: Any) -> list[Any]:
    listed = column.tolist() if isinstance(column, np.ndarray) else column
    return [tuple(row) for row in listed] if getattr(column, "ndim", 1) > 1 else listed


def _blocks(count: int) -> Iterator[slice]:
    for first in range(0, count, _BLOCK):
        yield slice(first, min(first + _BLOCK, count))
