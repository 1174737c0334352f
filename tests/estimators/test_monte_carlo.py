"""Sampled channels against exact ones and against channels that are discretised finely."""

from typing import Any

import gymnasium
import numpy as np
import pytest

import habilis as hb
from habilis.estimators import simulators

STEPS = np.linspace(-1, 1, 5)[:, None]


def shifted(noise, actions=STEPS):
    """s' = s + a + noise."""
    return simulators.linear_system([[1.0]], [[1.0]], noise=[[noise]], actions=actions)


def capacity_of_shifts(shifts, deviation):
    """The capacity of shifts in Gaussian noise, from a fine grid of outcomes."""
    x = np.linspace(shifts.min() - 8 * deviation, shifts.max() + 8 * deviation, 3001)
    P = np.exp(-(((x - shifts.reshape(-1, 1)) / deviation) ** 2) / 2)
    return hb.capacity(P / P.sum(axis=1, keepdims=True)).bits


def test_labels_of_a_noisy_table_give_its_empowerment():
    lake = hb.TabularMDP.from_gymnasium(gymnasium.make("FrozenLake-v1"))
    states = [0, 6, 14]
    exact = hb.empowerment(lake, 2, states=states)
    errors = []
    for samples in (300, 3000):
        method = hb.MonteCarlo(sequences=16, samples=samples)
        errors.append(hb.empowerment(lake, 2, states=states, method=method) - exact)
    assert (np.abs(errors[1]) < 0.02).all()
    assert errors[0].mean() > errors[1].mean() > 0  # few samples make it too large


@pytest.mark.parametrize("outcomes", ["gaussian", "kernel"])
def test_densities_give_the_capacity_of_shifts_in_noise(outcomes: Any):
    truth = capacity_of_shifts(STEPS, 0.5)
    method = hb.MonteCarlo(sequences=5, samples=300, outcomes=outcomes)
    found = [method.fit(shifted(0.5), 1, seed=seed).bits([[2.0]])[0] for seed in range(4)]
    assert np.mean(found) == pytest.approx(truth, abs=0.04)
    assert method.fit(shifted(0.5), 1).kind == "asymptotically exact"


def test_what_a_sensor_adds_is_noise_too():
    quiet = simulators.linear_system([[1.0]], [[1.0]], actions=STEPS)
    method = hb.MonteCarlo(sequences=25, samples=1000, noise=0.5)
    fitted = method.fit(quiet, 2)
    ends = np.add.outer(STEPS, STEPS)
    assert fitted.kind == "asymptotically exact"
    assert fitted.bits([[0.0]]) == pytest.approx(capacity_of_shifts(ends, 0.5), abs=0.02)


def test_outcomes_that_may_not_be_gaussian_are_an_approximation():
    pendulum = simulators.pendulum(noise=0.5)
    assert hb.MonteCarlo().fit(pendulum, 2).kind == "approximation"
    assert hb.MonteCarlo(outcomes="kernel").fit(pendulum, 2).kind == "asymptotically exact"


def test_it_cannot_tell_more_than_its_sequences_apart():
    quiet = simulators.double_integrator()
    for sequences in (1, 7):
        fitted = hb.MonteCarlo(sequences, noise=1e-9).fit(quiet, 4)
        assert fitted.bits([[0, 0]]) == pytest.approx(np.log2(sequences), abs=1e-9)


def test_other_units_change_nothing():
    noisy = simulators.double_integrator(noise=0.5)
    for outcomes in ("gaussian", "kernel"):
        method = hb.MonteCarlo(8, 50, outcomes)
        wide, narrow = (
            method.fit(noisy, 3, lambda seen, scale=scale: seen * np.array([scale]))
            for scale in ([1.0, 1.0], [1e3, 1e-3])
        )
        assert wide.bits([[0.1, 0.2]]) == pytest.approx(narrow.bits([[0.1, 0.2]]), abs=1e-6)


def test_the_same_seed_gives_the_same_numbers_whatever_else_is_asked():
    ball = simulators.ball_in_box(noise=0.2)
    states = ball.random_states(3, np.random.default_rng(0))
    method = hb.MonteCarlo(6, 20)
    fitted = method.fit(ball, 2, seed=3)
    together = fitted.bits(states)
    assert np.array_equal(together, np.concatenate([fitted.bits(one[None]) for one in states]))
    assert np.array_equal(together, method.fit(ball, 2, seed=3).bits(states))
    assert not np.array_equal(together, method.fit(ball, 2, seed=4).bits(states))


def test_nothing_can_be_done_in_no_time():
    assert hb.MonteCarlo().fit(shifted(1.0), 0).bits([[1.0]]) == 0


@pytest.mark.ill_typed
def test_wrong_arguments_are_refused_in_one_line():
    with pytest.raises(ValueError, match="sequences is 0"):
        hb.MonteCarlo(sequences=0)
    with pytest.raises(ValueError, match="samples is 0"):
        hb.MonteCarlo(samples=0)
    odd: Any = "histogram"
    with pytest.raises(
        ValueError, match="outcomes 'histogram' is unknown; use one of auto, labels"
    ):
        hb.MonteCarlo(outcomes=odd)
    with pytest.raises(ValueError, match="noise is -1"):
        hb.MonteCarlo(noise=-1)
    with pytest.raises(ValueError, match="tolerance is 0"):
        hb.MonteCarlo(tolerance=0)
    with pytest.raises(ValueError, match="said to be labels"):
        hb.MonteCarlo(outcomes="labels").fit(shifted(1.0), 1).bits([[0.0]])
    with pytest.raises(ValueError, match="singular"):
        hb.MonteCarlo().fit(simulators.pendulum(), 2).bits([[0, 0]])
    with pytest.raises(ValueError, match="action box is unbounded"):
        hb.MonteCarlo().fit(simulators.linear_system([[1.0]], [[1.0]]), 1)
    with pytest.raises(ValueError, match="horizon is 2000000000"):
        hb.MonteCarlo().fit(shifted(1.0), 2 * 10**9)
