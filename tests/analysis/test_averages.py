from dataclasses import replace

import numpy as np
import pytest

import habilis as hb
from habilis.analysis.averages import (
    average_empowerment,
    compare,
    ranking,
)
from habilis.analysis.influence import reliability
from habilis.analysis.usefulness import usefulness
from habilis.benchmarks.counting import enumerate_sequences

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


def test_that_a_tool_can_be_put_down_changes_no_average():
    laid = replace(ROOM, drop=True)
    assert compare(laid, ["picker", "none"], 2) == compare(ROOM, ["picker", "none"], 2)
    found, wanted = usefulness(laid, 2), usefulness(ROOM, 2)
    assert np.array_equal(found.with_tool, wanted.with_tool)
    assert np.array_equal(found.better_than_none, wanted.better_than_none)
    assert reliability(laid, 2, slip=0.25) == reliability(ROOM, 2, slip=0.25)


def test_ranking_is_from_the_most_to_the_least():
    assert ranking({"a": 0.1, "b": 0.3, "c": 0.2}) == ["b", "c", "a"]


def test_what_cannot_be_measured_is_refused():
    with pytest.raises(ValueError, match="no tools to compare"):
        compare(ROOM, [], 1)
    with pytest.raises(ValueError, match="spoon"):
        compare(ROOM, ["spoon"], 1)
    cramped = hb.World.parse("P#A.CG", "cramped")
    assert np.isfinite(average_empowerment(hb.tabulate(cramped), 1))
    with pytest.raises(ValueError, match="no room to hold the tool"):
        average_empowerment(hb.tabulate(hb.World.parse("A#P\n#C#\nG#.", "cells")), 1)


def test_the_benchmarks_enumeration_is_right():
    mdp = hb.tabulate(ROOM)
    states = np.arange(mdp.states)
    np.testing.assert_allclose(
        enumerate_sequences(mdp, mdp.factor("object"), states, 3),
        hb.empowerment(mdp, 3, "object"),
    )
