"""Array arguments are read as given, or refused."""

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import polars as pl
import pytest
from scipy.sparse import csr_array

import habilis as hb
from habilis.analysis.data_frames import to_dataframe
from habilis.analysis.futures import futures
from habilis.empowerment.horizons import empowerment_by_horizon
from habilis.empowerment.tabular.persistence import persistence
from habilis.envs.functional import FunctionalEnv
from habilis.envs.table import TableEnv
from habilis.envs.vector import TableVectorEnv
from habilis.rewards.cached_tables import kept_empowerment
from habilis.rewards.shaping import Bonus

RING = hb.TabularMDP.deterministic([[1, 3], [2, 0], [3, 1], [0, 2]])
WORLD = hb.World.parse("AP.CG\n.....\n")
TABLE = hb.tabulate(WORLD)
EVEN = TABLE.factor("object") % 2 == 0
P = np.eye(4)[RING.next_state]

SENSED: dict[str, Callable[[Any], Any]] = {
    "empowerment": lambda s: hb.empowerment(TABLE, 2, s),
    "of some states": lambda s: hb.empowerment(TABLE, 2, s, states=[0, 5, 9]),
    "noisy": lambda s: hb.empowerment(TABLE.slippery(0.2), 2, s, states=[0, 5, 9]),
    "sampled": lambda s: hb.empowerment(TABLE, 2, s, method=hb.Sampled(samples=9)),
    "kept": lambda s: kept_empowerment(TABLE, 2, s),
    "landscape": lambda s: hb.landscape(WORLD, 2, s).values,
    "by horizon": lambda s: empowerment_by_horizon(TABLE, 2, s),
    "persistence": lambda s: persistence(TABLE, s),
    "futures": lambda s: futures(TABLE, TABLE.start, 2, s).seen,
    "functional": lambda s: _bits(FunctionalEnv(WORLD).with_empowerment(2, s, 0.1)),
    "reward": lambda s: hb.EmpowermentReward(TableEnv(TABLE), 2, s, 0.1).reset(seed=0)[1][
        "empowerment"
    ],
}


@pytest.mark.parametrize("what", SENSED)
@pytest.mark.parametrize(
    "given", [EVEN, EVEN.tolist(), pl.Series(EVEN)], ids=["array", "list", "pl"]
)
def test_a_boolean_sensor_is_one_of_two_labels(what: str, given: Any):
    np.testing.assert_array_equal(SENSED[what](given), SENSED[what](EVEN.astype(int)))


def test_a_boolean_sensor_gives_what_can_be_counted():
    bits = hb.empowerment(RING, 1, [True, False, True, True])
    assert bits.tolist() == [1, 0, 1, 0]  # from 0 to 1 or 3, from 1 to 2 or 0, and so on


def _bits(env: FunctionalEnv) -> np.ndarray:
    reward = env.default_params.empowerment
    assert reward is not None
    return np.asarray(reward.bits)


MASK = {
    "next_state": lambda m: hb.TabularMDP.deterministic(m(RING.next_state)),
    "P": lambda m: hb.TabularMDP.stochastic(m(P)),
    "reward": lambda m: hb.TabularMDP.deterministic(RING.next_state, m(np.ones((4, 2)))),
    "terminal": lambda m: hb.TabularMDP.deterministic(RING.next_state, None, m(np.zeros(4, bool))),
    "sensor": lambda m: hb.empowerment(RING, 1, m(np.arange(4))),
    "a noisy sensor": lambda m: hb.empowerment(RING, 1, m(np.eye(4))),
    "a kept sensor": lambda m: kept_empowerment(RING, 1, m(np.arange(4))),
    "states": lambda m: hb.empowerment(RING, 1, states=m(np.arange(4))),
    "states as bool": lambda m: hb.empowerment(RING, 1, states=m(np.ones(4, bool))),
    "actions": lambda m: hb.empowerment(RING, 1, "state", m(np.arange(2))),
    "a channel": lambda m: hb.capacity(m(np.eye(3))).bits,
    "values": lambda m: to_dataframe(RING, m(np.ones(4))),
    "actions of environments": lambda m: _stepped(m(np.zeros(3, int))),
}


def _stepped(actions: Any) -> Any:
    envs = TableVectorEnv(RING, 3)
    envs.reset(seed=0)
    return envs.step(actions)


def _masked(values: np.ndarray) -> np.ma.MaskedArray:
    mask = np.zeros(values.shape, bool)
    mask.flat[-1] = True
    return np.ma.masked_array(values, mask)


