"""The landscape of a model: the agent in every cell, all else as at the start."""

import numpy as np
import pytest

import habilis as hb


class Room:
    """Three rows of four cells; a step into the wall switches a lamp."""

    actions = "north", "east", "south", "west"
    initial = ((0, 0), False)

    def step(self, state, action):
        (row, column), lamp = state
        down, right = [(-1, 0), (0, 1), (1, 0), (0, -1)][action]
        to = row + down, column + right
        inside = 0 <= to[0] < 3 and 0 <= to[1] < 4
        return (to, lamp) if inside else ((row, column), not lamp)

    def factors(self, state):
        return {"agent": state[0], "lamp": int(state[1])}


class Dark(Room):
    def factors(self, state):
        return {"agent": state[0]}


def test_values_are_those_of_the_cells_with_the_lamp_off():
    found = hb.landscape(Room(), 2, "lamp")
    for row in range(3):
        for column in range(4):
            bits = hb.empowerment(Room(), 2, "lamp", states=[((row, column), False)])
            assert found.values[row, column] == bits[0]
    assert found.values[0, 0] == 1


def test_a_table_has_the_same_landscape_and_it_is_drawn(tmp_path):
    found, of_table = hb.landscape(Room(), 2, "agent"), hb.landscape(hb.explore(Room()), 2, "agent")
    assert np.array_equal(found.values, of_table.values)
    assert found.values[0, 0] == pytest.approx(np.log2(6))
    found.save(tmp_path / "room.png")
    assert (tmp_path / "room.png").read_bytes().startswith(b"\x89PNG")
    assert found.to_dataframe().height == 12


def test_what_has_no_landscape_is_refused():
    with pytest.raises(ValueError, match=r"Dark has 2 states with the agent at .* add factors"):
        hb.landscape(Dark(), 2)
    with pytest.raises(ValueError, match="has no landscape: it needs a factor 'agent'"):
        hb.landscape(hb.TabularMDP.deterministic([[0]]), 1)
    with pytest.raises(ValueError, match="Room is not a map; leave out tool, object and mdp"):
        hb.landscape(Room(), 1, tool=(0, 0))
