"""Kinds of empowerment in rewards: of our trainer, and of any environment."""

import gymnasium
import minigrid  # noqa: F401 (registers its environments)
import numpy as np
import pytest

import habilis as hb
from habilis.learning.intrinsic import value_table
from habilis.rewards.measures import measured


def test_the_trainers_table_is_that_of_the_kind():
    mdp = hb.tabulate(hb.load_world("corridor"))
    config = hb.Config(intrinsic="goal-directed:object", horizon=4, beta=0.1)
    expected = hb.goal_directed_empowerment(mdp, 4, sensor="object")
    np.testing.assert_array_equal(value_table(mdp, config), expected)


def test_effective_empowerment_shares_the_discount_of_the_agent():
    mdp = hb.TabularMDP.from_gymnasium(gymnasium.make("FrozenLake-v1"))
    config = hb.Config(intrinsic="effective:agent", beta=0.1).changed(discount=0.8)
    expected = hb.effective_empowerment(mdp, "uniform", 0.8, "agent")
    np.testing.assert_allclose(value_table(mdp, config), expected)


def test_values_are_read_from_the_disk_the_second_time(monkeypatch):
    mdp = hb.TabularMDP.deterministic([[0, 1], [1, 0]]).slippery(0.3)
    first = measured(mdp, 2, "closed-loop:state", 0.9)
    monkeypatch.setattr("habilis.rewards.measures.of_kind", None)
    np.testing.assert_array_equal(measured(mdp, 2, "closed-loop:state", 0.9), first)


def test_any_environment_can_have_it_in_its_reward():
    env = hb.EmpowermentReward(
        gymnasium.make("FrozenLake-v1"), 0, "effective:agent", beta=0.5, discount=0.9
    )
    _, info = env.reset(seed=0)
    mdp = hb.TabularMDP.from_gymnasium(gymnasium.make("FrozenLake-v1"))
    values = hb.effective_empowerment(mdp, "uniform", 0.9, "agent")
    assert info["empowerment"] == pytest.approx(values[0])
    observation, reward, _, _, info = env.step(2)
    assert reward == pytest.approx(info["extrinsic_reward"] + 0.5 * values[observation])


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"intrinsic": "effective:object", "horizon": 3}, "which has none; leave out the horizon"),
        ({"intrinsic": "goal-directed:object"}, "horizon 0, so it is 0 everywhere"),
        ({"intrinsic": "effective"}, "without a sensor; name one, as 'effective:object'"),
    ],
)
def test_a_horizon_goes_with_its_kind(settings, message):
    with pytest.raises(ValueError, match=message):
        hb.Config(beta=0.1, **settings)


def test_an_environment_refuses_a_horizon_that_the_kind_does_not_have():
    with pytest.raises(ValueError, match="horizon is 3 and sensor 'effective:agent', which has"):
        hb.EmpowermentReward(gymnasium.make("FrozenLake-v1"), 3, "effective:agent", beta=0.5)


LAKE = hb.TabularMDP.from_gymnasium(gymnasium.make("FrozenLake-v1"))


def leaning(mdp):
    """A policy that is not uniform."""
    policy = np.arange(1.0, mdp.states * mdp.action_count + 1).reshape(mdp.states, -1)
    return policy / policy.sum(axis=1, keepdims=True)


@pytest.mark.parametrize("policy", [leaning(LAKE), leaning])
def test_an_environments_values_follow_a_policy(policy):
    env = hb.EmpowermentReward(
        gymnasium.make("FrozenLake-v1"), 0, "effective:agent", beta=0.5, discount=0.9
    )
    env.follow(policy)
    _, info = env.reset(seed=0)
    values = hb.effective_empowerment(LAKE, leaning(LAKE), 0.9, "agent")
    assert info["empowerment"] == pytest.approx(values[0])


def test_layouts_that_appear_later_follow_the_policy_too():
    def lavagap():
        env = gymnasium.make("MiniGrid-LavaGapS5-v0")
        return hb.EmpowermentReward(env, 0, "effective:agent", beta=0.5, discount=0.5)

    env, other = lavagap(), lavagap()
    env.follow(leaning)  # it knows the layout of seed 0
    later = env.reset(seed=3)[1]["empowerment"]
    uniform = other.reset(seed=3)[1]["empowerment"]
    other.follow(leaning)
    assert later == pytest.approx(other.reset(seed=3)[1]["empowerment"])
    assert later != pytest.approx(uniform)


@pytest.mark.parametrize("vectorised", ["ours", "sync"])
def test_vector_environments_follow_it_as_one_does(vectorised):
    ours = vectorised == "ours"
    name = "habilis/Yard-v0" if ours else "FrozenLake-v1"
    mode = "vector_entry_point" if ours else "sync"
    envs = gymnasium.make_vec(name, num_envs=2, vectorization_mode=mode)
    envs = hb.EmpowermentReward(envs, 0, "effective:agent", beta=0.5, discount=0.5)
    one = hb.EmpowermentReward(gymnasium.make(name), 0, "effective:agent", beta=0.5, discount=0.5)
    for some in (envs, one):
        some.follow(leaning)
    both = envs.reset(seed=0)[1]["empowerment"]
    assert both[0] == pytest.approx(one.reset(seed=0)[1]["empowerment"])


def test_only_effective_empowerment_follows_a_policy():
    env = hb.EmpowermentReward(gymnasium.make("FrozenLake-v1"), 2, "state", beta=0.5)
    with pytest.raises(ValueError, match="sensor is 'state', which no policy changes"):
        env.follow(leaning)
