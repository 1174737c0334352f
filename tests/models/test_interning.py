"""Rows of integers, each with a number in the order in which they are first met."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from habilis.models.interning import InternedRows, Packing

NUMBERS = st.one_of(st.integers(-3, 3), st.integers(-(2**61), 2**61))


@st.composite
def batches(draw):
    columns = draw(st.integers(1, 5))
    shapes = array_shapes(min_dims=1, max_dims=1, min_side=0, max_side=8)
    rows = shapes.flatmap(lambda n: arrays(np.int64, (*n, columns), elements=NUMBERS))
    return columns, draw(st.lists(rows, max_size=5))


@settings(deadline=None, max_examples=40)
@given(batches())
def test_every_row_has_the_number_of_its_first_appearance(data):
    columns, parts = data
    found, first = InternedRows(columns), {}
    for rows in parts:
        numbers = found.add(rows)
        assert numbers.tolist() == [first.setdefault(tuple(r), len(first)) for r in rows.tolist()]
    assert [tuple(row) for row in found.rows().tolist()] == list(first)
    for rows in parts:
        assert found.find(rows).tolist() == [first[tuple(row)] for row in rows.tolist()]
    order = found.order().tolist()
    assert [list(first)[place] for place in order] == sorted(first)


@settings(deadline=None, max_examples=40)
@given(batches())
def test_rows_that_are_not_there_have_no_number(data):
    columns, parts = data
    found, known = InternedRows(columns), set()
    for rows in parts[:1]:
        found.add(rows)
        known = {tuple(row) for row in rows.tolist()}
    for rows in parts[1:]:
        assert (found.find(rows) < 0).tolist() == [tuple(r) not in known for r in rows.tolist()]


def test_a_table_of_many_rows_grows():
    rows = np.arange(60_000).reshape(-1, 2) % 1000
    found = InternedRows(2)
    numbers = np.concatenate([found.add(part) for part in np.array_split(rows, 7)])
    assert len(found) == 500
    assert (found.take(numbers) == rows).all()


def test_rows_that_are_left_out_have_no_number_and_are_not_kept():
    found = InternedRows(1)
    assert found.add(np.array([[5], [6], [5]]), np.array([False, True, False])).tolist() == [
        -1,
        0,
        -1,
    ]
    assert found.rows().tolist() == [[6]]


def test_twelve_small_numbers_are_one_word():
    none = np.zeros(12, np.int64)
    assert Packing.of(none, none + 31).words == 1
    assert Packing.of(none, none + 63).words == 2


def test_values_that_fall_one_by_one_are_repacked_a_few_times_only(monkeypatch):
    made = []
    of = Packing.of
    monkeypatch.setattr(
        Packing, "of", lambda *ranges, **more: made.append(ranges) or of(*ranges, **more)
    )
    found = InternedRows(1)
    for value in range(1000):
        found.add(np.array([[-value]]))
    assert len(made) < 20
    assert found.rows()[:, 0].tolist() == [-value for value in range(1000)]
