"""Agents that learn where tools may fail."""

import json
from dataclasses import replace
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest

import habilis as hb
from habilis.cache import fingerprint
from habilis.cli import main
from habilis.learning.batches import train_jobs
from habilis.learning.config import Config
from habilis.learning.dynamics import make_dynamics
from habilis.learning.folder import load_run
from habilis.learning.jobs import Job, digest_of_own_tool
from habilis.learning.replay import best_return_from, greedy_actions, play, success, table_of
from habilis.learning.runner import train
from habilis.learning.sources import map_of
from habilis.learning.training_problem import (
    DEFAULT_CONDITIONS,
    Conditions,
    best_return,
    expected_returns,
    training_problem,
)
from habilis.transitions import Transitions
from habilis.worlds.plans import best_returns, distances

EXAMPLES = Path(__file__).parents[2] / "examples"
MAP = "P = picker slip 0.3\nA....\n.P...\n..C..\n.....\n....G\n"
SURE = MAP.replace(" slip 0.3", "")
LEARN = Config(world="fails.txt", runs=1, steps=600_000)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "fails.txt").write_text(MAP)
    return tmp_path


@pytest.fixture(scope="module")
def world() -> hb.World:
    return hb.World.parse(MAP, name="fails")


def expected(mdp: hb.TabularMDP, limit: int) -> np.ndarray:
    """Bellman's equation with dense matrices, one for each action."""
    assert not isinstance(mdp.transitions, np.ndarray)
    moves = mdp.transitions.toarray().reshape(mdp.states, mdp.action_count, -1)
    rewards = np.where(mdp.terminal, 0.0, -1.0)
    best = np.zeros(mdp.states)
    for _ in range(limit):
        best = (moves @ (rewards + np.where(mdp.terminal, 0, best))).max(axis=1)
    return best


def test_the_best_return_is_that_of_bellman_s_equation():
    mdp = hb.tabulate(hb.World.parse("P = picker slip 0.3\nA.P.\n..C.\n...G", name="small"))
    for limit in (1, 2, 7, 60):
        assert np.allclose(best_returns(mdp, limit), expected(mdp, limit), atol=1e-6)


def test_in_a_deterministic_world_the_best_return_is_that_of_a_shortest_plan():
    mdp = hb.tabulate(hb.World.parse(SURE))
    far = distances(mdp)
    there = far > 0
    assert there.any()
    assert (best_returns(mdp, 100)[there] == 1 - far[there]).all()
    assert (best_returns(mdp, 100)[far < 0] == -100).all()


def test_a_tool_that_may_fail_costs_something_and_its_luck_is_known(world):
    sure = hb.World.parse(SURE)
    shortest = best_return(sure, DEFAULT_CONDITIONS, 500)
    assert shortest - 3 < best_return(world, DEFAULT_CONDITIONS, 500) < shortest
    mdp = hb.tabulate(world)
    assert distances(mdp)[mdp.start] == 1 - shortest  # with luck


def test_every_outcome_of_an_action_has_its_share():
    jobs = [Job.of(i, LEARN.changed(runs=2, steps=40_000, seed=i)) for i in range(4)]
    train_jobs(jobs)
    transitions = Transitions.of(jobs[0].mdp)
    lasts = [record.last for job in jobs for record in job.records]
    done = np.concatenate([last.transitions for last in lasts if last is not None])
    chosen, outcome = np.divmod(done, transitions.outcomes)
    share = transitions.probabilities[chosen, 1]
    random = (share > 0.01) & (share < 0.99)
    assert random.sum() > 200
    assert (outcome == 1)[random].mean() == pytest.approx(share[random].mean(), abs=0.12)
    assert (outcome == 1)[~random].sum() == 0


def test_a_transition_index_encodes_state_action_and_outcome(world):
    dynamics, _ = make_dynamics(hb.tabulate(world))
    states, actions = jnp.divmod(jnp.arange(dynamics.states * dynamics.actions), dynamics.actions)
    for draw in (0.0, 0.999):
        done = dynamics.transition(states, actions, jnp.full(len(states), draw))
        assert (dynamics.state_of(done) == states).all()
        assert (dynamics.action_of(done) == actions).all()


@pytest.mark.parametrize(
    "algorithm",
    [
        {"algorithm": "a2c"},
        {"algorithm": "ppo"},
        {"algorithm": "q-learning", "learning_rate": 0.1},
        {"algorithm": "soft-value-iteration"},
    ],
    ids=lambda settings: settings["algorithm"],
)
def test_it_is_learned_in_spite_of_it(algorithm):
    run = train(LEARN.changed(**algorithm))
    assert None not in run.converged_at
    assert run.best_return == pytest.approx(best_return_from(run, table_of(run).start))
    assert play(run).finished


def test_planning_weighs_what_may_come_by_how_likely_it_is(world):
    settings = {"algorithm": "soft-value-iteration", "discount": 1.0, "temperature": 0.005}
    run = train(LEARN.changed(steps=300_000, sweeps=2, **settings))
    mdp = table_of(run)
    best = expected_returns(world, DEFAULT_CONDITIONS, 500)
    near = np.flatnonzero((best > -15) & ~mdp.terminal)
    assert len(near) > 500
    values = np.asarray(run.parameters[0]).max(axis=1)
    assert np.allclose(values[near], best[near], atol=0.1)