@pytest.mark.parametrize("what", MASK)
def test_a_masked_entry_is_refused_and_a_mask_of_nothing_is_none(what: str):
    for masked in (_masked, lambda values: list(_masked(values))):
        with pytest.raises(
            ValueError, match=r"masked entries; fill them with \.filled\(value\)"
        ) as caught:
            MASK[what](masked)
        assert "\n" not in str(caught.value)
        assert ("available=" in str(caught.value)) == (what in ("next_state", "P"))
    MASK[what](np.ma.masked_array)
    MASK[what](lambda values: _masked(values).filled(0) * 0 + values)


LABELS = [
    *([0.0, 1.0, 2.0, 3.0], [0, 1, np.nan, 3], list("abca"), [0, 1, None, 3], [2**70, 1, 2, 3]),
    *(np.array([0, 1, 2, 3], kind) for kind in ("m8[s]", "M8[s]", complex, object)),
    *(pl.Series([0, None, 2, 3]), pl.Series([True, None, False, True]), pl.Series(list("abca"))),
    *(np.zeros(4, [("a", int)]), [[0, 1, 2, 3]], [[0], [1], [2], [3]], {0, 1, 2, 3}, b"abcd", None),
]


@pytest.mark.parametrize("labels", LABELS, ids=repr)
def test_what_is_no_label_for_each_state_is_refused(labels: Any):
    with pytest.raises(ValueError, match="sensor"):
        hb.empowerment(RING, 1, labels)


@pytest.mark.parametrize(
    "labels",
    [
        np.array([2**63, 1, 2, 3], np.uint64),
        np.array([-5, 7, 7, 0], np.int8),
        pl.Series([3, 1, 3, 0]),
        [True, False, False, True],
    ],
    ids=repr,
)
def test_labels_count_by_which_are_equal(labels: Any):
    named = np.unique(np.asarray(labels), return_inverse=True)[1].tolist()
    wanted = [np.log2(len({named[after] for after in row})) for row in RING.next_state]
    assert hb.empowerment(RING, 1, labels).tolist() == wanted


def _as(kind: Any, values: np.ndarray) -> Any:
    return values.astype(kind)


@pytest.mark.parametrize("kind", ["m8[s]", "M8[s]", complex, object, str])
@pytest.mark.ill_typed
def test_what_is_no_number_is_no_table_and_no_channel(kind: Any):
    for what in (
        lambda: hb.TabularMDP.deterministic(RING.next_state.astype(kind)),
        lambda: hb.TabularMDP.stochastic(P.astype(kind)),
        lambda: hb.TabularMDP.deterministic(RING.next_state, np.zeros((4, 2)).astype(kind)),
        lambda: hb.capacity(np.eye(3).astype(kind)),
        lambda: hb.empowerment(RING, 1, "state", _as(kind, np.arange(2))),
        lambda: hb.empowerment(RING, 1, states=np.arange(2).astype(kind)),
    ):
        with pytest.raises(ValueError, match=r"type|not finite"):
            what()


@pytest.mark.parametrize(
    "terminal",
    [
        ["False"] * 4,
        [0, 0.5, 1, 0],
        [0, np.nan, 1, 0],
        [0, 2, 3, 1],
        [None] * 4,
        np.zeros(4, "M8[s]"),
    ],
    ids=repr,
)
def test_ends_are_true_or_false(terminal: Any):
    with pytest.raises(ValueError, match=r"terminal has .* give true or false for each state"):
        hb.TabularMDP.deterministic(RING.next_state, None, terminal)


def test_ends_may_be_zeros_and_ones():
    for terminal in ([0, 1, 1, 0], [0.0, 1.0, 1.0, 0.0], pl.Series([False, True, True, False])):
        mdp = hb.TabularMDP.deterministic(RING.next_state, None, terminal)
        assert mdp.terminal.tolist() == [False, True, True, False]


@pytest.mark.parametrize("error", [TypeError, RuntimeError])
def test_what_cannot_become_an_array_is_refused_in_one_line(error: type[Exception]):
    class Tensor:
        def __array__(self, dtype: Any = None, copy: Any = None) -> np.ndarray:
            raise error("it is on another device")

    with pytest.raises(ValueError, match=r"sensor is not an array \(it is on another device\)"):
        hb.empowerment(RING, 1, Tensor())


