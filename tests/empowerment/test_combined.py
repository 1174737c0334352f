"""Sums and products of the values through several sensors, with gaps that hold."""

import json
from dataclasses import replace
from typing import Any

import numpy as np
import polars as pl
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import habilis as hb
from habilis.analysis.averages import average_empowerment
from habilis.analysis.futures import futures
from habilis.analysis.influence import influence_range, latency
from habilis.cli import main
from habilis.empowerment.combined import combined_with_gaps
from habilis.empowerment.horizons import empowerment_by_horizon

ROOM = "D = ball\nG = goal of C\nA.P\n.C.\nD.G\n"
WORLD = hb.World.parse(ROOM)
TABLE = hb.tabulate(WORLD)
NOISY = TABLE.slippery(0.2)
CAN, BALL = "object:can", "object:ball"
SUM, PRODUCT = f"{CAN} + {BALL}", f"{CAN} * {BALL}"
MIXED = f"agent + {CAN}*{BALL}"
SOME = np.argsort(-hb.empowerment(TABLE, 2, PRODUCT), stable=True)[:4]


def test_a_sum_and_a_product_are_those_of_the_values_in_bits():
    can, ball, agent = (hb.empowerment(TABLE, 2, name) for name in (CAN, BALL, "agent"))
    np.testing.assert_array_equal(hb.empowerment(TABLE, 2, SUM), can + ball)
    np.testing.assert_array_equal(hb.empowerment(TABLE, 2, PRODUCT), can * ball)
    np.testing.assert_array_equal(hb.empowerment(TABLE, 2, MIXED), agent + can * ball)
    np.testing.assert_array_equal(hb.empowerment(TABLE, 2, f"{CAN}+{CAN}"), can + can)


def test_they_are_not_the_empowerment_through_a_joint_sensor():
    joint = TABLE.factor(CAN) * 100 + TABLE.factor(BALL)
    assert (hb.empowerment(TABLE, 2, joint) != hb.empowerment(TABLE, 2, SUM)).any()


def test_a_factor_with_such_a_name_is_itself():
    factors = {
        "a": np.array([0, 1, 1], np.int32),
        "b": np.array([0, 0, 1], np.int32),
        "a+b": np.array([0, 1, 2], np.int32),
    }
    mdp = replace(hb.TabularMDP.deterministic([[1, 2], [0, 2], [2, 2]]), factors=factors)
    assert hb.empowerment(mdp, 1, "a+b")[0] == 1
    assert hb.empowerment(mdp, 1, "a + b")[0] == 0 + 1


@pytest.mark.parametrize("unit", ["bits", "nats"])
def test_values_are_in_the_unit_that_is_asked_for(unit: Any):
    can, ball = (hb.empowerment(TABLE, 2, name, unit=unit) for name in (CAN, BALL))
    np.testing.assert_array_equal(hb.empowerment(TABLE, 2, SUM, unit=unit), can + ball)
    np.testing.assert_array_equal(hb.empowerment(TABLE, 2, PRODUCT, unit=unit), can * ball)


# Gaps


@pytest.mark.parametrize("method", [hb.Exact(1e-2), hb.Sampled(4)], ids=["exact", "sampled"])
@pytest.mark.parametrize("sensor", [SUM, PRODUCT, MIXED])
def test_the_gaps_of_a_stochastic_table_hold(sensor: str, method: Any):
    close, rest = hb.empowerment(NOISY, 2, sensor, states=SOME, return_gap=True)
    wide, gap = hb.empowerment(NOISY, 2, sensor, states=SOME, method=method, return_gap=True)
    assert (wide <= close + rest).all()
    assert (close <= wide + gap).all()
    assert rest.max() < 1e-5 < gap.max()


def test_gaps_of_a_sum_are_added_and_that_of_a_product_is_between_its_bounds():
    method = hb.Sampled(3)
    (can, of_can), (ball, of_ball) = (
        hb.empowerment(NOISY, 2, name, states=SOME, method=method, return_gap=True)
        for name in (CAN, BALL)
    )
    bits, gap = hb.empowerment(NOISY, 2, SUM, states=SOME, method=method, return_gap=True)
    np.testing.assert_array_equal(bits, can + ball)
    np.testing.assert_array_equal(gap, of_can + of_ball)
    bits, gap = hb.empowerment(NOISY, 2, PRODUCT, states=SOME, method=method, return_gap=True)
    np.testing.assert_array_equal(bits, can * ball)
    np.testing.assert_allclose(bits + gap, (can + of_can) * (ball + of_ball), rtol=1e-12)


sizes = st.floats(0, 20)


