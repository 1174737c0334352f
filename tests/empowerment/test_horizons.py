"""Empowerment of every horizon at once is that of each."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tables import labelled_tables

import habilis as hb
from habilis.empowerment.horizons import empowerment_by_horizon

MDP = hb.TabularMDP


@settings(deadline=None)
@given(labelled_tables(), st.integers(0, 9), st.data())
def test_every_row_is_what_that_horizon_alone_gives(drawn, horizon, data):
    table, labels = drawn
    mdp = MDP.deterministic(table)
    states = data.draw(st.none() | st.lists(st.integers(0, len(table) - 1), min_size=1))
    used = data.draw(st.none() | st.lists(st.integers(0, table.shape[1] - 1), min_size=1))
    unit = data.draw(st.sampled_from(["bits", "nats"]))
    found = empowerment_by_horizon(mdp, horizon, labels, used, states, unit=unit)
    assert len(found) == horizon + 1
    for h, row in enumerate(found):
        alone = hb.empowerment(mdp, h, labels, used, states, unit=unit)
        np.testing.assert_array_equal(row, alone)


@pytest.mark.parametrize("tool", ["picker", "broom", "none"])
def test_rows_of_a_world_are_the_same_to_the_last_bit(tool):
    mdp = hb.tabulate(hb.load_world("yard", tool=tool))
    states = np.flatnonzero(mdp.flags["equipped"] | (tool == "none"))
    found = empowerment_by_horizon(mdp, 4, "object", states=states)
    for h, row in enumerate(found):
        np.testing.assert_array_equal(row, hb.empowerment(mdp, h, "object", states=states))


@pytest.mark.parametrize(
    "options", [{}, {"method": hb.Sampled(samples=7, seed=3)}], ids=["exact", "sampled"]
)
def test_noise_makes_no_difference(options):
    mdp = hb.tabulate(hb.World.parse("A.C\n.PG"), slip=0.2)
    states = [mdp.start, 3]
    found = empowerment_by_horizon(mdp, 2, "object", states=states, **options)
    for h, row in enumerate(found):
        np.testing.assert_array_equal(
            row, hb.empowerment(mdp, h, "object", states=states, **options)
        )
    assert (found[2] > found[0]).any()


def test_a_sensor_of_very_many_labels_is_counted_forward():
    ring = MDP.deterministic([[(s - 1) % 5000, (s + 1) % 5000] for s in range(5000)])
    found = empowerment_by_horizon(ring, 3, "state", states=[7])
    np.testing.assert_array_equal(found[:, 0], np.log2([1, 2, 3, 4]))


@pytest.mark.ill_typed
def test_what_cannot_be_asked_is_refused_as_it_is_of_one_horizon():
    mdp = MDP.deterministic([[0, 1], [1, 0]])
    wrong: list[dict[str, Any]] = [{"unit": "dits"}, {"threads": 0}, {"seed": -1}]
    for options in [*wrong, {"tolerance": "small"}]:
        with pytest.raises(ValueError, match=next(iter(options))):
            empowerment_by_horizon(mdp, 2, "state", **options)
    with pytest.raises(ValueError, match="whole number from 0 up"):
        empowerment_by_horizon(mdp, -1, "state")
    with pytest.raises(ValueError, match="use indices from 0 to 1"):
        empowerment_by_horizon(mdp, 1, "state", actions=[2])
    with pytest.raises(ValueError, match="use indices from 0 to 1"):
        empowerment_by_horizon(mdp, 1, "state", states=[2])
