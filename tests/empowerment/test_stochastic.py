"""Noisy empowerment is the capacity of the channel that all action sequences make."""

import os
import re
import subprocess
import sys
import time
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array
from slow_channels import blahut_arimoto, channel_of_sequences

import habilis as hb
from habilis.channels.capacity import ConvergenceWarning
from habilis.empowerment.tabular import cost as effort
from habilis.empowerment.tabular.cost import estimate
from habilis.empowerment.tabular.open_loop import exact, problem_of
from habilis.mdp import TabularMDP

CLOSE = 3e-6  # our gap and that of the slow capacity


def maze(side: int, slip: float, walls: tuple[int, ...] = ()) -> TabularMDP:
    """A room with some walls; five actions, the last of them to stay."""
    free = [cell for cell in range(side * side) if cell not in walls]
    place = {cell: state for state, cell in enumerate(free)}
    table = np.empty((len(free), 5), int)
    for state, cell in enumerate(free):
        row, column = divmod(cell, side)
        for a, (r, c) in enumerate([(-1, 0), (0, 1), (1, 0), (0, -1), (0, 0)]):
            inside = 0 <= row + r < side and 0 <= column + c < side
            table[state, a] = place.get(cell + r * side + c, state) if inside else state
    return TabularMDP.deterministic(table).slippery(slip)


@st.composite
def probabilities(draw: st.DrawFn) -> np.ndarray:
    """float[S, A, S]: some rows certain, some spread; absorbing and unreachable states."""
    states, actions = draw(st.integers(1, 5)), draw(st.integers(1, 3))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    P = rng.dirichlet(np.full(states, draw(st.sampled_from([0.2, 1.0]))), (states, actions))
    P[rng.random((states, actions)) < draw(st.sampled_from([0.0, 0.5]))] = np.eye(states)[-1]
    if draw(st.booleans()):
        P[0] = np.eye(states)[0]  # absorbing
    if draw(st.booleans()) and states > 1:  # nothing leads to the last
        P[:, :, 0] += P[:, :, -1]
        P[:, :, -1] = 0
    return P


@st.composite
def sensors(draw: st.DrawFn, states: int) -> Any:
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    kind = draw(st.sampled_from(["state", "labels", "noisy"]))
    if kind == "state":
        return "state"
    if kind == "labels":
        return rng.integers(3, size=states)
    return rng.dirichlet(np.full(draw(st.integers(1, 4)), 0.5), states)


def as_matrix(sensor: Any, states: int) -> np.ndarray:
    if isinstance(sensor, str):
        return np.eye(states)
    return np.eye(3)[sensor] if sensor.ndim == 1 else sensor


# Against all action sequences


@settings(max_examples=100, deadline=None)
@given(probabilities(), st.integers(0, 3), st.data())
def test_bits_are_the_capacity_of_all_action_sequences(
    P: np.ndarray, horizon: int, data: st.DataObject
):
    states, actions = P.shape[:2]
    sensor = data.draw(sensors(states))
    chosen = data.draw(st.none() | st.lists(st.integers(0, actions - 1), min_size=1, max_size=3))
    mdp = TabularMDP.stochastic(P)
    bits, gap = hb.empowerment(mdp, horizon, sensor, chosen, return_gap=True)
    for state in range(states):
        used = list(range(actions)) if chosen is None else sorted(set(chosen))
        channel = channel_of_sequences(P, as_matrix(sensor, states), state, horizon, used)
        slow = blahut_arimoto(channel, gap=2e-6)
        assert bits[state] <= slow + CLOSE
        assert slow <= bits[state] + gap[state] + 1e-9
    assert (gap <= 1e-6).all()


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 6), st.integers(1, 3), st.integers(0, 3), st.integers(0, 2**32 - 1))
def test_a_noisy_sensor_on_a_certain_world_is_a_channel_too(
    states: int, actions: int, horizon: int, seed: int
):
    rng = np.random.default_rng(seed)
    table = rng.integers(states, size=(states, actions))
    sensor = rng.dirichlet(np.full(3, 0.5), states)
    bits = hb.empowerment(TabularMDP.deterministic(table), horizon, sensor)
    P = np.eye(states)[table]
    for state in range(states):
        channel = channel_of_sequences(P, sensor, state, horizon, list(range(actions)))
        assert bits[state] == pytest.approx(blahut_arimoto(channel, gap=2e-6), abs=CLOSE)


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 6), st.integers(1, 3), st.integers(0, 3), st.integers(0, 2**32 - 1))
def test_counting_and_capacities_agree_where_nothing_is_uncertain(
    states: int, actions: int, horizon: int, seed: int
):
    rng = np.random.default_rng(seed)
    mdp = TabularMDP.deterministic(rng.integers(states, size=(states, actions)))
    labels = rng.integers(3, size=states)
    counted = hb.empowerment(mdp, horizon, labels)
    assert np.allclose(counted, hb.empowerment(mdp, horizon, np.eye(3)[labels]), atol=1e-6)
    assert TabularMDP.stochastic(np.eye(states)[mdp.next_state]).is_stochastic is False


