"""Landscapes, tables and sensors of worlds with several things."""

import numpy as np
import pytest

import habilis as hb

ROOM = hb.World.parse(
    "R = rake\nD = ball\nG = goal of C\nH = goal of D\nA....\n.PCR.\n.D#.H\n....G\n", name="room"
)
ONE = hb.World.parse("R = rake\nA....\n.PCR.\n..#..\n....G\n", name="one")
MDP = hb.tabulate(ROOM)


def test_every_cell_that_the_agent_can_be_in_has_a_value():
    values = hb.landscape(ROOM, 2, "object:can").values
    missing = {(int(row), int(column)) for row, column in np.argwhere(np.isnan(values))}
    assert missing == {(1, 1), (1, 2), (1, 3), (2, 1), (2, 2)}


def test_what_is_in_hand_follows_from_where_the_agent_is():
    bits = hb.landscape(ROOM, 1, "tool:picker").values
    assert bits[1, 0] > 0  # beside the picker
    assert bits[1, 4] == 0  # beside the rake
    assert hb.landscape(ROOM, 1, "tool:rake").values[1, 4] > 0


def test_the_values_are_those_of_the_table():
    found = hb.landscape(ROOM, 3, "object:can")
    given = hb.landscape(ROOM, 3, "object:can", mdp=MDP)
    both = np.isfinite(given.values)
    np.testing.assert_array_equal(found.values[both], given.values[both])
    assert 1 < both.sum() < np.isfinite(found.values).sum()  # some cannot be reached from the map's
    labels = hb.landscape(ROOM, 3, MDP.factor("object:can"))
    np.testing.assert_array_equal(labels.values, given.values)


def test_random_outcomes_count():
    sure = hb.landscape(ONE, 1, "object").values
    slipping = hb.landscape(ONE, 1, "object", slip=0.5).values
    assert np.nanmax(slipping) < np.nanmax(sure)


def test_things_can_be_put_anywhere():
    found = hb.landscape(ROOM, 2, "object:can", tool={"rake": (0, 0)}, object={"ball": (3, 0)})
    assert isinstance(found.world, hb.World)
    assert found.world.tools[1].cell == (0, 0)
    assert found.world.objects[1].cell == (3, 0)
    assert np.isnan(found.values[0, 0])
    assert np.isfinite(found.values[1, 3])
    assert found.world.agent != (0, 0)


def test_a_table_of_another_world_is_refused():
    with pytest.raises(ValueError, match="of another map"):
        hb.landscape(ROOM, 2, "object:can", mdp=hb.tabulate(ONE))


def test_where_the_table_has_no_such_state_it_says_so():
    stuck = hb.World.parse("D = can\nG = goal of C\nA#C#D\n#####\n....G", name="stuck")
    with pytest.raises(ValueError, match="stuck: no state of the table"):
        hb.landscape(stuck, 1, "object:can", object={"can2": (2, 0)}, mdp=hb.tabulate(stuck))


def test_the_only_object_needs_no_name():
    mdp = hb.tabulate(ONE)
    bits = hb.empowerment(mdp, 3, "object")
    np.testing.assert_array_equal(bits, hb.empowerment(mdp, 3, "object:can"))
    np.testing.assert_array_equal(mdp.factor("object"), mdp.factor("object:can"))
    start = {"agent": (0, 0), "tool:picker": (1, 1), "tool:rake": (1, 3), "held": -1}
    assert mdp.find(**start, object=(1, 2)) == mdp.find(**start, **{"object:can": (1, 2)})
    placement = {name: cell for name, cell in start.items() if name != "held"}
    around = hb.empowerment(ONE, 3, "object", states=[placement | {"object:can": (1, 2)}])
    assert around[0] == bits[mdp.start]


def test_one_of_several_has_to_be_named():
    with pytest.raises(ValueError, match=r"could be several things.*object:can, object:ball"):
        hb.empowerment(MDP, 3, "object")
    with pytest.raises(ValueError, match="'tool' could be several things"):
        MDP.find(tool=(1, 1))
    with pytest.raises(ValueError, match="is unknown"):
        MDP.factor("object:tin")


def test_a_hand_is_no_cell():
    table = hb.to_dataframe(MDP, hb.empowerment(MDP, 1, "held"))
    assert "held" in table.columns
    assert "held_row" not in table.columns
    assert set(table["held"]) == {-1, 0}
    beside = MDP.flags["equipped"]
    assert (table["held"].to_numpy()[beside] >= 0).all()


def test_what_is_in_hand_can_be_sensed_on_a_map_too_large_for_small_sets():
    rows = [
        "A" + "." * 39,
        "P" + "." * 39,
        "..R" + "." * 37,
        *["." * 40] * 30,
        "C" + "." * 38 + "G",
    ]
    world = hb.World.parse("R = rake\n" + "\n".join(rows))
    placement = {
        "agent": (1, 1),
        "tool:picker": (0, 0),
        "tool:rake": (2, 2),
        "object:can": (5, 5),
    }
    assert hb.empowerment(world, 1, "held", states=[placement])[0] == np.log2(3)
