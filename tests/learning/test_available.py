"""Agents never take actions that are not available, and value what is left."""

from dataclasses import replace

import jax
import numpy as np
import pytest
from available import random_probabilities, random_table
from hypothesis import given, settings
from hypothesis import strategies as st
from probes import QUICK_A2C, learn

import habilis as hb
from habilis.learning.algorithms.ppo import PPO
from habilis.learning.algorithms.q_learning import QLearning
from habilis.learning.algorithms.soft_value_iteration import SoftValueIteration
from habilis.learning.config import Config
from habilis.learning.dynamics import make_dynamics, roomy
from habilis.learning.episodes import Ledger
from habilis.learning.rollout import Context, EnvState, rollout, sample_action
from habilis.learning.training_problem import success_rate
from habilis.mdp import TabularMDP
from habilis.transitions import Transitions
from habilis.worlds.plans import best_returns, distances, solve

# Four cells in a row. Action 0 goes right, 1 left, 2 straight to the end for a reward that would
# beat all others where it is not available: it is in the third cell alone.
ROW = TabularMDP.deterministic(
    [[1, 0, 3], [2, 0, 3], [3, 1, 3], [3, 3, 3]],
    reward=[[-1, 9, 9], [-1, -1, 9], [9, -1, 2], [0, 0, 0]],
    terminal=[False, False, False, True],
    available=[[True, False, False], [True, True, False], [False, True, True], [False] * 3],
)
BEST = [0, 0, 2]

ALGORITHMS = [
    pytest.param(replace(QUICK_A2C, discount=0.9), 1500, id="a2c"),
    pytest.param(
        PPO(
            envs=8,
            rollout=16,
            learning_rate=5e-3,
            discount=0.9,
            hidden=(16,),
            minibatches=2,
            entropy=0.01,
            reward_scale=1.0,
        ),
        300,
        id="ppo",
    ),
    pytest.param(QLearning(epsilon=1.0, epsilon_end=1.0, discount=0.9), 2000, id="q-learning"),
    pytest.param(
        SoftValueIteration(rollout=10, temperature=0.1, discount=0.9), 200, id="soft values"
    ),
]


def values_of(mdp: TabularMDP, discount: float, temperature: float = 0.0) -> np.ndarray:
    """Q by plain loops over states and available actions; 0 for the others."""
    P = np.stack([mdp.transition(a).toarray() for a in range(mdp.action_count)], axis=1)
    there, Q = mdp.available, np.zeros(P.shape[:2])
    for _ in range(500):
        V = np.zeros(len(P))
        for s in range(len(P)):
            own = Q[s][there[s]]
            if mdp.ends[s]:
                continue
            most = own.max()
            soft = (
                temperature * np.log(np.exp((own - most) / temperature).sum()) if temperature else 0
            )
            V[s] = most + soft
        Q = np.where(there, mdp.reward + discount * P @ V, 0.0)
    return Q


@pytest.mark.parametrize(("algorithm", "updates"), ALGORITHMS)
def test_what_is_not_available_is_never_taken_and_has_no_probability(algorithm, updates):
    learned = learn(ROW, Config(algorithm=algorithm, episode_limit=30), updates)
    here = slice(0, 3)
    assert (learned.policy[here][~ROW.available[here]] == 0).all()
    assert np.allclose(learned.policy.sum(axis=1), 1, atol=1e-5)
    assert learned.policy[here].argmax(axis=1).tolist() == BEST
    # Without an action that is not available no episode is shorter than three steps.
    assert learned.episodes[:, 0].min() >= 3
    assert learned.episodes[:, 1].max() == 0
    assert np.isfinite(learned.loss).all()


def test_q_learning_comes_to_the_values_of_the_best_available_actions():
    learned = learn(
        ROW,
        Config(algorithm=QLearning(epsilon=1.0, epsilon_end=1.0, discount=0.9), episode_limit=30),
        3000,
    )
    there = ROW.available[:3]
    expected = values_of(ROW, 0.9)[:3]
    assert np.allclose(learned.values[:3][there], expected[there], atol=1e-3)
    assert not learned.values[:3][~there].any()


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("certain", [True, False])
def test_soft_values_are_those_of_plain_loops(seed: int, certain: bool):
    rng = np.random.default_rng(seed)
    if certain:
        shape = (table := random_table(rng)).shape
        mdp = TabularMDP.deterministic(table, rng.normal(size=shape), rng.random(shape[0]) < 0.2)
    else:
        shape = (P := random_probabilities(rng)).shape[:2]
        mdp = TabularMDP.stochastic(P, rng.normal(size=shape), rng.random(shape[0]) < 0.2)
    if mdp.ends[mdp.start] and not mdp.terminal[mdp.start]:
        with pytest.raises(ValueError, match="no action is available in state 0; give another"):
            make_dynamics(mdp)
        return
    algorithm = SoftValueIteration(temperature=0.5, discount=0.8, reward_scale=1.0)
    learned = learn(mdp, Config(algorithm=algorithm), 60)
    expected = values_of(mdp, 0.8, temperature=0.5)
    there = mdp.available
    assert np.allclose(learned.values[there], expected[there], atol=1e-3)