def test_slippery_worlds_go_through_every_sensor():
    world = hb.World.parse("APC\n..G")
    mdp, certain = hb.tabulate(world, slip=0.2), hb.tabulate(world)
    P = np.stack([mdp.transition(a).toarray() for a in range(8)], axis=1)
    for sensor in ("state", "agent", "object"):
        bits = hb.empowerment(mdp, 2, sensor, states=[0, 5])
        labels = np.arange(mdp.states) if sensor == "state" else mdp.factor(sensor)
        seen = np.eye(labels.max() + 1)[labels]
        for value, state in zip(bits, [0, 5], strict=True):
            channel = channel_of_sequences(P, seen, state, 2, list(range(8)))
            assert value == pytest.approx(blahut_arimoto(channel, gap=2e-6), abs=CLOSE)
        assert (bits <= hb.empowerment(certain, 2, sensor, states=[0, 5]) + 1e-9).all()


def test_one_slippery_step_is_a_channel_with_a_closed_form():
    # Four actions to four places, each with 0.85 and the others with 0.05.
    mdp = TabularMDP.deterministic(np.tile(np.arange(4), (4, 1))).slippery(0.2)
    row = np.array([0.85, 0.05, 0.05, 0.05])
    assert np.allclose(hb.empowerment(mdp, 1), 2 + (row * np.log2(row)).sum(), atol=1e-9)
    nats = hb.empowerment(mdp, 1, unit="nats")
    assert np.allclose(nats, np.log(4) + (row * np.log(row)).sum(), atol=1e-9)


# What must hold for any


@settings(max_examples=60, deadline=None)
@given(probabilities(), st.integers(0, 3))
def test_more_actions_never_do_less_where_one_is_to_wait(P: np.ndarray, horizon: int):
    waiting = np.concatenate([P, np.eye(len(P))[:, None]], axis=1)
    mdp = TabularMDP.stochastic(waiting)
    assert (hb.empowerment(mdp, horizon) <= hb.empowerment(mdp, horizon + 1) + 1e-6).all()


@settings(max_examples=60, deadline=None)
@given(probabilities(), st.integers(0, 3))
def test_bits_are_at_most_those_of_all_reachable_observations(P: np.ndarray, horizon: int):
    mdp = TabularMDP.stochastic(P)
    reachable = np.linalg.matrix_power((P.sum(axis=1) > 0).astype(float), horizon) > 0
    assert (hb.empowerment(mdp, horizon) <= np.log2(reachable.sum(axis=1)) + 1e-9).all()


