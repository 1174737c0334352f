"""Empowerment of one of several players: beside lists of all sequences of all players."""

import re
import runpy
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from joint import against, ends, others_of, random_joint

import habilis as hb

ROOT = Path(__file__).parents[2]
XOR = hb.TabularMDP.deterministic([[0, 1, 1, 0]] * 2, players={"a": 2, "b": 2})


def random_sensor(rng: np.random.Generator, states: int) -> np.ndarray:
    """Labels, or probabilities of three observations."""
    if rng.random() < 0.5:
        return rng.integers(3, size=states)
    return rng.dirichlet(np.ones(3), states)


def as_rows(sensor: np.ndarray) -> np.ndarray:
    return np.eye(int(sensor.max()) + 1)[sensor] if sensor.ndim == 1 else sensor


def bits_of(rows: list[np.ndarray]) -> float:
    return hb.capacity(np.array(rows), tolerance=1e-9).bits


def by_sequence_of_others(mdp, place: int, start: int, horizon: int, sensor) -> dict:
    """The capacity against each sequence of the others, from a list of all sequences of all."""
    sizes = list(mdp.players.values())
    own = list(product(range(sizes[place]), repeat=horizon))
    theirs = product(range(len(others_of(sizes, place))), repeat=horizon)
    seen = as_rows(sensor)
    return {b: bits_of([against(mdp, place, start, a, b) @ seen for a in own]) for b in theirs}


# Policies of the others


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 10_000), st.booleans(), st.integers(0, 2))
def test_it_is_the_capacity_over_all_paths_of_the_others(seed: int, noisy: bool, horizon: int):
    rng = np.random.default_rng(seed)
    mdp = random_joint(rng, noisy)
    sensor, start = random_sensor(rng, mdp.states), int(rng.integers(mdp.states))
    sizes = list(mdp.players.values())
    for place, name in enumerate(mdp.players):
        policy = rng.dirichlet(np.ones(len(others_of(sizes, place))), mdp.states)
        rows = [
            ends(mdp, place, start, a, policy) @ as_rows(sensor)
            for a in product(range(sizes[place]), repeat=horizon)
        ]
        found, gap = hb.empowerment(
            *(mdp, horizon, sensor),
            states=[start],
            player=name,
            others=policy,
            return_gap=True,
        )
        assert found[0] == pytest.approx(bits_of(rows), abs=2e-6)
        assert gap[0] <= 1e-6


def test_without_a_player_the_joint_actions_are_the_inputs():
    assert hb.empowerment(XOR, 1).tolist() == [1, 1]
    assert hb.empowerment(XOR, 1, player="a").tolist() == pytest.approx([0, 0], abs=1e-6)
    one = hb.TabularMDP.deterministic(XOR.next_state)
    assert (hb.empowerment(XOR, 2) == hb.empowerment(one, 2)).all()


def test_uniform_is_the_default():
    mdp = random_joint(np.random.default_rng(1), stochastic=True, sizes=(2, 3))
    policy = np.full((mdp.states, 3), 1 / 3)
    wanted = hb.empowerment(mdp, 2, player="a", others=policy)
    for others in (None, "uniform", {}, {"b": "uniform"}):
        np.testing.assert_allclose(
            hb.empowerment(mdp, 2, player="a", others=others), wanted, atol=1e-6
        )


def test_actions_costs_and_sensors_by_action_are_the_players():
    rng = np.random.default_rng(2)
    mdp = random_joint(rng, stochastic=True, sizes=(3, 2))
    alone = mdp.of_player("a")
    sensor, cost = rng.dirichlet(np.ones(2), (3, mdp.states)), rng.random((mdp.states, 3))
    given: list[dict[str, Any]] = [
        {"actions": [0, 2]},
        {"sensor": sensor},
        {"cost": cost, "budget": 2.0},
        {"sensor_at": "each step"},
        {"states": np.full((1, mdp.states), 1 / mdp.states)},
        {"method": hb.Sampled(20)},
    ]
    for settings_ in given:
        found = hb.empowerment(mdp, 2, player="a", **settings_)
        assert found.tolist() == hb.empowerment(alone, 2, **settings_).tolist()


