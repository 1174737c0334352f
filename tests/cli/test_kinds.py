"""`habilis empowerment --kind`: the library's values, with their gaps."""

import json

import gymnasium
import pytest

import habilis as hb
from habilis.cli import main

LAKE = hb.TabularMDP.from_gymnasium(gymnasium.make("FrozenLake-v1", is_slippery=False))
TWO = "E = agent\n##.##\nE..A.\n"


def said(capsys, *words):
    assert main([*map(str, words), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize(
    ("kind", "expected"),
    [
        (["closed-loop"], hb.closed_loop_empowerment(LAKE, 2, "agent")),
        (["goal-directed", "--slack", 1], hb.goal_directed_empowerment(LAKE, 2, None, 1, "agent")),
        (["effective", "--discount", 0.5], hb.effective_empowerment(LAKE, "uniform", 0.5, "agent")),
    ],
)
def test_a_kind_has_the_values_of_its_function(capsys, tmp_path, kind, expected):
    table = tmp_path / "lake.npz"
    LAKE.save(table)
    words = "empowerment", table, "--horizon", 2, "--sensor", "agent", "--kind", *kind
    found = said(capsys, *words)
    assert found["kind"] == kind[0]
    assert found["mean"] == pytest.approx(expected.mean(), abs=1e-6)
    assert found["max"] == pytest.approx(expected.max(), abs=1e-6)
    assert found["gap"] <= 1e-6


@pytest.mark.parametrize("verb", ["empowerment", "landscape"])
def test_effective_empowerment_needs_no_horizon(capsys, tmp_path, verb):
    path = tmp_path / "two.txt"
    path.write_text("A.C\n..G\n")
    kind = verb, path, "--kind", "effective", "--discount", 0.5, "--sensor", "object"
    assert said(capsys, *kind) == said(capsys, *kind, "--horizon", 2)


@pytest.mark.parametrize("verb", ["empowerment", "landscape"])
def test_another_kind_without_a_horizon_is_refused(capsys, verb):
    assert main([verb, "yard", "--kind", "closed-loop"]) == 2
    message = "habilis: --horizon is missing; give a number of actions, as --horizon 3"
    assert message in capsys.readouterr().err


def test_goal_directed_empowerment_of_a_puzzle_sees_a_goal_beyond_the_horizon(capsys, tmp_path):
    path = tmp_path / "far.xsb"
    path.write_text("#########\n#@$    .#\n#########\n")
    words = "empowerment", path, "--sensor", "object", "--kind", "goal-directed", "--horizon", 1
    near = said(capsys, *words, "--slack", 2, "--start")
    mdp = hb.explore(hb.load_sokoban(path))
    expected = hb.goal_directed_empowerment(mdp, 1, None, 2, "object", [mdp.start])
    assert near["mean"] == expected[0]


def test_a_player_has_a_kind_against_a_policy_of_the_others(capsys, tmp_path):
    path = tmp_path / "two.txt"
    path.write_text(TWO)
    words = "empowerment", path, "--horizon", 1, "--player", "agent", "--kind", "effective"
    found = said(capsys, *words, "--discount", 0.5, "--sensor", "agent")
    one = hb.tabulate(hb.load_world(path)).of_player("agent")
    expected = hb.effective_empowerment(one, "uniform", 0.5, "agent")
    assert found["mean"] == pytest.approx(expected.mean(), abs=1e-6)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--kind", "effective"], "--discount is None and kind 'effective'; give --discount"),
        (["--slack", "1"], "--slack is 1 and kind 'open-loop', which has none; leave it out"),
        (
            ["--kind", "closed-loop", "--player", "agent", "--others", "worst"],
            "--others worst goes with --kind open-loop; leave one of them out",
        ),
        (
            ["--kind", "closed-loop", "--others", "uniform"],
            "--others is given without --player; name the player",
        ),
    ],
)
def test_what_does_not_go_together_is_refused_in_a_line(capsys, tmp_path, words, message):
    path = tmp_path / "two.txt"
    path.write_text(TWO)
    with pytest.raises(SystemExit) as stopped:
        raise SystemExit(main(["empowerment", str(path), "--horizon", "2", *words]))
    assert stopped.value.code == 2
    assert message in capsys.readouterr().err