@settings(max_examples=60, deadline=None)
@given(probabilities(), st.integers(0, 3), st.data())
def test_names_of_states_and_observations_do_not_matter(
    P: np.ndarray, horizon: int, data: st.DataObject
):
    sensor = as_matrix(data.draw(sensors(len(P))), len(P))
    order = np.array(data.draw(st.permutations(range(len(P)))))
    columns = np.array(data.draw(st.permutations(range(sensor.shape[1]))))
    renamed = P[order][:, :, order]
    bits = hb.empowerment(TabularMDP.stochastic(P), horizon, sensor)
    others = hb.empowerment(TabularMDP.stochastic(renamed), horizon, sensor[order][:, columns])
    assert np.allclose(bits[order], others, atol=2e-6)


def test_the_number_of_threads_does_not_matter():
    mdp = maze(5, 0.125, walls=(6, 12))
    one = hb.empowerment(mdp, 3, method=hb.Exact(threads=1), return_gap=True)
    for threads in (2, 5):
        several = hb.empowerment(mdp, 3, method=hb.Exact(threads=threads), return_gap=True)
        assert np.array_equal(one, several)


def test_states_are_answered_in_the_order_and_as_often_as_asked():
    mdp = maze(4, 0.1)
    all_bits = hb.empowerment(mdp, 2)
    asked = [3, 0, 3, 15]
    assert np.array_equal(hb.empowerment(mdp, 2, states=asked), all_bits[asked])
    assert hb.empowerment(mdp, 2, states=[]).shape == (0,)


def test_a_sparse_noisy_sensor_is_as_a_dense_one():
    mdp = maze(3, 0.1)
    sensor = np.random.default_rng(0).dirichlet(np.ones(4), 9)
    assert np.array_equal(hb.empowerment(mdp, 2, sensor), hb.empowerment(mdp, 2, csr_array(sensor)))


def test_commuting_actions_are_merged_exactly():
    mdp = maze(9, 0.125)
    centre = 40
    problem = problem_of(mdp, 3, "state", np.arange(5), 1e-6)
    beliefs, answer = exact(problem, centre)
    # Far from walls only the numbers of each action count: 3 out of 5 kinds with repetition.
    assert len(beliefs.steps[-1][0]) == 35
    assert answer.channel.shape == (35, 25)


def test_the_kept_sequences_lead_to_the_kept_beliefs():
    mdp = maze(4, 0.2, walls=(5,))
    P = np.stack([mdp.transition(a).toarray() for a in range(5)], axis=1)
    beliefs, _ = exact(problem_of(mdp, 3, "state", np.arange(5), 1e-6), 0)
    rows = np.arange(len(beliefs.matrix))
    for row, sequence in zip(rows, beliefs.sequences(rows), strict=True):
        belief = np.eye(mdp.states)[0]
        for action in sequence:
            belief = belief @ P[:, action]
        assert np.allclose(belief[beliefs.states], beliefs.matrix[row], atol=1e-14)


# Lower bounds


def test_sampled_sequences_give_a_lower_bound_and_say_how_far_it_may_be():
    mdp = maze(5, 0.125, walls=(7,))
    bits = hb.empowerment(mdp, 4)
    for samples in (1, 30, 400):
        some, gap = hb.empowerment(mdp, 4, method=hb.Sampled(samples=samples), return_gap=True)
        assert (some <= bits + 1e-6).all()
        assert (bits <= some + gap + 1e-6).all()
    assert np.abs(some - bits).max() < 0.4
    assert np.abs(some - bits).max() > 1e-6


def test_samples_are_the_same_for_one_seed_and_do_not_depend_on_the_company():
    mdp = maze(4, 0.1)
    bits = hb.empowerment(mdp, 3, method=hb.Sampled(samples=20, seed=7))
    assert np.array_equal(
        bits[[5]], hb.empowerment(mdp, 3, method=hb.Sampled(samples=20, seed=7), states=[5])
    )
    assert not np.array_equal(bits, hb.empowerment(mdp, 3, method=hb.Sampled(samples=20, seed=8)))


def test_a_lower_bound_needs_no_more_memory_for_longer_sequences():
    mdp = maze(6, 0.1)
    bits = hb.empowerment(mdp, 40, states=[0], method=hb.Sampled(50, max_gib=0.001))
    assert 0 < bits[0] < np.log2(36)


