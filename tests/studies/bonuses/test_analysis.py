"""The shared parts of the studies of learning agents."""

from dataclasses import replace

import numpy as np
import polars as pl
import pytest

from habilis.learning.config import Config
from habilis.learning.runs import Run
from habilis.statistics import bootstrap_interval, holm
from habilis.studies.bonuses.analysis import contrasts, sentences, summary
from habilis.studies.bonuses.report import Answer, write_report
from habilis.studies.bonuses.run import STUDIES
from habilis.studies.bonuses.study import BETAS, CONVERGENCE, FULL, Agent, Measure
from habilis.studies.bonuses.training import episodes_of, points_of
from habilis.studies.bonuses.weights import choose
from habilis.studies.comparison import Outcome

TWO_GOALS = STUDIES["two-goals"]
RNG = np.random.default_rng(0)


def made_up(study, converged_at, **columns):
    """Ten runs of every agent in every case; `converged_at` gives the episodes of run k of one."""
    rows = []
    for case in study.cases:
        for agent in study.agents:
            for run in range(10):
                at = converged_at(agent.name, run)
                row = {"case": case.name, "agent": agent.name, "beta": 0.1 * agent.has_bonus}
                row |= {"seed": 0, "run": run, "converged_at": at, "first_success": 5 + run}
                row |= {"episodes": at or 20_000, "steps": 100_000, "finite": True}
                rows.append(
                    row | {name: reported(agent.name, run) for name, reported in columns.items()}
                )
    whole = {"converged_at": pl.Int64, "first_success": pl.Int64}
    return pl.DataFrame(rows, schema_overrides=whole, infer_schema_length=None)


def episodes(agent, run):
    """The sum is the soonest, the product the latest; of the second can no run converges."""
    if agent.endswith("second can"):
        return None
    first = {"A2C + sum of both cans": 3_000, "A2C + product of both cans": 9_000}
    return first.get(agent, 6_000) + 10 * run


RUNS = made_up(TWO_GOALS, episodes)


def test_the_table_has_the_middle_half_and_its_interval():
    table = summary(TWO_GOALS, RUNS)
    assert len(table) == len(TWO_GOALS.cases) * len(TWO_GOALS.agents)
    one = table.filter(agent="A2C + sum of both cans").row(0, named=True)
    assert one["converged_at"] == np.mean([3020, 3030, 3040, 3050, 3060, 3070])
    assert (
        3_000 <= one["converged_at_low"] < one["converged_at"] < one["converged_at_high"] <= 3_090
    )
    assert (one["converged"], one["runs"]) == (10, 10)


def test_runs_that_exceeded_their_budget_have_no_mean():
    one = summary(TWO_GOALS, RUNS).filter(agent="A2C + second can").row(0, named=True)
    assert (one["converged"], one["converged_at"], one["converged_at_high"]) == (0, None, None)
    assert one["first_success"] is not None


def test_shares_are_means_with_the_bootstrap_interval_of_the_project():
    share = Measure("share", "a share", counts=False)
    values = RNG.uniform(size=10)
    study = replace(TWO_GOALS, measures=(share,))
    runs = made_up(study, episodes, share=lambda _, run: values[run])
    one = summary(study, runs).row(0, named=True)
    low, high = map(float, bootstrap_interval(values))
    assert (one["share"], one["share_low"], one["share_high"]) == pytest.approx(
        (values.mean(), low, high)
    )


def test_comparisons_and_their_sentences_come_from_the_numbers():
    compared = contrasts(TWO_GOALS, RUNS)
    outcome = {(c.agent, c.other): c.outcome for c in compared}
    assert outcome["A2C + sum of both cans", "A2C"] is Outcome.HOLDS
    assert outcome["A2C + product of both cans", "A2C"] is Outcome.OPPOSITE
    assert outcome["A2C + second can", "A2C"] is Outcome.OPPOSITE
    assert outcome["A2C + first can", "A2C"] is Outcome.UNDECIDED
    reported = dict.fromkeys(sentences(TWO_GOALS, compared))
    assert any("A2C + product of both cans is later than A2C (p = " in line for line in reported)
    assert any("A2C + first can is not distinguishable from A2C (p = " in line for line in reported)
    other = made_up(TWO_GOALS, lambda agent, run: 12_000 - (episodes(agent, run) or 0))
    turned = {(c.agent, c.other): c.outcome for c in contrasts(TWO_GOALS, other)}
    assert turned["A2C + sum of both cans", "A2C"] is Outcome.OPPOSITE


