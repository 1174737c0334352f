"""Probes: tiny tasks with known answers, each of which one kind of mistake would break."""

from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from probes import QUICK_A2C, learn, row

from habilis.learning.algorithms import actor_critic
from habilis.learning.algorithms.a2c import A2C, actor_critic_loss
from habilis.learning.algorithms.actor_critic import OPTIMIZERS, TrainState, apply_gradient
from habilis.learning.algorithms.protocol import bound
from habilis.learning.config import Config
from habilis.learning.dynamics import make_dynamics
from habilis.learning.lanes import advance, settings_of
from habilis.learning.networks import Network
from habilis.learning.rollout import Context
from habilis.mdp import TabularMDP

QUICK = Config(algorithm=QUICK_A2C, seed=3)
BONUS = {"intrinsic": "state", "horizon": 1, "beta": 1.0}


def test_it_solves_the_identity_task():
    """In state k action k is right: policy gradient, sampling, and the state it is shown."""
    reward = np.zeros((4, 3))
    reward[[0, 1, 2], [0, 1, 2]] = 1
    policy, _ = learn(row(4, 3, reward), QUICK)[:2]
    assert (policy[[0, 1, 2], [0, 1, 2]] > 0.9).all()


def test_it_solves_the_two_state_task():
    """A small reward now or a larger one a step later: the value must carry it back."""
    mdp = TabularMDP.deterministic(
        [[2, 1], [2, 2], [2, 2]],
        reward=[[0.3, 0.0], [1.0, 1.0], [0.0, 0.0]],
        terminal=[False, False, True],
    )
    patient, values = learn(mdp, QUICK.changed(discount=0.9))[:2]
    assert patient[0, 1] > 0.9
    np.testing.assert_allclose(values[:2], [0.9, 1.0], atol=0.1)
    hasty, values = learn(mdp, QUICK.changed(discount=0.1))[:2]
    assert hasty[0, 0] > 0.9
    assert values[0] == pytest.approx(0.3, abs=0.1)


def test_the_value_of_a_state_before_the_end_is_its_reward():
    """Termination must not bootstrap: the state after the end is worth nothing."""
    _, values = learn(row(2, 1, [[1.0], [0.0]]), QUICK)[:2]
    assert values[0] == pytest.approx(1.0, abs=0.05)


def test_the_value_under_truncation_is_that_of_the_endless_task():
    """Reward 1 for ever, cut off every 4 steps: worth 1 / (1 - 0.5), not 1 + 1/2 + 1/4 + 1/8."""
    mdp = TabularMDP.deterministic([[0]], reward=[[1.0]])
    for limit in (4, 5):
        _, values = learn(mdp, QUICK.changed(episode_limit=limit, rollout=4))[:2]
        assert values[0] == pytest.approx(2.0, abs=0.05)


def test_the_state_that_a_truncated_step_led_to_is_what_is_bootstrapped_from():
    """Cut off in state 3, which is worth 10 for ever, and not in the start that follows."""
    next_state = [[1], [2], [3], [3]]
    reward = [[0.0], [0.0], [0.0], [5.0]]
    mdp = TabularMDP.deterministic(next_state, reward)
    _, values = learn(mdp, QUICK.changed(episode_limit=4))[:2]
    np.testing.assert_allclose(values, [1.25, 2.5, 5.0, 10.0], rtol=0.1)


def test_an_episode_is_counted_from_its_first_to_its_last_step():
    """Return, length and flags of what ended, by termination here and by truncation there."""
    mdp = row(4, 1, [[-1.0], [-1.0], [0.0], [0.0]])
    mdp = replace(mdp, flags={"late": np.array([False, False, True, True])})
    found = learn(mdp, QUICK, updates=10)
    np.testing.assert_array_equal(np.unique(found.episodes, axis=0), [[3, -2, 2]])
    found = learn(mdp, QUICK.changed(episode_limit=2, rollout=2), updates=10)
    np.testing.assert_array_equal(np.unique(found.episodes, axis=0), [[2, -2, 1]])


def test_the_bonus_is_that_of_the_state_the_step_leads_to():
    """Two ways that differ only in the bonus of where they lead; the return does not have it."""
    mdp = TabularMDP.deterministic([[1, 2], [3, 3], [3, 3], [3, 3]], terminal=[0, 0, 0, 1])
    found = learn(mdp, QUICK.changed(**BONUS), table=[0.0, 0.0, 1.0, 0.0])
    assert found.policy[0, 1] > 0.9
    assert found.values[0] == pytest.approx(1.0, abs=0.1)
    assert (found.episodes[:, 1] == 0).all()


def test_reward_scale_scales_what_is_learned_and_not_what_is_counted():
    mdp = row(2, 1, [[1.0], [0.0]])
    found = learn(mdp, QUICK.changed(reward_scale=0.5))
    assert found.values[0] == pytest.approx(0.5, abs=0.05)
    assert (found.episodes[:, 1] == 1).all()


def test_entropy_keeps_the_policy_mixed():
    reward = [[1.0, 0.0], [0.0, 0.0]]
    sharp, _ = learn(row(2, 2, reward), QUICK)[:2]
    mixed, _ = learn(row(2, 2, reward), QUICK.changed(entropy=1.0))[:2]
    # The best of p + H(p) is the softmax of the rewards.
    assert mixed[0, 0] == pytest.approx(np.e / (1 + np.e), abs=0.05)
    assert sharp[0, 0] > 0.95


