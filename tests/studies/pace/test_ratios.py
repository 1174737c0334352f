"""The ratio over an ensemble."""

import numpy as np
import pytest
from paces import write_pace

from habilis.studies.comparison import Outcome
from habilis.studies.pace.data import AgentRuns, Learner, load_pace
from habilis.studies.pace.ratios import one_by_one, ratio_over
from habilis.studies.paper.published import EXPERIMENTS

FIRST, SECOND = EXPERIMENTS
VANILLA, FOE, TOE = FIRST.rows


def learner(vanilla, toe, had_vanilla=None, had_toe=None):
    """A learner with two agents in the corridor, by the episodes to convergence of their runs."""
    sides = (("none", vanilla, had_vanilla), ("TOE", toe, had_toe))
    agents = []
    for reward, counts, had in sides:
        counts = np.array(counts, float)
        measures = {"convergence": counts, "first success": counts / 10}
        had = counts if had is None else np.array(had, float)
        agents.append(AgentRuns("corridor", "picker", reward, 0, 0.0, measures, had))
    return Learner("one", "ensemble", {"table1": "corridor", "table2": "yard"}, tuple(agents))


def test_the_ratio_is_the_geometric_mean_over_learners_of_ratios_of_means():
    learners = [learner([100, 300], [50, 50]), learner([10, 10], [40, 120])]
    found = ratio_over(learners, FIRST, TOE, VANILLA)
    assert found is not None
    assert found.middle == pytest.approx(np.sqrt(50 / 200 * 80 / 10))
    assert (found.learners, found.converged, found.runs) == (2, 4, 4)


def test_a_run_that_did_not_converge_counts_with_what_it_had():
    one = learner([100, 100], [50, np.inf], had_toe=[50, 350])
    found = ratio_over([one], FIRST, TOE, VANILLA)
    assert found is not None
    assert found.middle == pytest.approx(2)
    assert (found.converged, found.runs, found.vanilla_converged) == (1, 2, 2)


def test_the_interval_is_that_of_a_plain_bootstrap_within_each_agent():
    random = np.random.default_rng(5)
    learners = [learner(random.lognormal(5, 0.4, 10), random.lognormal(5, 0.4, 10)) for _ in "123"]
    found = ratio_over(learners, FIRST, TOE, VANILLA)
    assert found is not None
    draws = []
    for _ in range(4000):
        logs = []
        for one in learners:
            bare, toe = (random.choice(agent.had, 10) for agent in one.agents)
            logs.append(np.log(toe.mean() / bare.mean()))
        draws.append(np.exp(np.mean(logs)))
    low, high = np.quantile(draws, [0.025, 0.975])
    assert found.low == pytest.approx(low, rel=0.03)
    assert found.high == pytest.approx(high, rel=0.03)


def test_orders_hold_are_opposite_or_undecided():
    near, far = [100, 110, 90, 105, 95], [200, 210, 190, 205, 195]
    outcomes = [
        ratio_over([learner(*sides)], FIRST, TOE, VANILLA).outcome  # pyright: ignore[reportOptionalMemberAccess]
        for sides in ((far, near), (near, far), (near, near))
    ]
    assert outcomes == [Outcome.HOLDS, Outcome.OPPOSITE, Outcome.UNDECIDED]


def test_an_agent_that_never_converges_is_not_the_sooner_one_for_having_had_few_long_episodes():
    """It hovers: its budget of steps is gone after 40 episodes; vanilla converges after 100."""
    one = learner([90, 95, 100, 105, 110], [np.inf] * 5, had_toe=[40] * 5)
    found = ratio_over([one], FIRST, TOE, VANILLA)
    assert found is not None
    assert found.middle == pytest.approx(0.4)
    assert (found.kind, found.outcome) == ("at least", Outcome.OPPOSITE)


def test_no_learner_with_both_rows_is_no_ratio():
    assert ratio_over([], FIRST, TOE, VANILLA) is None
    assert ratio_over([learner([1, 2], [3, 4])], FIRST, FOE, VANILLA) is None


def test_the_pairs_one_by_one_are_all_rows_of_all_pairs(tmp_path):
    rows = one_by_one(load_pace(write_pace(tmp_path)).ensemble)
    assert len(rows) == 5 * 7
    vanilla = rows.filter(row="A2C")
    assert vanilla["ratio"].null_count() == vanilla["outcome"].null_count() == 5
    assert set(rows.filter(row="A2C with 6-step TOE")["outcome"]) == {"holds"}
    assert one_by_one([]).is_empty()
