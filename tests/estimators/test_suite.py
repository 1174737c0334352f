"""The truths of the suite, against brute force and closed forms of their own."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy.optimize import minimize

import habilis as hb
from habilis.estimators import case_names
from habilis.estimators.evaluation import continuous_cases, finite_cases
from habilis.estimators.simulators import JaxSimulator


def test_there_are_at_least_fourteen_cases_of_every_sort():
    names = case_names()
    assert len(names) == len(set(names)) >= 14
    assert {"maze", "yard-object", "yard-slips-object", "frozen-lake"} <= set(names)
    assert {"channels-256", "lake-effective", "gauss-4", "trough"} <= set(names)


def test_the_maze_is_klyubins():
    (case,) = hb.suite(["maze"])
    mdp = case.simulator.mdp  # pyright: ignore[reportAttributeAccessIssue]
    walls = [cell for cell in range(100) for a in range(4) if mdp.next_state[cell, a] == cell]
    assert len(walls) == 40 + 2 * 22  # the outer wall, and both sides of those within
    shown = case.bits.reshape(10, 10)
    assert np.isclose(shown.min(), np.log2(11))
    assert np.isclose(shown.max(), np.log2(46))


def test_frozen_lake_is_gymnasiums():
    gymnasium = pytest.importorskip("gymnasium")
    theirs = hb.TabularMDP.from_gymnasium(gymnasium.make("FrozenLake-v1"))
    ours = finite_cases.frozen_lake()
    for action in range(4):
        assert abs(theirs.transition(action) - ours.transition(action)).max() < 1e-7


def test_a_truth_of_a_slippery_world_is_the_capacity_of_all_its_sequences():
    (case,) = hb.suite(["frozen-lake"])
    mdp = case.simulator.mdp  # pyright: ignore[reportAttributeAccessIssue]
    P = [mdp.transition(action).toarray() for action in range(4)]
    for state in (0, 6, 10):
        rows = [np.eye(16)[state] @ P[a] @ P[b] @ P[c] for a, b, c in product(range(4), repeat=3)]
        assert case.bits[state] == pytest.approx(hb.capacity(rows, 1e-9).bits, abs=1e-6)


def test_a_truth_of_effective_empowerment_is_the_information_of_the_first_action():
    (case,) = hb.suite(["lake-effective"])
    mdp = case.simulator.mdp  # pyright: ignore[reportAttributeAccessIssue]
    P = np.stack([mdp.transition(action).toarray() for action in range(4)])
    ends = P @ P.mean(axis=0)  # [a, s, s'']
    for state in range(16):
        given, seen = ends[:, state], ends[:, state].mean(axis=0)
        terms = np.where(
            given > 0,
            given * np.log2(np.where(given > 0, given, 1) / np.where(seen > 0, seen, 1)),
            0,
        )
        assert case.bits[state] == pytest.approx(terms.sum() / 4, abs=1e-6)


def test_binary_channels_are_one_minus_their_entropy():
    (case,) = hb.suite(["channels-2"])
    p = np.linspace(0, 0.5, 11)[1:]
    entropy = -p * np.log2(p) - (1 - p) * np.log2(1 - p)
    assert case.bits == pytest.approx([1.0, *(1 - entropy)], abs=1e-6)


def test_a_gaussian_truth_is_the_best_of_all_covariances():
    A, B, N = np.array([[0.8, 0.3], [-0.1, 0.9]]), np.array([[1.0], [0.4]]), 0.3 * np.eye(2)
    power = 2.0
    G = np.concatenate([A @ B, B], axis=1)
    V = N @ N.T + A @ N @ N.T @ A.T

    def bits(entries: np.ndarray) -> float:
        root = np.array([[entries[0], 0], [entries[1], entries[2]]])
        covariance = root @ root.T
        covariance *= power / np.trace(covariance)
        whole = np.eye(2) + np.linalg.solve(V, G @ covariance @ G.T)
        return -np.log2(np.linalg.det(whole)) / 2

    best = -min(minimize(bits, start).fun for start in ([1, 0, 1], [1, 1, 0.1], [0.1, -1, 1]))
    found = continuous_cases.linear_bits(A, B, N, [0, 1], 2, power)
    assert found == pytest.approx(best, abs=1e-6)


def test_the_gaussian_estimator_finds_the_gaussian_truths():
    pytest.importorskip("jax")
    for case in hb.suite(["gauss-1", "gauss-2", "gauss-4"]):
        assert case.power is not None
        found = hb.Gaussian(case.power, 0.0).fit(case.simulator, case.horizon, case.sensor)
        assert found.kind == "exact"
        assert found.bits(case.states) == pytest.approx(case.bits, abs=1e-6)


def test_a_line_is_within_its_error_of_the_known_capacity_of_an_amplitude():
    # Smith (1971): up to an amplitude of about 1.67 standard deviations two inputs are best.
    half = 1.2
    bits, gap = continuous_cases.line_bits(
        lambda state, action: 0 * state + action, 1.0, half, 1, np.zeros(1), (-half, half)
    )
    y = np.linspace(-12, 12, 200_001)
    two = (np.exp(-((y - half) ** 2) / 2) + np.exp(-((y + half) ** 2) / 2)) / np.sqrt(8 * np.pi)
    entropy = -(two * np.log2(np.maximum(two, 1e-300))).sum() * (y[1] - y[0])
    assert bits[0] == pytest.approx(entropy - np.log2(2 * np.pi * np.e) / 2, abs=1e-4 + gap[0])


def test_a_finer_line_stays_within_the_error():
    pytest.importorskip("jax")
    (case,) = hb.suite(["wall"])
    some = slice(0, 12, 5)
    finer, gap = continuous_cases.line_bits(
        continuous_cases._walled, 0.1, 0.5, 1, case.states[some, 0], (-1.0, 1.0), (33, 700)
    )
    assert (case.error < 0.01).all()
    assert (finer >= case.bits[some] - 1e-6).all()  # every action of the coarse grid is there
    assert (finer <= case.bits[some] + case.error[some] + 1e-6).all()
    assert (gap <= case.error[some] + 1e-6).all()


def test_rounded_truths_count_all_sequences():
    jnp = pytest.importorskip("jax.numpy")
    line = JaxSimulator(lambda state, action: state + action, [[-1.0], [0.4], [1.0]])
    ends = {sum(s) for s in product((-1.0, 0.4, 1.0), repeat=3)}
    cells = {round(end / 0.5) for end in ends}
    found = continuous_cases.counted_bits(
        line, 3, lambda seen: jnp.round(seen / 0.5), np.zeros((1, 1))
    )
    assert found == pytest.approx(np.log2([len(cells)]))


def test_truths_are_the_same_when_they_come_from_the_disk():
    first, second = (hb.suite(["maze-slips"])[0] for _ in range(2))
    assert np.array_equal(first.bits, second.bits)
    assert np.array_equal(first.states, second.states)
    assert (first.error < 1e-6).all()


def test_an_unknown_case_is_refused():
    with pytest.raises(ValueError, match="case 'amaze' is unknown; use maze, "):
        hb.suite(["amaze"])


def test_all_cases_hold_together():
    pytest.importorskip("jax")
    for case in hb.suite():
        assert case.states.shape == (len(case.bits), case.states.shape[1])
        assert case.error.shape == case.bits.shape
        assert (case.error >= 0).all()
        assert (case.error < 0.05).all()
        assert (case.bits >= 0).all()
        assert case.about
        assert case.target == ("effective" if "effective" in case.name else "capacity")
        assert replace(case, name="copy").bits is case.bits