def test_certain_worlds_can_be_sampled_too():
    mdp = TabularMDP.deterministic([[0, 1], [1, 2], [2, 0]])
    bits, gap = hb.empowerment(mdp, 2, method=hb.Sampled(samples=200), return_gap=True)
    assert np.allclose(bits, hb.empowerment(mdp, 2), atol=1e-6)
    assert (gap <= 1e-6).all()


# What it would cost


@pytest.mark.parametrize("limit", [{"max_gib": 1e-4}, {"max_seconds": 1e-3}])
def test_a_job_over_a_limit_is_refused_with_the_largest_horizon_that_fits(limit: Any):
    mdp, method = maze(10, 0.125, walls=(33, 34, 56)), hb.Exact(**limit)
    with pytest.raises(ValueError, match=r"horizon 12 takes about .* GiB and .* s") as refused:
        hb.empowerment(mdp, 12, method=method)
    message = str(refused.value)
    assert "method=hb.Sampled()" in message
    fits = re.search(r"the largest horizon that fits is about (\d+)", message)
    if fits is not None:
        assert int(fits[1]) < 12
        if "max_gib" in limit:
            assert len(hb.empowerment(mdp, int(fits[1]), states=[0], method=method)) == 1
    else:
        assert "no horizon fits" in message


def test_an_endless_horizon_is_refused_at_once():
    with pytest.raises(ValueError, match="the largest horizon that fits is"):
        hb.empowerment(maze(10, 0.125), 100_000)


def test_memory_that_was_estimated_too_low_is_not_exceeded_either(monkeypatch: pytest.MonkeyPatch):
    from habilis.empowerment.tabular import stochastic

    monkeypatch.setattr(stochastic, "check_effort", lambda *asked: None)
    with pytest.raises(ValueError, match=r"horizon 9 turns out .* horizon that fits is [3-6]:"):
        hb.empowerment(maze(10, 0.125), 9, method=hb.Exact(max_gib=0.001, threads=1))


def test_memory_is_estimated_from_what_merging_leaves():
    mdp = maze(10, 0.125, walls=(33, 34, 56))
    problem = problem_of(mdp, 6, "state", np.arange(5), 1e-6)
    effort = estimate(problem, np.arange(mdp.states), threads=1)
    beliefs, _ = exact(problem, 50)
    real = beliefs.matrix.size * 32 / 2**30
    assert real / 3 < effort.gib[-1] < real * 10
    assert (np.diff(effort.gib) > 0).all()


def test_what_is_compiled_on_first_use_is_no_part_of_the_estimate(tmp_path: Path):
    """Compiling takes seconds, which a few thousand states would multiply to hours."""
    code = (
        "import habilis as hb\n"
        "yard = hb.load_world('yard')\n"
        "mdp = hb.tabulate(hb.World.parse('P = picker slip 0.2\\n' + '\\n'.join(yard.rows)))\n"
        "limited = hb.Exact(max_seconds=100)\n"
        "hb.empowerment(mdp, 1, 'object', states=range(0, mdp.states, 10), method=limited)\n"
    )
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", code], stderr=subprocess.PIPE, text=True, env=environment
    )
    assert done.stderr == ""
    assert any(tmp_path.rglob("*.nbi"))  # it did compile


def test_what_else_runs_makes_no_estimate_larger(monkeypatch: pytest.MonkeyPatch):
    from habilis.empowerment.tabular import column_generation

    def interrupted(*asked: Any) -> Any:
        time.sleep(1)
        return solved(*asked)

    solved = column_generation.capacity_of
    monkeypatch.setattr(effort, "capacity_of", interrupted)
    mdp = maze(10, 0.125)
    estimated = estimate(problem_of(mdp, 2, "state", np.arange(5), 1e-6), np.arange(mdp.states), 1)
    assert 0 < estimated.seconds[-1] < mdp.states / 2


