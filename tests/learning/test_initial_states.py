"""Episodes that begin in random placements, and what was learned from others."""

import json
from itertools import islice
from math import perm

import jax
import numpy as np
import pytest

import habilis as hb
from habilis.cli import main
from habilis.learning import dynamics, jobs
from habilis.learning.batches import train_jobs
from habilis.learning.config import Config
from habilis.learning.folder import load_run
from habilis.learning.initial_states import random_placements
from habilis.learning.jobs import Job
from habilis.learning.replay import greedy_actions, play, success, table_of
from habilis.learning.runner import train
from habilis.learning.runs import Run
from habilis.learning.training_problem import Conditions, success_rate, training_problem
from habilis.sweeps.training import plain
from habilis.worlds.plans import distances, solve

ROOM = "R = rake\nA...\nP...\n.C..\n..RG\n"
OPEN = "A....\n.....\n..C..\n.....\n....G\n"
LEARN = Config(world="open.txt", runs=2, episodes=40_000, steps=300_000, episode_limit=50)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "room.txt").write_text(ROOM)
    (tmp_path / "open.txt").write_text(OPEN)
    return tmp_path


@pytest.fixture(scope="module")
def room() -> hb.World:
    return hb.World.parse(ROOM, name="room")


def test_placements_are_all_different_and_leave_the_agent_where_it_is(room):
    found = list(islice(random_placements(room, 0), 300))
    assert len({tuple(sorted(one.items())) for one in found}) == 300
    assert {one["agent"] for one in found} == {(0, 0)}
    assert all(len(set(one.values())) == 4 for one in found)
    assert list(islice(random_placements(room, 0), 300)) == found
    assert list(islice(random_placements(room, 1), 300)) != found


def test_placements_come_to_an_end():
    world = hb.World.parse("A.CG", name="line")
    assert len(list(random_placements(world, 0))) == perm(3, 1)


def test_those_held_out_are_others_and_all_can_be_solved(room):
    problem = training_problem(room, Conditions(20, 10, 3))
    assert (len(problem.seen), len(problem.unseen)) == (20, 10)
    assert len({*problem.seen, *problem.unseen}) == 30
    plans = [plan for state in problem.seen if (plan := solve(problem.mdp, int(state)))]
    assert problem.shortest_return == pytest.approx(np.mean([plan.best_return for plan in plans]))
    assert all(solve(problem.mdp, int(state)) for state in problem.unseen)
    assert (
        problem.mdp.start not in problem.seen
    )  # where the map has everything, which is in the table too
    assert not problem.mdp.terminal[problem.seen].any()


def test_distances_are_those_of_shortest_plans(room):
    mdp = hb.tabulate(room)
    far = distances(mdp)
    assert (far == 0).tolist() == mdp.terminal.tolist()
    for state in np.random.default_rng(0).choice(mdp.states, 40, replace=False):
        if not mdp.terminal[state]:
            plan = solve(mdp, int(state))
            assert far[state] == (-1 if plan is None else plan.steps)


def test_more_placements_than_can_be_solved_are_refused():
    world = hb.World.parse("A.CG", name="line")
    with pytest.raises(ValueError, match="line: the goal can be reached from 2 placements, not"):
        training_problem(world, Conditions(2, 1, 0))


def test_episodes_begin_in_all_of_the_placements_and_no_others():
    config = LEARN.changed(runs=1, episodes=600, starts=5, unseen=3)
    job = Job.of(0, config)
    first = np.asarray(job.start(0).env_state.state)
    begun = set(first.tolist())
    for seed in range(20):
        lane = Job.of(0, config.changed(seed=seed)).start(0)
        begun |= set(np.asarray(lane.env_state.state).tolist())
    assert begun == set(training_problem(job.world, job.conditions).seen.tolist())


def test_later_episodes_begin_in_all_of_them_too():
    config = LEARN.changed(runs=1, episodes=2_000, starts=5, episode_limit=5)
    job = Job.of(0, config)
    train_jobs([job])
    last = job.records[0].last
    assert last is not None
    states = last.transitions // job.mdp.action_count
    seen = training_problem(job.world, job.conditions).seen
    assert np.isin(seen, states).all()


def test_without_starts_nothing_is_other_than_it_was():
    """The default draws no random number more: see `test_runner` for the curves themselves."""
    job = Job.of(0, Config(world="open.txt"))
    assert job.dynamics[0].start.shape == ()
    assert not {"starts", "unseen", "starts_seed"} & plain(job.config).keys()
    assert "starts" in plain(job.config.changed(starts=3))


