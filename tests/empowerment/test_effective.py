"""Effective empowerment, beside sums over time, its relations to other kinds, and refusals."""

import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import habilis as hb
from habilis.empowerment import effective_empowerment


def random_model(seed, states=5, actions=3, observations=4):
    """Transition probabilities, a policy and a noisy sensor, with zeros among them."""
    rng = np.random.default_rng(seed)

    def some(*shape):
        rows = rng.dirichlet(np.full(shape[-1], 0.5), size=shape[:-1])
        rows[rows < 0.05] = 0
        return rows / rows.sum(axis=-1, keepdims=True)

    return some(states, actions, states), some(states, actions), some(states, observations)


def channels(P, policy, W, discount, first_step, steps=400):
    """P(o | s, a) by the sum over K, one step after the other: float64[S, A, O]."""
    under = np.einsum("sa,sat->st", policy, P)
    found = np.zeros((*P.shape[:2], W.shape[1]))
    if first_step == 0:
        found += (1 - discount) * W[:, None]
    reached = P
    for k in range(1, steps):
        if k >= first_step:
            found += (1 - discount) * discount ** (k - first_step) * (reached @ W)
        reached = reached @ under
    return found


def information(rows, weights):
    """I(A; O) in bits."""
    mean = np.maximum(weights @ rows, 1e-300)
    logs = np.log2(np.where(rows > 0, rows / mean, 1))
    return float(weights @ (rows * logs).sum(axis=1))


cases = given(
    st.integers(0, 10_000), st.floats(0, 0.9), st.integers(0, 4), st.sampled_from([2, 3, 6])
)


@settings(deadline=None, max_examples=25)
@cases
def test_it_is_the_information_of_the_summed_channel(seed, discount, first_step, states):
    P, policy, W = random_model(seed, states)
    mdp = hb.TabularMDP.stochastic(P, axes="SAS")
    bits, gap = effective_empowerment(
        mdp, policy, discount, W, first_step=first_step, return_gap=True
    )
    rows = channels(P, policy, W, discount, first_step)
    expected = [information(rows[s], policy[s]) for s in range(states)]
    np.testing.assert_allclose(bits, expected, atol=1e-6)
    assert (abs(bits - expected) <= gap + 1e-12).all()


@pytest.mark.parametrize("first_step", [0, 1])
def test_a_discount_of_next_to_nothing_is_none(first_step):
    for seed in range(4):
        P, policy, W = random_model(seed, 3)
        mdp = hb.TabularMDP.stochastic(P, axes="SAS")
        found = effective_empowerment(mdp, policy, 5e-324, W, first_step=first_step)
        expected = effective_empowerment(mdp, policy, 0, W, first_step=first_step)
        np.testing.assert_allclose(found, expected, atol=1e-12)


@pytest.mark.parametrize("discount", [0.97, 0.999])
def test_slow_dynamics_are_solved_to_the_gap(discount):
    """Two rings of 40 states each, between which a policy hardly ever passes; 20 labels."""
    rng = np.random.default_rng(1)
    side, labels = np.arange(80) // 40, np.arange(80) // 4
    here = np.arange(80) % 40
    P = np.zeros((80, 3, 80))
    for action, step in enumerate((-1, 1)):
        P[range(80), action, (here + step) % 40 + 40 * side] = 1
    P[range(80), 2, here + 40 * (1 - side)] = 1
    policy = rng.dirichlet([1.0, 1.0, 1e-3], size=80)
    mdp = hb.TabularMDP.stochastic(P, axes="SAS")
    bits, gap = effective_empowerment(mdp, policy, discount, labels, return_gap=True)
    W = np.eye(20)[labels]
    under = np.einsum("sa,sat->st", policy, P)
    N = np.linalg.solve(np.eye(80) - discount * under, (1 - discount) * under @ W)
    rows = (1 - discount) * P @ W + discount * P @ N
    expected = [information(rows[s], policy[s]) for s in range(80)]
    assert (abs(bits - expected) <= gap).all()
    assert gap.max() <= 1e-6


@settings(deadline=None, max_examples=15)
@cases
def test_maximised_it_is_the_capacity_of_the_summed_channel(seed, discount, first_step, states):
    P, policy, W = random_model(seed, states)
    mdp = hb.TabularMDP.stochastic(P, axes="SAS")
    bits, gap = effective_empowerment(
        mdp, policy, discount, W, first_step=first_step, maximise=True, return_gap=True
    )
    rows = channels(P, policy, W, discount, first_step)
    expected = [hb.capacity(rows[s], tolerance=1e-9).bits for s in range(states)]
    assert (abs(bits - expected) <= gap + 1e-8).all()
    assert (gap <= 1e-6).all()


@settings(deadline=None, max_examples=20)
@cases
def test_it_exceeds_neither_the_entropy_of_the_policy_nor_its_maximum(
    seed, discount, first_step, states
):
    P, policy, W = random_model(seed, states)
    mdp = hb.TabularMDP.stochastic(P, axes="SAS")
    bits = effective_empowerment(mdp, policy, discount, W, first_step=first_step)
    most = effective_empowerment(mdp, policy, discount, W, first_step=first_step, maximise=True)
    entropy = -(policy * np.log2(np.maximum(policy, 1e-300))).sum(axis=1)
    assert (bits <= entropy + 1e-6).all()
    assert (bits <= most + 2e-6).all()


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 10_000))
def test_maximised_without_discount_it_is_one_step_empowerment(seed):
    P, policy, W = random_model(seed)
    mdp = hb.TabularMDP.stochastic(P, axes="SAS")
    bits = effective_empowerment(mdp, policy, 0.0, W, maximise=True)
    np.testing.assert_allclose(bits, hb.empowerment(mdp, 1, W), atol=2e-6)


