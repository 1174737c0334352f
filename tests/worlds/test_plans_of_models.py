"""Shortest plans of models, found without all of their states."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from slow_pushworld import puzzles

import habilis as hb
from habilis.bridges import PushWorld
from habilis.models import TooManyStatesError

SHARED = Path(__file__).parents[2] / "../shared/pushworld"


@settings(deadline=None, max_examples=30)
@given(puzzles())
def test_the_plan_is_that_of_the_table(text):
    puzzle = PushWorld.parse(text)
    mdp = hb.explore(puzzle)
    plan, way = hb.solve(mdp), hb.solve(puzzle)
    if plan is None:
        assert way is None
        return
    assert way is not None
    assert len(way.actions) == plan.steps
    assert way.best_return == plan.best_return
    assert way.states[0] == puzzle.initial
    for place, action in enumerate(way.actions):
        assert puzzle.step(way.states[place], action) == way.states[place + 1]
    assert puzzle.solved(way.states[-1])


def test_nothing_is_expanded_beyond_the_nearest_goal():
    puzzle = PushWorld.parse("A M0 G0 . . . . . . .")
    assert hb.solve(puzzle, max_states=2) is not None
    way = hb.solve(puzzle, (0, 1))
    assert way is not None
    assert way.actions == (1,)
    with pytest.raises(TooManyStatesError, match="more than 5 states"):
        hb.solve(PushWorld.parse("A M0 . . . . . . . G0"), max_states=5)


def test_a_way_from_a_solved_state_has_an_action():
    way = hb.solve(PushWorld.parse("A . M0+G0 ."))
    assert way is not None
    assert way.actions == (0,)
    assert way.best_return == 0


@pytest.mark.skipif(not SHARED.is_dir(), reason="the puzzles of PushWorld are not here")
def test_a_plan_is_no_longer_than_the_reference_solution():
    puzzle = hb.load_pushworld(SHARED / "puzzles/level1/Pick A Tool.pwp")
    way = hb.solve(puzzle)
    assert way is not None
    assert len(way.actions) <= 18
    assert puzzle.terminal_many(np.array(way.states)).argmax() == len(way.actions)
