import numpy as np
import pytest
from scipy import stats

from habilis.statistics import (
    bootstrap_interval,
    interquartile_mean,
    mean,
    stratified_interval,
)


@pytest.mark.parametrize("runs", [1, 2, 3, 4, 5, 8, 10, 11])
def test_the_interquartile_mean_is_the_trimmed_mean_of_scipy(runs):
    scores = np.random.default_rng(runs).normal(size=(runs, 7))
    wanted = stats.trim_mean(scores, 0.25, axis=0)
    np.testing.assert_allclose(interquartile_mean(scores), wanted, rtol=1e-12)


def test_runs_that_fail_do_not_move_the_interquartile_mean():
    scores = np.array([-500.0, -500.0, -12.0, -12.0, -12.0, -12.0, -11.0, -11.0])
    assert interquartile_mean(scores) == -12
    assert mean(scores) < -100


@pytest.mark.parametrize("statistic", [mean, interquartile_mean])
def test_an_interval_is_that_of_scipy(statistic):
    scores = np.random.default_rng(1).gamma(2.0, size=20)
    wanted = stats.bootstrap(
        (scores,),
        lambda x, axis: statistic(np.moveaxis(x, axis, 0)),
        n_resamples=20_000,
        method="percentile",
        rng=np.random.default_rng(2),
    ).confidence_interval
    low, high = bootstrap_interval(scores, statistic, repeats=20_000)
    assert low == pytest.approx(wanted.low, abs=0.03)
    assert high == pytest.approx(wanted.high, abs=0.03)


def test_an_interval_covers_the_truth_about_as_often_as_it_says():
    random = np.random.default_rng(4)
    truth = 3.0
    # Each column is an experiment of its own; columns are drawn together, which does no harm here.
    experiments = random.normal(truth, 2.0, size=(20, 1_000))
    for confidence, least, most in ((0.95, 0.88, 0.96), (0.5, 0.43, 0.53)):
        low, high = bootstrap_interval(experiments, confidence=confidence, repeats=500)
        covered = ((low <= truth) & (truth <= high)).mean()
        assert least < covered < most  # a percentile interval of 20 runs is somewhat too narrow


def test_a_run_is_drawn_with_all_its_points():
    # The points of a run sum to 0, so those of any mean of runs do, and so do mirrored ends.
    runs = np.array([[1.0, -1.0], [5.0, -5.0], [9.0, -9.0]])
    low, high = bootstrap_interval(runs, lambda drawn: mean(drawn).sum(-1, keepdims=True))
    assert low == high == 0


def test_tasks_keep_their_shares():
    # Were runs drawn from the pool, the mean would vary; within tasks it cannot.
    low, high = stratified_interval([np.zeros(5), np.full(3, 8.0)], mean)
    assert low == high == 3
    loose = bootstrap_interval(np.array([0.0] * 5 + [8.0] * 3))
    assert loose[0] < 3 < loose[1]


def test_the_same_seed_gives_the_same_interval():
    values = np.random.default_rng(0).normal(size=(6, 50))
    one = bootstrap_interval(values, interquartile_mean)
    np.testing.assert_array_equal(one, bootstrap_interval(values, interquartile_mean))
    assert not np.array_equal(one, bootstrap_interval(values, interquartile_mean, seed=1))


def test_one_run_has_an_interval_of_no_width():
    low, high = bootstrap_interval(np.array([[3.0, 4.0]]))
    np.testing.assert_array_equal(low, [3, 4])
    np.testing.assert_array_equal(high, [3, 4])


def test_no_runs_are_refused():
    with pytest.raises(ValueError, match="over no runs; give at least one"):
        bootstrap_interval(np.empty((0, 3)))
    with pytest.raises(ValueError, match="confidence is 95"):
        bootstrap_interval(np.zeros((2, 3)), confidence=95)
