"""Empowerment within a budget: beside lists of sequences and closed forms, and refusals."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

import habilis as hb
from habilis.empowerment.budget import capacity_within

DETERMINISTIC = hb.TabularMDP.deterministic([[(s - 1) % 5, (s + 1) % 5, s] for s in range(5)])
STEPS = np.tile([1.0, 1.0, 0.0], (5, 1))


def entropy_within(costs, budget):
    """The largest entropy, in bits, at a mean cost of at most the budget: a Gibbs distribution."""
    costs = np.array(costs) - min(costs)

    def weights(price):
        raised = np.exp(-price * costs)
        return raised / raised.sum()

    spare = budget
    if costs.mean() <= spare:
        return np.log2(len(costs))
    price = brentq(lambda one: weights(one) @ costs - spare, 0, 200)
    p = weights(price)
    return float(-(p * np.log2(np.maximum(p, 1e-300))).sum())


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 10_000), st.integers(1, 4), st.floats(0.01, 3))
def test_without_noise_it_is_the_entropy_of_the_cheapest_ways(seed, horizon, above):
    rng = np.random.default_rng(seed)
    table, cost = rng.integers(5, size=(5, 2)), rng.integers(0, 4, size=(5, 2)) * 0.5
    least = {}
    for sequence in product(range(2), repeat=horizon):
        state, paid = 0, 0.0
        for action in sequence:
            paid, state = paid + cost[state, action], table[state, action]
        least[state] = min(least.get(state, np.inf), paid)
    budget = min(least.values()) + above
    found = hb.empowerment(
        hb.TabularMDP.deterministic(table), horizon, states=[0], cost=cost, budget=budget
    )
    assert found[0] == pytest.approx(entropy_within(list(least.values()), above), abs=2e-6)


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 10_000), st.floats(0, 1))
def test_of_two_inputs_it_is_the_best_mixture_that_the_budget_allows(seed, budget):
    P = np.random.default_rng(seed).dirichlet(np.ones(3), size=2)
    nats, gap = capacity_within(P, np.array([0.0, 1.0]), budget, 1e-9)
    share = np.linspace(0, budget, 4001)[:, None]
    mixed = (1 - share) * P[0] + share * P[1]
    entropies = -(P * np.log(P)).sum(axis=1)
    information = -(mixed * np.log(mixed)).sum(axis=1) - (
        (1 - share[:, 0]) * entropies[0] + share[:, 0] * entropies[1]
    )
    assert nats <= information.max() + 1e-6
    assert information.max() <= nats + gap + 1e-12
    assert gap < 1e-7


@settings(deadline=None, max_examples=15)
@given(st.integers(0, 10_000), st.integers(1, 3))
def test_the_curve_rises_bends_down_and_ends_at_plain_empowerment(seed, horizon):
    rng = np.random.default_rng(seed)
    P = rng.dirichlet(np.full(4, 0.5), size=(4, 2))
    mdp = hb.TabularMDP.stochastic(P, axes="SAS")
    cost = rng.random((4, 2))
    cost[:, 0] = 0  # one action is free
    budgets = np.linspace(0, cost.max() * horizon, 6)
    curve, gap = hb.empowerment(
        mdp, horizon, states=[0], cost=cost, budget=budgets, return_gap=True
    )
    assert (np.diff(curve[0]) >= -2e-6).all()
    assert (np.diff(curve[0], n=2) <= 4e-6).all()
    assert curve[0, -1] == pytest.approx(hb.empowerment(mdp, horizon, states=[0])[0], abs=2e-6)
    assert (gap <= 1e-6).all()


def test_one_budget_is_a_number_a_state_and_several_a_curve():
    one = hb.empowerment(DETERMINISTIC, 2, cost=STEPS, budget=1)
    several = hb.empowerment(DETERMINISTIC, 2, cost=STEPS, budget=[1, np.inf])
    assert one.shape == (5,)
    assert several.shape == (5, 2)
    np.testing.assert_allclose(several[:, 0], one)
    np.testing.assert_allclose(several[:, 1], np.log2(5))


def test_with_the_least_budget_only_the_cheapest_sequences_are_left():
    assert hb.empowerment(DETERMINISTIC, 2, states=[0], cost=STEPS, budget=0)[0] == pytest.approx(0)


def test_costs_are_means_over_the_states_that_are_reached():
    P = np.zeros((3, 2, 3))
    P[0, :, 1:] = 0.5
    P[1:] = np.eye(3)[1:, None]
    cost = np.array([[0, 0], [4, 4], [2, 2]])  # of the second action 3 in the mean
    mdp = hb.TabularMDP.stochastic(P, axes="SAS")
    with pytest.raises(
        ValueError, match=r"cheapest sequence of 2 actions from states\[0\] costs 3;"
    ):
        hb.empowerment(mdp, 2, states=[0], cost=cost, budget=2.5)
    assert hb.empowerment(mdp, 2, states=[0], cost=cost, budget=3) == pytest.approx(0)


@pytest.mark.ill_typed
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"budget": 1}, "budget is given without cost; give both, or neither"),
        ({"cost": STEPS}, "cost is given without budget; give both, or neither"),
        ({"cost": STEPS, "budget": "much"}, "budget is 'much'; give a number, or a sequence"),
        ({"cost": STEPS, "budget": [1, np.nan]}, "give a number, or a sequence of numbers"),
        ({"cost": STEPS[:2], "budget": 1}, r"cost has shape \(2, 3\) and type float64; give"),
        ({"cost": -STEPS, "budget": 1}, "cost has -1 for action 0 in state 0; give finite"),
        ({"cost": STEPS, "budget": 1, "sensor": "state + state"}, "several; with a budget give"),
        (
            {"cost": STEPS + 1, "budget": 1},
            r"cheapest sequence of 2 actions from states\[0\] costs 2",
        ),
        ({"cost": STEPS, "budget": 1, "method": hb.Sampled()}, "a budget needs every sequence"),
    ],
)
def test_what_it_refuses(arguments, message):
    with pytest.raises(ValueError, match=message):
        hb.empowerment(DETERMINISTIC, 2, **arguments)


def test_a_budget_that_only_rounding_puts_below_the_cheapest_sequence_is_enough():
    tenth = np.full((5, 3), 0.1)  # three of them are a little more than 0.3
    plain = hb.empowerment(DETERMINISTIC, 3, states=[0])
    found = hb.empowerment(DETERMINISTIC, 3, states=[0], cost=tenth, budget=[0.3, 0.30001])
    np.testing.assert_allclose(found[0], plain[0], atol=1e-6)
    with pytest.raises(ValueError, match=r"budget is 0.2999999, .* costs 0.3;"):
        hb.empowerment(DETERMINISTIC, 3, states=[0], cost=tenth, budget=0.2999999)
