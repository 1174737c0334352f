"""Counts of observations where nothing is noisy: by the cheapest way, if it fits."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Int32, Int64, UInt8

from habilis.compiled import INTERPRETED, compile_now
from habilis.empowerment.limits import (
    UNLIMITED,
    Clock,
    Limits,
    Progress,
    check_memory,
    unwatched,
    watched,
)
from habilis.empowerment.tabular.changing import changing
from habilis.empowerment.tabular.changing import memory as memory_of_changing
from habilis.empowerment.tabular.columns import Columns, memory
from habilis.empowerment.tabular.counting import (
    compile_lists,
    count_backward,
    count_forward,
    count_unions,
    few_steps,
    sets_backward,
    sizes,
    unite,
    words_united,
)
from habilis.empowerment.tabular.neighbourhoods import neighbourhood
from habilis.empowerment.tabular.recurring import FIRST_LOOK, repeated
from habilis.empowerment.tabular.windows import Window, count_in_window, window_of, worth_a_window

if TYPE_CHECKING:  # what it needs of Numba takes long to import
    from habilis.empowerment.tabular.spreading import Graph

MOST_PACKED_LABELS = 4096
"""Labels up to which all states' sets are carried back at once."""

_LISTED = 128  # states in a set up to which a list of them costs less than a row of bits
_LIST_STEPS = 2_000_000  # steps from state to state that a list may cost
_TRIED = 16  # states whose lists are tried out
_LONG = 64  # actions above which a shorter horizon with the same sets is looked for
_TRIFLE = 2_000_000  # state-actions in all steps below which that takes longer than it saves
_NARROW = 192  # labels up to which a step costs less than looking for what it can change
_GIB = 2**30

Counts = Int64[np.ndarray, "n"]
Levels = Int64[np.ndarray, "levels"]  # states within 0, 1, ... actions


@dataclass(frozen=True)
class Question:
    """A counting problem.

    Attributes:
        table: int32[S, A], the states that the chosen actions lead to.
        labels: int32[S], what is observed in each state, from 0; -1 for nothing.
        label_count: how many labels there are.
        horizon: h, in actions.
        starts: the states asked about, each as often as asked; `None` for all.
        cells: int32[S], the cells of a map that the labels stand for, if they stand for cells.
        shape: rows and columns of that map.
        threads: how many work side by side.
        limits: what it may cost.
        report: is called with the share that is done.
    """

    table: Int32[np.ndarray, "S A"]
    labels: Int32[np.ndarray, "S"]
    label_count: int
    horizon: int
    starts: Int64[np.ndarray, "n"] | None = None
    cells: Int32[np.ndarray, "S"] | None = None
    shape: tuple[int, int] | None = None
    threads: int = 1
    limits: Limits = UNLIMITED
    report: Progress = unwatched


@dataclass(frozen=True)
class _Part:
    """The part of a question that is worked on.

    Attributes:
        asked: the question of its states alone.
        place: the places of the starts in it.
        levels: how many states it has if the horizon is 0, 1, ..., up to where they are no more.
        first: the step before which the set of each is surely what the state shows.
        besides: bytes that it takes besides the question's table.
    """

    asked: Question
    place: Int32[np.ndarray, "n"] | Int64[np.ndarray, "n"]
    levels: Levels
    first: UInt8[np.ndarray, "S"]
    besides: int = 0


