"""A capacity is what theory says, and its certificate holds whatever the channel."""

import re
import sys
import warnings
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import LinearConstraint, minimize
from scipy.sparse import coo_array, csr_array, csr_matrix, eye_array
from slow_channels import blahut_arimoto, divergences

import habilis as hb
from habilis.channels.capacity import Capacity, ConvergenceWarning, merge_rows


def entropy(*probabilities: float) -> float:
    return -sum(p * np.log2(p) for p in probabilities if p > 0)


def holds(found: Capacity, P: np.ndarray, tolerance: float = 1e-6) -> None:
    """Checks a certificate by the definitions alone."""
    p = found.input_distribution
    assert p.shape == (len(P),)
    assert (p >= 0).all()
    assert p.sum() == pytest.approx(1, abs=1e-12)
    # D(P_x || q) bounds the capacity for every q: where p gives an output nothing at all, though
    # some input may cause it once in a billion times, that of p would bound it by infinity.
    each = divergences(P, np.maximum(p @ P, np.finfo(np.float64).tiny))
    assert found.bits == pytest.approx(p[p > 0] @ each[p > 0], abs=1e-12)
    assert found.gap >= each.max() - found.bits - 1e-15
    assert 0 <= found.gap <= tolerance


@st.composite
def channels(draw: st.DrawFn) -> np.ndarray:
    """Random channels: smooth or sparse, with rows and columns alike, unused or nearly so."""
    inputs, outputs = draw(st.integers(1, 12)), draw(st.integers(1, 9))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    P = rng.dirichlet(np.full(outputs, draw(st.sampled_from([0.1, 1.0, 20.0]))), inputs)
    if draw(st.booleans()):
        P = np.where(rng.random(P.shape) < 0.5, 0, P)
        P[np.arange(inputs), rng.integers(outputs, size=inputs)] += 0.1
    if draw(st.booleans()):
        P = P[rng.integers(inputs, size=inputs)]
    if draw(st.booleans()):
        P = P[:, rng.integers(outputs, size=outputs)]
        P = np.where(P.sum(axis=1, keepdims=True) > 0, P, 1.0)
    return P / P.sum(axis=1, keepdims=True)


# Closed forms

