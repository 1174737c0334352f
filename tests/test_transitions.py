"""Steps of tables and their random outcomes, drawn alike by all that draws."""

import random
import subprocess
import sys
from dataclasses import replace

import gymnasium
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from probes import QUICK_A2C, learn

import habilis as hb
from habilis.envs import TableEnv, TableVectorEnv
from habilis.envs.functional import FunctionalEnv
from habilis.learning import replay
from habilis.learning.config import Config
from habilis.learning.dynamics import make_dynamics
from habilis.learning.episodes import Ledger
from habilis.mdp import TabularMDP
from habilis.studio import scene_steps, scenes
from habilis.studio.protocol.scenes import Placement
from habilis.studio.scenes import Scene
from habilis.transitions import Transitions

FAILS = "P = picker slip 0.5\nAP.CG\n.....\n"
EAST = 1


def random_table(seed: int = 0, states: int = 6, actions: int = 3) -> TabularMDP:
    """Every action has several outcomes; its reward is one that no world has."""
    rng = np.random.default_rng(seed)
    P = rng.dirichlet(np.full(states, 0.5), (states, actions))
    P[P < 0.05] = 0
    P /= P.sum(axis=2, keepdims=True)
    reward = rng.integers(2, 100, (states, actions)) / 8
    return TabularMDP.stochastic(P, reward, terminal=np.arange(states) == 5)


OWN = random_table()


def lakes() -> list[tuple[gymnasium.Env, TabularMDP]]:
    names = "FrozenLake-v1", "CliffWalking-v1"
    envs = [gymnasium.make(name, is_slippery=True) for name in names]
    return [(env, TabularMDP.from_gymnasium(env)) for env in envs]


@pytest.mark.parametrize("mdp", [OWN, OWN.slippery(0.25), hb.tabulate(hb.World.parse(FAILS))])
def test_outcomes_are_drawn_as_often_as_the_table_says(mdp: TabularMDP):
    transitions = Transitions.of(mdp)
    number = 40_000
    draws = (np.arange(number) + 0.5) / number
    for choice in (0, 4, mdp.start * mdp.action_count + EAST):
        made = transitions.drawn(np.full(number, choice), draws)
        found = np.bincount(transitions.next_state[made], minlength=mdp.states) / number
        state, action = divmod(choice, mdp.action_count)
        assert found == pytest.approx(mdp.transition(action)[[state]].toarray()[0], abs=1e-4)
        assert transitions.reward[made].mean() == pytest.approx(mdp.reward[state, action], 1e-4)


@pytest.mark.parametrize("mdp", [OWN, hb.tabulate(hb.World.parse(FAILS), slip=0.2)])
def test_jax_and_single_draws_give_the_same_transitions(mdp: TabularMDP):
    transitions = Transitions.of(mdp)
    rng = np.random.default_rng(0)
    choice = rng.integers(mdp.states * mdp.action_count, size=500)
    draw = rng.random(500).astype(np.float32)
    made = transitions.drawn(choice, draw)
    compiled = jax.jit(lambda *drawn: transitions.in_jax().drawn(*drawn))
    assert np.array_equal(made, compiled(choice, draw))
    one_by_one = [transitions.drawn(int(c), float(d)) for c, d in zip(choice, draw, strict=True)]
    assert np.array_equal(made, one_by_one)


def test_a_deterministic_table_has_one_outcome_and_needs_no_draw():
    mdp = TabularMDP.deterministic([[1, -1], [0, 1]], reward=[[2, 0], [3, 4]])
    transitions = Transitions.of(mdp)
    assert transitions.outcomes == 1
    assert transitions.next_state.tolist() == [1, 0, 0, 1]
    assert transitions.reward.tolist() == [2, 0, 3, 4]
    assert transitions.drawn(3, None) == 3
    assert transitions.probabilities.tolist() == [[1]] * 4


def test_the_rewards_of_outcomes_are_those_of_the_states_entered():
    transitions = Transitions.of(hb.tabulate(hb.World.parse(FAILS)))
    entered = hb.tabulate(hb.World.parse(FAILS)).terminal[transitions.next_state]
    assert (transitions.reward == np.where(entered, 0, -1)).all()
    assert entered.any()


def test_where_a_table_has_other_rewards_its_outcomes_earn_them():
    """Also where the rewards were replaced of a table whose outcomes earned others."""
    world = hb.tabulate(hb.World.parse(FAILS))
    own = np.arange(world.reward.size, dtype=np.float32).reshape(world.reward.shape)
    for mdp in (OWN, replace(world, reward=own), replace(world, entry_reward=None)):
        transitions = Transitions.of(mdp)
        reward = np.repeat(mdp.reward.reshape(-1), transitions.outcomes)
        assert (transitions.reward == reward).all()


def test_single_actions_may_have_rewards_of_their_own():
    world = hb.tabulate(hb.World.parse(FAILS))
    reward = world.reward.copy()
    reward[:, EAST] = 7
    outcomes = Transitions.of(replace(world, reward=reward))
    earned = outcomes.reward.reshape(world.states, world.action_count, -1)
    assert (earned[:, EAST] == 7).all()
    as_before = Transitions.of(world).reward.reshape(earned.shape)
    others = np.arange(world.action_count) != EAST
    assert (earned[:, others] == as_before[:, others]).all()


# Everything that draws earns the rewards of the table.


