"""Every way of counting, at every horizon: as boolean powers of the one-step matrix have it."""

import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tables import one_step

import habilis as hb
from habilis.analysis.futures import futures
from habilis.analysis.influence import influence_range, latency
from habilis.empowerment.horizons import empowerment_by_horizon
from habilis.empowerment.limits import Limits, TooMuchError, watched
from habilis.empowerment.tabular import deterministic
from habilis.empowerment.tabular.column_counting import count_columns, count_every_horizon
from habilis.empowerment.tabular.columns import Columns
from habilis.empowerment.tabular.counting import count_backward, count_forward
from habilis.empowerment.tabular.deterministic import Question, counts, counts_by_horizon
from habilis.empowerment.tabular.eventual import same_horizon
from habilis.empowerment.tabular.spreading import Graph
from habilis.empowerment.tabular.windows import count_in_window, window_of

HORIZONS = st.one_of(st.integers(0, 40), st.sampled_from([10**6, 10**9 - 1, 10**9, 2**31 - 1]))


def power(leads: np.ndarray, horizon: int) -> np.ndarray:
    """bool[S, S]: whether so many actions lead from the one state to the other; by squaring."""
    found = np.eye(len(leads), dtype=bool)
    while horizon:
        if horizon & 1:
            found = found @ leads
        leads, horizon = leads @ leads, horizon >> 1
    return found


def truth(table: np.ndarray, labels: np.ndarray, horizon: int) -> list[int]:
    """|O_h(s)| of every state; what is labelled -1 is not observed."""
    reached = power(one_step(table), horizon)
    return [len(set(labels[row].tolist()) - {-1}) for row in reached]


