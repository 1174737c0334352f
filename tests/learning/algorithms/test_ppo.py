import jax.numpy as jnp
import numpy as np
import pytest
from probes import learn, row

from habilis.learning.algorithms.ppo import PPO, clipped_loss
from habilis.learning.config import Config
from habilis.mdp import TabularMDP

QUICK = Config(
    algorithm=PPO(
        envs=8,
        rollout=8,
        epochs=2,
        minibatches=2,
        learning_rate=5e-3,
        entropy=0.001,
        discount=0.5,
        reward_scale=1.0,
        hidden=(16,),
    ),
    seed=3,
)


def test_it_solves_the_identity_task():
    reward = np.zeros((4, 3))
    reward[[0, 1, 2], [0, 1, 2]] = 1
    policy = learn(row(4, 3, reward), QUICK, updates=400).policy
    assert (policy[[0, 1, 2], [0, 1, 2]] > 0.9).all()


def test_the_value_under_truncation_is_that_of_the_endless_task():
    mdp = TabularMDP.deterministic([[0]], reward=[[1.0]])
    config = QUICK.changed(episode_limit=8, learning_rate=0.01)
    assert learn(mdp, config, updates=400).values[0] == pytest.approx(2.0, abs=0.1)


def test_a_delayed_reward_is_preferred_if_it_is_larger():
    mdp = TabularMDP.deterministic(
        [[2, 1], [2, 2], [2, 2]],
        reward=[[0.3, 0.0], [1.0, 1.0], [0.0, 0.0]],
        terminal=[False, False, True],
    )
    assert learn(mdp, QUICK.changed(discount=0.9), updates=400).policy[0, 1] > 0.9
    assert learn(mdp, QUICK.changed(discount=0.1), updates=400).policy[0, 0] > 0.9


def test_the_loss_is_the_formula_by_hand():
    """Ratios 1.5, 0.5, 1.5, 0.5 with advantages of both signs: clipped only where that hurts."""
    policy = np.array([0.75, 0.25])
    outputs = jnp.array([[*np.log(policy), 2.0]] * 4)
    action = jnp.array([0, 1, 0, 1])
    old = jnp.log(jnp.array([0.5, 0.5, 0.5, 0.5]))
    advantage = jnp.array([1.0, 1.0, -1.0, -1.0])
    target = jnp.array([3.0, 2.0, 2.0, 2.0])
    loss = clipped_loss(outputs, action, old, advantage, target, 0.2, entropy=0.1, value=0.5)
    gained = (1.2 + 0.5 - 1.5 - 0.8) / 4
    entropy = -(policy * np.log(policy)).sum()
    assert loss == pytest.approx(-gained + 0.5 / 4 - 0.1 * entropy, rel=1e-5)


@pytest.mark.parametrize(
    "change",
    [{"clip_range": 0.01}, {"epochs": 3}, {"minibatches": 4}, {"normalise": True}],
    ids=str,
)
def test_every_setting_changes_what_is_learned(change):
    mdp = row(3, 2, [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
    one = learn(mdp, QUICK, updates=5)
    other = learn(mdp, QUICK.changed(**change), updates=5)
    assert not np.array_equal(one.policy, other.policy)


def test_minibatches_must_divide_the_batch():
    with pytest.raises(ValueError, match="minibatches is 3; give a divisor of envs"):
        PPO(minibatches=3)