def test_uniform_exploration_is_uniform_over_the_available_actions():
    table = [[1, 2, -1, 3, -1], *[[0, -1, -1, -1, -1]] * 3]
    dynamics, _ = make_dynamics(TabularMDP.deterministic(table))
    algorithm = QLearning(epsilon=1.0, epsilon_end=1.0, epsilon_steps=0)
    context = Context(dynamics, jax.numpy.float32(0), jax.random.key(0), lambda t: t * 0.0)
    draws = (np.arange(3000) + 0.5) / 3000
    states = jax.numpy.zeros(3000, int)
    values = algorithm.init(dynamics, 0, jax.random.key(0))
    actions, _ = algorithm.act(context, values, states, jax.numpy.asarray(draws, np.float32))
    counts = np.bincount(np.asarray(actions), minlength=5)
    assert (np.abs(counts - [1000, 1000, 0, 1000, 0]) <= 1).all()
    logits = jax.numpy.zeros((3000, 5))
    drawn = sample_action(
        logits, jax.numpy.asarray(draws, np.float32), dynamics.available_in(states)
    )
    assert (np.abs(np.bincount(drawn, minlength=5) - [1000, 1000, 0, 1000, 0]) <= 1).all()


def test_the_last_draw_takes_an_available_action():
    almost = jax.numpy.array([np.nextafter(np.float32(1), np.float32(0))])
    for seed in range(200):
        rng = np.random.default_rng(seed)
        there = rng.random((1, 7)) < 0.5
        there[0, 2] = True
        logits = jax.numpy.asarray(rng.normal(size=(1, 7)) * 5, np.float32)
        for draw in (almost, jax.numpy.zeros(1)):
            assert there[0, int(sample_action(logits, draw, jax.numpy.asarray(there))[0])]


def test_a_state_without_actions_ends_an_episode_as_a_failure():
    # From 0 to the goal 2, or into the trap 1.
    mdp = TabularMDP.deterministic(
        [[1, 2], [-1, -1], [-1, -1]], [[5, 1], [0, 0], [0, 0]], [False, False, True]
    )
    assert mdp.ends.tolist() == [False, True, True]
    dynamics, _ = make_dynamics(mdp)
    assert dynamics.goes_on.tolist()[:2] == [-1, -1]
    assert Ledger.of(mdp).terminated[:2].tolist() == [True, True]
    assert best_returns(mdp, 10).tolist() == [5, 0, 0]
    assert success_rate(mdp, np.array([0, 0, 0], np.int32), np.array([0]), 10) == 0
    assert success_rate(mdp, np.array([1, 0, 0], np.int32), np.array([0]), 10) == 1
    assert distances(mdp).tolist() == [1, -1, 0]
    learned = learn(
        mdp, Config(algorithm=QLearning(epsilon=1.0, epsilon_end=1.0), episode_limit=30), 500
    )
    assert learned.values[0] == pytest.approx([5 * 1, 1], abs=0.05)
    assert set(learned.episodes[:, 0]) == {1}


def test_plans_go_by_available_actions():
    plan = solve(ROW)
    assert plan is not None
    assert plan.actions == (0, 0, 2)
    assert best_returns(ROW, 30)[:3].tolist() == [0, 1, 2]
    assert distances(ROW).tolist() == [3, 2, 1, 0]
    closed = TabularMDP.deterministic(
        ROW.next_state, terminal=ROW.terminal, available=ROW.available & [[1, 1, 0]]
    )
    assert solve(closed) is None
    assert distances(closed).tolist() == [-1, -1, -1, 0]
    loops = TabularMDP.deterministic([[0, -1]], terminal=[True])
    assert hb.solve(loops) is not None
    assert hb.solve(TabularMDP.deterministic([[1, -1], [-1, 1]], terminal=[True, False])) is None


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_expected_returns_are_those_of_plain_loops(seed: int):
    rng = np.random.default_rng(seed)
    P = random_probabilities(rng)
    reward, terminal = rng.normal(size=P.shape[:2]), rng.random(len(P)) < 0.2
    mdp = TabularMDP.stochastic(P, reward, terminal)
    P = np.stack([mdp.transition(a).toarray() for a in range(mdp.action_count)], axis=1)
    V = np.zeros(len(P))
    for _ in range(7):
        after = np.where(mdp.terminal, 0, V)
        V = np.array(
            [
                max((mdp.reward[s, a] + P[s, a] @ after for a in np.flatnonzero(row)), default=0.0)
                for s, row in enumerate(mdp.available)
            ]
        )
    assert np.allclose(best_returns(mdp, 7), V, atol=1e-5)


