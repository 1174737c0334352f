"""Capacities of channels that are never written out, against those that are."""

import threading
import time
from typing import Any

import numpy as np
import pytest
from available import channel_of_sure_sequences, random_probabilities
from hypothesis import given, settings
from hypothesis import strategies as st
from slow_channels import blahut_arimoto, divergences

import habilis as hb
from habilis.channels.capacity_solver import newton
from habilis.channels.small_channels import inputs_of_few_outputs
from habilis.empowerment.tabular import beliefs, column_generation, stochastic
from habilis.empowerment.tabular.column_generation import (
    capacity_of,
    certified,
    generated,
    is_written_out,
    sequences_from,
)
from habilis.empowerment.tabular.last_actions import LANES, LastActions, side_by_side
from habilis.empowerment.tabular.open_loop import exact, problem_of
from habilis.mdp import TabularMDP

SEEDS = st.integers(0, 2**32 - 1)
CLOSE = 3e-6  # our gap and that of the slow capacity


@pytest.fixture(params=["merged", "followed"])
def merging(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Beliefs are merged up to the last action, or hardly at all."""
    if request.param == "followed":
        monkeypatch.setattr(beliefs, "ENOUGH", 1)
        monkeypatch.setattr(beliefs, "FEWER", 0.0)
    return request.param


def problem(P: np.ndarray, horizon: int, sensor: Any = "state", tolerance: float = 1e-6) -> Any:
    mdp = TabularMDP.stochastic(P)
    return problem_of(mdp, horizon, sensor, np.arange(P.shape[1]), tolerance)


def noisy_table(states: int, actions: int, seed: int) -> np.ndarray:
    """Every action may lead to three states, one of them the likeliest."""
    rng = np.random.default_rng(seed)
    P = np.zeros((states, actions, states))
    for s, a in np.ndindex(states, actions):
        P[s, a, rng.choice(states, 3, replace=False)] = [0.8, 0.15, 0.05]
    return P


@pytest.mark.parametrize("permuted", [False, True])
def test_what_the_last_action_shows_is_the_product_with_the_sensor(permuted: bool):
    """An identity is left out of it; labels in another order are no identity."""
    P = noisy_table(9, 3, seed=0)
    labels = np.random.default_rng(0).permutation(9) if permuted else np.arange(9)
    found = problem(P, 2, labels).last.toarray()
    np.testing.assert_array_equal(found, (P @ np.eye(9)[labels]).reshape(27, 9))


@settings(max_examples=25, deadline=None)
@given(SEEDS, st.integers(1, 4), st.booleans())
def test_every_sequence_is_followed_to_its_observations(seed: int, horizon: int, noisy: bool):
    rng = np.random.default_rng(seed)
    P = random_probabilities(rng)
    seen = rng.dirichlet(np.full(3, 0.5), len(P)) if noisy else np.eye(len(P))
    start, actions = int(rng.integers(len(P))), P.shape[1]
    for enough in (0, 2**18):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(beliefs, "ENOUGH", enough)
            patch.setattr(beliefs, "FEWER", 0.7 if enough else 0.0)
            sequences, _ = sequences_from(problem(P, horizon, seen), start)
        expected = channel_of_sure_sequences(P, seen, start, horizon, list(range(actions)))
        numbers, likeliest = sequences.neg_entropies()
        sure = np.flatnonzero(numbers > -np.inf)
        rows = sequences.rows(sure)
        assert as_set(rows) == as_set(expected)
        if not len(sure):
            continue
        terms = np.where(rows > 0, rows * np.log(np.maximum(rows, 1e-300)), 0).sum(axis=1)
        assert np.allclose(numbers[sure], terms, rtol=0, atol=1e-14)
        q = rng.dirichlet(np.ones(rows.shape[1]))
        found = sequences.divergences(numbers, np.log(q))
        assert np.allclose(found[sure], divergences(rows, q) * np.log(2), rtol=0, atol=1e-12)
        assert (found[np.setdiff1d(np.arange(len(numbers)), sure)] == -np.inf).all()
        if len(sure) == len(numbers):
            assert np.allclose(np.diag(sequences.rows(likeliest)), rows.max(axis=0), atol=1e-14)


def as_set(rows: np.ndarray) -> set[tuple[float, ...]]:
    """Distinct rows, without the observations that are never made."""
    rounded = np.round(rows, 9) + 0.0
    return {tuple(row[row > 0].tolist()) for row in rounded}


def test_logarithms_are_right_to_the_last_digits_from_the_least_to_one():
    x = np.concatenate([[0.0, 1.0, 0.5, 5e-324], 2.0 ** np.linspace(-1073, 0, 10_000)])
    x = np.concatenate([x, np.nextafter(1, 0) - np.linspace(0, 1e-9, 99), np.sqrt([0.5]), [0.75]])
    there = np.arange(2), np.zeros(1, np.int32), np.ones(1)
    alone = LastActions(side_by_side(x[:, None]), len(x), 1, 1, *there, *there, 1, True)
    expected = np.where(x > 0, x * np.log(np.where(x > 0, x, 1)), 0)
    numbers, likeliest = alone.neg_entropies()
    assert (np.abs(numbers - expected) <= 5e-16 * (x + np.abs(expected)) + 1e-300).all()
    assert numbers[1] == 0
    assert x[likeliest[0]] == 1


@pytest.mark.parametrize("horizon", [2, 5])
def test_a_certificate_holds_the_capacity_of_the_channel_written_out(merging: str, horizon: int):
    P = noisy_table(12, 3, horizon)
    for tolerance in (1e-1, 1e-3, 1e-8):
        asked = problem(P, horizon, tolerance=tolerance)
        for start in range(0, 12, 5):
            true = exact(problem(P, horizon, tolerance=1e-10), start)[1]
            bits, gap = generated(asked, start)
            assert bits <= true.bits + true.gap + 1e-12
            assert true.bits <= bits + gap + 1e-12
            assert gap <= tolerance


def test_a_gap_includes_what_rounding_and_merging_can_do():
    """Both bounds are the same number here: without noise in them the gap would be 0."""
    P = np.array([[[0.9, 0.1], [0.1, 0.9]]] * 2)
    asked = problem(P, 1, tolerance=0)
    sequences, merged = sequences_from(asked, 0)
    bits, gap = capacity_of(sequences, sequences.neg_entropies(), 0.0, 0.0)
    assert abs(bits - (1 + 0.9 * np.log2(0.9) + 0.1 * np.log2(0.1))) <= gap
    assert 1e-14 < gap < 1e-12
    assert merged > 0
    assert generated(asked, 0) == (bits, gap + merged)


@pytest.mark.parametrize("horizon", [3, 4])
def test_capacities_are_those_of_all_sequences_whatever_is_merged(merging: str, horizon: int):
    rng = np.random.default_rng(horizon)
    for seed in range(6):
        P = random_probabilities(np.random.default_rng(seed))
        sensor = rng.dirichlet(np.full(3, 0.5), len(P))
        matrix = channel_of_sure_sequences(P, sensor, 0, horizon, list(range(P.shape[1])))
        bits, gap = generated(problem(P, horizon, sensor), 0)
        true = blahut_arimoto(np.unique(matrix, axis=0), gap=2e-6) if len(matrix) else 0.0
        assert bits <= true + CLOSE
        assert true <= bits + gap + 1e-9


def test_sequences_are_added_until_none_does_better(monkeypatch: pytest.MonkeyPatch):
    P = noisy_table(9, 3, 0)
    expected = exact(problem(P, 5), 0)[1].bits
    monkeypatch.setattr(column_generation, "_ALL", 0)
    monkeypatch.setattr(column_generation, "_ADDED", 0)  # but for one in a round
    bits, gap = generated(problem(P, 5), 0)
    assert gap <= 1e-6
    assert bits == pytest.approx(expected, abs=2e-6)


def test_many_observations_are_left_to_blas(monkeypatch: pytest.MonkeyPatch):
    P = noisy_table(9, 3, 1)
    with_loops = generated(problem(P, 4), 0)
    monkeypatch.setattr(column_generation, "MOST_OUTPUTS", 3)
    monkeypatch.setattr(column_generation, "inputs_of_few_outputs", None)
    assert generated(problem(P, 4), 0)[0] == pytest.approx(with_loops[0], abs=2e-6)


@settings(max_examples=40, deadline=None)
@given(st.integers(2, 40), st.integers(2, 12), SEEDS)
def test_both_ways_of_newton_attain_the_same(rows: int, columns: int, seed: int):
    rng = np.random.default_rng(seed)
    P = rng.dirichlet(np.full(columns, 0.3), rows)
    entropy = np.where(P > 0, P * np.log(np.maximum(P, 1e-300)), 0).sum(axis=1)
    given = rng.dirichlet(np.ones(rows))
    for solve in (newton, inputs_of_few_outputs):
        inputs = solve(P, entropy, given, 1e-8)
        each = entropy - P @ np.log(np.maximum(inputs @ P, 1e-300))
        assert inputs.min() >= 0
        assert inputs.sum() == pytest.approx(1)
        assert each.max() - inputs @ each <= 1e-7


def test_inputs_that_are_the_best_at_once_stay_so():
    P = np.array([[0.9, 0.1], [0.1, 0.9]])
    entropy = (P * np.log(P)).sum(axis=1)
    for solve in (newton, inputs_of_few_outputs):
        assert solve(P, entropy, np.full(2, 0.5), 0.0) == pytest.approx([0.5, 0.5])


def test_values_are_the_same_to_the_bit_for_any_number_of_threads(merging: str):
    mdp = TabularMDP.stochastic(noisy_table(20, 4, 2))
    one = hb.empowerment(mdp, 5, method=hb.Exact(threads=1), return_gap=True)
    for threads in (2, 3, None):
        several = hb.empowerment(mdp, 5, method=hb.Exact(threads=threads), return_gap=True)
        assert np.array_equal(one, several)
    for state in (0, 13):
        alone = hb.empowerment(mdp, 5, states=[state], return_gap=True)
        assert np.array_equal(np.array(alone)[:, 0], np.array(one)[:, state])


def test_states_are_shared_out_among_threads(monkeypatch: pytest.MonkeyPatch):
    both, names = threading.Barrier(2, timeout=60), set()

    def spy(*asked: Any) -> tuple[float, float]:
        names.add(threading.get_ident())
        both.wait()  # passes only if two threads are at work
        return 0.0, 0.0

    monkeypatch.setattr(stochastic, "certified", spy)
    mdp = TabularMDP.stochastic(noisy_table(6, 2, 0))
    hb.empowerment(mdp, 2, method=hb.Exact(threads=2))
    assert len(names) == 2


def test_who_interrupts_does_not_wait_for_all_states(monkeypatch: pytest.MonkeyPatch):
    done: list[int] = []

    def slow(asked: Any, start: int) -> tuple[float, float]:
        time.sleep(0.01)
        done.append(start)
        return 0.0, 0.0

    def stop(done: int, known: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(stochastic, "certified", slow)
    asked = problem(noisy_table(200, 2, 0), 2)
    with pytest.raises(KeyboardInterrupt):
        stochastic.certified_bits(asked, np.arange(200), 2, hb.Exact().limits, stop)
    assert len(done) < 200


def test_beliefs_fill_blocks_in_their_order():
    matrix = np.random.default_rng(0).random((LANES + 3, 5))
    blocks = side_by_side(matrix)
    assert blocks.shape == (2, 5, LANES)
    assert np.array_equal(blocks.transpose(0, 2, 1).reshape(-1, 5)[: len(matrix)], matrix)
    assert not blocks[1, :, 3:].any()


def test_memory_does_not_grow_with_the_beliefs_of_the_last_actions():
    asked = problem(noisy_table(30, 4, 0), 9)
    sequences, _ = sequences_from(asked, 0)
    assert sequences.remaining > 1
    assert sequences.blocks.size <= beliefs.ENOUGH * 4


def test_few_sequences_are_written_out():
    """So that nothing is compiled for them; both ways have certificates of one capacity."""
    P = noisy_table(12, 3, seed=1)
    for horizon, few in ((5, True), (6, False)):  # 243 and 729 sequences
        asked = problem(P, horizon)
        assert is_written_out(asked) is few
        bits, gap = certified(asked, 0)
        generated_bits, generated_gap = generated(asked, 0)
        assert bits <= generated_bits + generated_gap
        assert generated_bits <= bits + gap
    answer = exact(problem(P, 5), 0)[1]
    assert certified(problem(P, 5), 0) == (answer.bits, answer.gap)
