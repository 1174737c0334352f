"""Environments say which actions are available, refuse the others, and slip among those alone."""

import pickle

import gymnasium
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from available import random_table
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import SyncVectorEnv
from hypothesis import given, settings
from hypothesis import strategies as st

from habilis.envs import EmpowermentReward, TableEnv, TableVectorEnv
from habilis.envs.functional import FunctionalEnv
from habilis.learning.dynamics import make_dynamics
from habilis.learning.rollout import EnvState, rollout, sample_action
from habilis.mdp import TabularMDP

# In a ring of four cells: forth, back, and from cell 3 alone into the trap 4; 5 is the goal.
RING = TabularMDP.deterministic(
    [[1, 3, -1], [2, -1, 5], [3, 1, -1], [-1, 2, 4], [-1, -1, -1], [-1, -1, -1]],
    reward=np.arange(18).reshape(6, 3) / 4,
    terminal=[0, 0, 0, 0, 0, 1],
)
FULL = TabularMDP.deterministic([[1, 0], [0, 1]])
KEY = jax.random.key(0)


def walk(env: gymnasium.Env, steps: int):
    """Every step of a walk over available actions."""
    env.action_space.seed(0)
    _, info = env.reset(seed=0)
    for _ in range(steps):
        before, mask = info["state"], info["action_mask"]
        action = int(env.action_space.sample(mask=mask))
        _, reward, terminated, truncated, info = env.step(action)
        yield before, mask, action, reward, terminated, info
        if terminated or truncated:
            _, info = env.reset()


def test_info_has_the_mask_that_spaces_sample_with():
    seen = set()
    for before, mask, action, reward, terminated, info in walk(TableEnv(RING), 500):
        assert mask.dtype == np.int8
        assert mask.tolist() == RING.available[before].astype(int).tolist()
        assert info["state"] == RING.next_state[before, action]
        assert reward == RING.reward[before, action]
        assert terminated == (info["state"] in (4, 5))
        seen.add((before, action))
    assert seen == {(s, a) for s, a in np.argwhere(RING.available).tolist() if s < 4}


def test_a_mask_is_the_callers_own():
    env = TableEnv(RING)
    env.reset()[1]["action_mask"][:] = 0
    assert env.reset()[1]["action_mask"].any()


def test_where_all_actions_are_available_there_is_no_mask():
    assert "action_mask" not in TableEnv(FULL).reset()[1]
    assert "action_mask" not in TableVectorEnv(FULL, 2).reset()[1]
    assert FunctionalEnv(FULL).default_params.available is None
    _, state = FunctionalEnv(FULL).reset(KEY)
    assert FunctionalEnv(FULL).action_mask(state).tolist() == [1, 1]


def test_an_unavailable_action_is_refused_and_nothing_happens():
    env = TableEnv(RING, slip=0.5)
    env.reset(seed=0)
    message = "action 2 is not available in state 0; use one of 0, 1"
    with pytest.raises(ValueError, match=f"^{message}$"):
        env.step(2)
    assert env.state == 0
    trapped = TableEnv(RING)
    trapped.reset()
    trapped.step(1)
    assert trapped.step(2)[2]
    with pytest.raises(
        ValueError, match="no action is available in state 4: its episode has ended"
    ):
        trapped.step(0)
    envs = TableVectorEnv(RING, 3)
    envs.reset()
    message = "action 2 is not available in state 0 of environment 1; use one of 0, 1"
    with pytest.raises(ValueError, match=f"^{message}$"):
        envs.step(np.array([0, 2, 2]))
    assert envs.state.tolist() == [0, 0, 0]


def test_a_start_without_actions_is_refused_everywhere():
    mdp = TabularMDP.deterministic([[0, 1], [-1, -1]], start=1)
    for make in (TableEnv, lambda m: TableVectorEnv(m, 2), FunctionalEnv):
        with pytest.raises(ValueError, match="no action is available in state 1; give another"):
            make(mdp)


def test_the_checker_is_content_where_it_may_start_with_any_action():
    mdp = TabularMDP.deterministic([[1, 2], [-1, 0], [0, -1]])
    check_env(TableEnv(mdp), skip_render_check=True)
    copied = pickle.loads(pickle.dumps(TableEnv(mdp)))
    assert copied.reset()[1]["action_mask"].tolist() == [1, 1]


@pytest.mark.parametrize("slip", [0.4, 1.0])
def test_slip_goes_to_available_actions_as_often_as_the_table_says(slip: float):
    counts = np.zeros(RING.next_state.shape)
    taken = np.zeros(RING.next_state.shape)
    for before, _, action, _, _, info in walk(TableEnv(RING, slip=slip), 6000):
        taken[before, action] += 1
        counts[before] += [info["state"] == t for t in RING.next_state[before]]
    assert not counts[~RING.available].any()
    for state in range(4):
        there = RING.available[state]
        # Actions are drawn uniformly, so that what comes of them is uniform with any slip.
        assert np.abs(counts[state][there] / counts[state].sum() - 1 / there.sum()).max() < 0.05
    envs = TableVectorEnv(RING, 4000, slip=slip)
    envs.reset(seed=0)
    envs.step(np.zeros(4000, int))
    expected = RING.slippery(slip).transition(0).toarray()[0]
    assert np.abs(np.bincount(envs.state, minlength=6) / 4000 - expected).max() < 0.03


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
def test_a_vector_environment_goes_as_single_ones_do(mode: str):
    envs = TableVectorEnv(RING, 5, max_steps=9, autoreset_mode=mode)
    single = [TableEnv(RING, max_steps=9) for _ in range(5)]
    _, info = envs.reset(seed=0)
    infos = [env.reset()[1] for env in single]
    envs.action_space.seed(0)
    ended = np.zeros(5, bool)
    for _ in range(200):
        masks = info["action_mask"]
        assert (masks.dtype, masks.shape) == (np.int8, (5, 3))
        assert info["_action_mask"].all()
        assert np.array_equal(masks, [one["action_mask"] for one in infos])
        actions = envs.action_space.sample(mask=tuple(masks))
        _, rewards, terminated, truncated, info = envs.step(actions)
        for i, env in enumerate(single):
            if ended[i] and mode == "NextStep":
                infos[i] = env.reset()[1]
                continue
            _, reward, over, cut, infos[i] = env.step(actions[i])
            assert (reward, over, cut) == (rewards[i], terminated[i], truncated[i])
            if (over or cut) and mode == "SameStep":
                last = info["final_info"]["action_mask"][i]
                assert np.array_equal(last, infos[i]["action_mask"])
                infos[i] = env.reset()[1]
        ended = terminated | truncated
        if mode == "Disabled" and ended.any():
            _, info = envs.reset(options={"reset_mask": ended})
            infos = [e.reset()[1] if ended[i] else infos[i] for i, e in enumerate(single)]


