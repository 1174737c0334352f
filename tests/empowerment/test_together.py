"""Beliefs, budgets and observations of every step together, beside lists of sequences."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import habilis as hb
from habilis.empowerment.budget import capacity_within


def listed(P, W, cost, belief, horizon, each_step):
    """Of every sequence of actions: P(observations), and the mean cost."""
    outputs, rows, costs = W.shape[1], [], []
    for sequence in product(range(P.shape[1]), repeat=horizon):
        paid, b = 0.0, belief
        for action in sequence:
            paid, b = paid + b @ cost[:, action], b @ P[:, action]
        costs.append(paid)
        if not each_step:
            rows.append(b @ W)
            continue
        row = []
        for shown in product(range(outputs), repeat=horizon):
            b = belief
            for action, o in zip(sequence, shown, strict=True):
                b = (b @ P[:, action]) * W[:, o]
            row.append(b.sum())
        rows.append(row)
    return np.array(rows), np.array(costs)


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 10_000), st.integers(1, 3), st.booleans(), st.booleans(), st.booleans())
def test_any_of_them_together_is_the_capacity_of_the_list(
    seed, horizon, each_step, budgeted, believed
):
    rng = np.random.default_rng(seed)
    P = rng.dirichlet(np.full(3, 0.5), size=(3, 2))
    W, cost = rng.dirichlet(np.ones(2), size=3), rng.random((3, 2))
    belief = rng.dirichlet(np.ones(3)) if believed else np.eye(3)[1]
    rows, costs = listed(P, W, cost, belief, horizon, each_step)
    budget = float(rng.uniform(costs.min(), costs.mean())) + 1e-9 if budgeted else np.inf
    within = {"cost": cost, "budget": budget} if budgeted else {}
    bits, gap = hb.empowerment(
        *(hb.TabularMDP.stochastic(P, axes="SAS"), horizon, W),
        states=belief[None] if believed else [1],
        sensor_at="each step" if each_step else "end",
        return_gap=True,
        **within,
    )
    expected = capacity_within(rows, costs, budget, 1e-9)[0] / np.log(2)
    assert bits[0] == pytest.approx(expected, abs=2e-6)
    assert expected <= bits[0] + gap[0] + 1e-8


def test_a_certain_belief_has_the_curve_of_its_state():
    ring = hb.TabularMDP.deterministic([[(s - 1) % 5, (s + 1) % 5, s] for s in range(5)])
    cost = np.tile([1.0, 2.0, 0.0], (5, 1))
    for at in ("end", "each step"):
        some = {"cost": cost, "budget": [0.5, 2, 9], "sensor_at": at}
        sure = hb.empowerment(ring, 3, states=np.eye(5)[[4]], **some)
        assert sure.shape == (1, 3)
        np.testing.assert_allclose(sure, hb.empowerment(ring, 3, states=[4], **some), atol=2e-6)


def test_without_noise_every_trajectory_costs_what_its_actions_cost():
    """A lamp: lit for 1 a step. Trajectories within a budget of 2 of 4 steps: bits of the mean."""
    lamp = hb.TabularMDP.deterministic([[0, 1], [0, 1]])
    cost = np.tile([0.0, 1.0], (2, 1))
    found = hb.empowerment(
        lamp, 4, states=[0], sensor_at="each step", cost=cost, budget=[1.0, 2.0, 4.0]
    )
    entropy = -(0.25 * np.log2(0.25) + 0.75 * np.log2(0.75))
    np.testing.assert_allclose(found[0], [4 * entropy, 4, 4], atol=2e-6)


def test_a_budget_below_the_cheapest_sequence_names_the_belief():
    lamp = hb.TabularMDP.deterministic([[0, 1], [0, 1]])
    paid, free = np.ones((2, 2)), np.array([[0, 0], [2, 2.0]])
    with pytest.raises(ValueError, match=r"2 actions from states\[1\] costs 2; give at least"):
        hb.empowerment(lamp, 2, states=[0, 1], cost=free, budget=1.5)
    with pytest.raises(ValueError, match=r"2 actions from states\[0\] costs 2; give at least"):
        hb.empowerment(lamp, 2, states=np.full((1, 2), 0.5), cost=paid, budget=1.5)


@pytest.mark.parametrize("within", [{}, {"cost": np.ones((30, 2)), "budget": 9.0}])
def test_what_takes_too_long_is_refused_with_what_fits(within):
    P = np.random.default_rng(0).dirichlet(np.ones(30), size=(30, 2))
    mdp = hb.TabularMDP.stochastic(P, axes="SAS")
    labels = np.arange(30) % 2
    method = hb.Exact(max_seconds=0.05)
    with pytest.raises(ValueError, match=r"takes about .*; the limits are 8 GiB and 0\.05 s, and"):
        hb.empowerment(mdp, 6, labels, sensor_at="each step", method=method, **within)
