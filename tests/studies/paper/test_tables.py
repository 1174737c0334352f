from dataclasses import replace

import numpy as np
import polars as pl
import pytest

from habilis.learning.config import Config
from habilis.learning.runs import Run
from habilis.studies.comparison import Outcome
from habilis.studies.paper.published import EXPERIMENTS
from habilis.studies.paper.tables import Result, row_orders, table
from habilis.worlds.world import load_world

FIRST, SECOND = EXPERIMENTS


def run(counts, exceeded=()):
    """A run whose runs took so many episodes; those that exceed their budget do not converge."""
    episodes = pl.DataFrame(
        {"run": np.repeat(np.arange(len(counts)), counts), "episode": 0, "return": -1.0}
    )
    converged = tuple(None if i in exceeded else int(n) for i, n in enumerate(counts))
    config = Config(runs=len(counts))
    return Run(config, load_world("corridor"), -14.0, episodes, converged, None)  # pyright: ignore[reportArgumentType]


def results(experiment, runs):
    return [Result.of(row, r) for row, r in zip(experiment.rows, runs, strict=True)]


def test_mean_and_deviation_are_over_all_runs():
    result = Result.of(FIRST.rows[0], run([10, 20, 60]))
    assert (result.mean, result.converged, result.all_converged) == (30, 3, True)
    assert result.deviation == pytest.approx(np.std([10, 20, 60], ddof=1))


def test_a_run_that_exceeded_its_budget_stays_in_the_mean_and_is_shown():
    result = Result.of(FIRST.rows[0], run([10, 20, 60], exceeded=[2]))
    assert (result.mean, result.converged, result.all_converged) == (30, 2, False)
    row = table(FIRST, results(FIRST, [run([10, 20, 60], [2]), run([30] * 3), run([60] * 3)]))
    assert row["mean_is_lower_bound"].to_list() == [True, False, False]
    assert row["converged"].to_list() == [2, 3, 3]


def test_ratios_are_to_the_vanilla_row_with_the_same_tool():
    rows = table(
        SECOND, results(SECOND, [run([10] * 2), run([5] * 2), run([100] * 2), run([80] * 2)])
    )
    assert rows["ours_ratio"].to_list() == [1.0, 0.5, 1.0, 0.8]
    published = rows["published_ratio"].to_list()
    assert published == pytest.approx([1, 11672.4 / 15555.4, 1, 37657.6 / 52872.2])


# By hand from means, deviations and n = 10, with Welch and Satterthwaite's degrees of freedom.
WELCH = {
    ("A2C with 6-step TOE", "A2C with 5-step FOE"): 0.1498,
    ("A2C with 6-step TOE", "A2C"): 7.983e-06,
    ("A2C with 5-step FOE", "A2C"): 0.0009385,
    ("A2C with 3-step TOE (picker)", "A2C (picker)"): 5.754e-10,
    ("A2C with 3-step TOE (picker)", "A2C with 3-step TOE (broom)"): 2.726e-08,
    ("A2C with 3-step TOE (picker)", "A2C (broom)"): 3.491e-08,
    ("A2C (picker)", "A2C with 3-step TOE (broom)"): 1.509e-07,
    ("A2C (picker)", "A2C (broom)"): 9.328e-08,
    ("A2C with 3-step TOE (broom)", "A2C (broom)"): 9.308e-05,
}


def test_a_ratio_to_a_lower_bound_is_an_upper_bound():
    whole, cut = run([10, 20]), run([10, 20], exceeded=[1])
    rows = table(SECOND, results(SECOND, [whole, cut, cut, whole]))
    assert rows["ratio_is"].to_list() == ["exact", "at least", "exact", "at most"]
    rows = table(SECOND, results(SECOND, [cut, cut, whole, whole]))
    assert rows["ratio_is"].to_list() == ["exact", "unknown", "exact", "exact"]


