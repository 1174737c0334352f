"""Windows, threads and worlds without a table change what it costs, and nothing else."""

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rooms import rooms

import habilis as hb
from habilis.empowerment.tabular import blocks, deterministic, windows
from habilis.empowerment.tabular.counting import count_backward, count_forward
from habilis.empowerment.tabular.windows import Window, count_in_window, window_of
from habilis.mdp import TabularMDP
from habilis.worlds.world import World

EVERYTHING = 10_000  # words: any window is worth it


@st.composite
def things_on_a_grid(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray, tuple[int, int]]:
    """A table, the cell of a thing in every state, and the shape; also jumps across the map."""
    shape = draw(st.sampled_from([(1, 7), (9, 1), (3, 5), (12, 11), (40, 40)]))
    states, actions = draw(st.integers(1, 40)), draw(st.integers(1, 4))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    cells = rng.integers(shape[0] * shape[1], size=states)
    if draw(st.booleans()):  # nearby: neighbours in the table are neighbours on the grid
        cells = np.sort(cells)
        offsets = rng.integers(-2, 3, size=(states, actions))
        table = np.clip(np.arange(states)[:, None] + offsets, 0, states - 1)
    else:
        table = rng.integers(states, size=(states, actions))
    return table.astype(np.int32), cells.astype(np.int32), shape


@settings(max_examples=200, deadline=None)
@given(things_on_a_grid(), st.integers(0, 6), st.sampled_from([1, 3]))
def test_counting_in_a_window_is_counting(thing, horizon: int, threads: int):
    table, cells, shape = thing
    row, column = (part.astype(np.int16) for part in np.divmod(cells, shape[1]))
    window = window_of(table, row, column, horizon, EVERYTHING, threads)
    assert window is not None
    count = count_in_window(table, row, column, horizon, window, threads)
    assert np.array_equal(count, count_backward(table, cells, shape[0] * shape[1], horizon))


@settings(max_examples=60, deadline=None)
@given(things_on_a_grid(), st.integers(0, 5))
def test_a_window_is_the_least_that_holds_every_displacement(thing, horizon: int):
    table, cells, shape = thing
    row, column = np.divmod(cells, shape[1])
    window = window_of(table, row.astype(np.int16), column.astype(np.int16), horizon, EVERYTHING, 1)
    moves, at = [(0, 0)], np.arange(len(table))[:, None]
    for _ in range(horizon):
        at = table[at].reshape(len(table), -1)
        down, right = row[at] - row[:, None], column[at] - column[:, None]
        moves += [(down.min(), right.min()), (down.max(), right.max())]
    (top, left), (bottom, right) = np.min(moves, axis=0), np.max(moves, axis=0)
    size = int(bottom - top + 1), int(right - left + 1)
    assert window == Window(int(top), int(left), *size)


def test_no_window_is_used_that_saves_nothing():
    table = np.array([[1, 0], [0, 1]], np.int32)
    far = np.array([0, 500], np.int16)
    assert window_of(table, far, far * 0, 1, 8, 1) is None
    assert window_of(table, far, far * 0, 0, 8, 1) == Window(0, 0, 1, 1)


def big_world() -> World:
    """Large enough for windows, and walled so that there are few placements."""
    rows = ["#" * 36 for _ in range(36)]
    rows[3] = "#" * 5 + "A.P...C..G" + "#" * 21
    rows[4] = "#" * 5 + ".........." + "#" * 21
    rows[5] = "#" * 5 + "...#......" + "#" * 21
    return World.parse("\n".join(rows), name="big")


