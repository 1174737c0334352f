import numpy as np
import polars as pl
import pytest

import habilis as hb
from habilis.benchmarks.counting import enumerate_sequences
from habilis.empowerment.measures import (
    average_empowerment,
    compare,
    landscape,
    ranking,
    world_landscape,
)
from habilis.empowerment.tables import save_table, state_table

ROOM = hb.World.parse("A..\nP#.\n.C.\n..G\n", "room")


def test_an_average_is_over_placements_with_the_tool_in_hand():
    mdp = hb.tabulate(ROOM)
    bits = hb.empowerment(mdp, 2, "object")
    assert average_empowerment(mdp, 2) == bits[mdp.flags["equipped"]].mean()
    assert not mdp.flags["equipped"].all()


def test_without_a_tool_an_average_is_over_all_placements():
    mdp = hb.tabulate(ROOM.with_tool("none"))
    assert average_empowerment(mdp, 2) == hb.empowerment(mdp, 2, "object").mean()


def test_compare_measures_every_tool_in_the_same_place():
    found = compare(ROOM, ["broom", "none"], 2)
    assert list(found) == ["broom", "none"]
    assert found["broom"] == average_empowerment(hb.tabulate(ROOM.with_tool("broom")), 2)


def test_ranking_is_from_the_most_to_the_least():
    assert ranking({"a": 0.1, "b": 0.3, "c": 0.2}) == ["b", "c", "a"]


def test_a_landscape_has_the_value_of_each_agent_cell():
    mdp = hb.tabulate(ROOM)
    values = landscape(mdp, 2, "object", tool=(1, 0), object=(2, 1))
    bits = hb.empowerment(mdp, 2, "object")
    for cell in np.ndindex(4, 3):
        try:
            expected = bits[mdp.find(agent=cell, tool=(1, 0), object=(2, 1))]
        except KeyError:
            expected = np.nan
        np.testing.assert_equal(values[cell], expected)
    assert np.isnan(values[1, 1])
    assert np.isfinite(values).sum() == 12 - 3


def test_a_landscape_away_from_the_maps_cell_has_the_tool_in_hand_only():
    values = landscape(hb.tabulate(ROOM), 1, "state", tool=(3, 1), object=(0, 2))
    assert sorted(map(tuple, np.argwhere(np.isfinite(values)))) == [(2, 1), (3, 0), (3, 2)]


def test_a_landscape_can_be_of_some_actions():
    mdp = hb.tabulate(ROOM)
    some = landscape(mdp, 1, "state", actions=[0], tool=(1, 0), object=(2, 1))
    assert np.nanmax(some) == 0


def test_a_worlds_landscape_is_at_its_maps_cells():
    mdp = hb.tabulate(ROOM)
    np.testing.assert_array_equal(
        world_landscape(ROOM, 2, "object"),
        landscape(mdp, 2, "object", tool=ROOM.tool_cell, object=ROOM.object),
    )


def test_what_cannot_be_measured_is_refused():
    mdp = hb.tabulate(ROOM)
    with pytest.raises(ValueError, match="give two distinct free cells"):
        landscape(mdp, 1, tool=(1, 0), object=(1, 1))
    with pytest.raises(ValueError, match="give two distinct free cells"):
        landscape(mdp, 1, tool=(1, 0), object=(1, 5))
    with pytest.raises(ValueError, match="the tool has no cell"):
        landscape(mdp, 1, object=(2, 1))
    with pytest.raises(ValueError, match="needs a world's table"):
        landscape(hb.TabularMDP.deterministic([[0]]), 1, object=(0, 0))
    with pytest.raises(ValueError, match="no tools to compare"):
        compare(ROOM, [], 1)
    with pytest.raises(ValueError, match="rake"):
        compare(ROOM, ["rake"], 1)
    cramped = hb.World.parse("P#A.CG", "cramped")
    assert np.isfinite(average_empowerment(hb.tabulate(cramped), 1))
    with pytest.raises(ValueError, match="no room to hold the tool"):
        average_empowerment(hb.tabulate(hb.World.parse("A#P\n#C#\nG#.", "cells")), 1)


def test_per_state_tables_name_cells_by_row_and_column(tmp_path):
    mdp = hb.tabulate(ROOM)
    bits = hb.empowerment(mdp, 1)
    table = state_table(mdp, bits)
    assert table["bits"].to_list() == bits.tolist()
    state = mdp.find(agent=(0, 0), tool=(1, 0), object=(2, 1))
    row = table.row(state, named=True)
    assert (row["agent_row"], row["agent_column"]) == (0, 0)
    assert (row["tool_row"], row["tool_column"]) == (1, 0)
    assert row["equipped"] is True
    for path in (tmp_path / "t.csv", tmp_path / "t.parquet"):
        save_table(table, path)
        again = pl.read_csv(path) if path.suffix == ".csv" else pl.read_parquet(path)
        assert again["bits"].to_list() == bits.tolist()
    with pytest.raises(ValueError, match=r"use \.csv or \.parquet"):
        save_table(table, tmp_path / "t.txt")


def test_the_benchmarks_enumeration_is_right():
    mdp = hb.tabulate(ROOM)
    states = np.arange(mdp.states)
    np.testing.assert_allclose(
        enumerate_sequences(mdp, mdp.factor("object"), states, 3),
        hb.empowerment(mdp, 3, "object"),
    )
