"""Bonuses that follow the agent's own policy."""

import numpy as np
import pytest

import habilis as hb
from habilis.learning import checkpoints
from habilis.learning.batches import train_jobs
from habilis.learning.jobs import Job

# A ring of eight states, of which one is the goal; labels tell its halves apart.
RING = hb.TabularMDP.deterministic(
    [[(s - 1) % 8, (s + 1) % 8, s] for s in range(8)],
    reward=np.full((8, 3), -1.0),
    terminal=np.arange(8) == 4,
)
OWN = hb.Config(
    world=RING, intrinsic="effective:state", beta=0.1, policy_every=5, runs=2, episodes=2_000,
    steps=40_000,
).changed(discount=0.5)  # fmt: skip


def trained(config):
    job = Job.of(0, config)
    train_jobs([job])
    return job


def test_the_bonus_is_effective_empowerment_under_the_agents_policy():
    job = trained(OWN)
    for run in range(2):
        lane = job.lane(run)
        policy = np.asarray(
            job.config.algorithm.policy(job.dynamics[0], lane.train_state.parameters)
        )
        assert int(lane.updates) % 5 == 0
        expected = hb.effective_empowerment(RING, policy / policy.sum(1, keepdims=True), 0.5)
        np.testing.assert_allclose(job.followed(lane.train_state), expected, atol=1e-6)
    # What the run had in its last stretch is of the policy before it, no longer uniform.
    uniform = hb.effective_empowerment(RING, "uniform", 0.5)
    assert abs(job.lane(0).novelty - uniform).max() > 0.01


def test_it_is_computed_every_so_many_updates(monkeypatch):
    at = []
    followed = Job.followed

    def counted(self, train_state):
        at.append(1)
        return followed(self, train_state)

    monkeypatch.setattr(Job, "followed", counted)
    job = trained(OWN.changed(runs=1, policy_every=7))
    assert len(at) == int(job.lane(0).updates) // 7


def test_runs_with_it_go_on_after_an_interruption_as_if_there_had_been_none(tmp_path):
    class StopError(Exception):
        pass

    def stop(_):
        if checkpoints.checkpoints(tmp_path / "cut"):
            raise StopError

    with pytest.raises(StopError):
        hb.train(OWN, stop, out=tmp_path / "cut", checkpoint_seconds=0)
    cut = hb.train(OWN, out=tmp_path / "cut", resume=True)
    assert cut.episodes.equals(hb.train(OWN).episodes)


def test_it_counts_for_what_is_learned():
    plain = hb.train(OWN.changed(policy_every=0))
    assert not plain.episodes.equals(hb.train(OWN).episodes)


def test_a_run_gives_its_policy():
    run = hb.train(OWN)
    policy = run.policy(1)
    assert policy.shape == (8, 3)
    np.testing.assert_allclose(policy.sum(axis=1), 1)
    assert run.mdp.states == 8
    with pytest.raises(ValueError, match="run is 2; use 0 to 1"):
        run.policy(2)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"intrinsic": "object", "horizon": 2}, "intrinsic 'object', which no policy changes"),
        ({"intrinsic": "count"}, "intrinsic 'count', which no policy changes"),
        ({"intrinsic": "none", "beta": 0.0}, "intrinsic 'none', which no policy changes"),
        ({"algorithm": "q-learning"}, "plays no part in q-learning; leave it at 0"),
        ({"policy_every": -1}, "policy_every is -1"),
    ],
)
def test_what_no_policy_changes_does_not_follow_one(settings, message):
    with pytest.raises(ValueError, match=message):
        OWN.changed(**settings)
