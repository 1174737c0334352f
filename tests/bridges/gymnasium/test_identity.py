"""Two things are the same state when their values are the same."""

import collections
import copy
import datetime
import enum
import functools
import logging
import random
import threading
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from habilis.bridges.gymnasium.identity import digest, view

SAME: list[tuple[Any, Any]] = [
    ((0,), np.array([0])),
    ([1, 2.0, True], np.array([1, 2, 1], np.int8)),
    (np.float32(0.5), 0.5),
    (np.int64(3), 3.0),
    (True, 1),
    (0.0, -0.0),
    (np.array([0.0, 1.0]), np.array([-0.0, 1.0])),
    (float("nan"), np.float32("nan")),
    ([float("nan"), 1.0], np.array([np.nan, 1.0])),
    (2 + 0j, 2),
    (2**70, np.float64(2**70)),
    (np.zeros((3, 4, 5)), np.zeros((3, 4, 5), int).tolist()),
    (np.zeros((2, 0)), [[], []]),
    (np.array(3), 3),
    (np.array(["a", "b"]), ["a", "b"]),
    (np.array([{1}, None], object), [{1}, None]),
    ({1, 2}, frozenset((2.0, 1))),
    ({"a": 1, "b": [1]}, {"b": np.array([1.0]), "a": True}),
    (collections.OrderedDict(a=1, b=2), {"b": 2, "a": 1}),
    (random.Random(1), np.random.default_rng(2)),
    (random.Random(1), logging.getLogger("x")),
    ([random.Random(1)], [np.random.default_rng(2)]),
    (np.uint64(2**63), 2**63),
    (Image.new("L", (2, 2), 7), Image.new("L", (2, 2), 7)),
]
DIFFERENT: list[tuple[Any, Any]] = [
    ((0,), (1,)),
    ((0,), 0),
    ([], {}),
    ([], None),
    (None, 0),
    ("1", 1),
    (b"a", "a"),
    (2**53, 2**53 + 1),
    (np.array([2**53]), np.array([2**53 + 1])),
    (1 + 2j, 1),
    ([1, [2]], [[1], 2]),
    ([[1, 2], [3]], [[1], [2, 3]]),
    (np.zeros((2, 3)), np.zeros((3, 2))),
    ([1, 2], [2, 1]),
    ({1: 2}, {2: 1}),
    (collections.deque([1]), collections.deque([2])),
    (datetime.date(2020, 1, 1), datetime.date(2020, 1, 2)),
    (iter([1, 2]), iter([1, 3])),
    (functools.partial(max, 1), functools.partial(max, 2)),
    (int, float),
    (len, max),
    ((1).bit_length, (2).bit_length),
    (lambda: 1, lambda: 2),
    ({0: random.Random(1)}, {1: random.Random(1)}),
    ([random.Random(1)], []),
    (np.uint64(2**63), np.uint64(2**63 + 1)),
    (np.datetime64("2020-01-01"), np.datetime64("2020-01-02")),
    (np.timedelta64(1, "D"), np.timedelta64(2, "D")),
    (Image.new("L", (2, 2), 7), Image.new("L", (2, 2), 8)),
    (enum.Flag("F", "A B")(0), enum.Flag("F", "A B")(1)),
]


@pytest.mark.parametrize(("one", "other"), SAME)
def test_equal_values_are_one_state_whatever_their_types(one: Any, other: Any):
    assert digest(one) == digest(other)
    assert digest({"x": [one, "y"]}) == digest({"x": (other, "y")})


@pytest.mark.parametrize(("one", "other"), DIFFERENT)
def test_different_values_are_different_states(one: Any, other: Any):
    assert digest(one) != digest(other)


class Node:
    def __init__(self, value: Any, **parts: Any) -> None:
        self.value = value
        vars(self).update(parts)


class Slots:
    __slots__ = ("__hidden", "x")

    def __init__(self, x: Any, hidden: Any) -> None:
        self.x, self.__hidden = x, hidden


class Marked(list):
    mark = 0


def test_objects_are_their_classes_and_attributes():
    assert digest(Node(1)) == digest(Node(1.0))
    assert digest(Node(1)) != digest(Node(2))
    assert digest(Node(1)) != digest(type("Other", (Node,), {})(1))
    assert digest(Slots(1, 2)) == digest(Slots(1, 2))
    assert digest(Slots(1, 2)) != digest(Slots(1, 3))
    one, other = Marked([1]), Marked([1])
    assert digest(one) == digest(other) == digest([1])
    other.mark = 3
    assert digest(one) != digest(other)