@pytest.mark.parametrize("beta", [1e308, -1e31, 10**400])
def test_a_weight_too_large_to_learn_with_is_refused_as_that(beta: float):
    for make in (
        lambda: Bonus(beta=beta),
        lambda: hb.Config(intrinsic="object", horizon=1, beta=beta),
        lambda: hb.EmpowermentReward(TableEnv(TABLE), 1, "object", beta),
        lambda: FunctionalEnv(WORLD).with_empowerment(1, "object", beta),
    ):
        with pytest.raises(ValueError, match=r"beta is .*; give one from -1e\+30 to 1e\+30"):
            make()


@pytest.mark.parametrize("kind", [np.float16, np.float32, np.float64, np.longdouble])
@pytest.mark.ill_typed
def test_a_number_of_numpys_is_a_number(kind: Any):
    half: Any = kind(0.5)
    config = hb.Config(intrinsic="object", horizon=1, beta=half, runs=np.int64(3))  # pyright: ignore[reportArgumentType]
    assert config == hb.Config(intrinsic="object", horizon=1, beta=0.5, runs=3)
    assert type(config.beta) is float
    assert type(config.runs) is int
    assert json.loads(json.dumps(config.as_dict()))["beta"] == 0.5
    assert Bonus(beta=half).numbers(half) == Bonus(beta=0.5).numbers(0.5)
    zero: Any = np.int8(0)
    for slip in (half, zero):
        noisy, wanted = TABLE.slippery(slip), TABLE.slippery(float(slip))
        for action in range(TABLE.action_count):
            difference = noisy.transition(action) - wanted.transition(action)
            assert difference.count_nonzero() == 0
    assert hb.tabulate(WORLD, half).is_stochastic
    assert TableEnv(TABLE, slip=half).mdp.states == TABLE.states
    assert hb.capacity(np.eye(2), half).bits == pytest.approx(1)
    method = hb.Exact(max_gib=half, max_seconds=half, tolerance=half, threads=np.int64(3))  # pyright: ignore[reportArgumentType]
    assert repr(method) == repr(hb.Exact(0.5, 0.5, 0.5, 3))
    assert repr(hb.Sampled(np.int64(3), np.int8(1))) == repr(hb.Sampled(3, 1))  # pyright: ignore[reportArgumentType]
    assert hb.empowerment(RING, 1, method=method).tolist() == hb.empowerment(RING, 1).tolist()


@pytest.mark.parametrize("slip", [np.bool_(True), np.float32("nan"), np.float32(1.5), 0.5j, "0.5"])
@pytest.mark.ill_typed
def test_what_is_no_probability_is_no_slip(slip: Any):
    for make in (lambda: TABLE.slippery(slip), lambda: TableEnv(TABLE, slip=slip)):
        with pytest.raises(ValueError, match="give a probability from 0 to 1"):
            make()


@pytest.mark.parametrize("kind", [int, bool])
def test_labels_in_a_column_are_refused_with_the_shape_that_they_must_have(kind: Any):
    for labels in (np.arange(4)[:, None], np.arange(3)[:, None]):
        with pytest.raises(ValueError, match=r"give labels of shape \(4,\)"):
            hb.empowerment(RING, 1, labels.astype(kind))


@pytest.mark.ill_typed
def test_what_holds_matrices_and_is_no_list_is_refused_as_that():
    eyes = [csr_array(np.eye(2)), csr_array(np.eye(2))]
    boxed = np.empty(2, object)
    boxed[:] = eyes
    refused: list[tuple[Any, str]] = [
        ((eye for eye in eyes), r"P is a generator; give a list, as list\(P\)"),
        (iter(eyes), r"P is a list_iterator; give a list"),
        (boxed, r"P is an array of sparse matrices; give a list of them, as P\.tolist\(\)"),
        ({0: eyes[0]}, r"P is a dict; give an array \[states, actions, states\]"),
    ]
    for given, says in refused:
        with pytest.raises(ValueError, match=says):
            hb.TabularMDP.stochastic(given)
    assert hb.TabularMDP.stochastic(boxed.tolist()).action_count == 2
    with pytest.raises(ValueError, match=r"next_state is a generator; give a list"):
        hb.TabularMDP.deterministic(row for row in [[0]])  # pyright: ignore[reportArgumentType]
    with pytest.raises(ValueError, match=r"actions has 1000000000000000000000; use indices from"):
        hb.empowerment(RING, 1, actions=[0, 10**21])