def test_the_papers_pairs_are_separated_as_its_figures_say():
    """All at p < 0.001, but for FOE and TOE of Table I, p = 0.15."""
    for experiment in EXPERIMENTS:
        same = [run([10, 12])] * len(experiment.rows)
        for c in row_orders(experiment, results(experiment, same)):
            assert c.published_p == pytest.approx(WELCH[c.faster, c.slower], rel=0.001)
            if {c.faster, c.slower} == {"A2C with 5-step FOE", "A2C with 6-step TOE"}:
                assert c.published_p == pytest.approx(0.15, abs=0.005)
            else:
                assert c.published_p < 0.001
            assert c.published_ratio < 1


def test_verdicts_are_plain_about_order_doubt_and_runs_that_exceeded_their_budget():
    fast, slow = run([100, 110, 105, 104, 107]), run([200, 210, 205, 220, 190])
    exceeded = run([900, 111, 104, 103, 102], exceeded=[0])
    verdict = {
        (c.faster, c.slower): c.verdict
        for c in row_orders(FIRST, results(FIRST, [slow, fast, exceeded]))
    }
    vanilla, foe, toe = (row.label for row in FIRST.rows)
    assert verdict[foe, vanilla].startswith("the paper's order (p = ")
    assert verdict[toe, foe].startswith("undecided: not separated (p = ")
    assert verdict[toe, vanilla].startswith("undecided: not separated (p = ")
    opposite = row_orders(FIRST, results(FIRST, [fast, slow, slow]))
    assert all(
        c.verdict.startswith("the opposite order (p") for c in opposite if c.slower == vanilla
    )


def test_where_runs_exceeded_their_budget_ranks_decide_and_not_the_episodes_they_had():
    """One of ten exceeds its budget: early or late, it counts as the slowest."""
    fast, slow = list(range(100, 110)), list(range(200, 210))
    for had in (1, 5_000):
        few = run([*fast[:9], had], exceeded=[9])
        ours = row_orders(FIRST, results(FIRST, [run(slow), few, few]))
        assert all(c.outcome is Outcome.HOLDS for c in ours if c.slower == "A2C")
        assert all(not c.complete for c in ours)
        none = run([had] * 10, exceeded=range(10))
        ours = row_orders(FIRST, results(FIRST, [run(slow), none, none]))
        assert all(c.outcome is Outcome.OPPOSITE for c in ours if c.slower == "A2C")


def test_the_median_takes_a_run_that_exceeded_its_budget_for_the_longest():
    assert Result.of(FIRST.rows[0], run([10, 20, 1], exceeded=[2])).median == 20
    assert Result.of(FIRST.rows[0], run([10, 20, 1], exceeded=[0, 2])).median == np.inf


def test_equal_rows_and_rows_that_do_not_vary_are_undecided():
    for counts in ([100, 110, 105], [100, 100, 100]):
        for c in row_orders(FIRST, results(FIRST, [run(counts)] * 3)):
            assert c.outcome is Outcome.UNDECIDED
            assert c.verdict == "undecided: not separated (p = 1)"


def test_welch_is_welch_and_undefined_for_single_runs():
    a, b = [100, 120, 90, 101], [130, 180, 150, 177]
    found = row_orders(FIRST, results(FIRST, [run(b), run(a), run(a)]))[1]
    x, y = np.array(a, float), np.array(b, float)
    va, vb = x.var(ddof=1) / 4, y.var(ddof=1) / 4
    t = (x.mean() - y.mean()) / np.sqrt(va + vb)
    df = (va + vb) ** 2 / (va**2 / 3 + vb**2 / 3)
    from scipy.stats import t as student

    assert found.ours_p == pytest.approx(2 * student.sf(abs(t), df))
    single = row_orders(FIRST, results(FIRST, [run([10]), run([20]), run([30])]))
    assert all(c.ours_p == 1 for c in single)


def test_rows_are_the_papers():
    assert [row.label for row in FIRST.rows] == [
        "A2C",
        "A2C with 5-step FOE",
        "A2C with 6-step TOE",
    ]
    assert [(r.tool, r.horizon, r.beta) for r in SECOND.rows if not r.vanilla] == [
        ("picker", 3, 0.08),
        ("broom", 3, 0.08),
    ]
    assert replace(FIRST.rows[0], beta=0.1).vanilla is False