@pytest.mark.parametrize("tool", ["picker", "broom", "none"])
@pytest.mark.parametrize("sensor", ["agent", "object", "tool"])
def test_a_large_map_counts_as_if_every_cell_had_its_bit(tool: str, sensor: str):
    world = big_world().with_tool(tool)
    mdp = hb.tabulate(world)
    if sensor not in mdp.factors:
        return
    assert windows.worth_a_window((36, 36))
    for horizon in (0, 1, 4, 50):
        cells = mdp.factor(sensor)
        plain = hb.empowerment(mdp, horizon, cells)  # labels: no window
        assert np.array_equal(hb.empowerment(mdp, horizon, sensor), plain)
        some = np.arange(0, mdp.states, 11)
        assert np.array_equal(hb.empowerment(mdp, horizon, sensor, states=some), plain[some])
        moves = hb.empowerment(mdp, horizon, sensor, range(4))
        assert np.array_equal(moves, hb.empowerment(mdp, horizon, cells, range(4)))


def test_the_window_is_what_is_used_on_a_large_map(monkeypatch: pytest.MonkeyPatch):
    used: list[Window] = []

    def spy(table, row, column, horizon, window, threads, **how):
        used.append(window)
        return count_in_window(table, row, column, horizon, window, threads, **how)

    monkeypatch.setattr(deterministic, "count_in_window", spy)
    hb.empowerment(hb.tabulate(big_world()), 2, "object")
    assert [window.words for window in used] == [1]  # of 21 for all 1,296 cells


def test_too_many_cells_for_packed_bits_are_counted_forward():
    # 100 x 100 cells; the thing may be anywhere one action later: no window, too many labels.
    states = 5000
    rng = np.random.default_rng(0)
    cells = rng.permutation(10_000)[:states].astype(np.int32)
    mdp = TabularMDP.deterministic(rng.integers(states, size=(states, 3)))
    mdp = replace(mdp, factors={"thing": cells}, shape=(100, 100))
    some = [0, 17, 4999]
    labels = np.arange(states, dtype=np.int32)
    counts = count_forward(mdp.next_state, labels, states, 3, np.array(some))
    assert np.array_equal(hb.empowerment(mdp, 3, "thing", states=some), np.log2(counts))


# Threads


