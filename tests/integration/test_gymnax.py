"""gymnax's wrappers, and agents written for gymnax, on our functional environment."""

import gymnax
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from gymnax.environments import spaces
from gymnax.experimental.rollout import RolloutWrapper
from gymnax.wrappers import (
    FlattenObservationWrapper,
    GymnaxToGymWrapper,
    LegacyStepAPIWrapper,
    LogWrapper,
    StickyActionWrapper,
)

from habilis.envs.functional import KINDS, FunctionalEnv

SMALL = "AP.CG\n.....\n"
KEY = jax.random.key(0)


def walk(env, steps):
    """Rewards, ends and infos of a random walk."""
    params = env.default_params
    actions = jax.random.randint(KEY, (steps,), 0, env.num_actions)

    def step(state, action):
        _, state, reward, terminated, truncated, info = env.step(KEY, state, action, params)
        return state, (reward, terminated | truncated, info)

    return jax.jit(lambda s: jax.lax.scan(step, s, actions))(env.reset(KEY, params)[1])[1]


@pytest.mark.parametrize("kind", KINDS)
def test_it_says_and_does_what_gymnaxs_own_environments_do(kind):
    ours = FunctionalEnv("corridor", observation=kind)
    theirs, their_params = gymnax.make("FrozenLake-misc")
    params = ours.default_params
    # Everything public that theirs have, ours have, but for gradients of continuous dynamics.
    missing = {name for name in dir(theirs) if not name.startswith("_")} - set(dir(ours))
    assert all("gradient" in name or name in vars(theirs) for name in missing), missing
    assert isinstance(ours.action_space(params), spaces.Discrete)
    assert isinstance(ours.observation_space(params), spaces.Box)
    assert isinstance(ours.state_space(params), spaces.Dict)
    our_step, their_step = (
        env.step(KEY, env.reset(KEY, p)[1], jnp.int32(0), p)
        for env, p in ((ours, params), (theirs, their_params))
    )
    assert len(our_step) == len(their_step)
    for one, other in zip(our_step[2:5], their_step[2:5], strict=True):
        assert (one.shape, one.dtype) == (other.shape, other.dtype)
    assert {"terminated", "truncated", "final_observation"} <= our_step[-1].keys()


def test_log_wrapper_counts_episodes():
    rewards, ended, info = walk(LogWrapper(FunctionalEnv(SMALL, max_steps=12)), 3000)
    at = np.flatnonzero(ended)
    assert len(at) > 200
    total = np.cumsum(rewards)[at]
    assert np.allclose(info["returned_episode_returns"][at], np.diff(total, prepend=0), atol=1e-3)
    assert np.array_equal(info["returned_episode_lengths"][at], np.diff(at, prepend=-1))
    assert np.array_equal(info["returned_episode"], ended)
    assert len(np.unique(info["returned_episode_lengths"][at])) > 3


def test_flatten_observation_wrapper_flattens_a_grid():
    plain = FunctionalEnv(SMALL, observation="grid")
    env = FlattenObservationWrapper(LogWrapper(plain))
    params = env.default_params
    observed, state = env.reset(KEY, params)
    assert observed.shape == env.observation_space(params).shape == (5 * 2 * 5,)
    assert jnp.array_equal(observed, plain.reset(KEY, params)[0].reshape(-1))
    observed, *_, info = env.step(KEY, state, jnp.int32(0), params)
    assert observed.shape == info["final_observation"].shape


def test_sticky_actions_and_the_old_interface_work():
    env = StickyActionWrapper(FunctionalEnv(SMALL), sticky_action_prob=1.0)
    _, state = env.reset(KEY)
    state = state.replace(last_action=jnp.int32(1))
    _, after, *_ = env.step(KEY, state, jnp.int32(0), env.default_params)
    plain = FunctionalEnv(SMALL)
    assert after.env_state.index == plain.step(KEY, state.env_state, jnp.int32(1))[1].index

    old = LegacyStepAPIWrapper(FunctionalEnv(SMALL, max_steps=1))
    _, state = old.reset(KEY)
    _, _, reward, done, _ = old.step(KEY, state, jnp.int32(0), old.default_params)
    assert bool(done)
    assert reward == -1


def test_its_rollouts_run_our_environment():
    env = FunctionalEnv(SMALL)
    manager = RolloutWrapper(env=env, env_params={"max_steps_in_episode": 40})
    observations, actions, rewards, _, done, total = jax.jit(manager.batch_rollout)(
        jax.random.split(KEY, 6), None
    )
    assert observations.shape == (6, 40, 3)
    assert actions.max() == 7
    assert total.shape == (6, 1)
    for i in range(6):
        first = int(np.argmax(done[i]))
        assert total[i, 0] == rewards[i, : first + 1].sum()


@pytest.mark.parametrize("kind", KINDS)
def test_its_bridge_makes_a_gymnasium_environment_of_it(kind):
    env = GymnaxToGymWrapper(FunctionalEnv(SMALL, observation=kind))
    observed, _ = env.reset(seed=0)
    assert np.asarray(observed) in env.observation_space
    observed, reward, terminated, truncated, _ = env.step(env.action_space.sample())
    assert np.asarray(observed) in env.observation_space
    assert (float(reward), bool(terminated), bool(truncated)) == (-1, False, False)
