"""Averages in stochastic worlds, estimated from random placements."""

from dataclasses import replace

import numpy as np

import habilis as hb
from habilis.analysis.averages import compare, compared_states
from habilis.studio import scene_steps
from habilis.studio.estimates import Estimate, verdicts
from habilis.studio.limits import DRAWN
from habilis.studio.protocol.answers import Verdict
from habilis.studio.random_placements import random_placements
from habilis.studio.scenes import Scene

WORLD = hb.World.parse("A#P.\n.C..\n...G\n####", "map")


def test_an_estimate_is_as_near_to_the_average_as_it_says():
    exact = compare(WORLD, ["picker", "broom", "none"], 2, slip=0.1)
    asked = Scene(WORLD, horizon=2, slip=0.1)
    for tool, wanted in exact.items():
        bits = scene_steps.sampled(asked, tool, 0, DRAWN)["bits"]
        found = Estimate.of(bits)
        assert len(bits) == DRAWN
        assert 0 < abs(found.bits - wanted) < 1.5 * found.within
        assert found.within < 0.1


def test_that_a_tool_can_be_put_down_changes_no_average():
    laid = replace(WORLD, drop=True)
    for one, slip in ((scene_steps.average, 0.0), (scene_steps.sampled, 0.1)):
        some = (0, 3) if one is scene_steps.sampled else ()
        found, wanted = (
            one(Scene(world, horizon=2, slip=slip), "picker", *some) for world in (laid, WORLD)
        )
        assert found == wanted


def test_placements_are_drawn_as_those_that_averages_go_over():
    for tool in ("picker", "none"):
        mdp = hb.tabulate(WORLD.with_tool(tool))
        states = [mdp.find(**place) for place in random_placements(WORLD.with_tool(tool), 20_000)]
        counts = np.bincount(states, minlength=mdp.states)
        wanted = compared_states(mdp)
        assert np.array_equal(counts > 0, wanted)
        mean = 20_000 / wanted.sum()
        assert abs(counts[wanted] - mean).max() < 5 * mean**0.5


def test_an_average_that_takes_too_long_is_left_to_an_estimate():
    large = hb.load_world("yard")
    assert scene_steps.average(Scene(large, horizon=4, slip=0.2), "picker") == {"bits": None}
    assert scene_steps.average(Scene(large, horizon=4), "picker")["bits"] > 0


def test_a_verdict_is_left_open_where_estimates_overlap():
    bare = Estimate(1.0, 0.1, True)
    for bits, within, better in ((1.05, 0.1, None), (1.3, 0.1, True), (0.7, 0.1, False)):
        known = {"none": bare, "broom": Estimate(bits, within, True)}
        said = Verdict(useful=True, better_than_none=better, equal=False)
        assert verdicts(known) == {"broom": said}
    exact = {"none": Estimate(1.0, 0.0, True), "broom": Estimate(1.0, 0.0, True)}
    assert verdicts(exact)["broom"].better_than_none is False
    assert verdicts({"broom": bare}) == {}


def test_the_interval_of_an_estimate_holds_the_average_of_what_it_was_drawn_from():
    random = np.random.default_rng(0)
    held = 0
    for _ in range(1_000):
        estimate = Estimate.of(random.exponential(size=100).tolist())
        held += abs(estimate.bits - 1) <= estimate.within
    assert 910 < held < 980


def test_a_tie_is_called_a_tie():
    bare = Estimate(0.5, 0.0, True)
    of = {
        "same": Estimate(0.5 + 1e-9, 0.0, True),
        "more": Estimate(0.5001, 0.0, True),
        "less": Estimate(0.4999, 0.0, True),
        "open": Estimate(0.5, 0.1, True),
    }
    said = verdicts({"none": bare} | of)
    assert [said[tool].equal for tool in of] == [True, False, False, False]
    assert [said[tool].better_than_none for tool in of] == [False, True, False, None]
    nothing = verdicts({"none": Estimate(0.0, 0.0, False), "rake": Estimate(0.0, 0.0, False)})
    assert nothing["rake"] == Verdict(useful=False, better_than_none=False, equal=True)