@settings(max_examples=200, deadline=None)
@given(st.lists(st.tuples(sizes, sizes, st.floats(0, 1)), min_size=3, max_size=3))
def test_whatever_the_true_values_are_they_are_between_the_bounds(values: Any):
    """True values are anywhere from the lower bounds to these and their gaps."""
    mdp = replace(
        hb.TabularMDP.deterministic([[0]]), factors={n: np.zeros(1, np.int32) for n in "abc"}
    )
    known = dict(zip("abc", values, strict=True))

    def through(name: Any) -> Any:
        low, gap, _ = known[name]
        return np.array([low]), np.array([gap])

    a, b, c = (low + share * gap for low, gap, share in values)
    for sensor, true in [
        ("a+b", a + b),
        ("a*b", a * b),
        ("a*b*c", a * b * c),
        ("a+b*c", a + b * c),
    ]:
        (low,), (gap,) = combined_with_gaps(mdp, sensor, through)
        rounding = 1e-12 * (low + gap)
        assert low - rounding <= true <= low + gap + rounding


def test_counts_have_no_gap():
    for sensor in (SUM, PRODUCT):
        assert not hb.empowerment(TABLE, 2, sensor, states=SOME, return_gap=True)[1].any()


# Everywhere


def test_measures_of_combined_sensors_are_made_of_their_values():
    by_horizon = empowerment_by_horizon(TABLE, 2, SUM)
    for h, row in enumerate(by_horizon):
        np.testing.assert_array_equal(row, hb.empowerment(TABLE, h, SUM))
    can, ball = (hb.persistence(TABLE, name) for name in (CAN, BALL))
    np.testing.assert_array_equal(hb.persistence(TABLE, SUM), can + ball)
    np.testing.assert_array_equal(hb.persistence(TABLE, PRODUCT), can * ball)
    equipped = TABLE.flags["equipped"]
    assert (
        average_empowerment(TABLE, 2, PRODUCT) == hb.empowerment(TABLE, 2, PRODUCT)[equipped].mean()
    )
    once = [latency(TABLE, 4, name) for name in (CAN, BALL)]
    np.testing.assert_array_equal(latency(TABLE, 4, SUM), np.minimum(*once))
    assert (latency(TABLE, 4, PRODUCT) >= np.maximum(*once)).all()


def test_a_landscape_of_a_sum_is_the_sum_of_the_landscapes():
    can, ball = (hb.landscape(WORLD, 2, name).values for name in (CAN, BALL))
    found = hb.landscape(WORLD, 2, SUM)
    np.testing.assert_array_equal(found.values, can + ball)
    assert found.title == f"2-step empowerment, sensor '{SUM}'"


def test_a_world_needs_no_table_for_them():
    there = {"agent": (0, 0), "tool:picker": (0, 2), CAN: (1, 1), BALL: (2, 0)}
    bits = [hb.empowerment(WORLD, 2, name, states=[there]) for name in (SUM, CAN, BALL)]
    assert bits[0] == bits[1] + bits[2] > 0


@pytest.mark.parametrize("sensor", ["object:can+object:tin", "object:can*none", "object:can+"])
def test_an_unknown_part_is_named(sensor: str):
    part = sensor.replace(CAN, "").strip("+*")
    for measure in (hb.empowerment, empowerment_by_horizon, latency):
        with pytest.raises(
            ValueError, match=rf"^sensor '{part}' is unknown; use one of state, agent"
        ):
            measure(TABLE, 2, sensor)
    with pytest.raises(ValueError, match=rf"^sensor '{part}' is unknown"):
        hb.persistence(TABLE, sensor)


def test_what_has_no_value_of_its_own_is_refused():
    with pytest.raises(ValueError, match=r"^sensor is '.*', and futures are those of a single one"):
        futures(TABLE, TABLE.start, 2, SUM)
    with pytest.raises(ValueError, match=r"object:can \+ object:ball"):
        influence_range(TABLE, 2, SUM)


def test_the_command_line_takes_them(tmp_path: Any, capsys: Any, monkeypatch: Any):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "room.txt").write_text(ROOM)
    arguments = ["room.txt", "--horizon", "2", "--sensor", SUM, "--json"]
    assert main(["empowerment", *arguments, "--out", "bits.csv"]) == 0
    bits = hb.empowerment(TABLE, 2, SUM)
    assert json.loads(capsys.readouterr().out)["mean"] == bits.mean()
    np.testing.assert_array_equal(pl.read_csv("bits.csv")["bits"].to_numpy(), bits)
    assert main(["empowerment", *arguments, "--slip", "0.2", "--method", "sampled"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["mean"] < bits.mean()
    assert answer["gap"] > 0
    assert main(["landscape", *arguments]) == 0
    values = json.loads(capsys.readouterr().out)["values"]
    np.testing.assert_array_equal(np.array(values, float), hb.landscape(WORLD, 2, SUM).values)
    assert main(["futures", *arguments]) == 2
    assert "--sensor is 'object:can + object:ball', and futures" in capsys.readouterr().err
