"""Leaving out what h actions cannot change makes no difference, whatever the table."""

import time
import tracemalloc
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import habilis as hb
from habilis.benchmarks.counting import room
from habilis.compiled import compile_now
from habilis.empowerment.limits import Limits, TooMuchError, watched
from habilis.empowerment.tabular import deterministic
from habilis.empowerment.tabular.changing import changing
from habilis.empowerment.tabular.counting import count_backward, count_unions, unite
from habilis.empowerment.tabular.deterministic import Question, counts, counts_by_horizon


def truth(table: np.ndarray, labels: np.ndarray, horizon: int) -> list[int]:
    """|O_h(s)| of every state, with Python's sets; what is labelled -1 is not observed."""
    sets = [{label} - {-1} for label in labels.tolist()]
    for _ in range(horizon):
        sets = [set().union(*(sets[t] for t in row)) for row in table.tolist()]
    return [len(one) for one in sets]


@st.composite
def slow_tables(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray, int]:
    """Tables in which labels change seldom, with states in any order."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    states, actions = draw(st.integers(1, 60)), draw(st.integers(1, 3))
    moves = rng.choice([-1, 0, 0, 0, 1], size=(states, actions))
    table = np.clip(np.arange(states)[:, None] + moves, 0, states - 1)
    labels = np.arange(states) // draw(st.integers(1, 30)) - draw(st.sampled_from([0, 1]))
    order = rng.permutation(states) if draw(st.booleans()) else np.arange(states)
    place = np.argsort(order)
    return place[table[order]].astype(np.int32), labels[order].astype(np.int32), states


@settings(deadline=None, max_examples=80)
@given(slow_tables(), st.integers(0, 20), st.sampled_from([1, 2]))
def test_the_smaller_problem_has_the_same_counts(drawn, horizon: int, threads: int):
    table, labels, label_count = drawn
    small = changing(table, labels, label_count, horizon, threads)
    if small is None:
        return
    some = small.table, small.labels, label_count, horizon, threads
    found = count_backward(*some, first=small.first)
    assert found[small.place].tolist() == truth(table, labels, horizon)
    assert len(small.table) == small.sizes[-1]
    side_by_side = labels[small.states].astype(np.uint16)  # -1 comes last
    assert np.array_equal(np.sort(side_by_side), side_by_side)


@settings(deadline=None, max_examples=50)
@given(slow_tables(), st.integers(0, 20), st.booleans(), st.data())
def test_counts_leave_out_what_cannot_change(drawn, horizon: int, on_a_map: bool, data):
    table, labels, label_count = drawn
    starts = data.draw(st.none() | st.lists(st.integers(0, len(table) - 1)))
    asked = None if starts is None else np.array(starts, np.int64)
    where = slice(None) if asked is None else asked
    cells = 41 * np.maximum(labels, 0) if on_a_map else None
    question = Question(table, labels, label_count, horizon, asked, cells, (61, 41))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(deterministic, "_NARROW", 0)
        patch.setattr(deterministic, "_TRIFLE", 0)
        found, rows = counts(question), counts_by_horizon(question)
    for h in (0, 1, horizon // 2, horizon):
        if h <= horizon:
            assert rows[h].tolist() == np.array(truth(table, labels, h))[where].tolist()
    assert found.tolist() == rows[-1].tolist()


@pytest.mark.parametrize("horizon", [1, 2, 3, 250, 254, 255, 256, 257, 400, 10**6])
def test_a_change_from_far_away_arrives_when_it_does(horizon: int):
    table = np.maximum(np.arange(420) - 1, 0).astype(np.int32)[:, None]  # leads to state 0
    labels = (np.arange(420) > 0).astype(np.int32)
    small = changing(table, labels, 2, horizon, 1)
    assert small is not None
    found = count_backward(small.table, small.labels, 2, horizon, first=small.first)[small.place]
    assert found.tolist() == [1] * 420
    table = np.concatenate([table, np.arange(420, dtype=np.int32)[:, None]], axis=1)  # or stays
    small = changing(table, labels, 2, horizon, 1)
    assert small is not None
    found = count_backward(small.table, small.labels, 2, horizon, first=small.first)[small.place]
    assert found.tolist() == [1] + [2] * min(horizon, 419) + [1] * max(419 - horizon, 0)


def test_what_nothing_changes_is_left_out_at_any_horizon():
    table = np.array([[0, 1], [1, 0], [2, 3], [3, 2]], np.int32)
    labels = np.array([0, 1, 2, 2], np.int32)
    small = changing(table, labels, 3, 10**9, 1)
    assert small is not None
    assert small.states.tolist() == [0, 1]
    assert small.sizes.tolist() == [4, 6]
    assert changing(table, np.arange(4, dtype=np.int32), 4, 10**9, 1) is None  # saves nothing


def both(kernel: Any) -> list[Callable[..., Any]]:
    """As it is compiled, and in NumPy."""
    return [kernel.machine, kernel.uncompiled]


@settings(deadline=None, max_examples=50)
@given(st.integers(1, 40), st.integers(1, 9), st.integers(1, 17), st.integers(0, 2**32 - 1))
def test_rows_of_any_length_are_united_and_counted(states, actions, words, seed):
    rng = np.random.default_rng(seed)
    table = rng.integers(states, size=(states, actions)).astype(np.int32)
    sets = rng.integers(2**63, size=(states, words)).astype(np.uint64) << np.uint64(1)
    sets[rng.random(sets.shape) < 0.7] = 0
    first = rng.choice([0, 2, 3, 255], size=states).astype(np.uint8)
    begin, end = sorted(rng.integers(states + 1, size=2).tolist())
    inside = np.zeros(states, np.bool_)
    inside[begin:end] = first[begin:end] <= 2
    union = np.where(inside[:, None], np.bitwise_or.reduce(sets[table], axis=1), sets)
    for one in both(unite):
        out = sets.copy()
        assert one(table, first, 2, sets, out, begin, end) == bool((union != sets).any())
        assert np.array_equal(out, union)
    expected = np.where(inside, np.bitwise_count(union).sum(axis=1, dtype=np.int64), -1)
    for one in both(count_unions):
        counted = np.full(states, -1, np.int64)
        one(table, first, 2, sets, counted, begin, end)
        assert np.array_equal(counted, expected)


def test_a_table_may_be_a_view_of_another_array():
    table = np.array([[1, 0, 1], [1, 1, 0], [0, 2, 2]], np.int32)[:, ::2]
    labels = np.arange(3, dtype=np.int32)
    for horizon in (1, 2, 3):
        expected = truth(table, labels, horizon)
        assert count_backward(table, labels, 3, horizon).tolist() == expected
        compile_now(unite, count_unions)
        assert count_backward(table, labels, 3, horizon).tolist() == expected


def test_the_memory_foreseen_is_what_it_takes(monkeypatch: pytest.MonkeyPatch):
    mdp = hb.tabulate(room(15))
    foreseen: list[float] = []

    def spy(horizon, steps, gib, *rest):
        foreseen.append(gib)
        return watched(horizon, steps, gib, *rest)

    monkeypatch.setattr(deterministic, "watched", spy)
    labels = mdp.factor("object")
    question = Question(mdp.next_state, labels, 225, 4)
    end = time.monotonic() + 2
    while time.monotonic() < end:  # until all is compiled, which takes memory too
        counts(question)
    tracemalloc.start()
    before, _ = tracemalloc.get_traced_memory()
    counts(question)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    answer = 24 * mdp.states
    assert peak - before <= foreseen[-1] * 2**30 + answer
    assert foreseen[-1] < 2 * 4 * 8 * mdp.states / 2**30  # of all states' sets
    limits = Limits(0.9 * foreseen[-1], 60)
    with pytest.raises(TooMuchError, match=r"largest horizon that fits is [123]"):
        counts(Question(mdp.next_state, labels, 225, 4, limits=limits))
