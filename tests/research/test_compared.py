"""The learners that the ensemble is compared with."""

from pathlib import Path

import polars as pl

from habilis.learning.config import Config
from habilis.studies.pace.data import FOLDER, load_pace
from habilis.studies.paper.published import EXPERIMENTS
from habilis.studies.paper.settings import frozen_settings
from research.pace.compared import FAST, as_rows, compared_agents, nearest

ROOT = Path(__file__).parents[2]


def test_each_learner_has_every_row_on_the_first_two_worlds():
    everyone = compared_agents()
    for learner in {agent.learner for agent in everyone}:
        mine = [agent for agent in everyone if agent.learner == learner]
        assert [(a.map, a.tool, a.reward) for a in mine] == [
            ("corridor", "picker", "none"),
            ("corridor", "picker", "FOE"),
            ("corridor", "picker", "TOE"),
            ("yard", "picker", "none"),
            ("yard", "picker", "TOE"),
            ("yard", "broom", "none"),
            ("yard", "broom", "TOE"),
        ]


def test_the_fast_learner_has_the_papers_weights_and_the_frozen_settings():
    fast = [agent for agent in compared_agents() if agent.learner == FAST]
    rows = [row for experiment in EXPERIMENTS for row in experiment.rows]
    assert [(a.horizon, a.beta) for a in fast] == [(row.horizon, row.beta) for row in rows]
    settings = frozen_settings()
    for agent in fast:
        assert {k: agent.config.as_dict()[k] for k in settings} == settings
        assert (agent.config.runs, agent.config.seed) == (10, 0)


def test_the_nearest_of_the_grid_is_by_ratio_and_nothing_stays_nothing():
    assert [nearest(h, (1, 3, 6, 8)) for h in (0, 3, 5, 6)] == [0, 3, 6, 6]
    assert nearest(2, (1, 5)) == 1, "a half is nearer than two and a half"


def test_what_is_checked_in_of_the_multiverse_are_the_runs_of_its_report():
    """Trained again for when they first succeeded: to the same episodes, all 350 of them."""
    docs = pl.read_csv(ROOT / "docs/multiverse/runs.csv", infer_schema_length=None)
    reported = {learner.name: learner for learner in load_pace(FOLDER).compared}
    for agent in compared_agents():
        if agent.learner == FAST:
            continue
        runs = docs.filter(
            part="multiverse",
            learner=agent.learner,
            map=agent.map,
            tool=agent.tool,
            reward=agent.reward,
            horizon=agent.horizon,
            beta=agent.beta,
        ).sort("run")
        (found,) = (
            a
            for a in reported[agent.learner].agents
            if (a.map, a.tool, a.reward) == (agent.map, agent.tool, agent.reward)
        )
        at = runs["converged_at"].cast(pl.Float64).fill_null(float("inf"))
        assert found.counts["convergence"].tolist() == at.to_list()
        assert found.had.tolist() == runs["episodes_had"].to_list()


def test_rows_are_written_as_they_are_read(tmp_path):
    everyone = compared_agents()[:7]
    assert isinstance(everyone[0].config, Config)
    results = pl.DataFrame(
        [
            {"point": point, "run": run, "converged_at": None if run == 1 else 700 + run}
            | {"episodes_had": 900, "steps_had": 5_000, "best_return": -14.0}
            | {"curve": [-100.0, -20.0] if run else [-100.0, -90.0]}
            for point in range(7)
            for run in range(3)
        ]
    )
    as_rows(everyone, results).write_csv(tmp_path / "compared.csv")
    (learner,) = load_pace(tmp_path).compared
    agent = learner.agents[0]
    assert agent.counts["convergence"].tolist() == [700, float("inf"), 702]
    assert agent.budgeted().tolist() == [700, 900, 702]
    assert agent.counts["first success"].tolist() == [float("inf"), 200, 200]
