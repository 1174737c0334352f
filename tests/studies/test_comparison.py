"""One definition of holds, undecided and opposite."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import polars as pl
import pytest

from habilis.statistics import mann_whitney
from habilis.studies.comparison import (
    Outcome,
    compare,
    compare_within,
    in_words,
    tally,
)
from habilis.studies.paper import tables
from habilis.studies.paper.published import EXPERIMENTS
from research.multiverse import claims


def test_mann_whitney_is_what_it_says():
    a, b = np.array([1.0, 2, 5, np.inf]), np.array([3.0, 4, 6, 7])
    below, p = mann_whitney(a, b)
    assert below == (4 + 4 + 2 + 0) / 16
    deviation = np.sqrt(4 * 4 * 9 / 12)
    from scipy.stats import norm

    assert p == pytest.approx(2 * norm.sf((10 - 8 - 0.5) / deviation))
    assert mann_whitney(np.full(3, np.inf), np.full(3, np.inf)) == (0.5, 1.0)


def test_separated_runs_hold_or_are_opposite_and_others_are_undecided():
    soon, late = np.arange(10.0), np.arange(10.0) + 100
    assert compare(soon, late).outcome is Outcome.HOLDS
    assert compare(late, soon).outcome is Outcome.OPPOSITE
    assert compare(soon, soon + 0.5).outcome is Outcome.UNDECIDED
    assert compare(soon, soon).p == 1


def test_a_run_that_exceeded_its_budget_is_later_than_all_others():
    some = np.array([1.0, 2, 3, 4, 5, 6, 7, 8, 9, 10])
    found = compare(some, np.full(10, np.inf))
    assert (found.outcome, found.superiority) == (Outcome.HOLDS, 1)
    assert (found.sooner_converged, found.later_converged) == (10, 0)


@pytest.mark.ill_typed
def test_the_report_and_the_multiverse_say_the_same_of_the_same_runs():
    """Ways in which ten runs may interleave with ten others, some infinite, by both."""
    random = np.random.default_rng(0)
    for _ in range(50):
        shift, exceeded = random.integers(0, 60), random.integers(0, 4)
        sides = [random.integers(100, 200, 10) + extra for extra in (0, shift)]
        frames, results = [], []
        for label, counts in zip(("A2C with 6-step TOE", "A2C"), sides, strict=True):
            at = [None if k < exceeded else int(n) for k, n in enumerate(counts)]
            frames.append(pl.DataFrame({"converged_at": at, "steps_had": counts}))
            row = next(row for row in EXPERIMENTS[0].rows if row.label == label)
            run: Any = SimpleNamespace(converged_at=at)
            results.append(tables.Result(row, run, counts.astype(float)))
        expected = claims.verdict(frames[0], frames[1], "episodes")
        first, second = results
        found = tables._order(first, second)
        assert found.outcome is expected.outcome
        assert (found.ranks.superiority, found.ranks.p) == (expected.superiority, expected.p)


def test_over_one_setting_the_verdict_is_mann_whitneys_ties_and_infinite_runs_included():
    random = np.random.default_rng(3)
    for _ in range(30):
        a, b = (random.integers(0, 12, size).astype(float) for size in (10, 7))
        a[a > 10] = np.inf
        b[b > 9] = np.inf
        one, over = compare(a, b), compare_within([(a, b)])
        assert over.superiority == pytest.approx(one.superiority)
        assert over.p == pytest.approx(one.p)
        assert (over.sooner_converged, over.later_converged) == (
            one.sooner_converged,
            one.later_converged,
        )


def test_over_several_settings_p_is_that_of_permuting_the_runs_within_each():
    """Settings differ a hundredfold in pace, which a test of all runs pooled would not survive."""
    random = np.random.default_rng(1)
    pairs = [
        (scale * random.lognormal(-0.25, 0.3, 6), scale * random.lognormal(0, 0.3, 6))
        for scale in (1, 10, 100)
    ]
    found = compare_within(pairs)
    drawn = []
    for _ in range(4000):
        total = 0.0
        for a, b in pairs:
            both = random.permutation(np.concatenate([a, b]))
            total += mann_whitney(both[:6], both[6:])[0] - 0.5
        drawn.append(abs(total / 3) >= abs(found.superiority - 0.5) - 1e-12)
    assert found.p == pytest.approx(np.mean(drawn), abs=0.02)


def test_agents_that_never_converge_are_undecided_over_settings_too():
    never = np.full(5, np.inf)
    assert compare_within([(never, never)] * 3).outcome is Outcome.UNDECIDED


def test_a_tally_names_all_three_values_even_those_that_do_not_occur():
    counts = tally([Outcome.UNDECIDED] * 4 + [Outcome.HOLDS] * 8)
    assert in_words(counts) == "holds 8, undecided 4, opposite 0"


@pytest.mark.parametrize("value", ["holds", "undecided", "opposite"])
def test_outcomes_are_written_as_the_words_that_are_printed(value):
    assert str(Outcome(value)) == value