def test_object_empowerment_is_that_of_the_stochastic_world():
    job = Job.of(0, LEARN.changed(intrinsic="object", horizon=2, beta=0.1))
    assert np.allclose(job.table, hb.empowerment(job.mdp, 2, "object"))
    sure = hb.empowerment(hb.tabulate(hb.World.parse(SURE)), 2, "object")
    assert job.table.mean() < sure.mean() - 0.01


def test_episodes_are_random_and_the_success_rate_is_the_share_of_those_that_succeed():
    run = train(LEARN.changed(steps=20_000, episode_limit=9))
    episodes = [play(run, seed=seed) for seed in range(300)]
    assert play(run, seed=7) == episodes[7]
    assert len({episode.states for episode in episodes}) > 1
    assert max(len(episode.actions) for episode in episodes) <= 9
    share = np.mean([episode.finished for episode in episodes])
    wanted = success(run).seen
    assert abs(share - wanted) < 4 * np.sqrt(0.25 / 300)
    mdp, policy = table_of(run), greedy_actions(run, table_of(run), 0)
    transitions = Transitions.of(mdp)
    next_state = transitions.next_state.reshape(-1, transitions.outcomes)
    for episode in episodes[:20]:
        for before, action, after in zip(
            episode.states, episode.actions, episode.states[1:], strict=False
        ):
            assert action == policy[before]
            assert after in next_state[before * mdp.action_count + action]


def test_episodes_may_begin_anywhere_as_well():
    settings = {"algorithm": "soft-value-iteration", "starts": 4, "unseen": 2}
    run = train(LEARN.changed(steps=40_000, **settings))
    rate = success(run)
    assert rate.seen > 0.99
    assert rate.unseen is not None
    conditions = Conditions.of(run.config)
    problem, expects = (
        training_problem(run.world, conditions),
        expected_returns(run.world, conditions, 500),
    )
    assert run.best_return == pytest.approx(expects[problem.seen].mean())
    assert run.best_return < problem.shortest_return


def test_a_goal_out_of_reach_is_refused_in_a_stochastic_world_too(tmp_path):
    (tmp_path / "shut.txt").write_text("P = picker slip 0.3\nA.P#G\n.C.##\n.....\n")
    with pytest.raises(ValueError, match=r"shut\.txt: the goal cannot be reached"):
        train(Config(world="shut.txt"))


def test_the_digest_of_a_custom_tool_depends_on_its_failure_probability():
    sure = hb.World.parse(SURE).with_tool(f"{EXAMPLES / 'rake.py'}:Rake")
    worlds = [sure.with_tool(replace(sure.tools[0], slip=slip)) for slip in (0.0, 0.2, 0.3)]
    digests = [digest_of_own_tool(world) for world in (sure, *worlds)]
    assert digests[0] == digests[1]
    assert len(set(digests)) == 3


def test_the_command_line_trains_watches_and_says_how_often_it_succeeds(capsys):
    command = ["--steps", "300000", "--runs", "1", "--out", "run"]
    assert main(["train", "fails.txt", *command]) == 0
    assert load_run("run").map.tools[0].slip == 0.3
    capsys.readouterr()
    seen = set()
    for seed in range(8):
        status = main(["watch", "run", "--seed", str(seed), "--json"])
        reported = json.loads(capsys.readouterr().out)
        assert status == (0 if reported["finished"] else 1)
        assert 0 < reported["success"]["seen"] <= 1
        seen.add(tuple(reported["actions"]))
    assert len(seen) > 1
    main(["watch", "run"])
    assert "reaches the goal in" in capsys.readouterr().out
    assert main(["watch", "run", "--seed", "-1"]) == 2
    assert capsys.readouterr().err.strip() == "habilis: --seed is -1; give one of 0 or more"


def test_actions_may_slip_too(capsys):
    slips = LEARN.changed(world="fails.txt", slip=0.1, algorithm="soft-value-iteration")
    job = Job.of(0, slips)
    assert job.dynamics[0].transitions.outcomes > 2
    assert job.best_return < Job.of(0, LEARN).best_return
    measured = hb.tabulate(map_of(job.world), slip=0.1)
    assert fingerprint(job.mdp.transitions) == fingerprint(measured.transitions)
    bare = Config(world="line.txt", slip=0.5)
    Path("line.txt").write_text("A.CG\n")
    # Of 8 times east is east 5 times and west once: beside the can T = 1 + T / 4 + (1.6 + T) / 8.
    assert Job.of(0, bare).best_return == pytest.approx(1 - (1.6 + 1.92))
    command = ["--slip", "0.1", "--algorithm", "soft-value-iteration", "--steps", "300000"]
    assert main(["train", "fails.txt", *command, "--runs", "1", "--out", "run"]) == 0
    run = load_run("run")
    assert run.config.slip == 0.1
    assert run.converged_at[0] is not None
    assert table_of(run).is_stochastic
    capsys.readouterr()
    assert main(["train", "fails.txt", "--slip", "1.5", "--out", "other"]) == 2
    assert "slip is 1.5; give a number from 0 to 1" in capsys.readouterr().err
