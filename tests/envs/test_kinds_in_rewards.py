"""Kinds of empowerment in rewards: of our trainer, and of any environment."""

import gymnasium
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
    ],
)
def test_a_horizon_goes_with_its_kind(settings, message):
    with pytest.raises(ValueError, match=message):
        hb.Config(beta=0.1, **settings)


def test_an_environment_refuses_a_horizon_that_the_kind_does_not_have():
    with pytest.raises(ValueError, match="horizon is 3 and sensor 'effective:agent', which has"):
        hb.EmpowermentReward(gymnasium.make("FrozenLake-v1"), 3, "effective:agent", beta=0.5)