@pytest.mark.parametrize("threads", [2, 3, 7])
def test_the_number_of_threads_does_not_matter(threads: int, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(blocks, "_WORTHWHILE", 1)
    mdp = hb.tabulate(big_world())
    for sensor in ("state", "object", mdp.factor("object")):
        one = hb.empowerment(mdp, 4, sensor, method=hb.Exact(threads=1))
        assert np.array_equal(one, hb.empowerment(mdp, 4, sensor, method=hb.Exact(threads=threads)))
    many = hb.tabulate(hb.load_world("yard"))
    one = hb.empowerment(many, 3, "state", method=hb.Exact(threads=1))
    assert np.array_equal(one, hb.empowerment(many, 3, "state", method=hb.Exact(threads=threads)))


@settings(deadline=None)
@given(st.integers(1, 50), st.integers(1, 9))
def test_blocks_cover_every_state_once_and_in_order(states: int, threads: int):
    got = blocks.in_blocks(lambda a, b: list(range(a, b)), states, 10**9, threads)
    assert [state for block in got for state in block] == list(range(states))
    assert len(got) == min(states, threads)


def test_little_work_is_not_shared_out():
    assert len(blocks.in_blocks(lambda a, b: b - a, 100, 8, threads=4)) == 1


# Worlds without a table


WORLDS = rooms([(1, 5), (2, 3), (3, 3), (3, 4)], lambda cells: min(2, cells))


def placements_of(world: World, mdp: TabularMDP) -> list[dict[str, tuple[int, int]]]:
    cells = {
        name: [divmod(int(cell), world.width) for cell in mdp.factor(name)] for name in mdp.factors
    }
    return [{name: cells[name][s] for name in cells} for s in range(mdp.states)]


@settings(max_examples=60, deadline=None)
@given(WORLDS, st.integers(0, 3), st.data())
def test_a_world_answers_as_its_table_does(world: World, horizon: int, data: st.DataObject):
    mdp = hb.tabulate(world)
    places = placements_of(world, mdp)
    sensor = data.draw(st.sampled_from(["state", *mdp.factors]))
    actions = data.draw(st.sampled_from([None, [0, 2], range(4)]))
    asked = data.draw(st.lists(st.integers(0, mdp.states - 1), min_size=1, max_size=5))
    bits = hb.empowerment(mdp, horizon, sensor, actions, asked)
    found = hb.empowerment(world, horizon, sensor, actions, [places[s] for s in asked])
    assert np.array_equal(found, bits)


def test_a_world_without_states_is_its_table():
    world = hb.load_world("yard")
    bits = hb.empowerment(world, 2, "object")
    assert np.array_equal(bits, hb.empowerment(hb.tabulate(world), 2, "object"))


def test_a_placement_may_have_the_tool_lie_where_the_map_has_it_not():
    world = World.parse("A...\n.P..\n..C.\n...G")
    away = {"agent": (0, 0), "tool": (3, 0), "object": (2, 2)}
    assert hb.empowerment(world, 1, "agent", states=away) == np.log2(3)
    with pytest.raises(KeyError):
        hb.tabulate(world).find(**away)


def huge_world() -> World:
    """200 x 200 free cells: eight thousand million placements."""
    rows = [["."] * 200 for _ in range(200)]
    for character, row, column in ("A", 0, 0), ("P", 100, 101), ("C", 102, 101), ("G", 199, 199):
        rows[row][column] = character
    return World.parse("\n".join(map("".join, rows)), name="huge")


def test_a_world_too_large_to_tabulate_answers_for_some_states():
    world = huge_world()
    with pytest.raises(ValueError, match="placements are more than"):
        hb.tabulate(world)
    place = {"agent": (100, 100), "tool": (100, 101), "object": (100, 102)}
    bits = hb.empowerment(world, 6, "object", states=[place])
    # Far from every wall, the same as in the middle of a room just large enough.
    room = World.parse("\n".join(["." * 31] * 13 + ["A.P.C.G" + "." * 24] + ["." * 31] * 17))
    small = hb.empowerment(
        room, 6, "object", states={"agent": (15, 14), "tool": (15, 15), "object": (15, 16)}
    )
    assert np.array_equal(bits, small)
    assert bits > 5


@pytest.mark.parametrize(
    ("states", "message"),
    [
        ([0, 1], "states has 0; of a world, give placements such as {'agent': (0, 0)"),
        ("all", "states has 'all'; of a world, give placements"),
        ({"agent": (0, 0), "object": (0, 2)}, "huge has agent, tool, object"),
        ({"agent": (0, 0), "tool": (0, 1), "object": (0, 200)}, "(0, 200) is outside the 200 x"),
        ({"agent": (0, 0), "tool": (0, 1), "object": 7}, "the object's cell is 7; give (row, col"),
        ({"agent": (0, 0), "tool": (0, 0), "object": (1, 1)}, "two things in one cell"),
    ],
)
def test_what_is_no_placement_is_refused(states: Any, message: str):
    with pytest.raises(ValueError, match=re.escape(message)):
        hb.empowerment(huge_world(), 1, "object", states=states)


def test_walls_hold_nothing():
    place = {"agent": (0, 0), "tool": (3, 5), "object": (3, 6)}
    with pytest.raises(ValueError, match=re.escape("the agent's cell (0, 0) is a wall")):
        hb.empowerment(big_world(), 1, "object", states=place)


def test_labels_need_a_table():
    with pytest.raises(ValueError, match="or tabulate it"):
        hb.empowerment(huge_world(), 1, np.zeros(3, int), states=[{}])


def test_what_few_actions_reach_may_still_be_too_much():
    from habilis.worlds.reach import reachable

    place = {"agent": (100, 100), "tool": (100, 101), "object": (100, 102)}
    with pytest.raises(ValueError, match="huge: 6 actions reach more than 100 placements"):
        reachable(huge_world(), place, 6, max_states=100)
