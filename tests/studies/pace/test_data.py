"""Reading what is checked in at the paper's pace."""

import numpy as np
import pytest
from paces import write_pace

from habilis.studies.pace.data import FILES, FOLDER, load_pace
from habilis.studies.paper.published import EXPERIMENTS

FIRST, SECOND = EXPERIMENTS


@pytest.fixture
def folder(tmp_path):
    return write_pace(tmp_path / "pace")


def test_what_is_written_is_read(folder):
    pace = load_pace(folder)
    assert pace.missing == ()
    assert [pair.setting for pair in pace.pairs] == [11, 12, 13, 14, 15]
    assert pace.best is not None
    assert pace.best is pace.pairs[0]
    assert pace.best.maps == {"table1": "corridor-01", "table2": "yard-01"}
    assert pace.best.learner["learning_rate"] == 0.002
    assert pace.best.learner["hidden"] == (64, 64), "as a field of Config"
    assert [learner.name for learner in pace.ensemble] == [f"pair {k}" for k in range(1, 6)]
    assert pace.thirty is not None
    assert {agent.runs for agent in pace.thirty.agents} == {30}
    assert len(pace.learners) == 5 + 5
    assert pace.after == ("The budget of the broom was doubled.",)
    assert pace.screened is not None
    assert pace.screened["setting"].n_unique() == 12


def test_every_row_of_both_tables_is_found_by_its_tool_and_reward(folder):
    for learner in load_pace(folder).ensemble:
        for experiment in EXPERIMENTS:
            for row in experiment.rows:
                agent = learner.agent(experiment, row)
                assert agent is not None
                assert (agent.tool, agent.horizon, agent.beta) == (row.tool, row.horizon, row.beta)
                assert agent.map == learner.maps[experiment.name]


def test_a_run_that_did_not_converge_is_infinite_and_counts_with_the_episodes_it_had(folder):
    broom = SECOND.rows[2]
    agent = load_pace(folder).ensemble[0].agent(SECOND, broom)
    assert agent is not None
    assert (agent.runs, agent.came(), agent.came("first success")) == (10, 9, 10)
    assert np.isinf(agent.counts["convergence"][0])
    assert agent.budgeted()[0] == agent.had[0] < np.inf
    np.testing.assert_array_equal(agent.budgeted()[1:], agent.counts["convergence"][1:])


@pytest.mark.parametrize("name", FILES)
def test_a_file_that_is_missing_is_named_and_the_rest_is_read(folder, name):
    (folder / name).unlink()
    pace = load_pace(folder)
    assert pace.missing == (name,)
    assert len(pace.learners) == {"ensemble.csv": 5, "compared.csv": 5}.get(name, 10)


@pytest.mark.parametrize(
    ("name", "old", "new", "error"),
    [
        ("ensemble.csv", "first_success,steps", "firsts,steps", "no column 'first_success'"),
        ("ensemble.csv", "yard-01,corridor-01,picker", "yard-01,x,picker", "pair 1 has a row on x"),
        ("ensemble.csv", ",none,0,0.0,10,10,", ",none,0,0.0,10,9,", "converged is 9, but 10 runs"),
        ("ensemble.csv", ",none,0,0.0,10,10,", ",none,0,0.0,9,10,", "10 counts for 9 runs"),
        ("ensemble.csv", ",FOE,", ",EOF,", "no such reward"),
        ("ensemble.csv", "- ", "some ", "give numbers and -"),
        ("compared.csv", ",had", ",has", "no count in 'had'"),
        ("thirty.csv", "1,11,corridor-01,yard-01,y", "2,11,corridor-01,yard-01,y", "2 pairs"),
        ("pairs.toml", "yard =", "yards =", "pair 1 has no yard"),
        ("pairs.toml", "[[pair]]", "[pair]", "cannot be read"),
        ("after.toml", 'decided = ["', 'decided = [3, "', "list of sentences"),
    ],
)  # fmt: skip
def test_a_file_that_is_wrong_is_refused_in_one_line(folder, name, old, new, error):
    path = folder / name
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(ValueError, match=error) as caught:
        load_pace(folder)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_what_is_checked_in_can_be_read():
    pace = load_pace(FOLDER)
    for learner in pace.learners:
        for experiment in EXPERIMENTS:
            for row in experiment.rows:
                assert learner.agent(experiment, row) is not None, (learner.name, row.label)
    for pair, learner in zip(pace.pairs, pace.ensemble, strict=False):
        assert pair.maps == learner.maps
