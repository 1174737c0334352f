"""Probes: tiny tasks with known answers, each of which one kind of mistake would break."""

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from habilis.learning.a2c import Shape, _optimizer, actor_critic_loss, advance, start_lanes
from habilis.learning.config import Config
from habilis.learning.networks import ActorCritic
from habilis.learning.train import make_settings, make_task
from habilis.mdp import TabularMDP

QUICK = Config(
    envs=8, rollout=4, learning_rate=5e-3, entropy=0.001, discount=0.5, hidden=(16,), seed=3
)


def learn(mdp, config=QUICK, updates=1500, bonus=None):
    """Trains one agent; returns its policy's probabilities and its values in all states."""
    task, rows = make_task(mdp)
    shape = Shape(config.envs, config.rollout, config.optimizer, config.hidden, rows)
    settings = make_settings([config], np.zeros((1, mdp.states)) if bonus is None else bonus)
    lanes = start_lanes(task, settings, shape, jax.random.key(config.seed)[None])
    lanes, log = advance(task, settings, lanes, shape, updates)
    network = jax.tree.map(lambda leaf: leaf[0], lanes.network)
    logits, values = network(task.inputs)
    return np.asarray(jax.nn.softmax(logits)), np.asarray(values), log


def cycle(states, actions, reward, terminal_last=True):
    """States in a row, whatever is done; the last is terminal."""
    next_state = np.minimum(np.arange(states)[:, None] + 1, states - 1)
    terminal = np.arange(states) == states - 1
    return TabularMDP.deterministic(
        np.repeat(next_state, actions, axis=1), reward, terminal & terminal_last
    )


def test_it_solves_the_identity_task():
    """In state k action k is right: policy gradient, sampling, and the state it is shown."""
    reward = np.zeros((4, 3))
    reward[[0, 1, 2], [0, 1, 2]] = 1
    policy, _, _ = learn(cycle(4, 3, reward))
    assert (policy[[0, 1, 2], [0, 1, 2]] > 0.9).all()


def test_it_solves_the_two_state_task():
    """A small reward now or a larger one a step later: the value must carry it back."""
    mdp = TabularMDP.deterministic(
        [[2, 1], [2, 2], [2, 2]],
        reward=[[0.3, 0.0], [1.0, 1.0], [0.0, 0.0]],
        terminal=[False, False, True],
    )
    patient, values, _ = learn(mdp, replace(QUICK, discount=0.9))
    assert patient[0, 1] > 0.9
    np.testing.assert_allclose(values[:2], [0.9, 1.0], atol=0.1)
    hasty, values, _ = learn(mdp, replace(QUICK, discount=0.1))
    assert hasty[0, 0] > 0.9
    assert values[0] == pytest.approx(0.3, abs=0.1)


def test_the_value_of_a_state_before_the_end_is_its_reward():
    """Termination must not bootstrap: the state after the end is worth nothing."""
    _, values, _ = learn(cycle(2, 1, [[1.0], [0.0]]))
    assert values[0] == pytest.approx(1.0, abs=0.05)


def test_the_value_under_truncation_is_that_of_the_endless_task():
    """Reward 1 for ever, cut off every 4 steps: worth 1 / (1 - 0.5), not 1 + 1/2 + 1/4 + 1/8."""
    mdp = TabularMDP.deterministic([[0]], reward=[[1.0]])
    for limit in (4, 5):
        _, values, _ = learn(mdp, replace(QUICK, episode_limit=limit, rollout=4))
        assert values[0] == pytest.approx(2.0, abs=0.05)


def test_the_state_that_a_truncated_step_led_to_is_what_is_bootstrapped_from():
    """Cut off in state 3, which is worth 10 for ever, and not in the start that follows."""
    next_state = [[1], [2], [3], [3]]
    reward = [[0.0], [0.0], [0.0], [5.0]]
    mdp = TabularMDP.deterministic(next_state, reward)
    _, values, _ = learn(mdp, replace(QUICK, episode_limit=4))
    np.testing.assert_allclose(values, [1.25, 2.5, 5.0, 10.0], rtol=0.1)


def test_an_episode_is_counted_from_its_first_to_its_last_step():
    """Return, length and flags of what ended, by termination here and by truncation there."""
    mdp = cycle(4, 1, [[-1.0], [-1.0], [0.0], [0.0]])
    mdp = replace(mdp, flags={"late": np.array([False, False, True, True])})
    _, _, log = learn(mdp, updates=10)
    episodes = np.asarray(log.tally)[np.asarray(log.ended)]
    np.testing.assert_array_equal(np.unique(episodes, axis=0), [[3, -2, 2]])
    _, _, log = learn(mdp, replace(QUICK, episode_limit=2, rollout=2), updates=10)
    episodes = np.asarray(log.tally)[np.asarray(log.ended)]
    np.testing.assert_array_equal(np.unique(episodes, axis=0), [[2, -2, 1]])


def test_the_bonus_is_that_of_the_state_the_step_leads_to():
    """Two ways that differ only in the bonus of where they lead; the return does not have it."""
    mdp = TabularMDP.deterministic([[1, 2], [3, 3], [3, 3], [3, 3]], terminal=[0, 0, 0, 1])
    bonus = np.array([[0.0, 0.0, 1.0, 0.0]])
    policy, values, log = learn(mdp, bonus=bonus)
    assert policy[0, 1] > 0.9
    assert values[0] == pytest.approx(1.0, abs=0.1)
    assert (np.asarray(log.tally)[np.asarray(log.ended)][:, 1] == 0).all()


