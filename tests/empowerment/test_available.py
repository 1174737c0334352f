"""Empowerment ranges over the sequences that can surely be carried out, and no others."""

from typing import Any

import numpy as np
import pytest
from available import (
    as_probabilities,
    channel_of_sure_sequences,
    random_probabilities,
    random_table,
    sure_sequences,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from slow_channels import blahut_arimoto

import habilis as hb
from habilis.analysis.futures import futures
from habilis.analysis.influence import latency
from habilis.empowerment.horizons import empowerment_by_horizon
from habilis.empowerment.tabular.persistence import persistence
from habilis.mdp import TabularMDP

CLOSE = 3e-6
SEEDS = st.integers(0, 2**32 - 1)


def capacity_of(channel: np.ndarray) -> float:
    """Bits, 0 without inputs."""
    return blahut_arimoto(np.unique(channel, axis=0), gap=2e-6) if len(channel) else 0.0


def any_sensor(rng: np.random.Generator, states: int) -> tuple[Any, np.ndarray]:
    """A sensor of any kind, and the same as a matrix."""
    kind = rng.integers(3)
    if kind == 0:
        return "state", np.eye(states)
    if kind == 1:
        labels = rng.integers(3, size=states)
        return labels, np.eye(3)[labels]
    noisy = rng.dirichlet(np.full(int(rng.integers(1, 5)), 0.5), states)
    return noisy, noisy


def any_actions(rng: np.random.Generator, count: int) -> tuple[list[int] | None, list[int]]:
    """A choice of actions, and which these are."""
    if rng.random() < 0.5:
        return None, list(range(count))
    chosen = sorted(set(rng.integers(count, size=2).tolist()))
    return chosen, chosen


@settings(max_examples=150, deadline=None)
@given(SEEDS, st.integers(0, 4))
def test_counts_are_of_complete_sequences_of_available_actions(seed: int, horizon: int):
    rng = np.random.default_rng(seed)
    table = random_table(rng)
    labels = rng.integers(3, size=len(table))
    given, used = any_actions(rng, table.shape[1])
    mdp, P = TabularMDP.deterministic(table), as_probabilities(table)
    for sensor, shown in (("state", np.arange(len(table))), (labels, labels)):
        bits, gap = hb.empowerment(mdp, horizon, sensor, given, return_gap=True)
        expected = []
        for state in range(len(table)):
            last = [int(b.argmax()) for _, b in sure_sequences(P, state, horizon, used)]
            expected.append(np.log2(max(len(set(shown[last])), 1)))
        assert np.allclose(bits, expected, atol=1e-12)
        assert not gap.any()
        some = rng.integers(len(table), size=3)
        assert np.array_equal(hb.empowerment(mdp, horizon, sensor, given, states=some), bits[some])
        rows = empowerment_by_horizon(mdp, horizon, sensor, given)
        assert np.allclose(rows[-1], expected, atol=1e-12)


@settings(max_examples=100, deadline=None)
@given(SEEDS, st.integers(0, 4), st.booleans())
def test_the_true_value_lies_in_the_certificate(seed: int, horizon: int, certain: bool):
    rng = np.random.default_rng(seed)
    P = as_probabilities(random_table(rng)) if certain else random_probabilities(rng)
    sensor, matrix = any_sensor(rng, len(P))
    given, used = any_actions(rng, P.shape[1])
    mdp = TabularMDP.stochastic(P)
    bits, gap = hb.empowerment(mdp, horizon, sensor, given, return_gap=True)
    low, wide = hb.empowerment(
        mdp, horizon, sensor, given, return_gap=True, method=hb.Sampled(samples=20)
    )
    assert (gap <= 1e-6).all()
    for state in range(len(P)):
        channel = channel_of_sure_sequences(P, matrix, state, horizon, used)
        true = capacity_of(channel)
        assert bits[state] <= true + CLOSE
        assert true <= bits[state] + gap[state] + 1e-9
        assert low[state] <= true + CLOSE
        assert true <= low[state] + wide[state] + 1e-9
        if not len(channel):
            assert bits[state] == gap[state] == low[state] == 0


@settings(max_examples=50, deadline=None)
@given(SEEDS, st.integers(0, 3))
def test_futures_are_sequences_that_can_surely_be_carried_out(seed: int, horizon: int):
    rng = np.random.default_rng(seed)
    P = random_probabilities(rng) if rng.random() < 0.5 else as_probabilities(random_table(rng))
    mdp, state = TabularMDP.stochastic(P), int(rng.integers(len(P)))
    given, used = any_actions(rng, P.shape[1])
    found = futures(mdp, state, horizon, actions=given)
    sure = dict(sure_sequences(P, state, horizon, used))
    assert found.sequences.shape == (len(found.probability), horizon)
    assert len(found.sequences) == 0 if not sure else found.probability.sum() == pytest.approx(1)
    for sequence, row in zip(found.sequences.tolist(), found.channel, strict=True):
        assert np.allclose(row, sure[tuple(sequence)][found.observations], atol=1e-9)
    assert len(found.seen) == len(found.observations)


def test_large_sets_of_labels_are_counted_forward_just_so():
    rng = np.random.default_rng(3)
    states = 5000  # more labels than are packed
    table = rng.integers(states, size=(states, 3))
    table[rng.random(table.shape) < 0.4] = -1
    mdp, some = TabularMDP.deterministic(table), [0, 1, 17, 4999]
    P_of = {s: {int(t) for t in table[s] if t >= 0} for s in range(states)}
    for horizon in (0, 1, 2, 6):
        bits = hb.empowerment(mdp, horizon, states=some)
        for value, start in zip(bits, some, strict=True):
            here = {start}
            for _ in range(horizon):
                here = set().union(*(P_of[s] for s in here)) if here else set()
            assert value == np.log2(max(len(here), 1))


def test_a_dead_end_counts_for_its_own_horizon_alone():
    # From 0 to 1, 2 or 3; 3 is a dead end; 1 and 2 stay where they are.
    mdp = TabularMDP.deterministic([[1, 2, 3], [1, -1, -1], [-1, 2, -1], [-1, -1, -1]])
    assert np.allclose(hb.empowerment(mdp, 1), [np.log2(3), 0, 0, 0])
    assert np.allclose(hb.empowerment(mdp, 2), [1, 0, 0, 0])
    assert np.allclose(hb.empowerment(mdp, 50), [1, 0, 0, 0])
    assert np.allclose(hb.empowerment(mdp, 2, actions=[2]), 0)
    assert latency(mdp, 3, "state").tolist() == [1, np.inf, np.inf, np.inf]


@settings(max_examples=30, deadline=None)
@given(SEEDS, st.integers(65, 300))
def test_long_horizons_through_noisy_sensors_are_those_of_the_labels(seed: int, horizon: int):
    rng = np.random.default_rng(seed)
    mdp = TabularMDP.deterministic(random_table(rng))
    labels = rng.integers(3, size=mdp.states)
    through_labels = hb.empowerment(mdp, horizon, labels)
    assert np.allclose(hb.empowerment(mdp, horizon, np.eye(3)[labels]), through_labels, atol=1e-9)


def test_an_action_that_may_come_to_be_unavailable_is_not_sure():
    # Action 1 leads to 1 or 2 alike; in 2 only action 0 is available: after it, 1 is not sure.
    P = np.zeros((3, 2, 3))
    P[0, 0, 0] = 1
    P[0, 1, 1:] = 0.5
    P[1] = np.eye(3)[[0, 1]]
    P[2, 0, 0] = 1
    bits = hb.empowerment(TabularMDP.stochastic(P), 2)
    surely = [P[0, 0] @ P[:, 0], P[0, 0] @ P[:, 1], P[0, 1] @ P[:, 0]]
    assert len(list(sure_sequences(P, 0, 2, [0, 1]))) == 3
    assert bits[0] == pytest.approx(capacity_of(np.array(surely)), abs=CLOSE)
    assert bits[0] == pytest.approx(1, abs=CLOSE)


def test_what_is_nearly_impossible_still_decides_what_is_available():
    # After both actions nearly the same is believed; but after 1 the dead end 2 is possible.
    P = np.zeros((4, 2, 4))
    P[0, 0, 1] = 1
    P[0, 1, 1:3] = 1 - 1e-15, 1e-15
    P[1] = np.eye(4)[[1, 3]]
    P[3] = np.eye(4)[[3, 3]]
    for order in ([0, 1], [1, 0]):
        mdp = TabularMDP.stochastic(P[:, order])
        found = futures(mdp, 0, 2)
        assert found.empowerment == pytest.approx(1, abs=1e-6)
        assert set(found.sequences[:, 0].tolist()) == {order.index(0)}


def test_a_possibility_however_small_is_not_forgotten():
    # State 0 is left with probability 0.9 a step, and lacks action 1; state 1 has it, to 2.
    P = np.zeros((3, 2, 3))
    P[0, 0] = 0.1, 0.9, 0
    P[1] = np.eye(3)[[1, 2]]
    P[2] = np.eye(3)[[2, 2]]
    mdp, horizon = TabularMDP.stochastic(P), 400  # 0.1 ** 400 is 0 in float64
    bits, gap = hb.empowerment(mdp, horizon, return_gap=True)
    assert bits[0] == gap[0] == 0
    assert bits[1] == 1
    assert hb.empowerment(mdp, horizon, method=hb.Sampled(samples=5))[0] == 0


@settings(max_examples=60, deadline=None)
@given(SEEDS)
def test_persistence_goes_by_the_cycles_that_are_available(seed: int):
    rng = np.random.default_rng(seed)
    table = random_table(rng)
    labels = rng.integers(3, size=len(table))
    reach = np.eye(len(table), dtype=bool)
    for _ in range(len(table)):
        for state, action in np.argwhere(table >= 0):
            reach[state] |= reach[table[state, action]]
    both = reach & reach.T
    counts = np.array([len(set(labels[row])) for row in both])
    expected = [np.log2(counts[row].max()) for row in reach]
    assert np.allclose(persistence(TabularMDP.deterministic(table), labels), expected)


@pytest.mark.parametrize("horizon", [3, 12])
def test_limits_are_estimated_where_nothing_can_be_done(horizon: int):
    # Many states, noisy: costs are estimated before the start. No action anywhere but in 0.
    states = 200
    P = np.zeros((states, 4, states))
    P[0] = np.random.default_rng(0).dirichlet(np.ones(states), 4)
    bits, gap = hb.empowerment(TabularMDP.stochastic(P), horizon, return_gap=True)
    assert not bits.any()
    assert not gap.any()


def test_a_table_whose_actions_are_nowhere_available_has_no_empowerment():
    mdp = TabularMDP.deterministic([[-1, -1], [-1, -1]])
    each: list[dict[str, Any]] = [{}, {"sensor": np.eye(2)}, {"method": hb.Sampled()}]
    for options in each:
        for horizon in (0, 1, 5):
            bits, gap = hb.empowerment(mdp, horizon, return_gap=True, **options)
            assert bits.tolist() == gap.tolist() == [0, 0]
    assert futures(mdp, 0, 2).sequences.shape == (0, 2)
    assert persistence(mdp, "state").tolist() == [0, 0]
