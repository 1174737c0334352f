"""The study of tools in PushWorld: the movables that a solution uses, verdicts, and its page."""

from pathlib import Path

import numpy as np
import polars as pl
import pytest
from polars.testing import assert_frame_equal

import habilis as hb
from habilis.bridges import PushWorld
from habilis.models.limits import TooManyStatesError
from habilis.statistics import bootstrap_interval
from research.tools_in_pushworld import cases, losses, page, pictures, precision, solutions

ROOT = Path(__file__).parents[2]
SHARED = ROOT / "../shared/pushworld"
RESULTS = ROOT / "research/tools_in_pushworld/results"
PAGE = ROOT / "docs/explanation/tools-in-pushworld.md"
LEFT, RIGHT, UP, DOWN = range(4)

ROD = """
A  M1 M1 AW M0 .  G0
.  .  .  W  .  .  .
M2 .  .  .  .  .  .
"""


def table(name):
    return pl.read_csv(RESULTS / f"{name}.csv", infer_schema_length=None)


@pytest.mark.parametrize(
    ("text", "plan", "used"),
    [
        ("A M1 M0 . .", [RIGHT, RIGHT], {"m1": 2}),
        ("A M1 M2 M0 .", [RIGHT], {"m1": 1, "m2": 1}),  # each of a chain
        ("A M1 . M0 .", [RIGHT, RIGHT], {"m1": 1}),  # once they touch
        ("A M1 M0 M2 .", [RIGHT], {"m1": 1}),  # what the target pushes is no tool
        ("A M0 M1 .", [RIGHT], {}),
        ("A M1 M0 W", [RIGHT], {}),  # nothing moves
        ("A M0 .\nA M1 .", [RIGHT], {}),  # moved beside it
        ("A M1 M0 .\nA M0 M0 .", [RIGHT], {}),  # the agent touches the target as well
        ("A M1 .\n. M1 M0\n. .  .", [RIGHT], {}),  # it stops at the edge
        ("A M1 . .\n. M1 M0 .", [RIGHT], {"m1": 1}),
        (". M1 M1 M1 .\n. . M0 M1 A\n. . . . .", [LEFT], {"m1": 1}),
        ("A M1 M1 M1 .\n. M1 M0 M1 .\n. M1 M1 M1 .", [RIGHT], {"m1": 1}),  # each pushes the other
        (". M2 M2 M2 .\n. M2 M0 M2 .\nA M1 M0 . .", [RIGHT], {"m1": 1}),  # M2 by the target alone
    ],
)
def test_a_movable_is_used_where_the_agent_pushes_the_target_through_it(text, plan, used):
    assert dict(solutions.used_movables(PushWorld.parse(text), plan, "m0")) == used


def test_a_plan_is_read_by_its_letters(tmp_path):
    file = tmp_path / "a.yaml"
    file.write_text("planner: human\npuzzle: A Puzzle\nplan: LRUD\n")
    assert solutions.load_plan(file) == [LEFT, RIGHT, UP, DOWN]
    file.write_text("plan: LRX\n")
    with pytest.raises(ValueError, match="there is no line 'plan: '"):
        solutions.load_plan(file)


def test_states_are_evenly_spaced_and_the_solved_one_is_left_out():
    assert losses.chosen_states([(n,) for n in range(13)], 6) == [
        (0,),
        (2,),
        (4,),
        (6,),
        (8,),
        (10,),
    ]
    assert losses.chosen_states([(n,) for n in range(3)], 6) == [(0,), (1,)]


def test_losses_are_those_of_the_tool_ranking():
    text = "A  M1 M1 AW M0 .  G0\n.  .  .  W  .  M3  .\nM2 .  .  .  .  .  G3"
    puzzle = PushWorld.parse(text)
    states = solutions.replayed(puzzle, [RIGHT, LEFT, DOWN, DOWN])
    found = losses.losses(puzzle, ["m0", "m3"], states, 4)
    for target in ("m0", "m3"):
        ours = {f"object:{x.object}": x for x in found if x.target == target}
        ranked = hb.tool_ranking(puzzle, target, horizon=4, states=states)
        assert len(ours) == len(ranked) == 3
        for name, *numbers in ranked.iter_rows():
            its = ours[name]
            assert [its.bits.mean(), its.fixed.mean(), its.removed.mean()] == pytest.approx(numbers)


