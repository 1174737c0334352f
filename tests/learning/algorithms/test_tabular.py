"""The two algorithms that keep a table: Q-learning and soft value iteration."""

import numpy as np
import pytest
from probes import learn, row
from scipy.special import logsumexp

from habilis.learning.algorithms.q_learning import QLearning
from habilis.learning.algorithms.soft_value_iteration import SoftValueIteration
from habilis.learning.config import Config
from habilis.learning.folder import load_run
from habilis.learning.replay import play
from habilis.learning.runner import train
from habilis.mdp import TabularMDP

# Three states, the third terminal; action 0 waits, action 1 goes on.
NEXT = [[0, 1], [1, 2], [2, 2]]
REWARD = np.array([[-1.0, -2.0], [-1.0, 5.0], [0.0, 0.0]])
MDP = TabularMDP.deterministic(NEXT, REWARD, [False, False, True])


def test_q_learning_comes_to_the_solution_of_bellmans_equation():
    config = Config(algorithm=QLearning(epsilon=0.5, epsilon_steps=0, discount=0.8))
    values = learn(MDP, config, updates=2000).values
    wanted = np.zeros((3, 2))
    for _ in range(200):
        best = wanted.max(axis=1) * [1, 1, 0]
        wanted[:2] = (REWARD + 0.8 * best[NEXT])[:2]
    np.testing.assert_allclose(values[:2], wanted[:2], atol=1e-3)


def test_q_learning_is_one_update_by_hand():
    mdp = row(2, 1, [[3.0], [0.0]])
    config = Config(algorithm=QLearning(envs=1, rollout=1, learning_rate=0.25))
    assert learn(mdp, config, updates=1).values[0, 0] == 0.75
    assert learn(mdp, config, updates=2).values[0, 0] == 0.75 + 0.25 * 2.25


def test_epsilon_is_the_share_of_actions_at_random():
    """Half of what is explored is the best action too."""
    mdp = TabularMDP.deterministic([[0, 0]], [[0.0, 1.0]])
    for epsilon in (0.0, 0.4, 1.0):
        algorithm = QLearning(epsilon=epsilon, epsilon_steps=0, learning_rate=1.0)
        found = learn(mdp, Config(algorithm=algorithm, episode_limit=100), updates=1000)
        mean = found.episodes[10:, 1].mean() / 100
        assert mean == pytest.approx(0 if epsilon == 0 else 1 - epsilon / 2, abs=0.02)


def test_soft_values_solve_the_soft_bellman_equation():
    algorithm = SoftValueIteration(rollout=2, temperature=0.5, discount=0.9, reward_scale=0.7)
    values = learn(MDP, Config(algorithm=algorithm), updates=300).values
    soft = 0.5 * logsumexp(values / 0.5, axis=1) * [1, 1, 0]
    np.testing.assert_allclose(values, 0.7 * REWARD + 0.9 * soft[NEXT], atol=1e-3)


def test_a_cold_soft_policy_is_the_best_one_and_a_warm_one_is_mixed():
    for temperature, least, most in ((0.05, 0.999, 1.0), (50.0, 0.1, 0.9)):
        algorithm = SoftValueIteration(rollout=2, temperature=temperature, discount=0.9)
        found = learn(MDP, Config(algorithm=algorithm, episode_limit=50), updates=400)
        went_on = found.lane.train_state.parameters / temperature
        share = 1 / (1 + np.exp(went_on[1, 0] - went_on[1, 1]))
        assert least <= share <= most


@pytest.mark.parametrize("name", ["q-learning", "soft-value-iteration", "ppo"])
def test_every_algorithm_learns_a_world_and_is_kept(name, tmp_path):
    (tmp_path / "room.txt").write_text("A.\nC.\n..\nG.\n")
    config = Config(
        world=str(tmp_path / "room.txt"), runs=2, episodes=40_000, episode_limit=50, steps=2_000_000
    ).changed(algorithm=name, rollout=16)
    config = config.changed(**{"epsilon_steps": 100_000} if name == "q-learning" else {})
    run = train(config, out=tmp_path / "run")
    assert all(at is not None for at in run.converged_at)
    again = load_run(tmp_path / "run")
    assert again.config == config
    assert play(again, 1).episode_return == run.best_return == -1