def test_of_shares_the_larger_is_the_better():
    share = Measure("share", "a share", counts=False)
    study = replace(TWO_GOALS, measures=(share,), pairs=(("PPO", "A2C"),))
    runs = made_up(study, episodes, share=lambda agent, run: 0.01 * run + 0.5 * (agent == "PPO"))
    (one,) = contrasts(study, runs)
    assert one.outcome is Outcome.HOLDS
    assert "PPO is higher than A2C" in sentences(study, [one])[0]


def test_p_values_are_corrected_as_holm_has_them():
    assert holm([0.2, 0.001, 0.02]) == pytest.approx([0.2, 0.003, 0.04])
    assert holm([0.5, 0.6]) == [1.0, 1.0]


def tried(values, measure="converged_at"):
    rows = [
        {"case": "a", "agent": "b", "beta": beta, "converged_at": None, "first_success": None}
        | {measure: value}
        for beta, several in values.items()
        for value in several
    ]
    return pl.DataFrame(rows, infer_schema_length=None)


@pytest.mark.parametrize(
    ("values", "best"),
    [
        ({0.03: [900, 900], 0.1: [500, 700], 0.3: [None, 100]}, 0.1),
        ({0.03: [None, None], 0.1: [None, None], 0.3: [None, 5_000]}, 0.3),
        ({0.3: [500, 700], 0.1: [600, 600]}, 0.1),
    ],
)
def test_a_weight_is_chosen_by_how_many_converge_then_by_how_soon(values, best):
    assert choose(tried(values), CONVERGENCE) == {("a", "b"): best}


def test_where_no_run_converges_the_first_success_decides():
    found = tried({0.03: [50, None], 0.1: [500, 700], 0.3: [40, None]}, "first_success")
    assert choose(found, CONVERGENCE) == {("a", "b"): 0.1}


def test_by_a_share_the_largest_mean_decides():
    found = tried({0.03: [0.2, 0.9], 0.1: [0.6, 0.6], 0.3: [0.5, 0.5]}, "unseen")
    assert choose(found, Measure("unseen", "success", counts=False)) == {("a", "b"): 0.1}


def test_the_first_success_is_the_first_episode_that_was_not_cut_off():
    steps = {"run": [1, 1, 1], "steps": [500, 20, 30], "return": [-500.0, -19.0, -29.0]}
    whole = Run(Config(), TWO_GOALS.cases[0].world, -20.0, pl.DataFrame(steps), (None,) * 2, None)
    assert episodes_of(whole, 1) == {"first_success": 2, "steps": 550}
    part = replace(whole, episodes=whole.episodes.head(1))
    assert episodes_of(part, 1) == {"first_success": None, "steps": 500}


def test_every_bonus_has_the_same_weights_and_horizon_and_settings():
    for study in STUDIES.values():
        for agent in study.agents:
            bare = Agent.of(agent.name, algorithm=agent.config.as_dict()["algorithm"])
            assert agent.config.algorithm == bare.config.algorithm
            assert agent.config.horizon in (0, 4)
            assert agent.has_bonus == (agent.config.beta in BETAS)


def test_weights_are_chosen_from_other_random_numbers_and_placements():
    for study in STUDIES.values():
        agent = next(agent for agent in study.agents if agent.has_bonus)
        case = study.cases[0]
        shown, tried_ = (points_of(study, case, agent, 0.1, FULL, tried=t) for t in (False, True))
        assert sum(point.config.runs for point in shown) == 10
        for column in ("seed", "starts_seed") if "starts" in case.settings else ("seed",):
            mine, others = ({getattr(p.config, column) for p in part} for part in (shown, tried_))
            assert mine.isdisjoint(others)


def test_pairs_are_of_agents_that_there_are():
    for study in STUDIES.values():
        names = {agent.name for agent in study.agents}
        assert len(names) == len(study.agents)
        assert {name for pair in study.pairs for name in pair} <= names


def test_a_report_shows_what_was_found(tmp_path):
    answer = Answer.of(TWO_GOALS, RUNS)
    write_report([answer], FULL, tmp_path)
    page = (tmp_path / "report.html").read_text()
    assert answer.outcome[0] in page
    assert "<svg" in page
    assert "3,045" in page
    assert "meaningless" not in page
    assert pl.read_csv(tmp_path / "two-goals.csv").height == len(TWO_GOALS.agents)
