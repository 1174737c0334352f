"""Updates on one episode of each environment: steps after its end count nowhere."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from probes import QUICK_A2C, learn, row
from updates import chain, rollouts_of, updates

from habilis.learning import intrinsic
from habilis.learning.algorithms.a2c import A2C
from habilis.learning.config import Config
from habilis.learning.dynamics import make_dynamics
from habilis.learning.episodes import Ledger
from habilis.learning.runs import Record
from habilis.mdp import TabularMDP

LEARNER = A2C(envs=6, rollout=0, hidden=(8,), schedule="episodes")
CONFIG = Config(algorithm=LEARNER, episode_limit=9)
COUNTS = CONFIG.changed(intrinsic="count", beta=0.1)


@pytest.fixture(scope="module")
def made():
    """Two updates in which some episodes terminate early and others are cut off."""
    found = updates(chain(4), COUNTS)
    lengths = {int(n) for update in found for n in (update.log.transition[0] >= 0).sum(axis=0)}
    assert 9 in lengths
    assert min(lengths) < 7
    return found


def test_each_environment_makes_one_episode_an_update(made):
    mdp = chain(4)
    for update, rollout in zip(made, rollouts_of(mdp, COUNTS, made), strict=True):
        ended = rollout.terminated | rollout.truncated
        np.testing.assert_array_equal(ended.sum(axis=0), 1)
        lengths = np.asarray(rollout.mask).sum(axis=0)
        np.testing.assert_array_equal(ended.argmax(axis=0) + 1, lengths)
        np.testing.assert_array_equal(update.after.env_state.steps, 0)
        np.testing.assert_array_equal(update.after.env_state.state, mdp.start)
        np.testing.assert_array_equal(rollout.truncated.any(axis=0) <= (lengths == 9), True)


def test_steps_and_episodes_are_those_that_were_made(made):
    mdp = chain(4)
    record = Record(COUNTS, 0.0, Ledger.of(mdp))
    steps = 0
    for number, update in enumerate(made):
        transition = update.log.transition[0]
        did = np.asarray(transition), np.asarray(update.log.truncated[0])
        record.add(record.gain(*did, 0.0))
        steps += int((transition >= 0).sum())
        assert record.steps == int(update.after.counts.steps) == steps
        assert record.count == int(update.after.counts.episodes) == 6 * (number + 1)
        assert record.last is not None
        assert (record.last.transitions >= 0).all()
    assert record.episodes()[:, 0].sum() == steps
    assert (record.running == 0).all()


def test_states_are_counted_where_they_were_entered(made):
    mdp, wanted = chain(4), np.zeros(4)
    for update in made:
        transition = update.log.transition[0]
        state, action = np.divmod(transition[transition >= 0], mdp.action_count)
        wanted += np.bincount(mdp.next_state[state, action], minlength=4)
        np.testing.assert_array_equal(update.after.novelty, wanted)


def test_a_network_is_distilled_from_the_states_that_were_entered():
    """From all steps with a mask, and from those alone that it leaves."""
    dynamics, rows = make_dynamics(chain(6))
    kept = intrinsic.init("rnd", dynamics, rows, jax.random.key(0))
    states, mask = jnp.array([[1, 2], [3, 5], [4, 5]]), jnp.array([[1, 1], [1, 0], [1, 0]], bool)
    masked = intrinsic.visited("rnd", kept, dynamics, states, mask)
    alone = intrinsic.visited("rnd", kept, dynamics, states[mask][:, None])
    for ours, wanted in zip(jax.tree.leaves(masked), jax.tree.leaves(alone), strict=True):
        np.testing.assert_allclose(ours, wanted, rtol=1e-5, atol=1e-7)
    everything = intrinsic.visited("rnd", kept, dynamics, states)
    assert float(everything.scale) != pytest.approx(float(alone.scale), rel=1e-6)


def test_a_single_step_has_an_advantage_of_nothing_where_advantages_are_standardised():
    """One environment, one step to the end: there is no deviation to divide by."""
    learner = A2C(envs=1, rollout=0, normalise=True, unbiased=True, hidden=(4,))
    found = learn(row(2, 2, np.ones((2, 2))), Config(algorithm=learner), updates=3)
    assert np.isfinite(found.loss).all()
    assert np.isfinite(found.values).all()


def endless(limit_is_terminal: bool, **changes) -> np.ndarray:
    """The values of four states in a row, a reward of 1 a step for ever, cut off after 4 steps."""
    mdp = TabularMDP.deterministic([[1], [2], [3], [3]], reward=[[1.0]] * 4)
    config = Config(
        algorithm=QUICK_A2C, episode_limit=4, limit_is_terminal=limit_is_terminal, seed=3
    )
    return learn(mdp, config.changed(**changes)).values


@pytest.mark.parametrize(
    "change", [{}, {"rollout": 0}, {"rollout": 3, "networks": "separate"}], ids=str
)
def test_with_the_limit_as_terminal_the_cut_off_task_is_what_is_valued(change):
    np.testing.assert_allclose(endless(True, **change), [1.875, 1.75, 1.5, 1.0], atol=0.05)


def test_otherwise_the_endless_one_is_valued_from_whole_episodes_too():
    np.testing.assert_allclose(endless(False, rollout=0), 2.0, atol=0.05)


def test_it_learns_from_whole_episodes():
    """In state k action k is right; the policy is that of the return, whenever episodes end."""
    mdp = TabularMDP.deterministic(
        [[3, 1, 1], [3, 3, 2], [3, 3, 3], [3, 3, 3]],
        reward=[[0.2, 0.0, 0.0], [0.0, 0.0, 0.5], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]],
        terminal=np.arange(4) == 3,
    )
    config = Config(algorithm=QUICK_A2C, seed=3).changed(rollout=0, discount=0.9, episode_limit=6)
    found = learn(mdp, config)
    assert found.policy[0, 0] < 0.1
    assert found.policy[1, 2] > 0.9
    assert found.policy[2, 2] > 0.9
