"""A sensor may depend on the last action: what is observed after it, in the state it led to."""

from itertools import product

import numpy as np
import pytest
from available import as_probabilities, random_probabilities, random_table
from hypothesis import given, settings
from hypothesis import strategies as st

import habilis as hb
from habilis.analysis.futures import futures
from habilis.empowerment.horizons import empowerment_by_horizon
from habilis.empowerment.tabular.persistence import persistence
from habilis.mdp import TabularMDP
from habilis.rewards.cached_tables import kept_empowerment

CLOSE = 3e-6
SEEDS = st.integers(0, 2**31 - 1)


def random_case(seed: int) -> tuple[np.ndarray, np.ndarray, list[int] | None, list[int]]:
    """Probabilities of a table, a sensor float[A, S, O], and a choice of actions."""
    rng = np.random.default_rng(seed)
    P = as_probabilities(random_table(rng)) if rng.random() < 0.5 else random_probabilities(rng)
    states, actions, _ = P.shape
    shape, seen = (actions, states), int(rng.integers(1, 5))
    if rng.random() < 0.3:
        sensor = np.eye(seen)[rng.integers(seen, size=shape)]
    else:
        sensor = rng.dirichlet(np.full(seen, 0.5), shape)
    if rng.random() < 0.5:
        return P, sensor, None, list(range(actions))
    chosen = sorted(set(rng.integers(actions, size=2).tolist()))
    return P, sensor, chosen, chosen


def observed(
    P: np.ndarray, sensor: np.ndarray, state: int, horizon: int, actions: list[int]
) -> dict[tuple[int, ...], np.ndarray]:
    """The distribution of the observation after every sequence that can surely be carried out."""
    found = {}
    for sequence in product(actions, repeat=horizon):
        belief, sure = np.eye(len(P))[state], True
        for action in sequence:
            sure &= bool(P[belief > 0, action].any(axis=1).all())
            belief = belief @ P[:, action]
        if sure:
            found[sequence] = belief @ sensor[sequence[-1]]
    return found


def capacity_of(channel: dict[tuple[int, ...], np.ndarray]) -> float:
    """Bits, 0 without inputs; less than the true value by no more than a millionth."""
    return hb.capacity(np.array(list(channel.values()))).bits if channel else 0.0


@settings(max_examples=50, deadline=None)
@given(SEEDS, st.integers(1, 4))
def test_the_true_value_lies_in_the_certificate(seed: int, horizon: int):
    P, sensor, given, used = random_case(seed)
    mdp = TabularMDP.stochastic(P)
    bits, gap = hb.empowerment(mdp, horizon, sensor, given, return_gap=True)
    method = hb.Sampled(samples=20, seed=seed)
    low, wide = hb.empowerment(mdp, horizon, sensor, given, return_gap=True, method=method)
    assert (gap <= 1e-6).all()
    for state in range(len(P)):
        channel = observed(P, sensor, state, horizon, used)
        true = capacity_of(channel)
        assert bits[state] <= true + CLOSE
        assert true <= bits[state] + gap[state] + 1e-9
        assert low[state] <= true + CLOSE
        assert true <= low[state] + wide[state] + 1e-9
        if not channel:
            assert bits[state] == gap[state] == low[state] == 0
    some = np.random.default_rng(seed).integers(len(P), size=2)
    assert np.array_equal(hb.empowerment(mdp, horizon, sensor, given, some), bits[some])


@settings(max_examples=30, deadline=None)
@given(SEEDS, st.integers(1, 4))
def test_many_samples_reach_the_value_of_few_sequences(seed: int, horizon: int):
    P, sensor, given, _ = random_case(seed)
    mdp = TabularMDP.stochastic(P)
    exact = hb.empowerment(mdp, horizon, sensor, given)
    low = hb.empowerment(mdp, horizon, sensor, given, method=hb.Sampled(samples=3000))
    assert np.allclose(low, exact, atol=CLOSE)


@settings(max_examples=30, deadline=None)
@given(SEEDS, st.integers(0, 4))
def test_a_sensor_equal_for_all_actions_gives_the_value_of_that_one(seed: int, horizon: int):
    P, sensor, given, _ = random_case(seed)
    mdp, one = TabularMDP.stochastic(P), sensor[0]
    same = np.broadcast_to(one, sensor.shape)
    by_action = hb.empowerment(mdp, horizon, same, given)
    assert np.allclose(by_action, hb.empowerment(mdp, horizon, one, given), atol=CLOSE)


