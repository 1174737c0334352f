"""Distributions over sequences, against sums over all of them and closed forms."""

from itertools import product

import numpy as np
import pytest

import habilis as hb
from habilis.estimators import ActionBox, simulators
from habilis.estimators.learned.coding import coding_of
from habilis.estimators.learned.features import outcome_features, state_features
from habilis.estimators.sensors import reading

jax = pytest.importorskip("jax")
eqx = pytest.importorskip("equinox")
networks = pytest.importorskip("habilis.estimators.learned.networks")


def stirred(module):
    """A network whose weights are random everywhere, also where they begin as zeros."""
    leaves, tree = jax.tree.flatten(module)
    keys = jax.random.split(jax.random.key(5), len(leaves))
    some = [0.5 * jax.random.normal(k, x.shape) for k, x in zip(keys, leaves, strict=True)]
    return jax.tree.unflatten(tree, some)


def test_probabilities_of_all_sequences_sum_to_one_and_are_how_often_they_are_drawn():
    model = stirred(networks.Symbols((4,), 8, 3, 2, jax.random.key(0)))
    every = np.array(list(product(range(3), repeat=2)), np.int32)
    given = (np.full((9, 1), 2, np.int32),)
    p = np.exp(np.asarray(model.log_prob(given, every), np.float64))
    assert p.sum() == pytest.approx(1, abs=1e-5)
    drawn = np.asarray(model.sample((np.full((20_000, 1), 2, np.int32),), jax.random.key(1)))
    counts = np.bincount(drawn @ [3, 1], minlength=9)
    assert ((counts - 20_000 * p) ** 2 / (20_000 * p)).sum() < 26.1  # chi^2(8), p = 0.001


def test_an_action_depends_on_those_before_it():
    model = stirred(networks.Symbols((4,), 8, 2, 2, jax.random.key(0)))
    every = np.array(list(product(range(2), repeat=2)), np.int32)
    p = np.exp(np.asarray(model.log_prob((np.zeros((4, 1), np.int32),), every))).reshape(2, 2)
    after = p[:, 0] / p.sum(axis=1)
    assert abs(after[0] - after[1]) > 0.01


def test_a_normal_has_the_density_of_its_samples():
    stats = pytest.importorskip("scipy.stats")
    model = stirred(networks.Normal((2,), 8, 3, jax.random.key(0)))
    given = (np.array([[0.3, -1.0]], np.float32),)
    mean, factor, _ = (np.asarray(one, np.float64)[0] for one in model._moments(given))
    x = np.asarray(model.sample(given, jax.random.key(1)))
    expected = stats.multivariate_normal(mean, factor @ factor.T).logpdf(x[0])
    assert float(model.log_prob(given, x)[0]) == pytest.approx(expected, abs=1e-3)


def test_a_power_is_kept_in_every_state():
    model = stirred(networks.Normal((2,), 8, 3, jax.random.key(0), 5.0))
    given = (np.array([[0.3, -1.0], [2.0, 0.1]], np.float32),)
    mean, factor, _ = model._moments(given)
    spent = (np.asarray(mean) ** 2).sum(axis=1) + (np.asarray(factor) ** 2).sum(axis=(1, 2))
    assert spent == pytest.approx([5.0, 5.0], rel=1e-4)


def test_few_sequences_are_symbols_and_many_are_actions_in_turn():
    actions = np.arange(4.0)[:, None]
    one = coding_of(actions, 3, None)
    assert (one.symbols, one.length) == (64, 1)
    decoded = one.sequences(np.arange(64)[:, None])
    assert np.array_equal(decoded[:, :, 0], list(product(range(4), repeat=3)))
    many = coding_of(actions, 9, None)
    assert (many.symbols, many.length) == (4, 9)
    assert np.array_equal(many.sequences(np.array([[3] * 9]))[0, :, 0], [3] * 9)


def test_numbers_of_a_box_are_inside_it():
    box = ActionBox([-1.0, 0.0], [1.0, 5.0])
    coding = coding_of(box, 2, None)
    assert coding.length == 4
    found = coding.sequences(np.array([[-50.0, -50.0, 50.0, 0.0]], np.float32))
    assert found[0] == pytest.approx(np.array([[-1.0, 0.0], [1.0, 2.5]]))


def test_states_and_outcomes_of_a_table_are_told_apart():
    mdp = hb.tabulate(hb.load_world("yard"))
    simulator = simulators.FiniteSimulator(mdp)
    starts = simulator.random_states(500, np.random.default_rng(0))
    features = state_features(simulator, starts)
    rows = features.of(starts)
    assert rows.dtype == np.int32
    assert rows.max() < features.size < 1000  # cells, not states
    assert len(np.unique(rows, axis=0)) == len(np.unique(starts))
    shown = reading(simulator, "object")
    cells = np.asarray(shown(starts), float)
    outcomes = outcome_features(simulator, shown, "object", features, starts, cells)
    found = outcomes.of((starts, cells))
    assert outcomes.size == len(np.unique(mdp.factor("object")))
    assert len(np.unique(found)) == len(np.unique(cells))


def test_numbers_are_scaled_and_a_change_is_seen_apart():
    ball = simulators.ball_in_box()
    starts = ball.random_states(400, np.random.default_rng(0))
    ends = starts + np.random.default_rng(1).normal(0, 0.001, starts.shape)
    shown = reading(ball, "state")
    features = state_features(ball, starts)
    assert features.of(starts).std(axis=0) == pytest.approx(np.ones(4), abs=1e-3)
    outcomes = outcome_features(ball, shown, "state", features, starts, ends)
    found = outcomes.of((starts, ends))
    assert outcomes.size == 8
    assert found[:, 4:].std(axis=0) == pytest.approx(np.ones(4), abs=1e-2)