def test_gymnasiums_own_vector_environment_has_the_same_masks():
    envs = SyncVectorEnv([lambda: TableEnv(RING)] * 3)
    _, info = envs.reset(seed=0)
    assert info["action_mask"].tolist() == [[1, 1, 0]] * 3
    own = TableVectorEnv(RING, 3).reset()[1]["action_mask"]
    assert own.dtype == info["action_mask"].dtype


def test_empowerment_in_the_reward_leaves_the_mask_as_it_is():
    envs = EmpowermentReward(TableVectorEnv(RING, 2), 2, "state", 1.0)
    assert envs.reset(seed=0)[1]["action_mask"].tolist() == [[1, 1, 0]] * 2


# As functions of JAX


def test_functions_go_as_the_environment_does():
    env = FunctionalEnv(RING, max_steps=20)
    step = jax.jit(env.step)
    plain = TableEnv(RING, max_steps=20)
    _, state = env.reset(KEY)
    mask = plain.reset()[1]["action_mask"]
    rng = np.random.default_rng(0)
    for _ in range(60):
        assert env.action_mask(state).tolist() == mask.tolist()
        action = int(rng.choice(np.flatnonzero(mask)))
        _, state, reward, terminated, truncated, info = step(KEY, state, jnp.int32(action))
        _, earned, over, cut, said = plain.step(action)
        assert (float(reward), bool(terminated), bool(truncated)) == (earned, over, cut)
        assert int(info["state"]) == said["state"]
        if over or cut:
            said = plain.reset()[1]
        mask = said["action_mask"]
        assert info["action_mask"].dtype == jnp.int8
        assert info["action_mask"].tolist() == mask.tolist()


@pytest.mark.parametrize("slip", [0.0, 0.9])
def test_an_unavailable_action_stays_in_place_for_nothing_under_jit(slip: float):
    env = FunctionalEnv(RING, slip=slip)
    params = env.default_params
    keys = jax.random.split(KEY, 200)
    _, states = jax.vmap(env.reset, (0, None))(keys, params)
    step = jax.jit(jax.vmap(env.step_env, (0, 0, None, None)))
    _, after, reward, terminated, info = step(keys, states, jnp.int32(2), params)
    assert set(after.index.tolist()) == {0}
    assert set(after.time.tolist()) == {1}
    assert not reward.any()
    assert not terminated.any()
    assert info["action_mask"].tolist() == [[1, 1, 0]] * 200


def test_slip_as_a_function_is_that_of_the_table():
    env, number = FunctionalEnv(RING, slip=0.6), 20_000
    keys = jax.random.split(KEY, number)
    _, states = jax.vmap(env.reset, (0, None))(keys, env.default_params)
    _, after, *_ = jax.vmap(env.step_env, (0, 0, None, None))(
        keys, states, jnp.int32(1), env.default_params
    )
    expected = RING.slippery(0.6).transition(1).toarray()[0]
    found = np.bincount(np.asarray(after.index), minlength=6) / number
    assert np.abs(found - expected).max() < 0.02


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_environment_and_trainer_make_the_same_steps(seed: int):
    rng = np.random.default_rng(seed)
    table = random_table(rng)
    mdp = TabularMDP.deterministic(
        table, rng.integers(-8, 8, table.shape), rng.random(len(table)) < 0.3
    )
    if mdp.ends[mdp.start]:
        return
    dynamics, _ = make_dynamics(mdp)

    def uniform(state, draw):
        logits = jnp.zeros((len(state), mdp.action_count))
        return sample_action(logits, draw, dynamics.available_in(state)), ()

    draws = jnp.asarray(rng.random((40, 1), np.float32))
    env_state = EnvState(jnp.array([mdp.start]), jnp.zeros(1, int))
    _, trajectory = rollout(dynamics, uniform, env_state, jnp.float32(7), draws)
    env = TableEnv(mdp, max_steps=7)
    env.reset()
    for transition, cut in zip(
        trajectory.transition[:, 0], trajectory.truncated[:, 0], strict=True
    ):
        assert env.state == int(dynamics.state_of(transition))
        _, reward, terminated, truncated, _ = env.step(int(dynamics.action_of(transition)))
        assert reward == float(dynamics.transitions.reward[transition])
        assert (terminated, truncated) == (bool(dynamics.terminated(transition)), bool(cut))
        if terminated or truncated:
            env.reset()
