"""The command line on maps of several tools and objects."""

import json
from pathlib import Path

import polars as pl
import pytest

from habilis.cli import main

ABOVE = "R = rake\nD = ball\nG = goal of C\nH = goal of D\n"
MAP = ABOVE + "A....\n.PCR.\n.D#.H\n....G\n"


@pytest.fixture
def room(tmp_path: Path) -> str:
    path = tmp_path / "room.txt"
    path.write_text(MAP)
    return str(path)


def answer(capsys: pytest.CaptureFixture, *arguments: str, status: int = 0) -> dict:
    assert main([*arguments, "--json"]) == status
    return json.loads(capsys.readouterr().out)


def refused(capsys: pytest.CaptureFixture, *arguments: str) -> str:
    assert main(arguments) == 2
    reported = capsys.readouterr()
    assert reported.out == ""
    assert reported.err.startswith("habilis: ")
    assert reported.err.count("\n") == 1
    return reported.err


def test_a_map_is_drawn_with_what_its_characters_stand_for(capsys, room, tmp_path):
    reported = answer(capsys, "worlds", room, "--out", str(tmp_path / "room.png"))
    assert reported["tools"] == ["picker", "rake"]
    assert reported["objects"] == ["can", "ball"]
    assert "R = rake" in reported["header"]
    assert (tmp_path / "room.png").stat().st_size > 1000
    assert main(["worlds", room]) == 0
    assert "R = rake\n" in capsys.readouterr().out


def test_a_plan_brings_every_object_to_its_goal(capsys, tmp_path):
    path = tmp_path / "line.txt"
    path.write_text("D = can\nG = goal of C\nH = goal of D\nAC.DG\n....H\n.....\n")
    assert answer(capsys, "solve", str(path), status=1)["steps"] is None
    path.write_text("D = can\nG = goal of C\nH = goal of D\nAC.G..\n..D...\n..H...\n")
    plan = answer(capsys, "solve", str(path))
    assert plan["return"] == 1 - plan["steps"]


def test_a_plan_may_put_a_tool_down(capsys, tmp_path):
    path = tmp_path / "down.txt"
    path.write_text("drop: true\n#APC.G\n")
    plan = answer(capsys, "solve", str(path))
    assert set(plan["actions"]) <= set(range(9))


def test_a_plan_with_a_tool_that_may_fail_is_refused(capsys, tmp_path):
    path = tmp_path / "slips.txt"
    path.write_text("P = picker slip 0.2\nAPC.G\n")
    assert "slips.txt: the tool 'picker' has slip 0.2" in refused(capsys, "solve", str(path))


def test_empowerment_over_one_of_several_objects(capsys, room, tmp_path):
    out = tmp_path / "bits.csv"
    arguments = ["empowerment", room, "--sensor", "object:can", "--horizon", "2"]
    reported = answer(capsys, *arguments, "--out", str(out))
    table = pl.read_csv(out)
    assert len(table) == reported["states"]
    assert {"object:can_row", "tool:rake_column", "held", "equipped"} <= set(table.columns)
    assert set(table["held"]) == {-1, 0}


def test_one_of_several_objects_has_to_be_named(capsys, room):
    reported = refused(capsys, "empowerment", room, "--sensor", "object", "--horizon", "2")
    assert "object:can, object:ball" in reported


def test_the_only_object_needs_no_name(capsys, tmp_path):
    path = tmp_path / "one.txt"
    path.write_text("R = rake\nA....\n.PCR.\n....G\n")
    arguments = ["empowerment", str(path), "--horizon", "2", "--sensor"]
    assert answer(capsys, *arguments, "object") == answer(capsys, *arguments, "object:can")


def test_a_landscape_with_a_tool_elsewhere(capsys, room, tmp_path):
    arguments = ["landscape", room, "--sensor", "object:can", "--horizon", "2"]
    here = answer(capsys, *arguments, "--out", str(tmp_path / "land.png"))["values"]
    there = answer(capsys, *arguments, "--tool-at", "rake=0,3", "--object-at", "ball=3,0")["values"]
    assert here[1][3] is None
    assert here[0][3] is not None
    assert there[0][3] is None
    assert there[1][3] is not None
    assert there[3][0] is None
    assert there[2][1] is not None


@pytest.mark.parametrize("verb", ["landscape", "futures"])
def test_one_of_several_has_to_be_specified(verb, capsys, room):
    arguments = [verb, room, "--horizon", "1", "--sensor", "object:can"]
    reported = refused(capsys, *arguments, "--tool-at", "0,1")
    assert "several tools, picker, rake" in reported
    assert "picker=0,1" in reported
    assert "name one of can, ball" in refused(capsys, *arguments, "--object-at", "tin=0,1")
    reported = refused(capsys, *arguments, "--tool-at", "rake=0,1", "--tool-at", "rake=0,2")
    assert "'rake'" not in reported
    assert "rake twice" in reported
    assert "is not a cell" in refused(capsys, *arguments, "--tool-at", "rake=north")
    assert "free cell" in refused(capsys, *arguments, "--tool-at", "rake=2,2")


def test_futures_of_one_of_several_objects(capsys, room, tmp_path):
    out = tmp_path / "futures.svg"
    arguments = ["futures", room, "--horizon", "2", "--sensor", "object:ball"]
    reported = answer(capsys, *arguments, "--agent-at", "3,1", "--out", str(out))
    assert set(reported["observations"]) == {11}
    assert "<svg" in out.read_text()
    reported = refused(capsys, *arguments[:-1], "held", "--out", str(out))
    assert "a picture needs cells" in reported
