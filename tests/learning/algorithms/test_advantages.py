import jax.numpy as jnp
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from habilis.learning.algorithms.actor_critic import generalised_advantages


def slow_advantages(reward, value, next_value, terminated, truncated, discount, gae_lambda):
    """By the definition: sums of discounted temporal differences, in float64."""
    steps = len(reward)
    advantages = np.zeros(steps)
    for t in range(steps):
        weight = 1.0
        for k in range(t, steps):
            future = 0.0 if terminated[k] else next_value[k]
            advantages[t] += weight * (reward[k] + discount * future - value[k])
            if terminated[k] or truncated[k]:
                break
            weight *= discount * gae_lambda
    return advantages


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    discount=st.floats(0, 1),
    gae_lambda=st.floats(0, 1),
)
def test_advantages_are_the_sums_that_define_them(seed, discount, gae_lambda):
    rng = np.random.default_rng(seed)
    steps, envs = 7, 3
    reward, value, next_value = rng.normal(size=(3, steps, envs))
    ends = rng.choice(3, size=(steps, envs), p=[0.6, 0.2, 0.2])
    terminated, truncated = ends == 1, ends == 2
    ours = generalised_advantages(
        jnp.asarray(reward),
        jnp.asarray(value),
        jnp.asarray(next_value),
        jnp.asarray(terminated),
        jnp.asarray(truncated),
        discount,
        gae_lambda,
    )
    for e in range(envs):
        slow = slow_advantages(
            reward[:, e],
            value[:, e],
            next_value[:, e],
            terminated[:, e],
            truncated[:, e],
            discount,
            gae_lambda,
        )
        np.testing.assert_allclose(ours[:, e], slow, rtol=1e-4, atol=1e-5)


def test_with_lambda_one_advantage_plus_value_is_the_discounted_return():
    reward, value = jnp.array([[1.0], [2.0], [4.0]]), jnp.array([[9.0], [8.0], [7.0]])
    next_value = jnp.array([[8.0], [7.0], [100.0]])
    no = jnp.zeros((3, 1), bool)
    advantage = generalised_advantages(reward, value, next_value, no, no, 0.5, 1.0)
    np.testing.assert_allclose(
        (advantage + value)[:, 0], [1 + 1 + 1 + 12.5, 2 + 2 + 25, 4 + 50], rtol=1e-6
    )


def test_truncation_bootstraps_and_termination_does_not():
    one, no, yes = jnp.ones((1, 1)), jnp.zeros((1, 1), bool), jnp.ones((1, 1), bool)
    cut = generalised_advantages(one, 0 * one, 10 * one, no, yes, 0.9, 1.0)
    end = generalised_advantages(one, 0 * one, 10 * one, yes, no, 0.9, 1.0)
    np.testing.assert_allclose([cut[0, 0], end[0, 0]], [10.0, 1.0], rtol=1e-6)


def test_nothing_flows_back_over_the_end_of_an_episode():
    reward = jnp.array([[0.0], [1000.0]])
    zero, ended = jnp.zeros((2, 1)), jnp.array([[True], [False]])
    for terminated, truncated in ((ended, ~ended & False), (~ended & False, ended)):
        advantage = generalised_advantages(reward, zero, zero, terminated, truncated, 1.0, 1.0)
        assert advantage[0, 0] == 0