class Board:
    """Seen by NumPy as the same array whatever else it holds."""

    def __init__(self, at: int) -> None:
        self.at = at

    def __array__(self, dtype: Any = None, copy: Any = None) -> np.ndarray:
        return np.zeros(3)


class Grid(np.ndarray):
    at = 0


class Number(int):
    pass


def test_what_is_an_array_or_a_number_besides_keeps_its_attributes():
    assert digest(Board(1)) != digest(Board(2))
    one, other = np.zeros(3).view(Grid), np.zeros(3).view(Grid)
    assert digest(one) == digest(other) == digest([0, 0, 0])
    other.at = 1
    assert digest(one) != digest(other)
    seven = Number(7)
    assert digest(seven) == digest(7)
    seven.name = "seven"  # type: ignore[attr-defined]
    assert digest(seven) != digest(7)


def test_long_chains_are_compared():
    def chain(last: int) -> Node:
        node = Node(last)
        for _ in range(3000):
            node = Node(0, after=node)
        return node

    assert digest(chain(1)) == digest(chain(1))
    assert digest(chain(1)) != digest(chain(2))


def test_what_cannot_be_compared_is_left_out_wherever_it_is_met():
    lock = threading.Lock()
    with pytest.raises(ValueError, match=r"the attribute 'first' .* cannot be compared"):
        digest(Node(1, first=lock))
    both = Node(1, first=lock, second=lock)
    assert view(both, strict=False).digest == digest(Node(1))


def ring(*values: Any) -> Node:
    nodes = [Node(value) for value in values]
    for node, after in zip(nodes, nodes[1:] + nodes[:1], strict=True):
        node.after = after  # type: ignore[attr-defined]
    return nodes[0]


def test_objects_in_cycles_are_equal_if_no_path_distinguishes_them():
    assert digest(ring(1, 2)) == digest(ring(1, 2)) == digest(ring(1, 2, 1, 2))
    assert digest(ring(1, 1)) == digest(ring(1))
    assert digest(ring(1, 2)) != digest(ring(2, 1))
    assert digest(ring(1, 2, 3)) != digest(ring(1, 3, 2))
    assert digest([ring(1, 2), 1]) != digest([ring(1, 2), 2])
    one: list[Any] = [1]
    one.append(one)
    assert digest(one) == digest([1, one])
    assert digest(one) != digest([2, one])


def test_sharing_is_no_part_of_a_value():
    shared = Node([1, 2])
    assert digest([shared, shared]) == digest([Node([1, 2]), Node((1, 2))])


def grid(size: int, value: int = 0) -> Node:
    """Cells that know their neighbors; a walk over all paths would not end."""
    cells = [[Node((row, column)) for column in range(size)] for row in range(size)]
    for row, column in np.ndindex(size, size):
        sides = [(row + 1, column), (row - 1, column), (row, column + 1), (row, column - 1)]
        near = [cells[r][c] for r, c in sides if 0 <= r < size and 0 <= c < size]
        cells[row][column].near = near  # type: ignore[attr-defined]
    cells[-1][-1].value = value
    return cells[0][0]


def test_many_circles_cost_no_more_than_their_objects():
    assert digest(grid(12)) == digest(grid(12))
    assert digest(grid(12)) != digest(grid(12, 1))


def test_what_is_met_on_the_way_is_reported():
    generator = np.random.default_rng(0)
    seen = view({"a": [generator], "b": Node(1, other=generator)})
    assert [one is generator for one in seen.generators] == [True]


plain = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.binary(),
    lambda parts: st.lists(parts) | st.dictionaries(st.text(), parts),
    max_leaves=20,
)


@settings(deadline=None)
@given(plain)
def test_copies_have_the_value_of_what_they_were_copied_from(value: Any):
    assert digest(copy.deepcopy(value)) == digest(value)


@settings(deadline=None)
@given(st.lists(st.floats() | st.integers(-(2**60), 2**60), min_size=1))
def test_arrays_have_the_value_of_lists(values: list[float]):
    if all(type(value) is float for value in values):
        assert digest(np.array(values)) == digest(values)
    if all(type(value) is int for value in values):
        assert digest(np.array(values)) == digest(tuple(values))


@settings(deadline=None)
@given(plain, plain)
def test_a_value_changed_anywhere_is_another(value: Any, other: Any):
    same = digest(value) == digest(other)
    assert (digest([value, 1]) == digest([other, 1])) == same
    assert (digest({"x": value}) == digest({"x": other})) == same
    assert (digest(Node(value)) == digest(Node(other))) == same
