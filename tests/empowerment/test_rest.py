"""The sensor "rest": all factors but the agent's, as one."""

import itertools
import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import habilis as hb
from habilis.analysis import average_empowerment, futures
from habilis.cli import main
from habilis.empowerment.sensors import observations

MAP = "#####\n#APC#\n#..G#\n#####"
SEVERAL = "P = picker\nB = broom\nC = can\nD = ball\nG = goal of C\n######\n#APC.#\n#.BDG#\n######"


def with_factors(mdp, **factors):
    return replace(mdp, factors={k: np.array(v, np.int32) for k, v in factors.items()})


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10_000), st.integers(1, 3), st.integers(1, 3))
def test_it_counts_the_combinations_of_the_other_factors(seed, others, horizon):
    rng = np.random.default_rng(seed)
    table = rng.integers(6, size=(6, 2))
    labels = {f"thing{i}": rng.integers(-1, 2, size=6) for i in range(others)}
    mdp = hb.TabularMDP.deterministic(table)
    mdp = with_factors(mdp, agent=rng.integers(6, size=6), **labels)
    bits = hb.empowerment(mdp, horizon, "rest")
    for start in range(6):
        seen = set()
        for sequence in itertools.product(range(2), repeat=horizon):
            state = start
            for action in sequence:
                state = table[state, action]
            seen.add(tuple(int(one[state]) for one in labels.values()))
        assert bits[start] == pytest.approx(np.log2(len(seen)))


def test_in_a_world_it_is_the_joint_sensor_of_tool_and_object():
    mdp = hb.tabulate(hb.World.parse(MAP))
    together = np.unique(
        np.stack([mdp.factor("tool"), mdp.factor("object")]), axis=1, return_inverse=True
    )[1]
    np.testing.assert_array_equal(observations(mdp, "rest")[0], together)
    np.testing.assert_array_equal(
        hb.empowerment(mdp, 2, "rest"), hb.empowerment(mdp, 2, together.ravel())
    )


def test_several_tools_and_objects_and_what_is_held_belong_to_it():
    mdp = hb.tabulate(hb.World.parse(SEVERAL))
    others = [labels for name, labels in mdp.factors.items() if name != "agent"]
    assert len(others) == 5
    assert observations(mdp, "rest")[1] == len(np.unique(np.stack(others), axis=1).T)


def test_without_anything_but_an_object_it_is_the_object():
    mdp = hb.tabulate(hb.World.parse(MAP).with_tool("none"))
    np.testing.assert_array_equal(hb.empowerment(mdp, 2, "rest"), hb.empowerment(mdp, 2, "object"))


def test_every_measure_with_a_sensor_has_it():
    world = hb.World.parse(MAP)
    mdp = hb.tabulate(world)
    labels = observations(mdp, "rest")[0]
    for measure in (
        lambda sensor: hb.persistence(mdp, sensor),
        lambda sensor: hb.effective_empowerment(mdp, "uniform", 0.5, sensor, [mdp.start]),
        lambda sensor: hb.goal_directed_empowerment(mdp, 2, sensor=sensor),
        lambda sensor: hb.empowerment(mdp.slippery(0.2), 1, sensor, states=[mdp.start]),
    ):
        np.testing.assert_array_equal(measure("rest"), measure(labels))
    found = hb.landscape(world, 2, "rest")
    assert found.values[1, 1] == hb.empowerment(mdp, 2, "rest", states=[mdp.start])[0]
    assert average_empowerment(mdp, 2, "rest") > average_empowerment(mdp, 2, "object")
    both = hb.empowerment(mdp, 2, "rest") + hb.empowerment(mdp, 2, "agent")
    np.testing.assert_allclose(hb.empowerment(mdp, 2, "rest + agent"), both)


def test_futures_are_numbered_combinations():
    mdp = hb.tabulate(hb.World.parse(MAP))
    found = futures(mdp, mdp.start, 1, "rest")
    assert found.observations.max() < observations(mdp, "rest")[1]
    assert 2**found.empowerment == pytest.approx(len(found.observations))


def test_a_factor_of_that_name_is_meant_by_it():
    mdp = hb.TabularMDP.deterministic([[0, 1], [0, 1]])
    mdp = with_factors(mdp, agent=[0, 1], rest=[0, 0])
    assert hb.empowerment(mdp, 1, "rest").tolist() == [0, 0]


def test_the_command_line_and_training_have_it(tmp_path, capsys):
    path = tmp_path / "map.txt"
    path.write_text(MAP)
    assert main(["landscape", str(path), "--horizon", "2", "--sensor", "rest", "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)["values"]
    expected = hb.landscape(hb.World.parse(MAP), 2, "rest").values
    np.testing.assert_allclose(np.array(shown, float), expected)
    assert main(["futures", str(path), "--horizon", "1", "--sensor", "rest", "--json"]) == 0
    capsys.readouterr()
    picture = ["--out", str(tmp_path / "f.png")]
    assert main(["futures", str(path), "--horizon", "1", "--sensor", "rest", *picture]) == 2
    assert "a picture needs cells; use --sensor agent, tool, object" in capsys.readouterr().err
    from habilis.learning.intrinsic import check_sensors

    check_sensors(hb.tabulate(hb.World.parse(MAP)), "effective:rest")


@pytest.mark.parametrize(
    ("factors", "message"),
    [
        ({}, "the agent's factor 'agent' is unknown; this MDP has: none"),
        ({"taxi": [0, 1]}, "the agent's factor 'agent' is unknown; this MDP has: taxi"),
        ({"agent": [0, 1]}, "there is no rest, as the only factors are agent; use 'state'"),
    ],
)
@pytest.mark.parametrize("sensor", ["rest", "rest + state"])
def test_it_is_refused_where_there_is_no_agent_or_nothing_else(factors, message, sensor):
    mdp = with_factors(hb.TabularMDP.deterministic([[0, 1], [0, 1]]), **factors)
    with pytest.raises(ValueError, match=message):
        hb.empowerment(mdp, 1, sensor)


@pytest.mark.parametrize("player", ["agent", "agent2"])
def test_a_players_rest_is_all_but_itself(player):
    mdp = hb.tabulate(hb.World.parse("E = agent\n####\nA.C.\n..E.\n####"))
    others = [labels for name, labels in mdp.factors.items() if name != player]
    together = np.unique(np.stack(others), axis=1, return_inverse=True)[1].ravel()
    some = {"states": [0, mdp.start, mdp.states - 1], "player": player}
    for what in ("uniform", "best", "worst"):
        np.testing.assert_allclose(
            hb.empowerment(mdp, 2, "rest", **some, others=what),
            hb.empowerment(mdp, 2, together, **some, others=what),
            atol=2e-6,
        )
    alone = mdp.of_player(player)
    assert alone.players == {player: 5}
    np.testing.assert_array_equal(observations(alone, "rest")[0], together)
