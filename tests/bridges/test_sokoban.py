"""Sokoban: files of levels, and the rules that differ from PushWorld's."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from slow_pushworld import DIRECTIONS, SlowPuzzle

import habilis as hb
from habilis.bridges.puzzles.sokoban import parsed_level

TWO = """\
; 0
######
#@$ .#
######

; 1
 #####
 #+$*#
 # $ #
###### again
"""


def ran(level, actions):
    states = [level.initial]
    for action in actions:
        states.append(level.step(states[-1], "lrud".index(action)))
    return states


def loaded(tmp_path, text, level=0):
    (tmp_path / "levels.xsb").write_text(text)
    return hb.load_sokoban(tmp_path / "levels.xsb", level)


def test_a_level_is_one_of_those_in_a_file(tmp_path):
    text = TWO.replace(" again", "")
    first, second = loaded(tmp_path, text), loaded(tmp_path, text, 1)
    assert first.name == "levels.xsb#0"
    assert first.shape == (3, 6)
    assert first.objects == ("b0",)
    assert first.initial == (7, 8)
    assert second.objects == ("b0", "b1", "b2")
    assert second.initial == (8, 9, 10, 15)
    assert [goal.corner for goal in second.goals] == [(1, 2), (1, 4)]
    assert (1, 5) in second.walls
    assert (0, 0) not in second.walls


def test_titles_and_empty_lines_separate_levels_too():
    text = "Level 1\nAuthor: nobody\n#@$.#\n\n\n'second'\n#@ $.#\n"
    assert parsed_level(text).shape == (1, 5)
    assert parsed_level(text, 1).shape == (1, 6)


def test_rows_may_be_run_length_encoded():
    drawn = parsed_level("#####\n#@$.#\n##\n")
    for text in ("5#|#@$.#|2#", "5#\n#@$.#|##|\n", "5#|#@$.#|##"):
        encoded = parsed_level(text)
        assert encoded.walls == drawn.walls
        assert encoded.initial == drawn.initial
        assert encoded.shape == drawn.shape
    assert parsed_level("#@3-$.#").initial == (1, 5)


def test_one_box_at_a_time_is_pushed():
    level = parsed_level("#@$ $ .#")
    assert ran(level, "rr") == [(1, 2, 4), (2, 3, 4), (2, 3, 4)]


def test_a_level_is_solved_when_every_goal_holds_some_box():
    level = parsed_level("#@$ $..#")
    assert not level.solved((1, 2, 5))
    assert level.solved((1, 6, 5))
    assert level.solved((1, 5, 6))
    mdp = hb.explore(parsed_level("#@$ . $.#"))
    assert hb.solve(mdp) is None  # the second box cannot be reached but through the first
    plan = hb.solve(hb.explore(parsed_level("#@ $ .#\n#     #")))
    assert plan is not None
    assert [level.actions[action] for action in plan.actions] == ["right", "right", "right"]
    assert plan.best_return == -2


def test_a_box_has_its_own_factor():
    mdp = hb.explore(parsed_level("#@$ $ #"))
    assert {*mdp.factors} == {"agent", "object:b0", "object:b1"}
    assert hb.empowerment(mdp, 3, "object:b0", states=[0]) == 1  # pushed once, or not
    assert hb.empowerment(mdp, 3, "object:b1", states=[0]) == 0


def test_the_ranking_takes_levels():
    frame = hb.tool_ranking(parsed_level("#@$ $ #"), "object:b0", horizon=3)
    assert frame.rows() == [("object:b1", 1.0, 0.0, -1.0)]


@pytest.mark.parametrize(
    ("text", "level", "message"),
    [
        ("#$.#", 0, "line 1, column 1: the level has no agent"),
        ("#@.$#\n#  @#", 0, "line 2, column 4: a second agent"),
        ("\n\n#@.#", 0, "line 3, column 1: the level has 0 boxes for 1 goals"),
        ("#@x #", 0, "line 1, column 3: unknown character 'x'"),
        ("3#|#@?|3#", 0, "line 1, column 6: unknown character '?'"),
        ("#@#3", 0, "line 1, column 4: unknown character '3'"),
        ("#@3|#", 0, "line 1, column 4: unknown character '|'"),
        ("; nothing\n", 0, "there is no level"),
        (TWO, 2, "level is 2; the file has 2, give one from 0 to 1"),
        (TWO, -1, "level is -1"),
        (TWO, 1, "line 10, column 8: unknown character 'a'"),
    ],
)
def test_what_is_no_level_is_refused_with_its_place(text, level, message):
    with pytest.raises(ValueError, match=r"^levels\b") as refused:
        parsed_level(text, level)
    assert message in str(refused.value)


@st.composite
def levels(draw):
    """A level, and the same as a text of PushWorld."""
    height, width = draw(st.integers(1, 4)), draw(st.integers(3, 5))
    drawn = st.lists(st.sampled_from("   #$"), min_size=width, max_size=width)
    grid = draw(st.lists(drawn, min_size=height, max_size=height))
    grid[draw(st.integers(0, height - 1))][draw(st.integers(0, width - 1))] = "@"
    number = iter(range(height * width))
    elements = [[{" ": ".", "#": "W", "@": "A", "$": "M"}[c] for c in row] for row in grid]
    same = [[c + str(next(number)) if c == "M" else c for c in row] for row in elements]
    level = "\n".join("".join(row).replace(" ", "-") for row in grid)
    return level, "\n".join(" ".join(row) for row in same)


@settings(deadline=None, max_examples=40)
@given(levels(), st.lists(st.sampled_from([*DIRECTIONS]), max_size=20))
def test_transitions_are_those_of_the_plain_model_with_one_push(texts, actions):
    level, slow = parsed_level(texts[0]), SlowPuzzle(texts[1], most_pushed=1)
    state, slow_state = level.initial, slow.start
    for action in actions:
        state = level.step(state, level.actions.index(action))
        slow_state = slow.step(slow_state, action)
        assert [divmod(label, level.shape[1]) for label in state] == slow.corners(slow_state)


def test_a_file_that_cannot_be_read_is_refused(tmp_path: Path):
    with pytest.raises(ValueError, match="give the path of a file with Sokoban levels"):
        hb.load_sokoban(tmp_path / "none.xsb")
