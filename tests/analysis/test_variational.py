"""The variational bound: beside sums over all sequences and outcomes, its gaps, and refusals."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from trajectories import distributions, random_model

import habilis as hb
from habilis.analysis import variational_bound


def outcomes(P, W, start, sequence):
    """P(o | s, a^h), one action after the other."""
    belief = np.eye(len(P))[start]
    for action in sequence:
        belief = belief @ P[:, action]
    return belief @ W


def channel(P, W, start, horizon):
    sequences = itertools.product(range(P.shape[1]), repeat=horizon)
    return np.array([outcomes(P, W, start, one) for one in sequences])


cases = given(st.integers(0, 10_000), st.integers(1, 3), st.booleans())


@settings(deadline=None, max_examples=20)
@cases
def test_it_is_the_mean_of_what_the_decoder_says_more_than_the_source(seed, horizon, shared):
    P, _, mdp, rng = random_model(seed, states=3)
    W = distributions(rng, 3, 2)
    count = 2**horizon
    source = distributions(rng, 3, count)
    decoder = rng.dirichlet(np.ones(count), size=(1 if shared else 3, 2))
    found = variational_bound(mdp, horizon, source, decoder[0] if shared else decoder, W)
    for s in range(3):
        rows, q = channel(P, W, s, horizon), decoder[0 if shared else s]
        bound, information = 0.0, 0.0
        for a in range(count):
            for o in range(2):
                p = source[s, a] * rows[a, o]
                if p > 0:
                    posterior = p / (source[s] @ rows[:, o])
                    bound += p * (math.log2(q[o, a]) - math.log2(source[s, a]))
                    information += p * (math.log2(posterior) - math.log2(source[s, a]))
        assert found.bits[s] == pytest.approx(bound, abs=1e-12)
        assert found.information[s] == pytest.approx(information, abs=1e-12)
    assert (found.decoder_gap >= -1e-12).all()
    assert (found.source_gap >= -found.empowerment_gap - 1e-6).all()


@settings(deadline=None, max_examples=15)
@cases
def test_the_posterior_is_the_best_decoder_and_the_default(seed, horizon, uniform):
    P, _, mdp, rng = random_model(seed, states=3)
    count = 2**horizon
    source = np.full((3, count), 1 / count) if uniform else distributions(rng, 3, count)
    rows = np.array([channel(P, np.eye(3), s, horizon) for s in range(3)])
    joint = (source[:, :, None] * rows).transpose(0, 2, 1)
    sums = joint.sum(axis=2, keepdims=True)
    posterior = np.divide(joint, sums, out=np.zeros_like(joint), where=sums > 0)
    best = variational_bound(mdp, horizon, "uniform" if uniform else source)
    given = variational_bound(mdp, horizon, source, posterior)
    np.testing.assert_allclose(best.bits, given.bits, atol=1e-9)
    np.testing.assert_allclose(best.decoder_gap, 0, atol=1e-12)


@settings(deadline=None, max_examples=10)
@given(st.integers(0, 10_000))
def test_with_the_best_source_and_decoder_it_is_empowerment(seed):
    P, _, mdp, _ = random_model(seed, states=3)
    rows = np.array([channel(P, np.eye(3), s, 2) for s in range(3)])
    best = [hb.capacity(one, tolerance=1e-8).input_distribution for one in rows]
    found = variational_bound(mdp, 2, np.array(best))
    np.testing.assert_allclose(found.bits, hb.empowerment(mdp, 2), atol=1e-5)
    np.testing.assert_allclose(found.source_gap, 0, atol=1e-5)


def test_without_noise_a_uniform_source_misses_what_merges():
    ring = hb.TabularMDP.deterministic([[(s - 1) % 9, (s + 1) % 9] for s in range(9)])
    found = variational_bound(ring, 2, states=[0, 3])
    assert found.bits == pytest.approx([1.5, 1.5])  # 1/4, 1/2, 1/4
    assert found.empowerment == pytest.approx(np.log2([3, 3]))
    assert found.empowerment_gap.tolist() == [0, 0]
    assert repr(found) == "<VariationalBound: 1.5000 of 1.5850 bits; mean of 2 states>"


def test_a_decoder_that_excludes_what_happens_bounds_nothing():
    mdp = hb.TabularMDP.deterministic([[0, 1], [0, 1]])
    wrong = [[1.0, 0.0], [1.0, 0.0]]
    assert variational_bound(mdp, 1, decoder=wrong).bits.tolist() == [-np.inf, -np.inf]
    assert variational_bound(mdp, 1, decoder=[[1, 0], [0, 0]]).bits.tolist() == [-np.inf, -np.inf]
    assert variational_bound(mdp, 1, decoder=[[1, 0], [0, 1]]).bits.tolist() == [1, 1]


def test_only_sequences_that_can_surely_be_carried_out_are_drawn():
    mdp = hb.TabularMDP.deterministic([[0, 1, 2], [1, -1, 2], [-1, -1, -1]])
    found = variational_bound(mdp, 2)
    # From 0: 00, 01, 02, 10, 12; from 1: 00, 02; from 2 none.
    assert found.empowerment == pytest.approx([np.log2(3), 1, 0])
    assert found.bits == pytest.approx([-0.2 * np.log2(0.2) - 0.8 * np.log2(0.4), 1, 0])


def test_a_subset_of_actions_and_a_sensor_of_the_last_action():
    P, _, mdp, rng = random_model(4, states=3, actions=3)
    heard = distributions(rng, 3, 3, 2)  # [A, S, O]
    found = variational_bound(mdp, 2, sensor=heard, actions=[0, 2])
    for s in range(3):
        rows = np.array(
            [
                np.eye(3)[s] @ P[:, a] @ P[:, b] @ heard[b]
                for a, b in itertools.product([0, 2], repeat=2)
            ]
        )
        mean = rows.mean(axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):
            terms = np.where(rows > 0, rows * np.log2(rows / mean), 0)
        assert found.information[s] == pytest.approx(terms.sum() / 4, abs=1e-12)
    assert (found.source_gap >= -1e-6).all()


@pytest.mark.ill_typed
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"horizon": 0}, "horizon is 0; give a whole number from 1 up"),
        ({"horizon": 22}, r"2\^22 sequences of 2 states are 8,388,608, above 4,000,000; give a sh"),
        ({"source": "best"}, "source is 'best'; give 'uniform' or"),
        ({"source": [[1.0, 0.0]]}, r"source has shape \(1, 2\); give float\[states, sequences\]"),
        ({"source": [0.5, 0.4]}, "source, row 0 sums to 0.9"),
        ({"source": [0.5, 0.5]}, "source, row 1 has 0.5 for sequence 1, which cannot surely be"),
        ({"decoder": [[0.5, 0.5]]}, r"decoder has shape \(1, 1, 2\); give float\[states, observ"),
        ({"decoder": [[0.5, 0.4], [1, 0]]}, "decoder, row 0 sums to 0.9"),
        ({"sensor": "state + state"}, "several; give one alone"),
        ({"method": hb.Sampled()}, "method"),
    ],
)
def test_what_it_refuses(arguments, message):
    mdp = hb.TabularMDP.deterministic([[0, 1], [1, -1]])
    with pytest.raises(ValueError, match=message):
        variational_bound(mdp, **({"horizon": 1} | arguments))


def test_a_channel_that_spreads_too_far_is_refused(monkeypatch):
    import sys

    _, _, mdp, _ = random_model(0)
    monkeypatch.setattr(sys.modules["habilis.analysis.variational"], "_ENTRIES", 10)
    with pytest.raises(ValueError, match=r"has \d+ probabilities after 1 of 3 actions, above 10"):
        variational_bound(mdp, 3)


def test_a_sequence_that_may_meet_an_action_that_is_lacking_is_not_drawn():
    P = np.zeros((3, 2, 3))
    P[0, 0, [1, 2]] = 0.5  # then action 0 is available in one of them alone
    P[0, 1, 0] = P[1, 0, 1] = P[1, 1, 0] = P[2, 1, 2] = 1
    mdp = hb.TabularMDP.stochastic(P, axes="SAS")
    found = variational_bound(mdp, 2, states=[0])
    # Those that are left are 01, 10 and 11, a third each.
    rows = np.array([[0.5, 0, 0.5], [0, 0.5, 0.5], [1, 0, 0]])
    mean = rows.mean(axis=0)
    expected = (rows * np.log2(np.where(rows > 0, rows / mean, 1))).sum() / 3
    assert found.information[0] == pytest.approx(expected)
    with pytest.raises(
        ValueError, match="has 1 for sequence 0, which cannot surely be carried out"
    ):
        variational_bound(mdp, 2, source=[1, 0, 0, 0], states=[0])
