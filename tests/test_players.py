"""Tables of several players: joint actions, the table of one of them, and what is refused."""

from itertools import product
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from joint import ends, others_of, random_joint

import habilis as hb
from habilis.mdp import TabularMDP
from habilis.mdp_description import contents

GATE = TabularMDP.deterministic([[0, 0, 0, 1], [1, 1, 1, 1]], players={"walker": 2, "keeper": 2})


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 10_000), st.booleans())
def test_what_one_player_causes_is_the_sum_over_all_paths_of_the_others(seed: int, noisy: bool):
    rng = np.random.default_rng(seed)
    mdp = random_joint(rng, noisy)
    sizes = list(mdp.players.values())
    for place, name in enumerate(mdp.players):
        policy = rng.dirichlet(np.ones(len(others_of(sizes, place))), mdp.states)
        alone = mdp.of_player(name, policy)
        assert alone.action_count == sizes[place]
        start = int(rng.integers(mdp.states))
        for sequence in product(range(sizes[place]), repeat=2):
            belief = np.eye(mdp.states)[start]
            for action in sequence:
                belief = alone.transition(action).T @ belief
            np.testing.assert_allclose(
                belief, ends(mdp, place, start, sequence, policy), atol=1e-14
            )


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 10_000))
def test_rewards_are_the_mean_over_what_the_others_do(seed: int):
    rng = np.random.default_rng(seed)
    mdp = random_joint(rng, stochastic=True, sizes=(2, 3))
    policy = rng.dirichlet(np.ones(3), mdp.states)
    by_pairs = mdp.reward.reshape(-1, 2, 3)
    found = mdp.of_player("a", policy).reward
    np.testing.assert_allclose(found, (by_pairs * policy[:, None]).sum(axis=2), rtol=1e-5)
    first = rng.dirichlet(np.ones(2), mdp.states)
    found = mdp.of_player("b", {"a": first}).reward
    np.testing.assert_allclose(found, (by_pairs * first[:, :, None]).sum(axis=1), rtol=1e-5)


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 10_000))
def test_policies_by_name_are_independent_and_who_is_left_out_is_uniform(seed: int):
    rng = np.random.default_rng(seed)
    mdp = random_joint(rng, stochastic=True, sizes=(2, 3, 2))
    one = rng.dirichlet(np.ones(3), mdp.states)
    joint = (one[:, :, None] * np.full((mdp.states, 1, 2), 0.5)).reshape(mdp.states, -1)
    wanted = mdp.of_player("a", joint)
    for others in ({"b": one}, {"b": one, "c": "uniform"}):
        found = mdp.of_player("a", others)
        for action in range(2):
            difference = found.transition(action) - wanted.transition(action)
            assert abs(difference).max() < 1e-15


def test_the_last_player_varies_fastest():
    table = np.arange(6)[None].repeat(6, axis=0)
    mdp = TabularMDP.deterministic(table, players={"first": 2, "last": 3})
    for own, other in product(range(2), range(3)):
        policy = np.eye(3)[[other] * 6]
        assert mdp.of_player("first", policy).next_state[0, own] == 3 * own + other


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 10_000))
def test_a_deterministic_policy_keeps_a_table_deterministic(seed: int):
    rng = np.random.default_rng(seed)
    mdp = random_joint(rng, stochastic=False, sizes=(2, 3))
    chosen = rng.integers(3, size=mdp.states)
    alone = mdp.of_player("a", np.eye(3)[chosen])
    assert not alone.is_stochastic
    by_pairs = mdp.next_state.reshape(-1, 2, 3)
    assert (alone.next_state == by_pairs[np.arange(mdp.states), :, chosen]).all()


def test_what_does_not_depend_on_the_others_stays_deterministic():
    mdp = TabularMDP.deterministic([[1, 1, 0, 0], [1, 1, 0, 0]], players={"a": 2, "b": 2})
    assert mdp.of_player("a").next_state.tolist() == [[1, 0], [1, 0]]


def test_factors_start_and_cells_are_those_of_the_joint_table():
    two = hb.explore(Two())
    alone = two.of_player("left")
    assert alone.actions == ("stay", "go")
    assert alone.factor("left").tolist() == two.factor("left").tolist()
    assert (alone.start, alone.shape) == (two.start, two.shape)
    assert alone.state(0) == (0, 0)


