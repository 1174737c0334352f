"""The command line on maps with two agents and tables of several players."""

import json
from pathlib import Path

import pytest

import habilis as hb
from habilis.cli import main

HALL = "E = agent\nD = door\nA..D.E\n"


@pytest.fixture
def hall(tmp_path: Path) -> str:
    path = tmp_path / "hall.txt"
    path.write_text(HALL)
    return str(path)


def answer(capsys: pytest.CaptureFixture, *arguments: str) -> dict:
    assert main([*arguments, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def refused(capsys: pytest.CaptureFixture, *arguments: str) -> str:
    assert main(arguments) == 2
    reported = capsys.readouterr()
    assert reported.out == ""
    assert reported.err.count("\n") == 1
    return reported.err


def test_empowerment_is_of_the_player_that_is_named(capsys, hall):
    mdp = hb.tabulate(hb.World.parse(HALL))
    asked = "empowerment", hall, "--horizon", "2", "--sensor", "agent", "--player", "agent"
    for others in ("uniform", "best", "worst"):
        found = answer(capsys, *asked, "--others", others)
        values = hb.empowerment(mdp, 2, "agent", player="agent", others=others)
        assert found["mean"] == pytest.approx(values.mean(), abs=1e-9)
        assert (found["player"], found["others"]) == ("agent", others)
    assert answer(capsys, *asked)["others"] == "uniform"
    assert main([*asked, "--others", "worst"]) == 0
    assert "of 'agent', the others at their worst for it, through" in capsys.readouterr().out


def test_a_saved_table_of_several_players_has_them_too(capsys, tmp_path):
    mdp = hb.TabularMDP.deterministic([[0, 1, 1, 0]] * 2, players={"robot": 2, "human": 2})
    mdp.save(tmp_path / "xor.npz")
    asked = "empowerment", str(tmp_path / "xor.npz"), "--horizon", "1", "--sensor", "state"
    assert answer(capsys, *asked, "--player", "robot", "--others", "worst")["mean"] == 1
    assert answer(capsys, *asked, "--player", "robot")["mean"] == pytest.approx(0, abs=1e-6)
    assert answer(capsys, *asked)["mean"] == 1


def test_a_map_with_two_agents_is_drawn(capsys, hall):
    reported = answer(capsys, "worlds", hall)
    assert reported["header"] == ["E = agent", "D = door"]
    assert reported["map"] == ["A..D.E"]


def test_a_landscape_is_of_the_player_that_is_named(capsys, hall):
    asked = "landscape", hall, "--horizon", "2", "--sensor", "agent2", "--player", "agent2"
    found = answer(capsys, *asked, "--others", "worst")["values"]
    values = hb.landscape(hb.World.parse(HALL), 2, "agent2", player="agent2", others="worst").values
    assert found == [[None if value != value else value for value in values[0]]]


def test_what_is_for_one_agent_refuses_two_in_one_line(capsys, hall, tmp_path):
    for verb in ("compare", "futures"):
        assert "two agents, and this is for one" in refused(capsys, verb, hall, "--horizon", "2")
    out = str(tmp_path / "run")
    assert "two agents, and this is for one" in refused(capsys, "train", hall, "--out", out)
    assert not (tmp_path / "run").exists()
    asked = "empowerment", hall, "--horizon", "1", "--sensor", "agent", "--others", "best"
    assert "name the player whose empowerment it is (agent, agent2)" in refused(capsys, *asked)
    asked = "empowerment", "corridor", "--horizon", "1", "--sensor", "agent", "--player", "agent"
    assert "the table has no players" in refused(capsys, *asked)