# The best and the worst that the others do


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10_000), st.booleans(), st.integers(0, 2))
def test_best_and_worst_are_those_of_a_list_of_all_sequences(seed: int, noisy: bool, horizon: int):
    rng = np.random.default_rng(seed)
    mdp = random_joint(rng, noisy)
    sensor = random_sensor(rng, mdp.states)
    for place, name in enumerate(mdp.players):
        each = [
            by_sequence_of_others(mdp, place, start, horizon, sensor).values()
            for start in range(mdp.states)
        ]
        for others, pick in (("best", max), ("worst", min)):
            found, gap = hb.empowerment(
                mdp, horizon, sensor, player=name, others=others, return_gap=True
            )
            np.testing.assert_allclose(found, [pick(one) for one in each], atol=2e-6)
            assert gap.max() <= 1e-6


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 10_000), st.integers(0, 4))
def test_without_noise_best_and_worst_are_counts(seed: int, horizon: int):
    rng = np.random.default_rng(seed)
    mdp = random_joint(rng, stochastic=False, sizes=(2, 2))
    labels, table = rng.integers(3, size=mdp.states), mdp.next_state.reshape(-1, 2, 2)
    for start in range(mdp.states):
        counts = []
        for theirs in product(range(2), repeat=horizon):
            reached = {start}
            for b in theirs:
                reached = {int(table[s, a, b]) for s in reached for a in range(2)}
            counts.append(len({int(labels[s]) for s in reached}))
        for others, pick in (("best", max), ("worst", min)):
            found = hb.empowerment(mdp, horizon, labels, states=[start], player="a", others=others)
            assert found[0] == np.log2(pick(counts))


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 10_000), st.booleans(), st.integers(1, 3))
def test_what_does_not_look_is_at_most_the_best_and_the_best_at_most_one_mind(
    seed: int, noisy: bool, horizon: int
):
    rng = np.random.default_rng(seed)
    mdp = random_joint(rng, noisy, sizes=(2, 2))
    blind = np.tile(rng.dirichlet(np.ones(2)), (mdp.states, 1))
    by_others = {
        others: hb.empowerment(mdp, horizon, player="a", others=given)
        for others, given in (("best", "best"), ("worst", "worst"), ("blind", blind))
    }
    together = hb.empowerment(mdp, horizon)
    assert (by_others["worst"] <= by_others["best"] + 1e-6).all()
    assert (by_others["blind"] <= by_others["best"] + 2e-6).all()
    assert (by_others["best"] <= together + 2e-6).all()


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 10_000), st.booleans())
def test_the_first_step_of_any_policy_is_at_most_the_best(seed: int, noisy: bool):
    rng = np.random.default_rng(seed)
    mdp = random_joint(rng, noisy, sizes=(2, 3))
    policy = rng.dirichlet(np.full(3, 0.3), mdp.states)
    found = hb.empowerment(mdp, 1, player="a", others=policy)
    assert (found <= hb.empowerment(mdp, 1, player="a", others="best") + 2e-6).all()


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 10_000), st.integers(1, 3))
def test_without_noise_no_policy_is_more_than_one_mind(seed: int, horizon: int):
    rng = np.random.default_rng(seed)
    mdp = random_joint(rng, stochastic=False, sizes=(2, 2))
    policy = rng.dirichlet(np.full(2, 0.3), mdp.states)
    found = hb.empowerment(mdp, horizon, player="a", others=policy)
    assert (found <= hb.empowerment(mdp, horizon) + 2e-6).all()


def test_the_worst_is_no_lower_bound_on_noise():
    assert hb.empowerment(XOR, 1, player="a", others="worst").tolist() == [1, 1]
    assert hb.empowerment(XOR, 1, player="a", others="uniform").max() < 1e-6


def test_a_policy_that_looks_may_exceed_the_best_and_fall_below_the_worst():
    """The player sets a lamp; what the others do then shows it, or hides it."""
    start, off, on, dark, bright = range(5)
    table = np.repeat([[start], [off], [on], [dark], [bright]], 4, axis=1).reshape(5, 2, 2)
    table[start] = [[off, off], [on, on]]
    table[off], table[on] = [[dark, bright]] * 2, [[dark, bright]] * 2
    mdp = hb.TabularMDP.deterministic(table.reshape(5, 4), players={"a": 2, "b": 2})
    shows = np.array([[1, 0], [1, 0], [0, 1], [1, 0], [1, 0]])
    of: dict[str, Any] = {"states": [start], "player": "a"}
    assert hb.empowerment(mdp, 2, others="best", **of) == [0]
    assert hb.empowerment(mdp, 2, others=shows, **of) == [1]
    table[off], table[on] = [[dark, bright]] * 2, [[bright, dark]] * 2
    mdp = hb.TabularMDP.deterministic(table.reshape(5, 4), players={"a": 2, "b": 2})
    assert hb.empowerment(mdp, 2, others="worst", **of) == [1]
    assert hb.empowerment(mdp, 2, others=shows, **of) == [0]


