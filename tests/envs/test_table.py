"""A table as a Gymnasium environment."""

import pickle

import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import habilis as hb
from habilis.envs.observations import ranks
from habilis.envs.table import TableEnv


@pytest.fixture(scope="module")
def mdp():
    return hb.tabulate(hb.load_world("yard"))


def test_it_is_a_gymnasium_environment(mdp):
    check_env(TableEnv(mdp), skip_render_check=True)


def test_steps_are_those_of_the_table(mdp):
    env = TableEnv(mdp)
    _, info = env.reset(seed=0)
    state = mdp.start
    assert info["state"] == state
    for action in np.random.default_rng(0).integers(8, size=300):
        observation, reward, terminated, truncated, info = env.step(action)
        assert reward == mdp.reward[state, action]
        state = mdp.next_state[state, action]
        assert info["state"] == state
        assert terminated == mdp.terminal[state]
        assert not truncated
        assert observation in env.observation_space
        if terminated:
            env.reset()
            state = mdp.start


def test_observations_distinguish_states(mdp):
    assert len(np.unique(ranks(mdp).show(np.arange(mdp.states)), axis=0)) == mdp.states


def test_a_shortest_plan_ends_with_its_return(mdp):
    plan = hb.solve(mdp)
    assert plan is not None
    env = TableEnv(mdp)
    env.reset()
    steps = [env.step(action) for action in plan.actions]
    assert sum(step[1] for step in steps) == plan.best_return
    assert [step[2] for step in steps] == [False] * (len(steps) - 1) + [True]


def test_a_long_episode_is_cut_off_and_the_next_is_as_long(mdp):
    env = TableEnv(mdp, max_steps=3)
    for _ in range(2):
        env.reset()
        assert [env.step(0)[3] for _ in range(3)] == [False, False, True]


def test_an_environment_of_a_stochastic_table_is_a_gymnasium_environment(mdp):
    check_env(TableEnv(mdp.slippery(0.1)), skip_render_check=True)


def test_the_same_seed_draws_the_same_outcomes_and_copies_go_on_alike(mdp):
    one, same = TableEnv(mdp.slippery(0.5)), TableEnv(mdp.slippery(0.5))
    for env in (one, same):
        env.reset(seed=1)
    for count in range(60):
        if count == 30:
            same = pickle.loads(pickle.dumps(same))
        action = count % mdp.action_count
        assert one.step(action)[1:] == same.step(action)[1:]