@st.composite
def graphs(draw: st.DrawFn) -> np.ndarray:
    """Tables of every kind: at random, with self-loops, rings of several lengths, and mixtures."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    actions = draw(st.integers(1, 3))
    parts = []
    for _ in range(draw(st.integers(1, 4))):
        size, first = draw(st.integers(1, 30)), sum(map(len, parts))
        kind = draw(st.sampled_from(["random", "stays", "ring", "line"]))
        here = np.arange(size)[:, None]
        if kind == "random":
            part = rng.integers(size, size=(size, actions))
        elif kind == "stays":
            part = np.where(rng.random((size, actions)) < 0.7, here, rng.integers(size, size=1))
        elif kind == "ring":
            part = np.repeat((here + 1) % size, actions, axis=1)
        else:
            part = np.clip(here + rng.choice([-1, 1], size=(size, actions)), 0, size - 1)
        part = part + first
        if first and draw(st.booleans()):  # leads into the parts before
            part[rng.integers(size), rng.integers(actions)] = rng.integers(first)
        parts.append(part)
    return np.concatenate(parts).astype(np.int32)


@st.composite
def labelled(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray, int]:
    table = draw(graphs())
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    count = draw(st.integers(1, len(table) + 1))
    least = draw(st.sampled_from([-1, 0]))
    labels = rng.integers(least, count, size=len(table)).astype(np.int32)
    if draw(st.booleans()):
        labels, count = np.arange(len(table), dtype=np.int32), len(table)
    return table, labels, count


@settings(deadline=None, max_examples=150)
@given(labelled(), HORIZONS, st.sampled_from([1, 2]), st.data())
def test_every_kernel_counts_what_is_reached_at_any_horizon(drawn, horizon, threads, data):
    table, labels, count = drawn
    expected = truth(table, labels, horizon)
    every = np.arange(len(table))
    starts = np.array(data.draw(st.lists(st.sampled_from(every.tolist()), min_size=1, unique=True)))
    some = [expected[s] for s in starts]
    graph = Graph.of(table)
    assert count_backward(table, labels, count, horizon, threads).tolist() == expected
    assert count_forward(table, labels, count, horizon, starts, threads).tolist() == some
    back = Columns.of(labels, count, None)
    assert count_columns(graph, labels, count, horizon, back, threads).tolist() == expected
    there = Columns.of(labels, len(table) + 1, starts)
    assert there.forward
    assert count_columns(graph, labels, count, horizon, there, threads).tolist() == some


@settings(deadline=None, max_examples=100)
@given(labelled(), HORIZONS, st.sampled_from([0, 4096]), st.sampled_from([0, 3, 128]), st.data())
def test_what_is_chosen_by_cost_makes_no_difference(drawn, horizon, packed, listed, data):
    table, labels, count = drawn
    starts = data.draw(st.none() | st.lists(st.integers(0, len(table) - 1)))
    expected = np.array(truth(table, labels, horizon))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(deterministic, "MOST_PACKED_LABELS", packed)
        patch.setattr(deterministic, "_LISTED", listed)
        patch.setattr(deterministic, "_TRIFLE", 0)
        if starts is None:
            assert counts(Question(table, labels, count, horizon)).tolist() == expected.tolist()
            return
        asked = np.array(starts, np.int64)
        found = counts(Question(table, labels, count, horizon, asked))
        assert found.tolist() == expected[asked].tolist()


@settings(deadline=None, max_examples=60)
@given(labelled(), st.integers(0, 120), st.sampled_from([0, 4096]), st.data())
def test_all_horizons_at_once_are_each(drawn, horizon, packed, data):
    table, labels, count = drawn
    starts = np.array(data.draw(st.lists(st.integers(0, len(table) - 1))), np.int64)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(deterministic, "MOST_PACKED_LABELS", packed)
        found = counts_by_horizon(Question(table, labels, count, horizon, starts))
    assert found.shape == (horizon + 1, len(starts))
    for h in (0, 1, horizon // 3, horizon // 2, max(horizon - 1, 0), horizon):
        if h <= horizon:
            assert found[h].tolist() == np.array(truth(table, labels, h))[starts].tolist()
    every = np.arange(len(table))
    graph = Graph.of(table)
    rows = count_every_horizon(graph, labels, count, horizon, every, threads=2)
    assert rows[-1].tolist() == truth(table, labels, horizon)


@settings(deadline=None, max_examples=200)
@given(graphs(), st.one_of(st.integers(0, 3000), st.integers(0, 2**31 - 1)))
def test_a_shorter_horizon_is_exchanged_only_for_the_same_sets(table, horizon):
    shorter = same_horizon(Graph.of(table), horizon)
    assert 0 <= shorter <= horizon
    leads = one_step(table)
    assert np.array_equal(power(leads, shorter), power(leads, horizon))


def test_a_huge_horizon_becomes_one_of_the_size_of_the_graph():
    size = 1000
    line = np.clip(np.arange(size)[:, None] + [-1, 1], 0, size - 1).astype(np.int32)
    assert same_horizon(Graph.of(line), 10**9) < 3 * size
    ring = ((np.arange(size)[:, None] + [-1, 1]) % size).astype(np.int32)
    assert same_horizon(Graph.of(ring), 10**9) < 3 * size
    assert same_horizon(Graph.of(ring), 10**9) % 2 == 0
    assert same_horizon(Graph.of(ring), 10**9 + 1) % 2 == 1


@settings(deadline=None, max_examples=60)
@given(graphs(), HORIZONS, st.integers(0, 2**32 - 1), st.sampled_from([1, 2]))
def test_windows_count_at_any_horizon_and_not_what_is_not_seen(table, horizon, seed, threads):
    rng = np.random.default_rng(seed)
    cells = rng.integers(35, size=len(table)).astype(np.int32)
    shown = rng.random(len(table)) < 0.8
    row, column = (part.astype(np.int16) for part in np.divmod(cells, 7))
    window = window_of(table, row, column, horizon, 10_000, threads, shown=shown)
    assert window is not None
    found = count_in_window(table, row, column, horizon, window, threads, shown=shown)
    assert found.tolist() == truth(table, np.where(shown, cells, -1), horizon)


def test_a_thing_that_is_not_seen_needs_no_window():
    table = np.array([[1, 2], [1, 1], [2, 2]], np.int32)  # an action may end where nothing is seen
    row, column = np.array([5, 5, 0], np.int16), np.array([5, 6, 0], np.int16)
    window = window_of(table, row, column, 3, 100, 1, shown=np.array([True, True, False]))
    assert window is not None
    assert (window.rows, window.columns) == (1, 2)


# Through the front door


@pytest.mark.parametrize("name", ["corridor", "yard"])
def test_a_world_has_the_same_sets_for_ever_once_they_are_full(name):
    mdp = hb.tabulate(hb.load_world(name))
    ever = hb.empowerment(mdp, 10**9)
    assert np.array_equal(ever, hb.empowerment(mdp, 10**9 - 1))
    assert np.array_equal(ever, hb.empowerment(mdp, 120))
    assert (ever >= hb.empowerment(mdp, 20)).all()
    assert np.array_equal(hb.empowerment(mdp, 10**9, "object"), hb.empowerment(mdp, 120, "object"))
    some = np.arange(0, mdp.states, 997)
    assert np.array_equal(hb.empowerment(mdp, 10**9, states=some), ever[some])


def test_sets_that_alternate_are_those_of_an_even_or_an_odd_horizon():
    ring = hb.TabularMDP.deterministic([[(s - 1) % 6000, (s + 1) % 6000] for s in range(6000)])
    even, odd = hb.empowerment(ring, 10**9), hb.empowerment(ring, 10**9 - 1)
    assert (even == np.log2(3000)).all()
    assert np.array_equal(even, odd)
    side = np.arange(6000) % 2 * np.arange(6000)  # only odd states are distinguished
    assert hb.empowerment(ring, 10**9, side, states=[0, 1]).tolist() == [0, np.log2(3000)]
    assert hb.empowerment(ring, 10**9 - 1, side, states=[0, 1]).tolist() == [np.log2(3000), 0]


# Limits


def disjoint_rings(lengths: list[int]) -> hb.TabularMDP:
    """Sets whose period is the least common multiple: from the last state each ring is entered."""
    first = np.cumsum([0, *lengths])
    table = np.concatenate(
        [
            np.tile((np.arange(n)[:, None] + 1) % n + f, len(lengths))
            for n, f in zip(lengths, first[:-1], strict=True)
        ]
    )
    return hb.TabularMDP.deterministic(np.vstack([table, first[:-1]]))


def test_a_period_too_long_to_be_found_is_refused_and_a_short_one_answered():
    primes = [97, 101, 103, 107, 109, 113, 127, 131, 137, 139, 149, 151]
    long = disjoint_rings(primes)
    with pytest.raises(ValueError, match=r"the largest horizon that fits is about \d+:"):
        hb.empowerment(long, 10**9, method=hb.Exact(max_seconds=30))
    with pytest.raises(ValueError, match=r"the largest horizon that fits is about \d+:"):
        hb.empowerment(long, 10**9, states=[long.states - 1], method=hb.Exact(max_seconds=10))
    short = disjoint_rings([2, 3, 4])
    last = [short.states - 1]
    assert hb.empowerment(short, 10**9, states=last) == np.log2(3)


@pytest.mark.parametrize("sensor", ["state", "object"])
@pytest.mark.parametrize("by_horizon", [False, True])
def test_time_is_limited_where_nothing_is_noisy_too(sensor, by_horizon):
    mdp = hb.tabulate(hb.load_world("yard"))
    measure = empowerment_by_horizon if by_horizon else hb.empowerment
    with pytest.raises(
        TooMuchError,
        match=r"horizon 60 takes about \S+ GiB and \S+ s; the limits are 8 GiB and .*"
        r"the largest horizon that fits is about \d+: use it, raise max_gib or max_seconds",
    ) as refused:
        measure(mdp, 60, sensor, method=hb.Exact(max_seconds=1e-4))
    assert refused.value.fitting < 60


@pytest.mark.parametrize("sensor", ["state", "object"])
def test_memory_is_foreseen_and_not_taken_where_nothing_is_noisy_too(sensor):
    mdp = hb.tabulate(hb.load_world("yard"))
    hb.empowerment(mdp, 3, sensor)
    tracemalloc.start()
    with pytest.raises(ValueError, match=r"takes about \S+ GiB; the limits are 1e-05 GiB .* is 0:"):
        hb.empowerment(mdp, 30, sensor, method=hb.Exact(max_gib=1e-5))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 2 * mdp.next_state.nbytes


def test_the_largest_horizon_whose_neighbourhood_fits_is_named():
    line = hb.TabularMDP.deterministic(np.clip(np.arange(9000)[:, None] + [-1, 1], 0, 8999))
    with pytest.raises(TooMuchError, match="the largest horizon that fits is") as refused:
        hb.empowerment(line, 4000, states=[4500], method=hb.Exact(max_gib=1e-3))
    fitting = refused.value.fitting
    assert 0 < fitting < 4000
    assert hb.empowerment(line, fitting, states=[4500], method=hb.Exact(max_gib=1e-3)) == np.log2(
        fitting + 1
    )


def test_rows_for_too_many_horizons_are_refused():
    mdp = hb.TabularMDP.deterministic([[0, 1], [1, 0]])
    with pytest.raises(TooMuchError, match="the largest horizon that fits is") as refused:
        empowerment_by_horizon(mdp, 10**9, "state")
    assert 10**6 < refused.value.fitting < 10**9
    assert empowerment_by_horizon(mdp, 10**5, "state")[-1].tolist() == [1, 1]


def test_what_comes_first_is_found_for_any_horizon():
    """No row is kept for each horizon: the sets of the yard come to a fixed point by 80."""
    mdp = hb.tabulate(hb.load_world("yard"))
    assert np.array_equal(latency(mdp, 10**9), latency(mdp, 100))
    assert influence_range(mdp, 10**9) == influence_range(mdp, 100)
    ring = hb.TabularMDP.deterministic(np.arange(1, 10)[:, None] % 9)
    assert np.isinf(latency(ring, 10**9, "state")).all()


def test_time_of_an_unknown_number_of_rows_is_limited_by_the_clock():
    """A share of 10^9 actions says nothing where the first few rows come again."""
    mdp = hb.tabulate(hb.load_world("yard"))
    rows = latency(mdp, 10**9, method=hb.Exact(max_seconds=60))
    assert np.isfinite(rows).any()
    with pytest.raises(TooMuchError, match=r"takes more than \S+ s; .* is about \d+:") as refused:
        latency(mdp, 10**9, method=hb.Exact(max_seconds=1e-4))
    assert refused.value.fitting < 80


def test_rows_of_a_period_too_long_are_refused_as_they_come():
    long = disjoint_rings([97, 101, 103, 107, 109, 113])
    with pytest.raises(TooMuchError, match=r"the largest horizon that fits is \d+:") as refused:
        latency(long, 10**9, "state", method=hb.Exact(threads=1, max_gib=1e-2))
    assert 0 < refused.value.fitting < 10**5


def test_no_action_always_fits():
    mdp = hb.tabulate(hb.load_world("yard"))
    assert not hb.empowerment(mdp, 0, method=hb.Exact(max_gib=1e-9, max_seconds=1e-9)).any()


# With noise


@pytest.mark.parametrize("options", [{}, {"method": hb.Sampled()}, {"states": [0]}])
def test_endless_beliefs_and_samples_are_refused_at_once(options):
    mdp = hb.tabulate(hb.World.parse("A.C\n.PG"), slip=0.2)
    for horizon in (10**9, 2**31 - 1):
        tracemalloc.start()
        with pytest.raises(TooMuchError, match=rf"horizon {horizon} takes about") as refused:
            hb.empowerment(mdp, horizon, "object", **options)
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert peak < 100e6
        assert 0 <= refused.value.fitting < horizon


def test_a_single_belief_that_goes_on_for_ever_is_refused_too():
    chain = hb.TabularMDP.stochastic(np.array([[[0.5, 0.5]], [[0.1, 0.9]]]))
    with pytest.raises(TooMuchError, match="the largest horizon that fits is") as refused:
        hb.empowerment(chain, 10**9)
    assert refused.value.fitting > 10**4
    assert hb.empowerment(chain, 3000).tolist() == [0, 0]


def test_futures_of_endless_sequences_are_refused_and_of_long_ones_given():
    mdp = hb.TabularMDP.deterministic([[0, 1], [1, 0]])
    with pytest.raises(TooMuchError, match="the largest horizon that fits is"):
        futures(mdp, 0, 10**9)
    found = futures(mdp, 0, 1500)
    assert found.empowerment == 1
    assert found.sequences.shape == (2, 1500)


@settings(deadline=None, max_examples=40)
@given(graphs(), st.integers(65, 2**31 - 1), st.integers(0, 2**32 - 1))
def test_a_noisy_sensor_of_certain_states_has_any_horizon(table, horizon, seed):
    rng = np.random.default_rng(seed)
    sensor = rng.dirichlet(np.ones(3), size=len(table))
    mdp = hb.TabularMDP.deterministic(table)
    start = int(rng.integers(len(table)))
    bits, gap = hb.empowerment(mdp, horizon, sensor, states=[start], return_gap=True)
    reached = power(one_step(table), horizon)[start]
    expected = hb.capacity(sensor[reached])
    assert bits[0] <= expected.bits + expected.gap + 1e-9
    assert expected.bits <= bits[0] + gap[0] + 1e-9


def test_all_horizons_with_noise_need_room_for_their_rows():
    with pytest.raises(TooMuchError, match="the largest horizon that fits is"):
        empowerment_by_horizon(
            hb.TabularMDP.deterministic([[0, 1], [1, 0]]), 10**9, [[0.9, 0.1], [0.2, 0.8]]
        )


def test_a_limit_of_time_is_for_all_states_and_not_for_one():
    """The work is estimated from its share: nothing known yet refuses nothing."""
    watch = watched(100, 100, 0.5, Limits(8, 1e-9), lambda share: None)
    watch(0.0)
    watch(1.0)

    def work() -> None:
        while True:
            watch(0.25)

    with pytest.raises(TooMuchError, match=r"takes about 0.5 GiB and \S+ s; the limits are 8 GiB"):
        work()


def test_a_stall_of_the_machine_in_its_first_moments_refuses_nothing(monkeypatch):
    clock = iter([0.0, 1.0, 2.1, 4.5])
    monkeypatch.setattr("time.monotonic", lambda: next(clock))
    watch = watched(10_000, 10_000, 0.5, Limits(8, 3600), lambda share: None)
    watch(1e-4)  # a second for one step of ten thousand
    watch(0.1)
    watch(0.3)


def test_the_horizon_that_is_refused_is_the_one_that_was_asked_for():
    line = hb.TabularMDP.deterministic(np.clip(np.arange(9000)[:, None] + [-1, 1], 0, 8999))
    with pytest.raises(TooMuchError, match=r"horizon 1000000000 takes about \S+ GiB") as refused:
        hb.empowerment(line, 10**9, method=hb.Exact(max_gib=2e-3))
    assert refused.value.horizon == 10**9