def test_reward_scale_scales_what_is_learned_and_not_what_is_counted():
    mdp = cycle(2, 1, [[1.0], [0.0]])
    _, values, log = learn(mdp, replace(QUICK, reward_scale=0.5))
    assert values[0] == pytest.approx(0.5, abs=0.05)
    assert (np.asarray(log.tally)[np.asarray(log.ended)][:, 1] == 1).all()


def test_entropy_keeps_the_policy_mixed():
    reward = [[1.0, 0.0], [0.0, 0.0]]
    sharp, _, _ = learn(cycle(2, 2, reward))
    mixed, _, _ = learn(cycle(2, 2, reward), replace(QUICK, entropy=1.0))
    # The best of p + H(p) is the softmax of the rewards.
    assert mixed[0, 0] == pytest.approx(np.e / (1 + np.e), abs=0.05)
    assert sharp[0, 0] > 0.95


def test_the_loss_is_the_formula_by_hand():
    network = ActorCritic(2, 1, 2, (1,), jax.random.key(0))
    network = eqx.tree_at(
        lambda n: (n.embedding, n.layers[0]),
        network,
        (jnp.zeros((2, 1)), (jnp.zeros((1, 3)), jnp.array([jnp.log(3.0), 0.0, 2.0]))),
    )
    loss = actor_critic_loss(
        network,
        jnp.array([[0], [1]]),
        jnp.array([0, 1]),
        jnp.array([2.0, -1.0]),
        jnp.array([5.0, 2.0]),
        entropy=0.1,
        value=0.5,
    )
    entropy = -(0.75 * np.log(0.75) + 0.25 * np.log(0.25))
    first = -np.log(0.75) * 2 + 0.5 * 9 - 0.1 * entropy
    second = np.log(0.25) * 1 + 0 - 0.1 * entropy
    assert loss == pytest.approx((first + second) / 2, rel=1e-5)


@pytest.mark.parametrize(
    "change",
    [
        {"learning_rate": 1e-3},
        {"clip": 1e-3},
        {"entropy": 0.5},
        {"value": 2.0},
        {"discount": 0.9},
        {"gae_lambda": 0.2},
        {"reward_scale": 0.3},
        {"episode_limit": 5},
        {"optimizer": "adam"},
        {"envs": 4},
        {"rollout": 2},
        {"hidden": (17,)},
        {"seed": 4},
    ],
    ids=str,
)
def test_every_setting_changes_what_is_learned(change):
    next_state = np.array([[1, 0, 2], [2, 0, 1], [3, 1, 0], [3, 3, 3]])
    reward = np.array([[-1, -2, 0], [-1, 1, -1], [0, -1, 2], [0, 0, 0]], float)
    mdp = TabularMDP.deterministic(next_state, reward, np.arange(4) == 3)
    policy, values, _ = learn(mdp, updates=20)
    other_policy, other_values, _ = learn(mdp, replace(QUICK, **change), updates=20)
    assert not np.array_equal(policy, other_policy)
    assert not np.array_equal(values, other_values)


def optimizer_step(gradient, **change):
    """The first change of the parameters, float[n]."""
    config = replace(QUICK, learning_rate=0.1, **change)
    shape = Shape(1, 1, config.optimizer, (1,), 1)
    settings = jax.tree.map(lambda leaf: leaf[0], make_settings([config], np.zeros((1, 1))))
    transform = _optimizer(settings, shape)
    gradient = jnp.asarray(gradient)
    return np.asarray(transform.update(gradient, transform.init(gradient))[0])


def test_a_gradient_is_clipped_to_its_norm_then_scaled_by_rmsprop():
    def by_hand(gradient):
        return -0.1 * gradient / np.sqrt(0.01 * gradient**2 + 1e-5)

    small, large = np.array([0.3, -0.4]), np.array([30.0, -40.0])
    np.testing.assert_allclose(optimizer_step(small, clip=1.0), by_hand(small), rtol=1e-5)
    np.testing.assert_allclose(optimizer_step(large, clip=0.005), by_hand(large / 1e4), rtol=1e-5)


def test_adams_first_step_is_its_learning_rate():
    step = optimizer_step(np.array([0.3, -0.4]), clip=1.0, optimizer="adam")
    np.testing.assert_allclose(step, [-0.1, 0.1], rtol=1e-4)


def test_a_new_agent_is_undecided_and_expects_nothing():
    policy, values, _ = learn(cycle(4, 3, np.zeros((4, 3))), replace(QUICK, learning_rate=1e-9))
    np.testing.assert_allclose(policy, 1 / 3, atol=0.02)
    np.testing.assert_allclose(values, 0, atol=0.05)


def test_the_loop_is_compiled_once_for_equal_shapes():
    before = advance._cache_size()  # pyright: ignore[reportAttributeAccessIssue]
    config = replace(QUICK, hidden=(3,))
    learn(cycle(2, 1, [[1.0], [0.0]]), config, updates=2)
    learn(cycle(2, 1, [[2.0], [0.0]]), replace(config, learning_rate=1e-3, seed=8), updates=2)
    assert advance._cache_size() == before + 1  # pyright: ignore[reportAttributeAccessIssue]
