"""Comparisons of tools: statistics against arrays written by hand, and the world's own."""

import numpy as np
import pytest

from habilis.robots import Placements, ToolComparison, compare_tools, draw_comparison
from habilis.robots.comparison import INFLUENCE

pytest.importorskip("mujoco")


def made(bits: np.ndarray, latency: np.ndarray | None = None) -> ToolComparison:
    """A comparison with such values, along a line."""
    count = bits.shape[1]
    where = Placements(
        np.stack([np.arange(count) + 0.5, np.full(count, 0.5)], axis=1),
        np.stack([np.arange(count), np.zeros(count, int)], axis=1),
        count,
        np.zeros(2),
        np.array([float(count), 1.0]),
    )
    waits = np.full(bits.shape[:2], np.inf) if latency is None else latency
    names = ("none", "stick", "hook")[: len(bits)]
    return ToolComparison(names, where, bits, waits, np.arange(count) + 1.0, 3, "lower bound")


def test_a_verdict_needs_every_search_of_one_tool_above_every_search_of_the_other():
    none = np.array([[1.0, 2.0], [1.0, 2.0], [3.0, 4.0], [0.0, 0.0], [1.0, 1.0]])
    stick = np.array([[2.1, 3.0], [2.0, 3.0], [1.0, 2.9], [0.0, 0.0], [1.0, 1.5]])
    judged = made(np.stack([none, stick])).verdicts("stick")
    np.testing.assert_array_equal(judged.better, [True, False, False, False, False])
    np.testing.assert_array_equal(judged.worse, [False, False, True, False, False])
    np.testing.assert_array_equal(judged.equal, [False, False, False, True, False])
    np.testing.assert_array_equal(judged.undecided, [False, True, False, False, True])
    assert judged.level == pytest.approx(1 / 3)


def test_searches_of_equal_tools_give_a_verdict_as_often_as_its_level_says():
    generator = np.random.default_rng(0)
    judged = made(generator.normal(size=(2, 20_000, 4))).verdicts("stick")
    assert (judged.better | judged.worse).mean() == pytest.approx(judged.level, rel=0.15)
    assert judged.level == pytest.approx(2 / 70)


def test_intervals_cover_the_mean_and_are_narrower_for_pairs():
    generator = np.random.default_rng(1)
    place = generator.normal(size=(200, 1))
    bits = np.stack([place + 0.1 * generator.normal(size=(200, 3)) for _ in range(2)])
    bits[1] += 0.2
    found = made(bits)
    low, high = found.interval()
    assert ((low < found.averages) & (found.averages < high)).all()
    least, most = found.gain()
    assert 0.1 < least[1] < 0.2 < most[1] < 0.3
    assert (most - least)[1] < (high - low)[1] / 3
    np.testing.assert_array_equal((least[0], most[0]), (0, 0))
    np.testing.assert_array_equal(np.stack(found.ranks()), [[2, 1], [2, 1]])


def test_tools_that_cannot_be_told_apart_share_their_ranks():
    generator = np.random.default_rng(2)
    found = made(generator.normal(size=(3, 40, 2)) + np.array([0.0, 0.0, 5.0])[:, None, None])
    best, worst = found.ranks()
    np.testing.assert_array_equal(best, [2, 2, 1])
    np.testing.assert_array_equal(worst, [3, 3, 1])


def test_range_and_latency_are_of_placements_with_influence():
    bits = np.array([[[1.0], [0.0], [0.0]], [[2.0], [0.0], [1.0]]])
    found = made(bits, np.array([[2.0, np.inf, np.inf], [1.0, np.inf, 3.0]]))
    np.testing.assert_array_equal(found.range, [1.0, 3.0])
    np.testing.assert_array_equal(found.median_latency, [2.0, 2.0])
    np.testing.assert_allclose(found.influenced, [1 / 3, 2 / 3])
    frame = found.frame()
    assert frame["tool"].to_list() == ["stick", "none"]
    assert frame["latency"].to_list() == [1.0, 2.0]
    assert frame["better"].to_list() == [pytest.approx(2 / 3), None]


def test_latency_is_the_least_horizon_with_influence():
    found = compare_tools("reach.xml", ["none", "hook"], 4, side=3, seeds=1)
    for h in range(1, 5):
        shorter = compare_tools("reach.xml", ["none", "hook"], h, side=3, seeds=1)
        influenced = shorter.bits[:, :, 0] >= INFLUENCE
        np.testing.assert_array_equal(influenced, found.latency <= h)
    assert np.isfinite(found.latency).sum() > 3


def test_the_same_seed_gives_the_same_numbers_and_a_picture():
    first, second = (
        compare_tools("reach.xml", ["none", "stick"], 3, side=2, seeds=2, seed=5) for _ in range(2)
    )
    np.testing.assert_array_equal(first.bits, second.bits)
    np.testing.assert_array_equal(first.placements.positions, second.placements.positions)
    titles = [ax.get_title() for ax in draw_comparison(first, "reach.xml").axes]
    assert f"stick: {first.averages[1]:.2f} bits" in titles


def test_tools_named_twice_are_refused():
    with pytest.raises(ValueError, match="give different ones"):
        compare_tools("reach.xml", ["none", "none"])