CLOSED_FORMS: dict[str, tuple[Any, float]] = {
    "binary symmetric": ([[0.9, 0.1], [0.1, 0.9]], 1 - entropy(0.1, 0.9)),
    "binary symmetric, hardly a channel": (
        [[0.501, 0.499], [0.499, 0.501]],
        1 - entropy(0.501, 0.499),
    ),
    "binary erasure": ([[0.7, 0.3, 0], [0, 0.3, 0.7]], 0.7),
    "Z": ([[1, 0], [0.5, 0.5]], np.log2(1.25)),
    "Z, flipping with 0.1": (
        [[1, 0], [0.1, 0.9]],
        np.log2(1 + 0.9 * 0.1 ** (0.1 / 0.9)),
    ),
    "noisy typewriter": ((np.eye(26) + np.roll(np.eye(26), 1, axis=1)) / 2, np.log2(13)),
    "5-ary symmetric": (
        np.full((5, 5), 0.05) + 0.75 * np.eye(5),
        np.log2(5) - entropy(0.8, *[0.05] * 4),
    ),
    "noiseless": (np.eye(7), np.log2(7)),
    "noiseless, several inputs an output": (np.eye(3)[[0, 1, 1, 2, 2, 2]], np.log2(3)),
    "useless": (np.tile([0.2, 0.3, 0.5], (4, 1)), 0.0),
    "two channels side by side": (
        [[0.9, 0.1, 0, 0], [0.1, 0.9, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
        np.log2(2 ** (1 - entropy(0.1, 0.9)) + 2),
    ),
    "one input": ([[0.3, 0.7]], 0.0),
    "one output": ([[1.0], [1.0]], 0.0),
    "an output that never comes": ([[1, 0, 0], [0, 0, 1]], 1.0),
}


@pytest.mark.parametrize("name", CLOSED_FORMS)
def test_a_capacity_is_its_closed_form(name: str):
    P, bits = CLOSED_FORMS[name]
    found = hb.capacity(P)
    holds(found, np.asarray(P, float))
    assert found.bits <= bits + 1e-12
    assert found.bits + found.gap >= bits - 1e-12


def test_one_useful_pair_is_found_among_thousands_of_inputs():
    P = np.tile(np.full(50, 0.02), (5000, 1))
    P[7], P[4321] = np.eye(50)[0], np.eye(50)[1]
    found = hb.capacity(P)
    holds(found, P)
    # Like a Z channel: C = -log q(0), and the uniform input attains it too.
    bits = np.log2(2 + 2 ** (-entropy(0.02, 0.02, 0.96) / 0.96))
    assert found.bits <= bits + 1e-12 <= found.bits + found.gap + 2e-12


def test_the_useful_pair_is_found_when_no_two_inputs_are_alike():
    P = np.full((5000, 50), 0.02) + np.random.default_rng(0).uniform(0, 1e-4, (5000, 50))
    P[7], P[4321] = np.eye(50)[0], np.eye(50)[1]
    P /= P.sum(axis=1, keepdims=True)
    found = hb.capacity(P)
    holds(found, P)
    assert (found.input_distribution[[7, 4321]] > 0.3).all()


# Against others


def test_an_output_that_only_unused_inputs_cause_and_hardly_ever_leaves_the_certificate_finite():
    rare, even = 4.179e-09, 0.120189008
    P = np.array(
        [
            [rare, 1 - 2 * (rare + even), even, rare, even],
            [0, 1, 0, 0, 0],
            [0, 0.105256396, 0.447371802, 0, 0.447371802],
            [0, 3.05535367e-04, 0.4998472323165, 0, 0.4998472323165],
        ]
    )
    found = hb.capacity(P)
    assert (found.input_distribution @ P)[[0, 3]].max() < 1e-15
    holds(found, P)
    assert blahut_arimoto(P) <= found.bits + found.gap + 1e-9


@settings(max_examples=150, deadline=None)
@given(channels())
def test_the_certificate_holds_and_blahut_and_arimoto_agree(P: np.ndarray):
    found = hb.capacity(P)
    holds(found, P)
    slow = blahut_arimoto(P, gap=1e-5)
    assert found.bits - 1e-9 <= slow + 1e-5
    assert slow <= found.bits + found.gap + 1e-9


@pytest.mark.parametrize("seed", range(8))
def test_a_general_convex_solver_agrees(seed: int):
    rng = np.random.default_rng(seed)
    P = rng.dirichlet(np.full(5, [0.3, 1.0][seed % 2]), 6)

    def negative(p: np.ndarray) -> float:
        q = np.maximum(p @ P, 1e-300)
        return -float(p @ divergences(P, q))

    solved = minimize(
        negative,
        np.full(6, 1 / 6),
        method="SLSQP",
        bounds=[(0, 1)] * 6,
        constraints=LinearConstraint(np.ones((1, 6)), 1, 1),
        options={"ftol": 1e-14, "maxiter": 1000},
    )
    assert hb.capacity(P).bits == pytest.approx(-solved.fun, abs=2e-6)


@pytest.mark.parametrize(("inputs", "outputs"), [(64, 64), (300, 40), (40, 300)])
@pytest.mark.parametrize("alpha", [1, 0.05])
def test_large_random_channels_reach_the_tolerance(inputs: int, outputs: int, alpha: float):
    P = np.random.default_rng(3).dirichlet(np.full(outputs, alpha), inputs)
    for tolerance in (1e-3, 1e-6, 1e-9):
        holds(hb.capacity(P, tolerance), P, tolerance)


# What must not matter


@settings(max_examples=60, deadline=None)
@given(channels(), st.randoms(use_true_random=False))
def test_order_and_copies_of_inputs_and_outputs_do_not_matter(P: np.ndarray, random):
    rows, columns = list(range(len(P))), list(range(P.shape[1]))
    random.shuffle(rows)
    random.shuffle(columns)
    assert hb.capacity(P[rows + rows[:2]][:, columns]).bits == pytest.approx(
        hb.capacity(P).bits, abs=1e-6
    )
    halved = np.concatenate([P / 2, P / 2], axis=1)
    assert hb.capacity(halved).bits == pytest.approx(hb.capacity(P).bits, abs=1e-6)


@settings(max_examples=60, deadline=None)
@given(channels())
def test_sparse_channels_are_as_dense_ones(P: np.ndarray):
    dense = hb.capacity(P)
    for kind in (csr_array, coo_array, csr_matrix):
        sparse = hb.capacity(kind(P))
        assert sparse.bits == dense.bits
        assert np.array_equal(sparse.input_distribution, dense.input_distribution)


def test_a_sparse_channel_may_be_far_too_large_to_be_dense():
    found = hb.capacity(eye_array(200_000))
    assert found.bits == pytest.approx(np.log2(200_000), abs=1e-9)
    assert found.gap <= 1e-6


@settings(max_examples=60, deadline=None)
@given(channels(), channels())
def test_noise_after_a_channel_never_helps(P: np.ndarray, Q: np.ndarray):
    size = min(P.shape[1], len(Q))
    P = P[:, :size] + 1e-3
    P /= P.sum(axis=1, keepdims=True)
    assert hb.capacity(P @ Q[:size]).bits <= hb.capacity(P).bits + 1e-6


# Edges


def test_probabilities_next_to_nothing_do_no_harm():
    for tiny in (1e-300, 5e-324, 1e-17):
        for P in (
            [[1 - tiny, tiny], [0, 1]],
            [[tiny, 1], [1, 0], [0.5, 0.5]],
            [[tiny, 1, 0], [0, 1, 0], [0, 1 - tiny, tiny]],
        ):
            found = hb.capacity(P)
            assert 0 <= found.gap <= 1e-6
            assert found.bits == pytest.approx(1 if len(P[0]) == 2 else 0, abs=1e-5)


def test_nearly_identical_inputs_do_no_harm():
    P = np.tile(np.random.default_rng(0).dirichlet(np.ones(20)), (30, 1))
    P += np.random.default_rng(1).uniform(0, 1e-13, P.shape)
    P /= P.sum(axis=1, keepdims=True)
    found = hb.capacity(P)
    assert found.bits == pytest.approx(0, abs=1e-9)
    assert found.gap <= 1e-6


def test_single_precision_may_miss_one_by_its_own_rounding():
    P = np.random.default_rng(0).dirichlet(np.ones(50), 20).astype(np.float32)
    holds(hb.capacity(P), P.astype(float) / P.astype(float).sum(axis=1, keepdims=True))


def test_a_gap_above_the_tolerance_is_named_in_a_warning():
    P = np.random.default_rng(0).dirichlet(np.ones(30), 30)
    with pytest.warns(ConvergenceWarning, match="the gap is .* bits, above the tolerance of 1e-18"):
        found = hb.capacity(P, tolerance=1e-18)
    assert 0 < found.gap < 1e-9


def test_the_certificate_exposes_a_solver_that_gets_nowhere(monkeypatch: pytest.MonkeyPatch):
    from habilis.channels import capacity_solver as optimum

    monkeypatch.setattr(optimum, "newton", lambda part, entropy, inputs, tolerance: inputs * 0 + 1)
    monkeypatch.setattr(optimum, "_ROUNDS", 1)
    P = np.array([[0.9, 0.1], [0.3, 0.7], [0.5, 0.5]])
    with pytest.warns(ConvergenceWarning):
        found = hb.capacity(P)
    assert found.bits + found.gap >= blahut_arimoto(P)
    assert found.bits <= blahut_arimoto(P) + 1e-7


def test_the_certificate_exposes_inputs_merged_by_mistake(monkeypatch: pytest.MonkeyPatch):
    def all_alike(matrix, add=False):
        return matrix[[0]], np.zeros(matrix.shape[0], np.int64), np.array([0])

    def merged(matrix, add=False):
        return merge_rows(matrix, add) if add else all_alike(matrix)

    # The package's `capacity` is the function, so the module is not an attribute of it.
    monkeypatch.setattr(sys.modules["habilis.channels.capacity"], "merge_rows", merged)
    with pytest.warns(ConvergenceWarning):
        found = hb.capacity([[1, 0], [0.5, 0.5]])
    assert found.bits < np.log2(1.25) <= found.bits + found.gap


def test_no_warning_where_the_tolerance_is_reached():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        hb.capacity([[0.9, 0.1], [0.1, 0.9]], tolerance=1e-12)


# What is refused


@pytest.mark.parametrize(
    ("P", "message"),
    [
        ([], "P has shape (0,)"),
        ([[]], "P has shape (1, 0)"),
        (0.5, "P has shape ()"),
        ([0.5, 0.5], "P has shape (2,)"),
        ([[[1.0]]], "P has shape (1, 1, 1)"),
        ([["a"]], "give probabilities of shape [rows, columns]"),
        ([[1j]], "give probabilities of shape [rows, columns]"),
        ([[0.5, 0.5], [1.0]], "P is ragged"),
        ([[1.0, 0.0], [0.5, 0.4]], "P, row 1 sums to 0.9; divide each row by its sum"),
        ([[1.0, 0.0], [0.0, 0.0]], "P, row 1 sums to 0"),
        ([[1.5, -0.5]], "P, row 0, column 1 is -0.5; probabilities are from 0 to 1"),
        ([[1.0, 0.0], [np.nan, 1.0]], "P, row 1, column 0 is nan"),
        ([[np.inf, 0.0]], "P, row 0, column 0 is inf"),
        (csr_array([[1.0, 0.0], [0.5, 0.4]]), "P, row 1 sums to 0.9"),
        (csr_array((0, 3)), "P has shape (0, 3)"),
    ],
)
def test_what_is_no_channel_is_refused(P: Any, message: str):
    with pytest.raises(ValueError, match=re.escape(message)):
        hb.capacity(P)


@pytest.mark.parametrize("shape", [(2, 2), (2, 5), (5, 2), (1, 3)])
def test_a_channel_whose_columns_sum_to_one_is_to_be_transposed(shape: tuple[int, int]):
    P = np.random.default_rng(0).dirichlet(np.ones(shape[1]), shape[0])
    message = r"^P, row 0 sums to \S+, but every column to 1: rows are inputs; transpose it$"
    for transposed in (P.T, P.T.astype(np.float32), csr_array(P.T), P.T.tolist()):
        with pytest.raises(ValueError, match=message):
            hb.capacity(transposed)
    assert hb.capacity(P).bits >= 0
    with pytest.raises(ValueError, match="divide each row by its sum"):
        hb.capacity(P.T * 0.9)


@pytest.mark.parametrize("tolerance", [0, -1e-6, np.nan, np.inf, "1e-6", None, True])
@pytest.mark.ill_typed
def test_a_tolerance_that_is_no_number_above_zero_is_refused(tolerance: Any):
    with pytest.raises(ValueError, match="give a number of bits above 0"):
        hb.capacity([[1.0]], tolerance)


def test_the_matrix_given_is_left_alone():
    P = csr_array(np.array([[0.5, 0.5], [0.25, 0.75]]))
    before = P.toarray()
    hb.capacity(P)
    assert np.array_equal(P.toarray(), before)