def test_what_is_learned_from_many_placements_holds_in_others():
    many = train(LEARN.changed(starts=8, unseen=4, starts_seed=1))
    one = train(LEARN.changed(steps=100_000, starts=1, unseen=8, starts_seed=1))
    rates = [success(many, index) for index in range(2)]
    assert all(rate.seen >= 0.85 for rate in rates), rates

    def elsewhere(run: Run) -> float:
        return sum(success(run, index).unseen or 0.0 for index in range(2)) / 2

    assert elsewhere(many) > elsewhere(one)


def test_a_success_rate_is_the_share_of_starts_from_which_the_goal_is_reached():
    run = train(LEARN.changed(runs=1, steps=60_000, starts=6, unseen=4))
    mdp, policy = table_of(run), greedy_actions(run, table_of(run), 0)
    problem = training_problem(run.world, Conditions.of(run.config))

    def gets_there(state: int) -> bool:
        for _ in range(50):
            state = int(mdp.next_state[state, policy[state]])
            if mdp.terminal[state]:
                return True
        return False

    for states in (problem.seen, problem.unseen):
        wanted = np.mean([gets_there(int(state)) for state in states])
        assert success_rate(mdp, policy, states, 50) == pytest.approx(wanted)
    assert success(run).seen == success_rate(mdp, policy, problem.seen, 50)
    with pytest.raises(ValueError, match="run is 1; use 0 to 0"):
        success(run, 1)


def test_a_run_goes_on_and_is_watched_with_its_success(folder, capsys):
    command = ["train", "room.txt", "--starts", "4", "--unseen", "2", "--runs", "1"]
    command += ["--episodes", "50", "--episode-limit", "50", "--hidden", "8", "--out", "run"]
    assert main(command) == 0
    assert main([*command, "--resume"]) == 0
    capsys.readouterr()
    assert main(["watch", "run", "--json"]) in (0, 1)
    reported = json.loads(capsys.readouterr().out)
    assert reported["success"].keys() == {"seen", "unseen"}
    run = load_run("run")
    assert play(run).states[0] == table_of(run).start
    assert main(["watch", "run"]) in (0, 1)
    assert "of those held out" in capsys.readouterr().out


def test_configurations_with_other_starts_train_side_by_side_as_alone():
    base = LEARN.changed(runs=1, episodes=100, steps=20_000).changed(hidden=(8,))
    configs = [base, base.changed(starts=3), base.changed(starts=3, starts_seed=1)]
    together = train(configs)
    for config, run in zip(configs, together, strict=True):
        alone = train(config)
        for one, other in zip(
            jax.tree.leaves(run.parameters), jax.tree.leaves(alone.parameters), strict=True
        ):
            np.testing.assert_array_equal(one, other)
    assert not together[1].episodes.equals(together[2].episodes)


@pytest.mark.parametrize("algorithm", ["ppo", "q-learning", "soft-value-iteration"])
def test_every_algorithm_starts_from_the_given_states(algorithm):
    config = LEARN.changed(runs=1, episodes=100, steps=20_000, starts=3, unseen=1)
    run = train(config.changed(algorithm=algorithm))
    assert run.episodes.height > 0
    assert success(run).unseen in (0.0, 1.0)


@pytest.mark.ill_typed
@pytest.mark.parametrize(
    ("settings", "problem"),
    [
        ({"unseen": 3}, "unseen is 3 and starts_seed 0, but starts is 0"),
        ({"starts": -1}, "starts"),
        ({"starts": 1.5}, "starts"),
    ],
)
def test_starts_that_cannot_be_are_refused(settings, problem):
    with pytest.raises(ValueError, match=problem):
        Config(**settings)


def test_room_for_more_states_changes_nothing_that_is_learned(monkeypatch):
    """Tables of about one size share a program, so they are brought to one size."""
    config = LEARN.changed(steps=40_000, runs=1, starts=5, intrinsic="object", horizon=2, beta=0.1)
    one = train(config)
    monkeypatch.setattr(dynamics, "ROOM", 1)
    jobs._task.cache_clear()
    other = train(config)
    jobs._task.cache_clear()
    assert one.episodes.equals(other.episodes)
    assert success(one) == success(other)


def test_tables_with_other_starts_have_the_same_shape():
    several = [
        Job.of(0, LEARN.changed(world="room.txt", starts=5, starts_seed=k)) for k in range(3)
    ]
    assert len({job.mdp.states for job in several}) > 1
    assert len({job.dynamics[0].transitions.next_state.shape for job in several}) == 1


def test_what_learns_a_value_of_each_state_has_no_more_of_them():
    job = Job.of(0, LEARN.changed(algorithm="q-learning", starts=5))
    assert job.dynamics[0].states == job.mdp.states