def test_of_others_without_a_choice_all_values_are_one():
    mdp = random_joint(np.random.default_rng(3), stochastic=True, sizes=(3, 1))
    wanted = hb.empowerment(mdp, 3)
    for others in ("uniform", "best", "worst", {"b": np.ones((mdp.states, 1))}):
        np.testing.assert_allclose(
            hb.empowerment(mdp, 3, player="a", others=others), wanted, atol=2e-6
        )


def test_a_sensor_by_action_is_of_the_players_actions():
    rng = np.random.default_rng(4)
    mdp = random_joint(rng, stochastic=True, sizes=(2, 2))
    sensor = rng.dirichlet(np.ones(2), (2, mdp.states))
    fixed = [mdp.of_player("a", np.eye(2)[[b] * mdp.states]) for b in range(2)]
    each = np.array([hb.empowerment(one, 1, sensor) for one in fixed])
    found = hb.empowerment(mdp, 1, sensor, player="a", others="best")
    np.testing.assert_allclose(found, each.max(axis=0), atol=2e-6)
    with pytest.raises(ValueError, match=r"give \[actions of 'a', states, obs.*here 2 actions"):
        hb.empowerment(mdp, 1, np.repeat(sensor, 2, axis=0), player="a", others="best")


def test_only_the_chosen_actions_of_the_player_count():
    mdp = random_joint(np.random.default_rng(5), stochastic=False, sizes=(3, 2))
    by_pairs = mdp.next_state.reshape(-1, 3, 2)[:, [0, 2]].reshape(mdp.states, 4)
    fewer = hb.TabularMDP.deterministic(by_pairs, players={"a": 2, "b": 2})
    for others in ("best", "worst"):
        found = hb.empowerment(mdp, 3, actions=[0, 2], player="a", others=others)
        assert found.tolist() == hb.empowerment(fewer, 3, player="a", others=others).tolist()


def test_sequences_that_the_player_cannot_carry_out_do_not_count():
    table = [[1, 2, -1, -1], [1, 1, 0, 0], [2, 2, -1, -1]]  # b's second action leads to a dead end
    mdp = hb.TabularMDP.deterministic(table, players={"a": 2, "b": 2})
    assert hb.empowerment(mdp, 2, states=[0], player="a", others="best") == [1]
    assert hb.empowerment(mdp, 2, states=[0], player="a", others="worst") == [0]
    P = np.where(np.array(table)[..., None] >= 0, np.eye(3)[table], 0)
    noisy = np.eye(3)
    mdp = hb.TabularMDP.stochastic(P, players={"a": 2, "b": 2})
    assert hb.empowerment(mdp, 2, noisy, states=[0], player="a", others="best") == pytest.approx(1)
    assert hb.empowerment(mdp, 2, noisy, states=[0], player="a", others="worst") == [0]


# Assistance


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 10_000), st.booleans())
def test_assistance_is_the_mean_of_the_change_over_all_next_states(seed: int, noisy: bool):
    rng = np.random.default_rng(seed)
    mdp = random_joint(rng, noisy, sizes=(2, 1, 2))
    acting = rng.dirichlet(np.ones(2), mdp.states)  # of b and c, b without a choice
    value = hb.empowerment(mdp, 1, player="c", others="worst")
    found = hb.assistance(mdp, "a", "c", 1, acting=acting, others="worst")
    for state, action in product(range(mdp.states), range(2)):
        after = ends(mdp, 0, state, [action], acting)
        assert found[state, action] == pytest.approx(after @ value - value[state], abs=1e-12)


@pytest.mark.parametrize("others", ["uniform", "best"])
def test_assistance_in_some_states_is_that_of_the_whole_table(others: str):
    mdp = hb.tabulate(hb.World.parse("E = agent\n##.##\nE..A.\n")).slippery(0.1)
    whole = hb.assistance(mdp, "agent", "agent2", 1, "agent2", others=others)
    some = hb.assistance(mdp, "agent", "agent2", 1, "agent2", [7, 3, 7], others=others)
    assert whole.shape == (mdp.states, 5)
    np.testing.assert_allclose(some, whole[[7, 3, 7]], atol=1e-12)


def test_an_action_that_the_helper_lacks_has_no_assistance():
    mdp = hb.TabularMDP.deterministic([[-1, -1, 0, 0], [0, 1, 0, 1]], players={"a": 2, "b": 2})
    found = hb.assistance(mdp, "a", "b", 1)
    assert np.isnan(found).tolist() == [[True, False], [False, False]]