@settings(max_examples=30, deadline=None)
@given(SEEDS, st.integers(65, 200))
def test_long_horizons_are_those_of_the_table_of_last_actions_and_states(seed: int, horizon: int):
    rng = np.random.default_rng(seed)
    table = random_table(rng)
    states, actions = table.shape
    labels = rng.integers(3, size=(actions, states))
    # A state s of the table after action a is state a * S + s of the larger one.
    led = np.where(table >= 0, np.arange(actions) * states + table, -1)
    larger = TabularMDP.deterministic(np.concatenate([led] * actions))
    expected = hb.empowerment(larger, horizon, labels.ravel(), states=np.arange(states))
    mdp = TabularMDP.deterministic(table)
    assert np.allclose(hb.empowerment(mdp, horizon, np.eye(3)[labels]), expected, atol=1e-9)


@settings(max_examples=40, deadline=None)
@given(SEEDS, st.integers(0, 3))
def test_futures_end_with_the_action_that_shows_the_observation(seed: int, horizon: int):
    P, sensor, given, used = random_case(seed)
    mdp = TabularMDP.stochastic(P)
    found = futures(mdp, 0, horizon, sensor, given)
    assert found.sequences.shape[1] == horizon
    channel = observed(P, sensor, 0, horizon, used) if horizon else {}
    for sequence, row in zip(found.sequences.tolist(), found.channel, strict=True):
        assert not horizon or np.allclose(row, channel[tuple(sequence)][found.observations])
    assert found.empowerment == pytest.approx(capacity_of(channel), abs=CLOSE)


def test_only_looking_tells_the_states_apart():
    # Action 0 flips the state, 1 leaves it; only after 1 is it seen.
    mdp = TabularMDP.deterministic([[1, 0], [0, 1]])
    sensor = np.array([np.full((2, 2), 0.5), np.eye(2)])
    assert hb.empowerment(mdp, 0, sensor).tolist() == [0, 0]
    noise = hb.capacity([[0.5, 0.5], [1, 0]]).bits
    assert np.allclose(hb.empowerment(mdp, 1, sensor), noise, atol=1e-6)
    assert np.allclose(hb.empowerment(mdp, 2, sensor), 1, atol=1e-6)
    assert np.allclose(hb.empowerment(mdp, 2, sensor, actions=[0]), 0)
    assert np.allclose(hb.empowerment(mdp, 1000, sensor, unit="nats"), np.log(2), atol=1e-6)
    rows = empowerment_by_horizon(mdp, 2, sensor)
    assert np.allclose(rows, [[0, 0], [noise, noise], [1, 1]], atol=1e-6)


def test_kept_values_are_those_of_their_sensor(tmp_path):
    mdp = TabularMDP.deterministic([[1, 0], [0, 1]])
    first = np.array([np.full((2, 2), 0.5), np.eye(2)])
    for sensor in (first, first[::-1], first):
        kept = kept_empowerment(mdp, 1, sensor, folder=tmp_path)
        assert np.array_equal(kept, hb.empowerment(mdp, 1, sensor))
    assert len(list(tmp_path.iterdir())) == 2


def test_too_many_beliefs_are_refused_with_the_horizon_that_fits():
    rng = np.random.default_rng(0)
    P = rng.dirichlet(np.ones(30), (30, 4))
    mdp, sensor = TabularMDP.stochastic(P), rng.dirichlet(np.ones(5), (4, 30))
    with pytest.raises(ValueError, match="largest horizon that fits"):
        hb.empowerment(mdp, 40, sensor, method=hb.Exact(max_seconds=5))
    with pytest.raises(ValueError, match="largest horizon that fits"):
        hb.empowerment(mdp, 5, sensor, states=[0], method=hb.Exact(max_gib=1e-5))


@pytest.mark.parametrize(
    ("sensor", "reason"),
    [
        (np.ones((3, 2, 1)), r"\(3, 2, 1\); give .* here \(2, 3, observations\), as \.swapaxes"),
        (np.ones((2, 2, 1)), r"has shape \(2, 2, 1\); give \[actions, states, observations\]"),
        (np.ones((2, 3, 0)), "give probabilities of shape"),
        (np.ones((2, 3, 2)), "sensor, action 0, state 0 sums to 2; divide each row by its sum"),
        (np.array([np.eye(3), -np.eye(3)]), "sensor, action 1, state 0, column 0 is -1"),
        (np.full((2, 3, 2), np.nan), "probabilities are from 0 to 1"),
        (np.ones((1, 2, 3, 4)), "give one integer label"),
        (np.full((2, 3, 2), "a"), "give probabilities of shape"),
    ],
)
def test_a_sensor_that_is_none_is_refused(sensor: np.ndarray, reason: str):
    mdp = TabularMDP.deterministic([[1, 2], [2, 0], [0, 0]])
    with pytest.raises(ValueError, match=reason):
        hb.empowerment(mdp, 2, sensor)
    with pytest.raises(ValueError, match="the sensor is noisy"):
        persistence(mdp, np.ones((2, 3, 1)))