class Two:
    """Two counters, each of which its player may raise."""

    actions = "stay+stay", "stay+go", "go+stay", "go+go"
    players = MappingProxyType({"left": 2, "right": 2})
    initial = 0, 0

    def step(self, state, action):
        left, right = divmod(action, 2)
        return min(state[0] + left, 2), min(state[1] + right, 2)

    def factors(self, state):
        return {"left": state[0], "right": state[1]}


def test_a_model_names_its_players():
    assert hb.explore(Two()).players == {"left": 2, "right": 2}


def test_players_are_saved_shown_and_kept_by_noise(tmp_path: Path):
    GATE.save(tmp_path / "gate.npz")
    assert TabularMDP.load(tmp_path / "gate.npz").players == {"walker": 2, "keeper": 2}
    assert list(TabularMDP.load(tmp_path / "gate.npz").players) == ["walker", "keeper"]
    assert GATE.slippery(0.5).players == GATE.players
    assert "players walker (2 actions), keeper (2 actions)" in repr(GATE)
    assert contents(GATE)["players"] == "walker (2 actions), keeper (2 actions)"


# Available actions


def test_an_action_of_the_others_that_is_not_available_is_not_chosen():
    table = [[0, -1, 1, -1], [0, 1, 1, 0]]  # in state 0 the second has its first action alone
    mdp = TabularMDP.deterministic(table, players={"a": 2, "b": 2})
    alone = mdp.of_player("a")
    assert alone.transition(1).toarray().tolist() == [[0, 1], [0.5, 0.5]]
    assert alone.transition(0).toarray().tolist() == [[1, 0], [0.5, 0.5]]
    with pytest.raises(ValueError, match="state 0 chooses their joint action 1, which is not"):
        mdp.of_player("a", [[0.5, 0.5], [0.5, 0.5]])


def test_an_action_that_the_player_lacks_is_not_available():
    table = [[-1, -1, 1, 0], [0, 1, 1, 0], [-1, -1, -1, -1]]
    mdp = TabularMDP.deterministic(table, players={"a": 2, "b": 2})
    there = [[False, True], [True, True], [False, False]]
    assert mdp.of_player("a").available.tolist() == there
    assert mdp.of_player("a", [[1, 0]] * 3).available.tolist() == there


def test_where_others_decide_what_is_available_is_refused():
    mdp = TabularMDP.deterministic([[0, -1, 1, 0], [0, 1, 1, 0]], players={"a": 2, "b": 2})
    with pytest.raises(ValueError, match=r"in state 0 action 0 of 'a'.*give joint action 1 a next"):
        mdp.of_player("a")
    with pytest.raises(ValueError, match=r"in state 0 action 1 of 'b'.*joint action 0; give joint"):
        mdp.of_player("b")


# Refusals


@pytest.mark.parametrize(
    ("players", "problem"),
    [
        ({"a": 2, "b": 3}, r"2 x 3 = 6 joint actions, but there are 4 actions"),
        ({"a": 4, "b": 0}, "'b' has 0 actions; give a whole number from 1 up"),
        ({"a": 2.0, "b": 2}, "'a' has 2.0 actions"),
        ({"": 4}, "players has ''; give each player a name"),
    ],
)
@pytest.mark.ill_typed
def test_players_that_are_none_are_refused(players: dict, problem: str):
    with pytest.raises(ValueError, match=problem):
        TabularMDP.deterministic([[0, 0, 0, 0]], players=players)
    with pytest.raises(ValueError, match=problem):
        TabularMDP.stochastic(np.ones((1, 4, 1)), players=players)


@pytest.mark.parametrize(
    ("player", "others", "problem"),
    [
        ("nobody", "uniform", "player 'nobody' is unknown; use one of walker, keeper"),
        ("walker", "best", "others is 'best'; use 'uniform', or give the others' policy"),
        ("walker", np.ones((2, 3)), r"others has shape \(2, 3\).*here \(2, 2\)"),
        ("walker", np.ones((2, 2)), "others, state 0 sums to 2"),
        ("walker", {"walker": [[1, 0]] * 2}, "'walker', which is none of the other players; name"),
        ("walker", {"keeper": [[1, 0]]}, r"others, 'keeper' has shape \(1, 2\)"),
        ("walker", {"keeper": "best"}, "others has 'best' for 'keeper'"),
    ],
)
def test_others_that_are_no_policy_are_refused(player: str, others, problem: str):
    with pytest.raises(ValueError, match=problem):
        GATE.of_player(player, others)


def test_a_table_of_one_agent_has_no_player():
    with pytest.raises(ValueError, match="the table has no players; make it with players="):
        TabularMDP.deterministic([[0]]).of_player("robot")