def test_a_horizon_above_the_budget_is_refused():
    puzzle = PushWorld.parse(ROD)
    with pytest.raises(TooManyStatesError):
        losses.losses(puzzle, ["m0"], [puzzle.initial], 8, budget=50)


def test_a_puzzle_whose_states_are_exhausted_is_feasible_at_any_horizon():
    found = losses.feasible(PushWorld.parse("A M0 . . G0"))
    assert found["horizon"] == losses.LADDER[-1]
    assert (found["states_20"], found["bits_20"]) == (10, 2.0)


def test_a_puzzle_with_too_many_states_is_feasible_up_to_where_they_are_accepted(monkeypatch):
    monkeypatch.setattr(losses, "MOST_STATES", 380)
    found = losses.feasible(PushWorld.parse("\n".join([". " * 9] * 4 + ["A M0 . . . . . . G0"])))
    assert found == {"horizon": 12, "states_20": None, "seconds_20": None, "bits_20": None}


def tables_of(tmp_path, text, plan, horizon=3):
    """The tables of a puzzle that is written to a file."""
    (tmp_path / "rod.pwp").write_text(text)
    (tmp_path / "rod.yaml").write_text(f"plan: {plan}\n")
    rows = cases.cases_of("level1", tmp_path / "rod.pwp", tmp_path / "rod.yaml")
    puzzle = PushWorld.parse(text)
    states = solutions.replayed(puzzle, solutions.load_plan(tmp_path / "rod.yaml"))
    found = [
        {"level": "level1", "puzzle": "rod", "horizon": horizon}
        | {"target": x.target, "object": x.object}
        | {"lost_fixed": x.fixed.mean(), "lost_removed": x.removed.mean()}
        | {"fixed_first": x.fixed[0], "removed_first": x.removed[0]}
        for x in losses.losses(puzzle, ["m0"], losses.chosen_states(states), horizon)
    ]
    return pl.DataFrame(rows), pl.DataFrame(found)


def test_the_verdict_of_a_puzzle_follows_from_its_ranking(tmp_path):
    """M1 is the tool, the largest and the nearest to M0; of two movables one is used."""
    its, lost = tables_of(tmp_path, ROD, "RR")
    row = precision.verdicts(its, lost).row(0, named=True)
    assert [row[rule] for rule in precision.RULES] == [1.0, 1.0, 1.0, 1.0, 0.5, 1.0, 1.0, 1.0]
    assert row["answers_lost_fixed"]
    assert row["answers_lost_removed"]
    swapped = its.with_columns(steps_through=pl.col("steps_through").reverse())
    row = precision.verdicts(swapped, lost).row(0, named=True)
    assert [row[rule] for rule in precision.RULES] == [0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0]


def test_a_ranking_without_any_loss_is_no_answer(tmp_path):
    its, lost = tables_of(tmp_path, "A . . M0 . G0\nM1 . . . . .\n. . . . M2 .", "RRRR", 1)
    used = its.with_columns(steps_through=pl.Series([1, 0]))
    row = precision.verdicts(used, lost).row(0, named=True)
    assert not row["answers_lost_fixed"]
    assert not row["answers_lost_removed"]
    assert row["lost_fixed"] == row["lost_removed"] == row["chance"] == 0.5


@pytest.mark.parametrize(("steps", "goal"), [([0, 0], True), ([1, 2], True), ([0, 1], False)])
def test_targets_without_a_question_do_not_count(tmp_path, steps, goal):
    its, lost = tables_of(tmp_path, ROD, "RR")
    its = its.with_columns(steps_through=pl.Series(steps), goal=pl.lit(goal))
    assert precision.verdicts(its, lost).is_empty()
    assert not cases.asks(its.to_dicts())


