"""PushWorld: files, rules, and the same numbers as an independent model."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from slow_pushworld import DIRECTIONS, SlowPuzzle, puzzles

import habilis as hb
from habilis.bridges import PushWorld, load_pushworld

SHARED = Path(__file__).parents[2] / "../shared/pushworld"

# The agent pushes a hook around a corner of walls; the hook carries the block with it.
HOOK = """\
.  .  .  .  .  .
A  M1 M1 M1 M0 G0
.  .  .  M1 .  .
.  AW .  .  W  .
"""
ROOM = "\n".join(["A . M0 .", ". . M1 M1", "W . AW G0"])


def ran(puzzle, actions):
    states = [puzzle.initial]
    for action in actions:
        states.append(puzzle.step(states[-1], "lrud".index(action)))
    return states


def test_a_body_pushes_the_bodies_in_its_way_as_one():
    puzzle = PushWorld.parse(HOOK)
    assert puzzle.actions == ("left", "right", "up", "down")
    assert puzzle.initial == (6, 10, 7)
    assert ran(puzzle, "r")[-1] == (7, 11, 8)
    assert puzzle.solved((7, 11, 8))
    assert not puzzle.solved(puzzle.initial)


def test_nothing_moves_where_one_of_them_would_enter_a_wall():
    puzzle = PushWorld.parse(HOOK)
    assert ran(puzzle, "rr")[-1] == (7, 11, 8)  # the block is at the border
    below = ran(puzzle, "urd")  # from above, the hook would come onto no wall: it moves down
    assert below[-1] == (7, 10, 13)
    assert ran(puzzle, "urdd")[-1] == below[-1]  # now its end is at the border


def test_an_agents_wall_stops_the_agent_alone():
    puzzle = PushWorld.parse("M0 A AW .\n. . M1 .\n. . . .")
    assert ran(puzzle, "r")[-1] == puzzle.initial
    around = ran(puzzle, "ddru")  # M1 goes up onto the agent's wall
    assert around[-1] == (6, 0, 2)
    assert ran(puzzle, "ddruu")[-1] == around[-1]


def test_bodies_need_not_be_connected_and_pass_through_each_others_gaps():
    puzzle = PushWorld.parse(". M1 . M1 .\n. . M0 . .\n. . A . .")
    assert ran(puzzle, "u")[-1] == (7, 2, 1)  # M0 is between the parts of M1
    assert ran(puzzle, "urrul")[-1] == (3, 1, 0)  # both parts move, and M0 with them


def test_the_factors_are_the_corners_of_bounding_boxes():
    puzzle = PushWorld.parse(". A .\nA A .\n. . M10\n. M10 M10\nM2 . .")
    assert puzzle.objects == ("m2", "m10")
    mdp = hb.explore(puzzle, horizon=0)
    assert {name: mdp.factor(name).item() for name in mdp.factors} == {
        "agent": 0,
        "object:m2": 12,
        "object:m10": 7,
    }
    assert mdp.shape == (5, 3)
    assert mdp.actions == puzzle.actions


def test_rewards_and_ends_are_those_of_worlds():
    mdp = hb.explore(PushWorld.parse("A M0 . G0 ."))
    solved = mdp.factor("object") == 3  # wherever the agent is
    np.testing.assert_array_equal(mdp.terminal, solved)
    np.testing.assert_array_equal(mdp.reward, np.where(solved[mdp.next_state], 0, -1))
    assert solved.sum() == 3
    plan = hb.solve(mdp)
    assert plan is not None
    assert plan.best_return == -1


def test_a_puzzle_without_goals_is_never_solved():
    assert not hb.explore(PushWorld.parse("A M0 .")).terminal.any()


def test_a_goal_of_each_movable_has_to_be_filled():
    puzzle = PushWorld.parse("A M0+G0 M1 G1")
    assert not puzzle.solved(puzzle.initial)
    assert not puzzle.solved((0, 2, 3))
    assert puzzle.solved((0, 1, 3))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("A M0 .\n. .", "line 2, column 4: the row has 2 cells and the first row has 3"),
        ("A M0\n.  . W", "line 2, column 6: the row has 3 cells and the first row has 2"),
        ("A .\n\nM0 .", "line 2, column 1: the row has 0 cells"),
        ("\n. M0", "line 2, column 1: the puzzle has no agent"),
        ("A M0\n. G3", "line 2, column 3: G3 has no movable; draw M3"),
        ("A M0 G0\n. . G0", "line 1, column 6: G0 has another shape than M0; draw it with the"),
        ("A X", "line 1, column 3: unknown element 'X'"),
        ("A M01", "line 1, column 3: unknown element 'M01'"),
        ("A M0+", "line 1, column 3: unknown element ''"),
        ("A .+M0", "line 1, column 3: unknown element '.'"),
        ("A\tM0+M1", "line 1, column 3: M0 and M1 share a cell"),
        ("A M0+W", "line 1, column 3: W and M0 share a cell"),
        ("a+m0", "line 1, column 1: A and M0 share a cell"),
        ("A+AW M0", "line 1, column 1: AW and A share a cell"),
        ("A G0+G0 M0", "line 1, column 3: G0 and G0 share a cell"),
        (" \n\n", "there are no cells"),
    ],
)
def test_a_text_that_is_no_puzzle_is_refused_with_its_place(text, message):
    with pytest.raises(ValueError, match=r"^puzzle\b") as refused:
        PushWorld.parse(text)
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_file_that_is_none_is_refused(tmp_path):
    (tmp_path / "bytes.pwp").write_bytes(b"A \xff")
    (tmp_path / "ragged.pwp").write_text("A .\n.")
    for name, message in [
        ("bytes.pwp", "not a text file; give one with a PushWorld puzzle"),
        ("none.pwp", "cannot be read (No such file or directory)"),
        ("", "it is not a file"),
    ]:
        with pytest.raises(ValueError, match=r"^/") as refused:
            load_pushworld(tmp_path / name)
        assert message in str(refused.value)
    with pytest.raises(ValueError, match=r"^ragged\.pwp, line 2, column 2: "):
        hb.load_pushworld(str(tmp_path / "ragged.pwp"))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda p: p.step((0, 1), 0), "has 2 cells; give one for each of the 3 bodies"),
        (lambda p: p.step((0, 2, 99), 0), "the m1 is not on the map of 3 x 4 cells"),
        (lambda p: p.step((0, 2, 7), 0), "the m1 is not on the map"),
        (lambda p: p.step(p.initial, 4), "there is no action 4; give one from 0 to 3"),
        (lambda p: p.solved(()), "has 0 cells"),
        (lambda p: p.without("m7"), "there is no movable 'm7'; the movables are m0, m1"),
        (lambda p: p.fixed("agent"), "there is no movable 'agent'"),
        (lambda p: p.at((0, 1, 1)), "the m1 and the m0 are both at (0, 1)"),
        (lambda p: p.at((8, 1, 2)), "the agent and a wall are both at (2, 0)"),
        (lambda p: p.at((10, 1, 2)), "the agent and a wall of its own are both at (2, 2)"),
        (lambda p: p.step_many(np.array([[0, 2, 12]]), np.array([0])), "there is no cell 12"),
        (lambda p: p.step_many(np.array([[0, 2]]), np.array([0])), "shape (1, 2); give [n, 3]"),
    ],
)
def test_what_a_puzzle_does_not_have_is_refused(call, message):
    with pytest.raises(ValueError, match=r"^puzzle: ") as refused:
        call(PushWorld.parse(ROOM))
    assert message in str(refused.value)


def test_a_movable_can_be_removed_or_fixed():
    puzzle = PushWorld.parse("A M1 M0 . G0\n. . . . .")
    away = puzzle.without("object:m1")
    assert away.objects == ("m0",)
    assert away.initial == (0, 2)
    assert away.goals == puzzle.goals
    fixed = puzzle.fixed("m1", (5, 2, 7))
    assert fixed.initial == (5, 2)
    assert fixed.walls == {(1, 2)}
    assert ran(fixed, "rr")[-1] == (6, 2)
    assert puzzle.without("m0").goals == ()


@settings(deadline=None, max_examples=60)
@given(puzzles(), st.lists(st.sampled_from([*DIRECTIONS]), max_size=25))
def test_transitions_are_those_of_the_plain_model(text, actions):
    puzzle, slow = PushWorld.parse(text), SlowPuzzle(text)
    state, slow_state = puzzle.initial, slow.start
    for action in actions:
        state = puzzle.step(state, puzzle.actions.index(action))
        slow_state = slow.step(slow_state, action)
        assert [divmod(label, puzzle.shape[1]) for label in state] == slow.corners(slow_state)
        assert puzzle.solved(state) == slow.solved(slow_state)


@settings(deadline=None, max_examples=15)
@given(puzzles(), st.integers(0, 6))
def test_object_empowerment_is_that_of_the_plain_model(text, horizon):
    puzzle, slow = PushWorld.parse(text), SlowPuzzle(text)
    mdp = hb.explore(puzzle, horizon=horizon)
    reached = slow.reached(slow.start, horizon)
    for factor, name in zip(mdp.factors, slow.start, strict=True):
        bits = hb.empowerment(mdp, horizon, factor, states=[0])
        assert bits == np.log2(len({slow.corner(state, name) for state in reached}))


@pytest.mark.skipif(not SHARED.is_dir(), reason="the puzzles of PushWorld are not here")
@pytest.mark.parametrize(("level", "count"), [("level1", 68), ("level2", 74)])
def test_every_reference_solution_solves_its_puzzle_and_not_before_its_end(level, count):
    files = sorted((SHARED / "puzzles" / level).glob("*.pwp"))
    for file in files:
        solution = SHARED / "solutions" / level / f"{file.stem}.yaml"
        plan = solution.read_text().partition("plan: ")[2].strip().lower()
        puzzle = load_pushworld(file)
        states = [np.array([puzzle.initial])]
        for action in plan:
            states.append(puzzle.step_many(states[-1], np.array(["lrud".index(action)])))
        solved = puzzle.terminal_many(np.concatenate(states))
        assert solved[-1], file
        assert not solved[:-1].any(), file
    assert len(files) == count