def test_the_assistants_of_the_example_do_what_the_page_says(capsys):
    runpy.run_path(str(ROOT / "examples" / "assistant.py"), run_name="__main__")
    printed = capsys.readouterr().out
    page = (ROOT / "docs" / "explanation" / "kinds.md").read_text("utf-8")
    for own, human in (("2.20", "1.61"), ("2.32", "0.34"), ("1.46", "2.16")):
        assert re.search(rf" {own} +{human}\n", printed)
        assert f"| {own} | {human} |\n" in page


# Refusals


def test_more_than_the_limits_is_refused_with_the_horizon_that_fits():
    rng = np.random.default_rng(6)
    certain = hb.TabularMDP.deterministic(rng.integers(99, size=(99, 9)), players={"a": 3, "b": 3})
    few: dict[str, Any] = {
        "player": "a",
        "others": "best",
        "states": [0],
        "method": hb.Exact(max_gib=2e-4),
    }
    for mdp in (certain, certain.slippery(0.1)):
        with pytest.raises(
            ValueError, match=r"horizon that fits is \d: use it, .* policy$"
        ) as error:
            hb.empowerment(mdp, 9, **few)
        fitting = int(str(error.value).split("fits is ")[1][0])
        assert 0 < fitting < 9
        hb.empowerment(mdp, fitting, **few)
        with pytest.raises(ValueError, match=f"fits is {fitting}: use it"):
            hb.empowerment(mdp, fitting + 1, **few)
    with pytest.raises(ValueError, match=r"the largest horizon that fits is about \d+: use it"):
        hb.empowerment(certain, 30, player="a", others="worst", method=hb.Exact(max_seconds=0.05))


@pytest.mark.parametrize(
    ("given", "problem"),
    [
        ({"player": "c"}, "player 'c' is unknown; use one of a, b"),
        ({"others": "best"}, r"others is given without player; name the player .*\(a, b\)"),
        ({"player": "a", "others": "good"}, "use 'uniform', 'best', 'worst', or give"),
        ({"player": "a", "others": "best", "sensor_at": "each step"}, "leave out the rest"),
        ({"player": "a", "others": "best", "method": hb.Sampled()}, "leave out the rest"),
        ({"player": "a", "others": "best", "states": [[0.5, 0.5]]}, "leave out the rest"),
        (
            {"player": "a", "others": "best", "cost": np.ones((2, 2)), "budget": 1},
            "leave out the rest",
        ),
        ({"player": "a", "others": "best", "sensor": "state + state"}, "with others='best' give"),
        ({"player": "a", "actions": [2]}, "actions has 2; use indices from 0 to 1"),
        ({"player": "a", "others": "best", "actions": [2]}, "has 2; use indices from 0 to 1"),
    ],
)
def test_what_does_not_go_together_is_refused(given: dict[str, Any], problem: str):
    with pytest.raises(ValueError, match=problem):
        hb.empowerment(XOR, 1, **given)


def test_a_table_of_one_agent_has_no_players():
    alone = hb.TabularMDP.deterministic([[0, 1], [1, 0]])
    for others in ("uniform", "best"):
        with pytest.raises(ValueError, match="the table has no players"):
            hb.empowerment(alone, 1, player="a", others=others)


def test_sequences_that_the_others_could_not_carry_out_are_refused():
    mdp = hb.TabularMDP.deterministic([[0, -1, 1, -1], [0, 1, 1, 0]], players={"a": 2, "b": 2})
    with pytest.raises(ValueError, match="joint action 1 is not available in state 0"):
        hb.empowerment(mdp, 1, player="a", others="worst")
    assert hb.empowerment(mdp, 1, player="a", states=[0]) == [1]


def test_policies_need_the_numbers_of_states():
    class Pair:
        actions, initial = 4, 0
        players = property(lambda self: {"a": 2, "b": 2})

        def step(self, state, action):
            return (state + action) % 4

    assert hb.empowerment(Pair(), 1, player="a", others="best").tolist() == [1] * 4
    with pytest.raises(ValueError, match="a model's states have no numbers yet; explore"):
        hb.empowerment(Pair(), 1, player="a", others=np.full((4, 2), 0.5))


def test_nobody_assists_itself():
    with pytest.raises(ValueError, match="helper and helped are both 'a'; name two players"):
        hb.assistance(XOR, "a", "a", 1)
    with pytest.raises(ValueError, match="acting is 'best'; use 'uniform'"):
        hb.assistance(XOR, "a", "b", 1, acting="best")