def test_the_loss_is_the_formula_by_hand():
    loss = actor_critic_loss(
        jnp.array([[jnp.log(3.0), 0.0, 2.0]] * 2),
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
        {"entropy": 0.5, "entropy_end": 0.1, "entropy_steps": 100},
        {"entropy": 0.5, "entropy_end": 0.1, "entropy_steps": 100, "entropy_hold": 300},
        {"normalise": True},
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
    policy, values = learn(mdp, QUICK, updates=20)[:2]
    other_policy, other_values = learn(mdp, QUICK.changed(**change), updates=20)[:2]
    assert not np.array_equal(policy, other_policy)
    assert not np.array_equal(values, other_values)


def test_the_gradient_from_kept_activations_is_that_of_the_loss():
    network = Network(7, 2, 4, (5, 6), jax.random.key(0), gain=1.0)
    inputs = jnp.array([[0, 3], [1, 3], [2, 6], [2, 4]])
    rest = (
        jnp.array([0, 1, 2, 2]),
        jnp.array([2.0, -1.0, 0.5, 0.0]),
        jnp.array([5.0, 2.0, 0.0, 1.0]),
        0.1,
        0.5,
    )
    wanted = jax.grad(lambda n: actor_critic_loss(n(inputs), *rest))(network)
    activations = network.activations(inputs)
    of_outputs = jax.grad(actor_critic_loss)(activations[-1], *rest)
    found = network.gradient(inputs, activations, of_outputs)
    assert jax.tree.structure(found) == jax.tree.structure(wanted)
    for ours, theirs in zip(jax.tree.leaves(found), jax.tree.leaves(wanted), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-4, atol=1e-6)


def optimizer_step(gradient, clip, optimizer="rmsprop"):
    """The first change of the parameters, float[n]."""
    algorithm = A2C(optimizer=optimizer, learning_rate=0.1, clip=clip)
    hyperparams = settings_of(Config(algorithm=algorithm), np.zeros(1)).hyperparams
    context = context_at(0)
    parameters: Any = jnp.zeros(len(gradient))
    before = TrainState(parameters, OPTIMIZERS[optimizer].init(parameters))
    after: Any = apply_gradient(
        bound(algorithm, hyperparams), context, before, jnp.asarray(gradient)
    )
    return np.asarray(after.parameters)


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
    policy, values = learn(row(4, 3, np.zeros((4, 3))), QUICK.changed(learning_rate=1e-9))[:2]
    np.testing.assert_allclose(policy, 1 / 3, atol=0.02)
    np.testing.assert_allclose(values, 0, atol=0.05)


def test_the_loop_is_compiled_once_for_equal_shapes():
    before = advance._cache_size()  # pyright: ignore[reportAttributeAccessIssue]
    config = QUICK.changed(hidden=(3,))
    learn(row(2, 1, [[1.0], [0.0]]), config, updates=2)
    learn(row(2, 1, [[2.0], [0.0]]), config.changed(learning_rate=1e-3, seed=8), updates=2)
    assert advance._cache_size() == before + 1  # pyright: ignore[reportAttributeAccessIssue]


def context_at(global_step):
    dynamics, _ = make_dynamics(row(2, 1, [[1.0], [0.0]]))
    return Context(dynamics, jnp.float32(global_step), jax.random.key(0), jnp.abs)


def entropy_weight(global_step, **settings):
    return actor_critic.entropy_weight(A2C(**settings), context_at(global_step))


@pytest.mark.parametrize(
    ("global_step", "weight"), [(0, 0.8), (100, 0.8), (150, 0.5), (200, 0.2), (10_000, 0.2)]
)
def test_entropys_weight_is_held_then_falls_linearly_then_stays(global_step, weight):
    found = entropy_weight(
        global_step, entropy=0.8, entropy_end=0.2, entropy_hold=100, entropy_steps=100
    )
    assert found == pytest.approx(weight)


def test_entropys_weight_stays_where_no_steps_are_given():
    never = entropy_weight(10_000, entropy=0.8, entropy_end=0.2, entropy_hold=0, entropy_steps=0)
    assert never == pytest.approx(0.8)


def test_normalised_advantages_have_mean_zero_and_deviation_one():
    reported = actor_critic.normalised(jnp.array([[1.0, 5.0], [-3.0, 2.0]]))
    assert reported.mean() == pytest.approx(0, abs=1e-6)
    assert reported.std() == pytest.approx(1, rel=1e-5)


def test_schedules_count_environment_steps_not_updates():
    """Entropy vanishes after the first update, of 32 steps: the second one has none."""
    reward = np.zeros((2, 2))
    gone = QUICK.changed(entropy=1.0, entropy_end=0.0, entropy_hold=0, entropy_steps=32)
    kept = QUICK.changed(entropy=1.0, entropy_end=0.0, entropy_hold=0, entropy_steps=10**9)
    losses = [learn(row(2, 2, reward), config, updates=2).loss for config in (gone, kept)]
    assert losses[0][0] == pytest.approx(losses[1][0])
    assert losses[1][1] < -0.6, "two actions, at most 0.69 nats"
    assert losses[0][1] > -0.1
