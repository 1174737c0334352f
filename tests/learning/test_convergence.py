import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from habilis.learning.convergence import episodes_to_convergence, moving_average


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
