"""How growth is measured: every peer computes the same, and a slope is an exponent."""

from dataclasses import replace

import numpy as np
import pytest

from habilis.benchmarks import growth, run_benchmarks, time_of, times
from habilis.benchmarks.growth import AXES, Point, points, slope

CURVES = [(axis, name) for axis in AXES for name in axis.calls if name != "ours"]


@pytest.mark.parametrize(("axis", "peer"), CURVES, ids=[f"{a.name}, {n}" for a, n in CURVES])
def test_every_peer_computes_the_same(axis: growth.Axis, peer: str):
    size = axis.sizes[0]
    ours, theirs = axis.calls["ours"](size), axis.calls[peer](size)
    assert ours is not None
    assert theirs is not None
    bits, found = ours[0](), np.asarray(theirs[0]())
    asked = np.linspace(0, len(bits) - 1, len(found)).astype(int)
    np.testing.assert_allclose(found, bits[asked], atol=2e-6)
    assert theirs[1] == len(bits) / len(found)


@pytest.mark.parametrize("exponent", [0.0, 1.0, 2.5])
def test_the_slope_of_a_power_is_its_exponent(exponent: float):
    sizes = [10, 100, 1_000, 10_000]
    curve = [Point("states", "b", n, 3 * n**exponent, 0, 0, None) for n in sizes]
    assert slope(curve, "seconds") == pytest.approx(exponent)
    assert slope(curve, "gib") is None


def test_over_horizons_growth_is_a_factor_for_each_action():
    curve = [Point("horizon", "b", h, 0.1 * 8.0**h, 0, 0, 8.0**h) for h in range(1, 7)]
    assert slope(curve, "seconds") == pytest.approx(8)
    assert slope(curve, "gib") == pytest.approx(8)


def test_a_point_has_the_time_and_the_memory_of_all_states():
    point = growth._measured_apart("states, all seen", "dense rows of bits", 7)
    assert point is not None
    assert point.size == growth.tabulate(growth.square(7)).states
    assert 0 < point.least <= point.seconds <= point.most
    if point.gib is not None:  # three arrays of a bit for each pair of states
        assert 2 * point.size**2 / 8 < point.gib * 2**30 < 10 * point.size**2 / 8


def test_what_does_not_fit_is_left_out():
    assert growth.measured("horizon", "all sequences", 64) is None


def test_a_curve_ends_where_it_takes_too_long(monkeypatch: pytest.MonkeyPatch):
    axis = AXES[0]
    short = replace(axis, sizes=axis.sizes[:2], calls={"ours": axis.calls["ours"]})
    monkeypatch.setattr(growth, "AXES", (short,))
    monkeypatch.setattr(growth, "_LONGEST", 0.0)
    assert [point.name for point in points()] == ["ours"]
    (line,) = run_benchmarks(["growth"])  # a slope needs two points
    assert line.name == "ours, states"
    assert line.value > 0


def test_rounds_alternate():
    made: list[str] = []
    seconds = times({"a": lambda: made.append("a"), "b": lambda: made.append("b")}, rounds=3)
    assert made[-6:] == ["a", "b"] * 3
    assert {name: len(rounds) for name, rounds in seconds.items()} == {"a": 3, "b": 3}
    assert (time_of(lambda: None, rounds=2) >= 0).all()
