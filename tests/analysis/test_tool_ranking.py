"""Which object is the tool: bits lost when it is fixed, and when it is removed."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from slow_pushworld import SlowPuzzle, puzzles

import habilis as hb
from habilis.bridges import PushWorld

# Only the rod M1 reaches through the agent's wall; M2 is beside the way; M0 and M3 move together.
ROD = """\
A  M1 M1 AW M0 M3 .
.  .  .  W  .  .  .
M2 .  .  .  .  .  .
"""


def rows(frame):
    return {name: values for name, *values in frame.rows()}


def test_the_rod_is_the_tool():
    frame = hb.tool_ranking(PushWorld.parse(ROD), "object:m0", horizon=2)
    assert frame.columns == ["object", "bits", "lost_fixed", "lost_removed"]
    assert frame["object"].to_list() == ["object:m1", "object:m3", "object:m2"]
    assert rows(frame) == {
        "object:m1": [1, 1, 1],  # without it, the agent does not reach the target
        "object:m3": [1, 1, 0],  # where it is fixed, the target is too; else it does not matter
        "object:m2": [1, 0, 0],
    }


def test_an_obstacle_is_missed_where_it_is_fixed_and_not_where_it_is_gone():
    frame = hb.tool_ranking(PushWorld.parse("A M0 M1 .\n. . M1 W"), horizon=1)
    assert rows(frame) == {"object:m1": [0, 0, -1]}


def test_losses_are_means_over_the_states():
    puzzle = PushWorld.parse(ROD)
    near = puzzle.step(puzzle.initial, 1)  # h = 1 from there is h = 2 from the start
    both = hb.tool_ranking(puzzle, "m0", horizon=1, states=[puzzle.initial, near, near])
    assert rows(both)["object:m1"] == pytest.approx([2 / 3, 2 / 3, 2 / 3])


def test_the_target_is_the_one_that_is_asked_about():
    puzzle = PushWorld.parse("A M0 M1 . .\n. . . . .\n. M2 . . .")
    frame = hb.tool_ranking(puzzle, "object:m1", horizon=2)
    assert {*frame["object"]} == {"object:m0", "object:m2"}
    (bits,) = hb.empowerment(puzzle, 2, "object:m1", states=[puzzle.initial])
    assert frame["bits"].to_list() == [bits, bits]
    gone = puzzle.without("m0")
    (left,) = hb.empowerment(gone, 2, "object:m1", states=[gone.initial])
    assert rows(frame)["object:m0"][-1] == bits - left
    assert bits - left != 0


@pytest.mark.ill_typed
def test_states_and_targets_that_are_none_are_refused():
    puzzle = PushWorld.parse("A M0 M1 . .")
    for states in (puzzle.initial, [(0.5, 1.5, 2.5)], [3]):
        with pytest.raises(ValueError, match=r"puzzle: (a state|cell) is .*; give a"):
            hb.tool_ranking(puzzle, horizon=1, states=states)  # pyright: ignore[reportArgumentType]
    with pytest.raises(ValueError, match="there is no movable 0; the movables are m0, m1"):
        hb.tool_ranking(puzzle, target=0, horizon=1)  # pyright: ignore[reportArgumentType]
    with pytest.raises(ValueError, match=r"action is 1\.7; give a whole number"):
        puzzle.step(puzzle.initial, 1.7)  # pyright: ignore[reportArgumentType]


def test_no_state_is_explored_that_the_horizon_does_not_reach():
    puzzle = PushWorld.parse("A . . . . . . . M0 . M1 .")
    frame = hb.tool_ranking(puzzle, horizon=3, max_states=4)
    assert rows(frame) == {"object:m1": [0, 0, 0]}
    with pytest.raises(ValueError, match="more than 3 states can be reached within 3 actions"):
        hb.tool_ranking(puzzle, horizon=3, max_states=3)


def test_a_target_without_company_has_no_rows():
    frame = hb.tool_ranking(PushWorld.parse("A M0 ."), horizon=2)
    assert frame.is_empty()
    assert frame.columns == ["object", "bits", "lost_fixed", "lost_removed"]


@settings(deadline=None, max_examples=10)
@given(puzzles(), st.integers(0, 3), st.lists(st.integers(0, 3), max_size=8))
def test_losses_are_those_of_the_plain_model(text, horizon, actions):
    puzzle, slow = PushWorld.parse(text), SlowPuzzle(text)
    assume(len(slow.start) > 2)
    states, slow_states = [puzzle.initial], [slow.start]
    for action in actions:
        states.append(puzzle.step(states[-1], action))
        slow_states.append(slow.step(slow_states[-1], puzzle.actions[action]))

    def bits(state, walls=frozenset()):
        other = SlowPuzzle(text)
        other.walls, other.start = slow.walls | walls, state
        return np.log2(len({other.corner(s, "M0") for s in other.reached(state, horizon)}))

    found = rows(hb.tool_ranking(puzzle, horizon=horizon, states=states))
    free = [bits(state) for state in slow_states]
    for name in [*slow.start][2:]:
        left = [{key: state[key] for key in state if key != name} for state in slow_states]
        removed = [bits(state) for state in left]
        pairs = zip(left, slow_states, strict=True)
        fixed = [bits(state, whole[name]) for state, whole in pairs]
        expected = [np.mean(free), np.mean(free) - np.mean(fixed), np.mean(free) - np.mean(removed)]
        assert found[f"object:{name.lower()}"] == pytest.approx(expected)


@pytest.mark.ill_typed
def test_what_cannot_be_ranked_is_refused():
    puzzle = PushWorld.parse(ROD)
    for arguments, message in [
        ((hb.load_world("corridor"),), "World is not a puzzle; give one that load_pushworld"),
        ((puzzle, "object:m9"), "there is no movable 'object:m9'; the movables are m0, m1, m2, m3"),
    ]:
        with pytest.raises(ValueError, match=r"is no") as refused:
            hb.tool_ranking(*arguments, horizon=1)
        assert message in str(refused.value)
    with pytest.raises(ValueError, match="horizon"):
        hb.tool_ranking(puzzle, horizon=-1)
    with pytest.raises(ValueError, match="states is empty"):
        hb.tool_ranking(puzzle, horizon=1, states=[])
    with pytest.raises(ValueError, match="has 1 cells"):
        hb.tool_ranking(puzzle, horizon=1, states=[(0,)])