def test_what_the_agent_does_later_counts():
    # Left or right, and then away again or not: what is seen later depends on the policy.
    mdp = hb.TabularMDP.deterministic([[1, 2], [1, 0], [2, 0]])
    stay = [[0.5, 0.5], [1, 0], [1, 0]]
    leave = [[0.5, 0.5], [0, 1], [0, 1]]
    kept = effective_empowerment(mdp, stay, 0.9, states=[0])[0]
    lost = effective_empowerment(mdp, leave, 0.9, states=[0])[0]
    assert kept == pytest.approx(1, abs=1e-6)
    assert lost < 0.6


def test_a_sensor_that_depends_on_the_last_action_hears_that_of_the_policy():
    P, policy, _ = random_model(3)
    rng = np.random.default_rng(1)
    heard = rng.dirichlet(np.ones(3), size=(3, 5))  # [A, S, O]
    mdp = hb.TabularMDP.stochastic(P, axes="SAS")
    bits = effective_empowerment(mdp, policy, 0.7, heard)
    emitted = np.einsum("sat,ato->sao", P, heard)
    under, expected = np.einsum("sa,sat->st", policy, P), np.einsum("sa,sao->so", policy, emitted)
    later = np.linalg.solve(np.eye(5) - 0.7 * under, 0.3 * expected)
    rows = 0.3 * emitted + 0.7 * P @ later
    np.testing.assert_allclose(bits, [information(rows[s], policy[s]) for s in range(5)], atol=1e-6)


def test_observations_in_several_blocks_give_the_same_bits(monkeypatch):
    P, policy, _ = random_model(5, states=6)
    mdp = hb.TabularMDP.stochastic(P, axes="SAS")
    whole = effective_empowerment(mdp, policy, 0.8)
    monkeypatch.setattr(sys.modules["habilis.empowerment.effective"], "_BLOCK", 12)
    np.testing.assert_allclose(effective_empowerment(mdp, policy, 0.8), whole, atol=1e-12)


def test_uniform_is_over_available_actions():
    mdp = hb.TabularMDP.deterministic([[0, 1], [1, -1]])
    assert effective_empowerment(mdp, "uniform", 0.0).tolist() == [1.0, 0.0]


def test_nats_are_bits_times_the_logarithm_of_two():
    P, policy, W = random_model(7)
    mdp = hb.TabularMDP.stochastic(P, axes="SAS")
    bits = effective_empowerment(mdp, policy, 0.5, W)
    nats = effective_empowerment(mdp, policy, 0.5, W, unit="nats")
    np.testing.assert_allclose(nats, bits * np.log(2), rtol=1e-6)


TWO = [[0, 1], [1, -1]]


@pytest.mark.ill_typed
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"discount": 1.0}, "discount is 1.0; give a number from 0 up to but not 1"),
        ({"discount": "much"}, "discount is 'much'; give a number"),
        ({"policy": "greedy"}, "policy is 'greedy'; give 'uniform' or"),
        ({"policy": [[1.0, 0.0]]}, r"policy has shape \(1, 2\); give float\[states, actions\]"),
        ({"policy": [[0.5, 0.5], [0.5, 0.5]]}, "policy has 0.5 for action 1 in state 1, which is"),
        ({"policy": [[0.5, 0.4], [1, 0]]}, "policy, state 0 sums to 0.9"),
        ({"first_step": -1}, "first_step is -1; give a whole number"),
        ({"first_step": 10**9}, "first_step is 1,000,000,000, whose steps take 1.0e\\+14 products"),
        ({"sensor": "state + state"}, "several; give one alone"),
        ({"sensor": np.full((2, 2, 2), 0.5), "first_step": 0}, "shows nothing before an action"),
        ({"states": [2]}, "states has 2; use indices from 0 to 1"),
        ({"tolerance": 0}, "tolerance is 0; give a number above 0"),
    ],
)
def test_what_it_refuses(arguments, message):
    mdp = hb.TabularMDP.deterministic(TWO)
    with pytest.raises(ValueError, match=message):
        effective_empowerment(mdp, **({"policy": "uniform", "discount": 0.5} | arguments))


def test_a_state_without_actions_is_refused():
    mdp = hb.TabularMDP.deterministic([[0, 1], [-1, -1]])
    with pytest.raises(ValueError, match="state 1 has no action, so that a policy ends there"):
        effective_empowerment(mdp, "uniform", 0.5)


@pytest.mark.parametrize("maximise", [False, True])
def test_a_discount_that_rounding_does_not_allow_ends_with_a_gap_that_says_so(maximise):
    ring = hb.TabularMDP.deterministic([[(s - 1) % 9, (s + 1) % 9, s] for s in range(9)])
    with pytest.warns(hb.ConvergenceWarning, match="above the tolerance"):
        bits, gap = effective_empowerment(
            ring, "uniform", 1 - 1e-9, states=[0], maximise=maximise, return_gap=True
        )
    assert bits[0] == pytest.approx(0, abs=1e-9)
    assert 1e-6 < gap[0] < 1e-3


def test_rounding_takes_no_gap_above_the_tolerance():
    table = np.random.default_rng(0).integers(40, size=(40, 4))  # several blocks of observations
    mdp = hb.TabularMDP.deterministic(table)
    for maximise in (False, True):
        _, gap = effective_empowerment(mdp, "uniform", 0.9, maximise=maximise, return_gap=True)
        assert 0 < gap.max() <= 1e-6
    mdp = hb.tabulate(hb.load_world("yard"))
    best = effective_empowerment(mdp, "uniform", 0.9, "object", maximise=True)
    assert 0 < best.max() <= 3
