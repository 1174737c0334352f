"""The second part of the report."""

import shutil
from pathlib import Path

import numpy as np
import polars as pl
import pytest

import habilis as hb
from habilis.analysis.averages import average_empowerment
from habilis.statistics import interquartile_interval, pooled_interquartile_interval
from research.multiverse import claims
from research.multiverse.optimum import return_of_the_best_policy
from research.multiverse.report import settings_count, write_page, write_study
from research.multiverse.results import Multiverse, aggregate, joined, paper_curves
from research.multiverse.settings import BETAS, HORIZONS, WORLDS, agents, all_maps

EVERYONE = agents(all_maps())


def results_of(everyone, episodes, converged=lambda agent: True):
    """Results in which all runs of an agent take about as many episodes as a function says."""
    rows = [
        {
            "point": point,
            "run": run,
            "converged_at": episodes(agent) + run if converged(agent) else None,
            "episodes_had": episodes(agent) + run,
            "steps_had": 20 * (episodes(agent) + run),
            "best_return": -14.0,
            "final_return": -14.5,
            "curve": [-100.0] * (episodes(agent) // 100 + run) + [-20.0, -15.0],
        }
        for point, agent in enumerate(everyone)
        for run in range(10)
    ]
    return pl.DataFrame(rows, infer_schema_length=None)


@pytest.fixture(scope="module")
def study():
    """TOE is learned sooner than FOE, FOE than nothing, the picker sooner than the broom."""
    first = {"TOE": 3_000, "FOE": 4_000, "none": 5_000}

    def episodes(agent):
        return first[agent.reward] + 10_000 * (agent.tool == "broom")

    return Multiverse.of(joined(EVERYONE, results_of(EVERYONE, episodes)))


def test_the_grid_has_at_least_sixty_settings_and_ten_runs_of_each():
    settings = {
        (a.learner, a.horizon, a.beta)
        for a in EVERYONE
        if a.part == "multiverse" and a.reward != "none"
    }
    assert len(settings) >= 60
    assert all(agent.config.runs == 10 for agent in EVERYONE)
    assert {a.map for a in EVERYONE if a.part == "multiverse"} == {"corridor", "yard"}


def test_betas_and_horizons_reach_as_far_as_they_should():
    assert max(BETAS) == 0.3
    assert (min(HORIZONS), max(HORIZONS)) == (1, 8)


def test_every_claim_holds_everywhere_where_it_is_made_to(study):
    shares = claims.shares(study.multiverse)
    assert shares["claim"].to_list() == [claim.name for claim in claims.CLAIMS]
    assert (shares["holds"] == 1).all()


def test_a_claim_is_the_other_way_round_where_it_is_made_to_be():
    slow = {"TOE": 9_000, "FOE": 4_000, "none": 5_000}
    runs = joined(EVERYONE, results_of(EVERYONE, lambda agent: slow[agent.reward]))
    shares = claims.shares(claims.multiverse(runs.filter(part="multiverse"))).rows_by_key(
        "claim", named=True, unique=True
    )
    assert shares["TOE before vanilla (corridor, picker)"]["opposite"] == 1
    assert shares["FOE before vanilla (corridor, picker)"]["holds"] == 1
    assert shares["TOE before FOE (corridor)"]["opposite"] == 1
    assert shares["picker before broom, vanilla (yard)"]["undecided"] == 1


def test_a_run_that_exceeded_its_budget_comes_after_all_others():
    runs = joined(
        EVERYONE, results_of(EVERYONE, lambda agent: 5_000, lambda agent: agent.reward != "TOE")
    )
    reported = claims.multiverse(runs.filter(part="multiverse")).filter(
        claim="TOE before vanilla (corridor, picker)"
    )
    converging = reported.filter(pl.col("measure") != "first success")
    assert (converging["superiority"] == 0).all()
    assert (converging["outcome"] == "opposite").all()
    assert (reported.filter(measure="first success")["superiority"] == 0.5).all()


def test_first_success_is_when_the_curve_comes_up_to_twice_the_best_ones_cost():
    runs = pl.DataFrame(
        {"curve": [[-90.0, -28.5, -28.0, -40.0], [-90.0, -30.0]], "best_return": [-14.0, -14.0]}
    )
    assert claims.counts(runs, "first success").tolist() == [300, np.inf]


def test_the_choice_that_decides_explains_all():
    def episodes(agent):
        return 5_000 - 100 * (agent.reward == "TOE") * (1 if agent.beta > 0.1 else -1)

    runs = joined(EVERYONE, results_of(EVERYONE, episodes))
    verdicts = claims.multiverse(runs.filter(part="multiverse"))
    reported = claims.explained(verdicts.filter(measure="episodes"))
    row = reported.filter(claim="TOE before vanilla (yard, picker)").row(0, named=True)
    assert row["beta"] == pytest.approx(1)
    assert row["horizon"] == pytest.approx(0)
    assert row["learner"] == pytest.approx(0)


def test_the_pickers_average_toe_is_the_larger_one_on_every_map():
    for name, path in all_maps().items():
        if name.startswith("yard"):
            picker, broom = (hb.tabulate(hb.load_world(str(path), t)) for t in ("picker", "broom"))
            for horizon in HORIZONS:
                assert average_empowerment(picker, horizon, "object") > average_empowerment(
                    broom, horizon, "object"
                )


def test_the_papers_bonuses_leave_the_best_return_alone_and_a_large_one_does_not():
    mdp = hb.tabulate(hb.load_world("corridor"))
    bits = hb.empowerment(mdp, 6, "object")
    assert return_of_the_best_policy(mdp, bits, 0.0, 0.99) == -14
    assert return_of_the_best_policy(mdp, bits, 0.07, 0.99) == -14
    assert return_of_the_best_policy(mdp, bits, 0.3, 0.99) < -14


def test_a_bonus_larger_than_the_step_cost_keeps_the_agent_from_ending():
    line = hb.TabularMDP.deterministic(
        [[0, 1], [1, 2], [2, 2]], reward=np.full((3, 2), -1.0), terminal=[False, False, True]
    )
    never = return_of_the_best_policy(line, np.array([0.0, 2.0, 0.0]), 1.0, 0.9)
    assert never == -np.inf
    assert return_of_the_best_policy(line, np.array([0.0, 2.0, 0.0]), 0.1, 0.9) == -2


def test_the_page_has_every_table_and_picture_and_loads_nothing(study, tmp_path):
    write_study(study, tmp_path)
    text = (tmp_path / "report.html").read_text()
    assert text.count("<svg") == 10
    assert "src=" not in text
    assert f"A multiverse of {settings_count(study)} settings" in text
    for claim in claims.CLAIMS:
        assert claim.name in text
    names = {path.name for path in tmp_path.iterdir()}
    assert names >= {"runs.csv", "multiverse.csv", "maps.csv", "optima.csv", "rows.csv"}


def test_the_page_that_is_checked_in_is_what_the_data_and_the_template_give(tmp_path):
    """Or call `python -m research.multiverse --out docs/multiverse --page`."""
    docs = Path(__file__).parents[2] / "docs" / "multiverse"
    for picture in docs.glob("*.svg"):
        shutil.copy(picture, tmp_path)
    write_page(Multiverse.read(docs), tmp_path)
    assert (tmp_path / "report.html").read_text() == (docs / "report.html").read_text()


def test_the_worlds_are_the_papers():
    assert [(world, tool) for world, tool, _ in WORLDS] == [
        ("corridor", "picker"),
        ("yard", "picker"),
        ("yard", "broom"),
    ]


def runs_of(converged_at, steps, **columns):
    own = {"converged_at": converged_at, "steps_had": steps, "episodes_had": [9] * len(steps)}
    fixed = {name: [value] * len(steps) for name, value in columns.items()}
    return pl.DataFrame(own | fixed, schema_overrides={"converged_at": pl.Int64})


def test_episodes_and_steps_are_counted_apart_and_neither_without_convergence():
    runs = runs_of([5, 6, None], [500, 400, 300])
    assert claims.counts(runs, "episodes").tolist() == [5, 6, np.inf]
    assert claims.counts(runs, "steps").tolist() == [500, 400, np.inf]


def test_an_order_that_is_not_significant_is_undecided():
    even, odd = (list(range(start, start + 20, 2)) for start in (0, 5))
    reported = claims.verdict(runs_of(even, even), runs_of(odd, odd), "episodes")
    assert 0.05 < reported.p < 0.9
    assert reported.superiority > 0.5
    assert reported.outcome == "undecided"


def test_claims_on_maps_have_the_same_direction(study):
    assert (claims.shares(study.maps)["holds"] == 1).all()
    assert set(study.maps["map"]) == set(all_maps())


def test_an_interval_is_open_where_too_many_runs_exceeded_their_budget():
    ten = np.arange(1.0, 11.0)
    middle, low, high = interquartile_interval(ten)
    assert middle == 5.5
    assert low is not None
    assert low < 5.5
    assert high is not None
    assert high > 5.5
    ten[-2:] = np.inf
    middle, low, high = interquartile_interval(ten)
    assert middle == 5.5, "the two are in the upper quarter"
    assert low is not None
    assert high is None
    ten[-3:] = np.inf
    assert interquartile_interval(ten)[0] is None


def test_agents_that_never_converge_are_not_the_sooner_ones():
    tasks = [np.array([1.0, 2.0, 3.0, 4.0]), np.full(4, np.inf)]
    assert pooled_interquartile_interval(tasks) == (None, None, None)
    middle, low, high = pooled_interquartile_interval([np.array([0.5, 0.5, 0.5, 0.5])] * 2)
    assert (middle, low, high) == (0.5, 0.5, 0.5)


def test_vanilla_is_its_own_measure(study):
    reported = aggregate(study.runs)
    assert reported["agent"].to_list()[0] == "vanilla"
    assert reported["middle"][0] == pytest.approx(1, abs=0.01)
    assert (reported["middle"][1:] < 1).all()


def test_superiority_over_vanilla_and_its_interval(study):
    rows = study.rows.filter(pl.col("reward") != "none")
    assert (rows["superiority"] == 1).all()
    assert (rows["superiority_low"] == 1).all()
    vanilla = study.rows.filter(reward="none")
    assert (vanilla["superiority"] == 0.5).all()
    assert (vanilla["superiority_low"] < 0.5).all()
    assert (vanilla["superiority_high"] > 0.5).all()


def test_each_claim_reports_where_the_optimal_policy_changes(study):
    changed = study.changed()
    toe = changed.filter(claim="TOE before vanilla (corridor, picker)")
    lost = study.optima.filter(pl.col("best_policy") < pl.col("best_return") - 0.9)
    lost = lost.filter(map="corridor", reward="TOE")
    assert len(lost)
    assert set(toe.select("horizon", "beta").rows()) == set(lost.select("horizon", "beta").rows())
    assert changed.filter(claim="picker before broom, vanilla (yard)").is_empty()


def test_curves_end_where_the_first_run_exceeded_its_budget():
    runs = joined(EVERYONE, results_of(EVERYONE, lambda agent: 1_000, lambda agent: False))
    lengths = {
        table.shape[1] for agents in paper_curves(runs).values() for table in agents.values()
    }
    assert lengths == {12}, "ten blocks, and two more, of the first run"
