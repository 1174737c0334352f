from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from habilis.learning.convergence import (
    LONG_WINDOW,
    SHORT_WINDOW,
    Averages,
    episodes_to_convergence,
    moving_average,
)


@given(st.lists(st.floats(-100, 0), max_size=30), st.integers(1, 8))
def test_a_moving_average_is_the_mean_of_every_window(values, window):
    expected = [np.mean(values[i : i + window]) for i in range(len(values) - window + 1)]
    np.testing.assert_allclose(moving_average(values, window), expected, atol=1e-9)


def test_convergence_needs_both_windows_filled():
    assert episodes_to_convergence([-14.0] * 2098, -14) is None
    assert episodes_to_convergence([-14.0] * 2099, -14) == 2099


def test_convergence_is_the_first_episode_at_which_the_double_average_is_close():
    returns = np.concatenate([np.full(50, -100.0), np.full(200, -14.0)])
    found = episodes_to_convergence(returns, -14, windows=(5, 10))
    for count in range(14, 251):
        last = [np.mean(returns[count - 10 - 5 + i + 1 : count - 10 + i + 1]) for i in range(10)]
        if np.mean(last) >= -14.9:
            assert found == count
            break


@pytest.mark.parametrize(("level", "converges"), [(-14.89, True), (-14.91, False)])
def test_close_means_within_nine_tenths_of_the_best_return(level, converges):
    found = episodes_to_convergence(np.full(40, level), -14, windows=(5, 10))
    assert (found is not None) == converges


def test_a_run_that_gets_worse_again_has_converged_all_the_same():
    returns = np.concatenate([np.full(30, -14.0), np.full(100, -500.0)])
    assert episodes_to_convergence(returns, -14, windows=(5, 10)) == 14


@settings(deadline=None)  # it is compiled at first
@given(st.data(), st.integers(1, 7), st.integers(1, 9))
def test_convergence_seen_stretch_by_stretch_is_that_of_all_episodes(data, short, long):
    numbers = st.floats(-20, 0, width=32) | st.integers(-20, 0).map(float)
    returns = np.array(data.draw(st.lists(numbers, max_size=80)), np.float32)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(returns)), max_size=8)))
    # At the very level of some average, where one bit decides.
    smooth = moving_average(moving_average(returns, short), long)
    levels = st.floats(-20, 0)
    best = data.draw(st.sampled_from(list(smooth)) | levels if len(smooth) else levels) + 0.9
    averages, found = Averages.of((short, long)), None
    for start, stop in pairwise([0, *cuts, len(returns)]):
        averages, at = averages.after(returns[start:stop], best)
        found = at if found is None else found
        assert found == episodes_to_convergence(returns[:stop], best, (short, long))
    assert averages.episodes == len(returns)


def test_averages_round_as_the_prefix_sums_of_all_episodes_do():
    rng = np.random.default_rng(0)
    returns = (rng.normal(-30, 9, 9_000) + np.linspace(-40, 17, 9_000)).astype(np.float32)
    smooth = moving_average(moving_average(returns, SHORT_WINDOW), LONG_WINDOW)
    for level in np.quantile(smooth, [0.1, 0.5, 0.9], method="nearest"):
        for best in (level + 0.9, np.nextafter(level, 0) + 0.9):
            averages, found = Averages.of(), []
            for part in np.array_split(returns, 37):
                averages, at = averages.after(part, best)
                found += [at] if at is not None else []
            assert found[0] == episodes_to_convergence(returns, best)


def test_averages_before_a_stretch_are_left_as_they_were():
    averages, _ = Averages.of((2, 3)).after([-1.0, -2.0], -1)
    kept = averages.sums.copy(), averages.smooth_sums.copy()
    assert averages.after([-3.0, -4.0], -1)[0].episodes == 4
    np.testing.assert_array_equal(averages.sums, kept[0])
    np.testing.assert_array_equal(averages.smooth_sums, kept[1])