def test_a_gymnasium_environment_earns_the_rewards_of_its_table():
    env, rng = TableEnv(OWN, max_steps=20), np.random.default_rng(1)
    _, info = env.reset(seed=2)
    reached = set()
    for action in rng.integers(OWN.action_count, size=500):
        state = info["state"]
        _, reward, terminated, truncated, info = env.step(action)
        assert reward == OWN.reward[state, action]
        assert OWN.transition(action)[state, info["state"]] > 0
        assert terminated == OWN.terminal[info["state"]]
        reached.add((state, action, info["state"]))
        if terminated or truncated:
            _, info = env.reset()
    assert len({key[:2] for key in reached}) < len(reached)


def test_a_vector_environment_earns_the_rewards_of_its_table():
    envs, rng = TableVectorEnv(OWN, 64, autoreset_mode="SameStep"), np.random.default_rng(3)
    _, info = envs.reset(seed=4)
    for _ in range(50):
        states, actions = info["state"], rng.integers(OWN.action_count, size=64)
        _, rewards, *_, info = envs.step(actions)
        assert (rewards == OWN.reward[states, actions]).all()


def test_a_functional_environment_earns_the_rewards_of_its_table():
    env = FunctionalEnv(OWN)
    keys = jax.random.split(jax.random.key(5), (50, 64))
    actions = jax.random.randint(jax.random.key(6), (50, 64), 0, OWN.action_count)
    params = env.default_params

    def step(states, drawn):
        key, action = drawn
        _, after, reward, terminated, _, info = jax.vmap(env.step, (0, 0, 0, None))(
            key, states, action, params
        )
        return after, (states.index, info["state"], reward, terminated)

    _, states = jax.vmap(env.reset, (0, None))(keys[0], params)
    before, after, reward, terminated = jax.lax.scan(step, states, (keys, actions))[1]
    assert jnp.array_equal(reward, OWN.reward[before, actions])
    assert jnp.array_equal(terminated, OWN.terminal[after])
    P = np.stack([OWN.transition(a).toarray() for a in range(OWN.action_count)], axis=1)
    assert (P[before, actions, after] > 0).all()
    assert len(np.unique(np.stack([before, actions, after], 2).reshape(-1, 3), axis=0)) > 20


@pytest.mark.parametrize("slip", [0.0, 0.25])
def test_training_earns_the_rewards_of_its_table(slip: float):
    mdp = OWN.slippery(slip)
    dynamics, _ = make_dynamics(mdp)
    transitions = jnp.arange(len(dynamics.goes_on))
    reward = mdp.reward[dynamics.state_of(transitions), dynamics.action_of(transitions)]
    assert jnp.array_equal(dynamics.transitions.reward, reward)
    assert np.array_equal(Ledger.of(mdp).columns[:, 1], reward)
    trained = learn(mdp, Config(algorithm=QUICK_A2C, episode_limit=4), updates=20)
    _, returns, *_ = trained.episodes.T
    assert len(returns) > 100
    assert (returns * 8 % 1 == 0).all() == (slip == 0)
    assert (returns >= mdp.reward.min()).all()


def test_an_episode_that_is_played_earns_the_rewards_of_its_table(tmp_path, monkeypatch):
    (tmp_path / "fails.txt").write_text(FAILS)
    monkeypatch.chdir(tmp_path)
    run = hb.train(Config(world="fails.txt", runs=1, steps=1_000, episode_limit=9))
    mdp = replay.table_of(run)
    own = np.arange(mdp.reward.size, dtype=np.float32).reshape(mdp.reward.shape)
    monkeypatch.setattr(replay, "table_of", lambda run: replace(mdp, reward=own))
    for seed in range(20):
        episode = replay.play(run, seed=seed)
        states, actions = list(episode.states[:-1]), list(episode.actions)
        assert episode.episode_return == own[states, actions].sum()


def test_the_studio_earns_the_rewards_of_its_table(monkeypatch):
    reachable = scenes.reachable

    def with_own_rewards(*arguments):
        mdp, states = reachable(*arguments)
        own = np.arange(mdp.reward.size, dtype=np.float32).reshape(mdp.reward.shape)
        return replace(mdp, reward=own), states

    monkeypatch.setattr(scenes, "reachable", with_own_rewards)
    random.seed(0)
    world = hb.World.parse(FAILS)
    cells = ((0, 1), (0, 2), (0, 3))
    scene = Scene(world, "object", cells, 0, 1, "all", 0.0)
    at = {"agent": (0, 1), "tool": (0, 2), "object": (0, 3)}
    mdp, (state,) = with_own_rewards(world, at, 1)
    there = Placement(agent=at["agent"], tools=[at["tool"]], objects=[at["object"]])
    placements = []
    for _ in range(40):
        answer = scene_steps.step(scene, there, EAST)
        assert answer["reward"] == mdp.reward[state, EAST]
        placements.append(answer["placement"])
    assert len({str(placement) for placement in placements}) == 2


def test_the_outcomes_of_toy_text_environments_earn_what_their_own_tables_list():
    for env, mdp in lakes():
        listed = env.unwrapped.P  # pyright: ignore[reportAttributeAccessIssue]
        table = TableEnv(mdp, max_steps=60)
        rng = np.random.default_rng(7)
        _, info = table.reset(seed=8)
        rewards = set()
        for action in rng.integers(4, size=6_000):
            state = info["state"]
            _, reward, terminated, truncated, info = table.step(action)
            if state != mdp.start:  # from a cliff's start, one state may be entered for two rewards
                outcomes = [outcome[1:3] for outcome in listed[state][int(action)]]
                assert (info["state"] % len(listed), reward) in outcomes
                rewards.add(reward)
            if terminated or truncated:
                _, info = table.reset()
        assert len(rewards) == 2


def test_tables_are_stepped_through_without_jax():
    code = "import habilis.transitions, sys; print('jax' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