def test_distances_are_between_the_nearest_cells(tmp_path):
    its, _ = tables_of(tmp_path, ROD, "RR")
    assert its["distance"].to_list() == [2, 6]
    assert its["distance_along"].to_list() == [1.5, 6.0]  # after a step M1 is nearer by one
    assert its["cells"].to_list() == [2, 1]


def by_hand():
    """Three puzzles, of which the last has two targets."""
    right = [1.0, 0.0, 1.0, 0.0]
    rows = [
        {"level": "level1", "puzzle": name, "target": target, "horizon": 2}
        | dict.fromkeys(precision.RULES, hit)
        | {"chance": 0.25, "nearest": 1.0}
        | {f"answers_{rule}": name != "b" for rule in precision.LOSSES}
        for (name, target), hit in zip(
            [("a", "m0"), ("b", "m0"), ("c", "m0"), ("c", "m1")], right, strict=True
        )
    ]
    return pl.DataFrame(rows)


def test_each_puzzle_counts_once_and_is_what_the_interval_resamples():
    found = precision.precision(by_hand())
    every, answers = found.filter(rule="lost_fixed").iter_rows(named=True)
    assert (every["puzzles"], every["cases"], every["among"]) == (3, 4, "all")
    assert every["precision"] == 0.5
    low, high = bootstrap_interval(np.array([1.0, 0.0, 0.5]))
    assert (every["low"], every["high"]) == pytest.approx((float(low), float(high)), abs=1e-4)
    assert (every["over_chance"], every["over_nearest"]) == (0.25, -0.5)
    assert (answers["puzzles"], answers["cases"], answers["precision"]) == (2, 3, 0.75)


def test_where_no_puzzle_answers_there_is_no_precision():
    none = by_hand().with_columns(answers_lost_fixed=pl.lit(value=False))
    found = precision.precision(none).filter(rule="lost_fixed", among="answers")
    assert found["puzzles"].to_list() == [0]
    assert found["precision"].to_list() == [None]


def test_the_precision_checked_in_follows_from_the_losses_and_cases():
    horizon = pl.col("horizon").is_in([3, 16])
    found = precision.precision(precision.verdicts(table("cases"), table("losses").filter(horizon)))
    wanted = table("precision").filter(horizon)
    assert len(wanted) == 2 * (len(precision.RULES) + len(precision.LOSSES))
    assert_frame_equal(found, wanted.cast(found.schema), abs_tol=1e-4)


def words_of(text):
    return " ".join(text.split())


def test_the_page_has_the_numbers_of_the_tables():
    text = words_of(PAGE.read_text())
    found = page.pieces(*map(table, ("cases", "losses", "precision", "feasible")))
    assert [piece for piece in found if words_of(piece) not in text] == []


def test_the_picture_shows_each_puzzle_and_the_movables_that_are_used(tmp_path):
    its, lost = tables_of(tmp_path, ROD, "RR", pictures.HORIZON)
    figure = pictures.figure_of({"rod": PushWorld.parse(ROD)}, {"rod": "m0"}, its, lost)
    assert [text.get_text() for text in figure.texts] == ["rod: target 0"]
    _, bars = figure.axes
    words = [text.get_text() for text in bars.texts]
    assert "1: used" in words
    assert "2" in words
    assert len(bars.patches) == 4


@pytest.mark.skipif(not SHARED.exists(), reason="PushWorld's puzzles are not here")
@pytest.mark.parametrize("name", ["Pick A Tool", "Hockey Stick"])
def test_the_cases_checked_in_are_those_of_the_puzzles(name):
    files = {
        puzzle.stem: (level, puzzle, plan) for level, puzzle, plan in cases.puzzle_files(SHARED)
    }
    wanted = table("cases").filter(puzzle=name)
    assert_frame_equal(pl.DataFrame(cases.cases_of(*files[name])), wanted, check_dtypes=False)


def test_a_folder_without_puzzles_is_refused(tmp_path):
    with pytest.raises(ValueError, match="there are no puzzles"):
        cases.puzzle_files(tmp_path)