# What is refused


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"sensor": np.full((2, 2), 0.5)}, "sensor has 2 rows; give one integer label"),
        ({"sensor": np.full((3, 2), 0.4)}, "sensor, state 0 sums to 0.8"),
        ({"sensor": np.full((2, 3), 0.5)}, "3 states; its columns sum to 1: transpose it"),
        ({"sensor": csr_array(np.full((2, 3), 0.5))}, "its columns sum to 1: transpose it"),
        (
            {"sensor": np.array([[0.5, 0.2, 0.3], [0.4, 0.2, 0.3], [0.1, 0.6, 0.4]])},
            "sensor, state 1 sums to 0.9, but every column to 1: rows are states; transpose it",
        ),
        ({"sensor": [[1.5, -0.5]] * 3}, "sensor, state 0, column 1 is -0.5"),
        ({"sensor": np.ones((3, 1, 1))}, "sensor has shape (3, 1, 1)"),
        ({"sensor": "nose"}, "sensor 'nose' is unknown"),
        ({"horizon": -1}, "horizon is -1"),
        ({"actions": []}, "actions has shape (0,)"),
        ({"states": [3]}, "states has 3"),
        ({"unit": "bytes"}, "unit is 'bytes'; use 'bits' or 'nats'"),
        ({"method": "guess"}, "method is 'guess'; use hb.Exact() or hb.Sampled()"),
    ],
)
@pytest.mark.ill_typed
def test_bad_input_is_refused_with_the_fix(arguments: Any, message: str):
    P = np.full((3, 2, 3), 1 / 3)
    with pytest.raises(ValueError, match=re.escape(message)):
        hb.empowerment(TabularMDP.stochastic(P), **({"horizon": 1} | arguments))


def test_a_gap_above_the_tolerance_is_named_in_a_warning():
    with pytest.warns(ConvergenceWarning, match="above the tolerance of 1e-17"):
        bits = hb.empowerment(maze(3, 0.1), 2, method=hb.Exact(tolerance=1e-17))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert np.allclose(bits, hb.empowerment(maze(3, 0.1), 2), atol=1e-6)


def noisy_agent(mdp: hb.TabularMDP) -> np.ndarray:
    """A sensor that says with one error in ten whether the agent's cell is even or odd."""
    seen = np.full((mdp.states, 2), 0.1)
    seen[np.arange(mdp.states), mdp.factor("agent") % 2] = 0.9
    return seen


def within(options: dict[str, Any], seconds: float) -> dict[str, Any]:
    return options | {"method": replace(options["method"], max_seconds=seconds)}


def test_time_is_foreseen_for_all_states_together():
    mdp = hb.tabulate(hb.load_world("yard"))
    cases: list[dict[str, Any]] = [
        {"sensor": "object", "method": hb.Sampled()},
        {"sensor": noisy_agent(mdp), "method": hb.Exact()},
    ]
    for options in cases:
        with pytest.raises(ValueError, match=r"takes about .* the limits are 8 GiB and 1 s"):
            hb.empowerment(mdp, 40, **within(options, 1))
        one = hb.empowerment(mdp, 4, **within(options, 60), states=[0])
        assert np.isfinite(one).all()


@pytest.mark.parametrize(
    ("options", "advice"),
    [
        ({}, "use it, raise max_gib or max_seconds, or ask for a lower bound with method=hb.S"),
        ({"method": hb.Sampled()}, "use it, raise max_gib or max_seconds, or draw fewer samples"),
        (
            {"method": hb.Exact(max_gib=1e-12)},
            "no horizon fits: raise max_gib or max_seconds, or ask for a lower bound",
        ),
    ],
)
def test_a_refusal_advises_what_can_be_done(options: Any, advice: str):
    mdp = hb.tabulate(hb.World.parse("A.C\n.PG"), slip=0.2)
    with pytest.raises(ValueError, match=r"and (the largest|no) horizon (that )?fits") as refused:
        hb.empowerment(mdp, 10**9, "object", **options)
    assert advice in str(refused.value)
    assert str(refused.value).count("Sampled") == ("lower bound" in advice)