def counts(question: Question) -> Counts:
    """The number of observations reachable with h actions.

    Returns:
        |O_h(s)| for every state asked about; 0 where nothing is observed in the end.

    Raises:
        TooMuchError: it would take more than the limits.
    """
    part, horizon = _changing(_near(question)), question.horizon
    asked = part.asked
    if horizon == 0:
        return (asked.labels >= 0).astype(np.int64)[part.place]
    steps, graph = horizon, None
    if steps > _LONG and asked.table.size * steps > _TRIFLE:
        from habilis.empowerment.tabular.eventual import same_horizon
        from habilis.empowerment.tabular.spreading import Graph

        _check(horizon, part, _graph_bytes(asked))
        graph = Graph.of(asked.table)
        steps = same_horizon(graph, steps)
    asked = replace(asked, horizon=steps)
    part = replace(part, asked=asked)
    if _in_cells(asked):
        found = _in_window(question, part)
        if found is not None:
            return found[part.place]
    if asked.label_count <= MOST_PACKED_LABELS:
        gib = _check(horizon, part, _packed_bytes(asked, -(-asked.label_count // 64)))
        _compile_packed(asked)
        watch = watched(horizon, steps, gib, question.limits, question.report)
        return count_backward(
            asked.table, asked.labels, asked.label_count, steps, asked.threads, watch, part.first
        )[part.place]
    return _of_many_labels(question, part, graph)


def counts_by_horizon(question: Question) -> Int64[np.ndarray, "horizons n"]:
    """`counts` of 0, 1, ... h actions.

    Raises:
        TooMuchError: it would take more than the limits; h + 1 numbers a state asked about are
            part of it.
    """
    size = len(question.table if question.starts is None else question.starts)
    horizon, limits = question.horizon, question.limits
    check_memory(*_rows_gib(question, size, horizon + 1), horizon, limits)
    rows, period = counts_until_repeated(question)
    return rows[repeated(horizon, len(rows) - 1, period)]


def counts_until_repeated(question: Question) -> tuple[Int64[np.ndarray, "k n"], int]:
    """`counts` of 0, 1, ... actions, up to h or to where they come again, whichever is sooner.

    Returns:
        The k rows; and the period, so that the row after the last is the one of `period` rows
        before: see `repeated`.

    Raises:
        TooMuchError: it would take more than the limits.
    """
    part = _changing(_near(question))
    asked, place = part.asked, part.place
    horizon, limits = question.horizon, question.limits
    if asked.label_count <= MOST_PACKED_LABELS:
        gib = _check(horizon, part, _packed_bytes(asked, -(-asked.label_count // 64)))
        _compile_packed(asked)
        # When rows of a long horizon begin to repeat is unknown: only the time taken is limited.
        clock = Clock(horizon, limits)
        watch = watched(horizon, horizon, gib, limits, question.report)
        sets = sets_backward(
            asked.table,
            asked.labels,
            asked.label_count,
            horizon,
            asked.threads,
            part.first,
            jump=False,
        )
        rows: list[Counts] = []
        while True:
            try:
                now, _ = next(sets)
            except StopIteration as end:
                return np.stack(rows), end.value
            rows.append(sizes(now[place]))
            check_memory(*_rows_gib(question, len(place), len(rows), gib), horizon, limits)
            share = (len(rows) - 1) / max(horizon, 1)
            if horizon > _LONG:
                question.report(share)
                clock.check_now(len(rows) - 1)
            else:
                watch(share)
    from habilis.empowerment.tabular.column_counting import count_every_horizon
    from habilis.empowerment.tabular.spreading import Graph

    # A block of columns has a period of its own: all of them together seldom have a short one.
    columns = Columns.of(asked.labels, asked.label_count, None)
    gib = _check(horizon, part, _columns_bytes(asked, columns))
    check_memory(*_rows_gib(question, len(place), horizon + 1, gib), horizon, limits)
    _compile_columns(False)
    watch = watched(horizon, horizon, gib, limits, question.report)
    graph = Graph.of(asked.table)
    every = count_every_horizon(
        graph, asked.labels, asked.label_count, horizon, place, asked.threads, watch
    )
    return every, 0


def _rows_gib(question: Question, size: int, rows: int, besides: float = 0) -> tuple[float, int]:
    """The memory of so many rows and of what is besides, and the last row for which there is any.

    Rows are kept one by one, put together, and repeated; of many labels a thread has its own.
    """
    row = 8 * (2 + question.threads) * max(size, 1)
    left = int(min((question.limits.gib - besides) * _GIB, 2**62))
    return besides + row * rows / _GIB, max(left // row - 1, -1)


# Done once before anything is timed: the first time, it is compiled, for seconds. Only where there
# is so much to do.


def _compile_packed(asked: Question) -> None:
    states = len(asked.table)
    words = np.empty((0, -(-asked.label_count // 64)), np.uint64)
    step = words_united(asked.table, None, 1, words, words, 0, states)
    if step * asked.horizon > INTERPRETED:
        _compile_union()


@lru_cache(1)
def _compile_union() -> None:
    compile_now(unite, count_unions)
    count_backward(np.zeros((1, 1), np.int32), np.zeros(1, np.int32), 1, 2)


@lru_cache(1)
def _compile_window() -> None:
    table, cell = np.zeros((1, 1), np.int32), np.zeros(1, np.int16)
    window_of(table, cell, cell, 1, 2, 1)
    count_in_window(table, cell, cell, 1, Window(0, 0, 1, 1), 1)


@lru_cache(2)
def _compile_columns(forward: bool) -> None:
    from habilis.empowerment.tabular.column_counting import count_columns
    from habilis.empowerment.tabular.spreading import Graph

    table, labels, starts = np.zeros((1, 1), np.int32), np.zeros(1, np.int32), np.zeros(1, np.int64)
    columns = Columns.of(labels, 2, starts if forward else None)
    count_columns(Graph.of(table), labels, 2, 1, columns)


@lru_cache(1)
def _compile_lists() -> None:
    compile_lists()
    table, labels, starts = np.zeros((1, 1), np.int32), np.zeros(1, np.int32), np.zeros(1, np.int64)
    count_forward(table, labels, 1, 1, starts)


def _near(question: Question) -> _Part:
    """The part of a question that h actions can touch."""
    if question.starts is None:
        states = len(question.table)
        first = np.zeros(states, np.uint8)
        return _Part(question, np.arange(states), np.array([states]), first)
    near, table, place, levels = neighbourhood(question.table, question.starts, question.horizon)
    cells = None if question.cells is None else question.cells[near]
    asked = replace(question, table=table, labels=question.labels[near], cells=cells)
    return _Part(asked, place, levels, np.zeros(len(near), np.uint8))


def _changing(part: _Part) -> _Part:
    """The part that h actions can change, where that is less work."""
    asked, horizon = part.asked, part.asked.horizon
    cells = asked.cells if _in_cells(asked) else None
    many = asked.label_count > MOST_PACKED_LABELS and cells is None
    if many or asked.label_count <= _NARROW or asked.table.size * horizon <= _TRIFLE:
        return part
    found = changing(asked.table, asked.labels, asked.label_count, horizon, asked.threads)
    if found is None:
        return part
    if cells is not None:
        of_label = np.zeros(asked.label_count + 1, np.int32)
        of_label[asked.labels] = cells  # the last: without a label
        cells = of_label[found.labels]
    levels = np.arange(max(len(part.levels), len(found.sizes)))
    levels = np.minimum(
        part.levels[np.minimum(levels, len(part.levels) - 1)],
        found.sizes[np.minimum(levels, len(found.sizes) - 1)],
    )
    return _Part(
        replace(asked, table=found.table, labels=found.labels, cells=cells),
        found.place if asked.starts is None else found.place[part.place],
        levels,
        found.first,
        memory_of_changing(len(found.table), *asked.table.shape),
    )


def _in_cells(asked: Question) -> bool:
    """Whether labels are cells of a map so large that a window may be worth it."""
    return asked.cells is not None and asked.shape is not None and worth_a_window(asked.shape)


def _in_window(question: Question, part: _Part) -> Counts | None:
    """To how many cells a thing can be brought, if looking at those near it saves anything."""
    asked = part.asked
    assert asked.cells is not None
    assert asked.shape is not None
    row, column = (part.astype(np.int16) for part in np.divmod(asked.cells, asked.shape[1]))
    cells = asked.shape[0] * asked.shape[1]
    words = min(-(-cells // 64), MOST_PACKED_LABELS // 64)
    limits, steps, table, threads = question.limits, asked.horizon, asked.table, asked.threads
    shown = asked.labels >= 0
    gib = _check(question.horizon, part, lambda states: 24.0 * states)
    _compile_window()
    watch = watched(question.horizon, steps, gib, limits, question.report)
    # Shifting a word takes twice as long as uniting two, so half of them must be saved.
    window = window_of(
        table, row, column, steps, words // 2, threads, shown=shown, watch=_first_half(watch)
    )
    if window is None:
        return None
    gib = _check(question.horizon, part, _window_bytes(asked, window))
    watch = watched(question.horizon, steps, gib, limits, question.report)
    return count_in_window(table, row, column, steps, window, threads, shown=shown, watch=watch)


def _of_many_labels(question: Question, part: _Part, graph: "Graph | None") -> Counts:
    """As lists while sets are short, and as columns of bits where they outgrow these."""
    asked, starts, where = part.asked, part.place, slice(None)
    if question.starts is not None or len(asked.table) < len(question.table):
        starts, where = np.unique(part.place.astype(np.int64), return_inverse=True)
    columns = Columns.of(asked.labels, asked.label_count, starts)
    gib = _check(question.horizon, part, _columns_bytes(asked, columns))

    def listed(chosen: Counts, threads: int, watch: Progress) -> None:
        found[chosen] = count_forward(
            asked.table,
            asked.labels,
            asked.label_count,
            asked.horizon,
            starts[chosen],
            threads,
            most=_LISTED,
            most_steps=_LIST_STEPS,
            watch=watch,
        )

    found = np.full(len(starts), -1, np.int64)
    if len(starts):
        steps = asked.table, asked.labels, asked.label_count, asked.horizon, starts
        if few_steps(*steps, _LISTED, _LIST_STEPS) > INTERPRETED:
            _compile_lists()
        trial = np.unique(np.linspace(0, len(starts) - 1, _TRIED).astype(int))
        listed(trial, 1, unwatched)
        if (found[trial] >= 0).mean() > 0.5:
            rest = np.ones(len(starts), bool)
            rest[trial] = False
            watch = watched(question.horizon, asked.horizon, gib, question.limits, question.report)
            listed(np.flatnonzero(rest), asked.threads, watch)
    long = np.flatnonzero(found < 0)
    if len(long):
        from habilis.empowerment.tabular.column_counting import count_columns
        from habilis.empowerment.tabular.spreading import Graph

        graph = Graph.of(asked.table) if graph is None else graph
        columns = Columns.of(asked.labels, asked.label_count, starts[long])
        _compile_columns(columns.forward)
        watch = watched(question.horizon, asked.horizon, gib, question.limits, question.report)
        counted = count_columns(
            graph,
            asked.labels,
            asked.label_count,
            asked.horizon,
            columns,
            asked.threads,
            watch,
        )
        found[long] = counted if columns.forward else counted[starts[long]]
    return found[where]


def _first_half(watch: Progress) -> Progress:
    return lambda share: watch(share / 2)


# What it takes, in bytes, by how many states there are.


def _check(horizon: int, part: _Part, memory: Callable[[int], float]) -> float:
    """The memory in GiB, unless it is above the limit.

    Raises:
        TooMuchError: with the largest horizon within which few enough states are touched.
    """
    asked = part.asked
    gib = (memory(len(asked.table)) + part.besides) / _GIB
    if gib > asked.limits.gib:
        most = asked.limits.gib * _GIB - part.besides
        fitting = sum(memory(int(states)) <= most for states in part.levels) - 1
        check_memory(gib, max(fitting, 0), horizon, asked.limits)
    return gib


def _graph_bytes(asked: Question) -> Callable[[int], float]:
    return lambda states: states * (8.0 * asked.table.shape[1] + 64)


def _packed_bytes(asked: Question, words: int) -> Callable[[int], float]:
    planes = 3 if asked.horizon >= 2 * FIRST_LOOK else 2
    return lambda states: 8.0 * planes * max(words, 1) * states


def _window_bytes(asked: Question, window: Window) -> Callable[[int], float]:
    return _packed_bytes(asked, window.words)


def _columns_bytes(asked: Question, columns: Columns) -> Callable[[int], float]:
    return lambda states: float(
        memory(states, asked.table.shape[1], columns, asked.label_count, asked.threads)
    )