def test_outcomes_of_an_unavailable_action_lead_nowhere_else():
    P = np.zeros((3, 2, 3))
    P[0, 0] = 0.25, 0.25, 0.5
    P[1, 1, 0] = 1
    transitions = Transitions.of(TabularMDP.stochastic(P, [[3, 0], [0, 7], [0, 0]]))
    next_state, reward = (each.reshape(-1, 3) for each in transitions[:2])
    assert next_state[1].tolist() == [0, 0, 0]
    assert next_state[2].tolist() == [1, 1, 1]
    assert next_state[[4, 5]].tolist() == [[2, 2, 2]] * 2
    assert transitions.probabilities.sum(axis=1).tolist() == [1] * 6
    assert reward[0].tolist() == [3, 3, 3]
    assert reward[3].tolist() == [7, 7, 7]
    assert not reward[[1, 2, 4, 5]].any()


def test_room_for_more_states_changes_nothing():
    dynamics, _ = make_dynamics(ROW)
    wide = roomy(dynamics)
    assert wide.available is not None
    assert dynamics.available is not None
    assert wide.available[:4].tolist() == dynamics.available.tolist()
    assert wide.available.shape == (wide.states, wide.actions)
    plain, _ = make_dynamics(TabularMDP.deterministic([[0, 1], [1, 0]]))
    assert plain.available is None
    assert roomy(plain).available is None


def test_starts_without_actions_are_refused():
    with pytest.raises(ValueError, match="no action is available in state 1; give another start"):
        make_dynamics(TabularMDP.deterministic([[0, 0], [-1, -1]]), np.array([0, 1]))


def test_steps_of_a_task_are_those_of_the_table():
    dynamics, _ = make_dynamics(ROW)

    def uniform(state, draw):
        return sample_action(
            jax.numpy.zeros((len(state), 3)), draw, dynamics.available_in(state)
        ), ()

    draws = np.random.default_rng(0).random((500, 4), np.float32)
    _, trajectory = rollout(
        dynamics,
        uniform,
        EnvState(jax.numpy.zeros(4, int), jax.numpy.zeros(4, int)),
        jax.numpy.float32(50),
        jax.numpy.asarray(draws),
    )
    states, actions = (
        np.asarray(trajectory.state),
        np.asarray(dynamics.action_of(trajectory.transition)),
    )
    assert ROW.available[states, actions].all()
    for state in range(3):
        taken = np.bincount(actions[states == state], minlength=3) / (states == state).sum()
        even = ROW.available[state] / ROW.available[state].sum()
        assert np.abs(taken - even).max() < 0.1


def test_the_first_pass_of_ppo_has_the_policy_that_acted():
    # The probabilities' ratio is 1 then, and the loss minus the mean advantage, which is 0.
    algorithm = PPO(epochs=1, minibatches=1, normalise=True, value=0.0, entropy=0.0, rollout=16)
    learned = learn(ROW, Config(algorithm=algorithm, episode_limit=30), 1)
    assert abs(learned.loss[0]) < 1e-5


@pytest.mark.parametrize(
    "algorithm",
    [
        replace(QUICK_A2C, entropy=1.0, value=0.0),
        PPO(epochs=1, minibatches=1, entropy=1.0, value=0.0, rollout=4, normalise=True),
    ],
    ids=["a2c", "ppo"],
)
def test_where_there_is_no_choice_there_is_nothing_to_learn(algorithm):
    # One action a state: its probability is 1, so both its logarithm and the entropy are 0.
    mdp = TabularMDP.deterministic([[1, -1, -1], [-1, -1, 2], [-1, 0, -1]], np.ones((3, 3)))
    learned = learn(mdp, Config(algorithm=algorithm, episode_limit=30), 1)
    assert abs(learned.loss[0]) < 1e-5
    assert np.allclose(learned.policy, mdp.available)
