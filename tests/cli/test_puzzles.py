"""Puzzle files where the command line takes a world."""

import json

import pytest

import habilis as hb
from habilis.cli import main

ROD = """\
A  M1 M1 AW M0 M3 .  G0
.  .  .  W  .  .  .  .
M2 .  .  .  .  .  .  .
"""
LEVELS = "; 0\n######\n#@$ .#\n######\n\n; 1\n#######\n#@ $ .#\n#     #\n#######\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "rod.pwp").write_text(ROD)
    (tmp_path / "near.PWP").write_text("A M0 . G0\n. . . .\n")
    (tmp_path / "levels.xsb").write_text(LEVELS)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def printed(capsys, *words, status=0):
    assert main(list(words)) == status
    return capsys.readouterr().out


def test_worlds_draws_a_puzzle(folder, capsys):
    assert printed(capsys, "worlds", "near.PWP") == "A 0 . G0\n. . . . \n"
    found = json.loads(printed(capsys, "worlds", "levels.xsb#1", "--json", "--out", "level.png"))
    assert found == {
        "name": "levels.xsb#1",
        "height": 4,
        "width": 7,
        "objects": ["b0"],
        "goals": 1,
        "map": ["##############", "##A . 0 . G0##", "##. . . . . ##", "##############"],
    }
    assert (folder / "level.png").stat().st_size > 1000


def test_solve_finds_a_shortest_plan(folder, capsys):
    found = "2 steps, return -1\nright, right\n"
    assert printed(capsys, "solve", "near.PWP") == found
    assert printed(capsys, "solve", "levels.xsb") == found
    found = json.loads(printed(capsys, "solve", "levels.xsb#1", "--json"))
    assert found == {"steps": 3, "return": -2.0, "actions": [1, 1, 1]}
    (folder / "no.pwp").write_text("A W M0 G0")
    assert printed(capsys, "solve", "no.pwp", status=1) == "the goal is unreachable\n"


def test_empowerment_is_of_all_states_or_of_the_first(folder, capsys):
    words = "empowerment", "rod.pwp", "--horizon", "3", "--sensor", "object:m0", "--json"
    assert json.loads(printed(capsys, *words))["max"] > 1
    found = json.loads(printed(capsys, *words, "--start", "--max-states", "40", "--out", "b.csv"))
    assert found["states"] == 1
    assert found["mean"] == 1
    assert (folder / "b.csv").read_text().splitlines()[0].startswith("state,agent_row,agent_column")


def test_empowerment_of_the_first_state_of_a_world_is_that_of_its_map(capsys):
    words = "empowerment", "corridor", "--horizon", "2", "--json", "--start"
    found = json.loads(printed(capsys, *words))
    assert found["states"] == 1
    assert found["min"] == found["max"] > 0


def test_landscape_and_futures_take_puzzles(folder, capsys):
    words = "--horizon", "2", "--sensor", "object:m0"
    lines = printed(capsys, "landscape", "rod.pwp", *words, "--object-at", "m2=2,5").splitlines()
    assert lines[0] == " 1.00     .     .     .     .     .  1.58  1.00"
    assert [value == "." for value in lines[2].split()] == [column == 5 for column in range(8)]
    out = printed(capsys, "futures", "rod.pwp", *words, "--out", "futures.png")
    assert out.startswith("1.0000 bits, 2 possible observations\n")
    assert "→→" in out
    assert (folder / "futures.png").exists()
    moved = json.loads(printed(capsys, "futures", "rod.pwp", *words, "--agent-at", "0,7", "--json"))
    assert sorted(moved["observations"]) == [3, 4]


def test_compare_prints_the_tool_ranking(folder, capsys):
    assert printed(capsys, "compare", "rod.pwp", "--horizon", "2") == (
        "2-step object empowerment over m0: 1.0000 bits\n"
        "bits lost when another movable is fixed, and when it is removed\n"
        "              fixed  removed\n"
        "  object:m1  1.0000   1.0000\n"
        "  object:m3  1.0000   0.0000\n"
        "  object:m2  0.0000   0.0000\n"
    )
    words = "compare", "rod.pwp", "--horizon", "1", "--target", "object:m1", "--json"
    found = json.loads(printed(capsys, *words))
    assert found["target"] == "object:m1"
    assert found["horizon"] == 1
    assert {row["object"] for row in found["ranking"]} == {"object:m0", "object:m2", "object:m3"}
    out = printed(capsys, "compare", "levels.xsb", "--horizon", "1")
    assert out == "levels.xsb#0 has no movable other than b0\n"


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("worlds none.pwp", "none.pwp: cannot be read (No such file or directory); give the path"),
        ("worlds levels.xsb#7", "levels.xsb: level is 7; the file has 2, give one from 0 to 1"),
        ("solve rod.pwp --tool broom", "--tool is for worlds, and rod.pwp is a puzzle"),
        ("solve rod.pwp --max-states 3", "raise --max-states if there is memory for it"),
        ("landscape rod.pwp --horizon 1 --object-at 0,5", "specify which of m0, m1, m2, m3"),
        (
            "landscape rod.pwp --horizon 1 --object-at m3=0,4",
            "the m3 and the m0 are both at (0, 4)",
        ),
        ("futures rod.pwp --horizon 1 --agent-at 9,9", "the agent is at (9, 9); put it on the map"),
        ("futures rod.pwp --horizon 1 --tool-at 0,1", "--tool-at is for worlds"),
        ("empowerment rod.pwp --horizon 9 --max-states 9", "give --start for the first alone"),
        ("empowerment rod.pwp --horizon 9 --max-states 9 --start", "give a lower horizon"),
        ("compare rod.pwp", "no horizon; give --horizon"),
        ("compare rod.pwp --horizon 2 --pairs", "--pairs is for worlds"),
        ("compare rod.pwp --horizon 2 --target m9", "there is no movable 'm9'"),
        ("compare rod.pwp --horizon 2 --unit nats", "the tool ranking is exact and in bits"),
        ("compare corridor --horizon 2 --target m1", "--target is for puzzles; leave it out"),
    ],
)
def test_bad_input_is_refused_in_one_line(folder, capsys, command, message):
    before = sorted(folder.iterdir())
    assert main(command.split()) == 2
    out, error = capsys.readouterr()
    assert not out
    assert error.count("\n") == 1
    assert message in error
    assert sorted(folder.iterdir()) == before


def test_empowerment_takes_a_saved_table(tmp_path, capsys):
    path = tmp_path / "ring.npz"
    hb.TabularMDP.deterministic([[(s - 1) % 9, (s + 1) % 9] for s in range(9)]).save(path)
    assert main(["empowerment", str(path), "--horizon", "3", "--sensor", "state", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["mean"] == 2
    assert main(["empowerment", str(path), "--horizon", "3", "--tool", "broom"]) == 2
    assert "--tool is given for a table" in capsys.readouterr().err
