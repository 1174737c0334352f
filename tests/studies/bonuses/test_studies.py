"""The worlds of the studies of learning to choose, and the studies from end to end."""

import json
from dataclasses import replace

import numpy as np
import polars as pl
import pytest

import habilis as hb
from habilis.cli import main
from habilis.interruption import Interrupted
from habilis.learning.config import Config
from habilis.learning.runs import Run
from habilis.studies.bonuses import choosing
from habilis.studies.bonuses import run as bonus_studies
from habilis.studies.bonuses.choosing import FITTING
from habilis.studies.bonuses.report import Answer
from habilis.studies.bonuses.run import STUDIES
from habilis.studies.bonuses.study import QUICK
from habilis.studies.bonuses.training import LAYOUT, points_of, trained
from habilis.studies.bonuses.unseen import HELD_OUT
from habilis.sweeps.training import train_tasks
from habilis.tasks.session import opened
from habilis.worlds.world import NO_TOOL

CHOOSING, TWO_GOALS, UNSEEN = (STUDIES[name] for name in ("choosing", "two-goals", "unseen"))


@pytest.mark.parametrize("case", CHOOSING.cases, ids=lambda case: case.name)
def test_only_the_fitting_tool_reaches_the_goal(case):
    world = case.world
    assert FITTING in {tool.name for tool in world.tools}
    assert len(world.tools) in (2, 3)
    reached = {t.name for t in world.tools if hb.solve(hb.tabulate(world.with_tool(t)))}
    assert reached == {FITTING}
    assert hb.solve(hb.tabulate(world.with_tool(NO_TOOL))) is None
    assert hb.solve(hb.tabulate(world)) is not None


@pytest.mark.parametrize("case", CHOOSING.cases, ids=lambda case: case.name)
def test_a_shortest_plan_of_the_whole_world_ends_with_the_fitting_tool_in_hand(case):
    mdp = hb.tabulate(case.world)
    state = mdp.start
    plan = hb.solve(mdp)
    assert plan is not None
    for action in plan.actions:
        state = mdp.next_state[state, action]
    assert mdp.terminal[state]
    assert mdp.flags[f"equipped:{FITTING}"][state]


def test_one_world_lets_a_tool_be_put_down_and_one_does_not():
    assert {case.world.drop for case in CHOOSING.cases} == {True, False}


def test_a_tool_that_does_not_fit_is_kept_for_good_where_none_can_be_put_down():
    mdp = hb.tabulate(CHOOSING.cases[0].world)
    wrong = mdp.flags["equipped"] & ~mdp.flags[f"equipped:{FITTING}"]
    assert wrong.any()
    assert not mdp.flags[f"equipped:{FITTING}"][mdp.next_state[wrong]].any()
    assert not mdp.terminal[wrong].any()


def test_each_tool_of_several_has_a_flag_and_one_at_most_is_in_hand():
    world = CHOOSING.cases[0].world
    mdp = hb.tabulate(world)
    each = np.array([mdp.flags[f"equipped:{tool.name}"] for tool in world.tools])
    assert np.array_equal(each.any(axis=0), mdp.flags["equipped"])
    assert each.sum(axis=0).max() == 1
    alone = hb.tabulate(world.with_tool("rake"))
    assert list(alone.flags) == ["equipped", "attached"]


def test_both_cans_have_goals_and_ways_to_them():
    world = TWO_GOALS.cases[0].world
    assert [thing.goal is not None for thing in world.objects] == [True, True]
    assert world.objects[0].goal != world.objects[1].goal
    assert hb.solve(hb.tabulate(world)) is not None


def test_shares_of_the_fitting_tool_are_of_the_first_and_the_last_episodes():
    """It is in hand for three of five steps in the last 250 of 2,000 episodes, before for two."""
    had = np.where(np.arange(2_000) >= 1_750, 3, 2)
    steps = np.full(2_000, 5)
    zeros = np.zeros(2_000, int)
    episodes = pl.DataFrame({"run": zeros, "steps": steps, f"equipped:{FITTING}": had})

    whole = Run(Config(), CHOOSING.cases[0].world, -20.0, episodes, (None,), None)
    assert choosing.measure_run(whole, 0) == {"early": 0.0, "late": 1.0}
    part = replace(whole, episodes=episodes.head(1_800))
    assert choosing.measure_run(part, 0) == {"early": 0.0, "late": 0.5}


SHORT = {name: replace(study, cases=study.cases[:1]) for name, study in STUDIES.items()}
"""The studies with one case each: compiling takes most of the time."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """All three studies, trained next to nothing."""
    out = tmp_path_factory.mktemp("studies") / "out"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bonus_studies, "STUDIES", SHORT)
        assert main(["study", "--out", str(out), "--quick"]) == 0
        yield out


@pytest.mark.parametrize("study", SHORT.values(), ids=SHORT)
def test_a_study_runs_from_end_to_end(folder, study):
    runs = pl.read_csv(folder / f"{study.name}-runs.csv", infer_schema_length=None)
    assert len(runs) == 2 * len(study.agents)
    assert (runs["episodes"] > 0).all()
    table = pl.read_csv(folder / f"{study.name}.csv", infer_schema_length=None)
    assert table["agent"].to_list() == [agent.name for agent in study.agents]
    assert (folder / f"{study.name}.svg").read_text().count("<svg") == 1
    page = (folder / "report.html").read_text()
    assert study.title in page
    assert "the results are meaningless" in page


def test_unseen_placements_differ_from_seen_ones(folder):
    runs = pl.read_csv(folder / "unseen-runs.csv", infer_schema_length=None)
    shares = runs["unseen"] * HELD_OUT
    assert np.allclose(shares, shares.round())
    assert runs.select(pl.col("seen", "unseen").is_between(0, 1).all()).row(0) == (True, True)
    assert runs["seed"].n_unique() == 2


def test_what_is_there_is_not_trained_again(folder, capsys):
    kept = {path: path.stat().st_mtime_ns for path in (folder / "runs").iterdir()}
    damaged = next(iter(kept))
    damaged.write_bytes(b"")
    before = (folder / "choosing.csv").read_text(), (folder / "unseen-runs.csv").read_text()
    assert main(["study", "--out", str(folder), "--quick", "--resume", "--json"]) == 0
    reported = json.loads(capsys.readouterr().out)
    assert list(reported["studies"]) == list(STUDIES)
    assert all(answer["outcome"] for answer in reported["studies"].values())
    after = (folder / "choosing.csv").read_text(), (folder / "unseen-runs.csv").read_text()
    assert after == before
    trained = {p for p in kept if p.stat().st_mtime_ns != kept[p]}
    assert trained == {damaged}


def train_all(points, folder, executor=train_tasks, stopped=None):
    with opened(folder, LAYOUT, executor, resume=True) as session:
        session.stopped = stopped or session.stopped
        return trained(points, session)


def test_who_is_stopped_hears_how_to_go_on(tmp_path):
    """And what is kept already is not asked for again."""
    case, agent = TWO_GOALS.cases[0], TWO_GOALS.agents[0]
    points = points_of(TWO_GOALS, case, agent, 0.0, QUICK)
    with pytest.raises(Interrupted, match=r"0 of 1 tasks .* continue with --resume") as stop:
        train_all(points, tmp_path / "studies", stopped=lambda: 15)
    assert stop.value.signal == 15
    one = train_all(points, tmp_path / "studies")
    other = train_all(points, tmp_path / "studies", stopped=lambda: 15)
    assert one.equals(other)


def test_a_run_that_diverges_is_recorded_and_the_others_go_on(tmp_path):
    """Once: resuming does not train it again."""
    case, agent = TWO_GOALS.cases[0], TWO_GOALS.agents[0]
    wild = replace(agent, name="wild", config=agent.config.changed(learning_rate=1e30, clip=1e30))
    budget = replace(QUICK, most=2_000)
    points = [p for one in (wild, agent) for p in points_of(TWO_GOALS, case, one, 0.0, budget)]
    runs = train_all(points, tmp_path / "studies")
    assert runs.select("agent", "finite").rows() == [("wild", False)] * 2 + [(agent.name, True)] * 2
    gone = runs.filter(agent="wild")
    assert gone["converged_at"].null_count() == gone["first_success"].null_count() == 2
    assert (runs.filter(agent=agent.name)["steps"] > 0).all()

    def nobody(tasks, done, stopped):
        raise AssertionError([task.label for task in tasks])

    assert train_all(points, tmp_path / "studies", nobody).equals(runs)
    study = replace(TWO_GOALS, agents=(wild, agent), pairs=((agent.name, "wild"),))
    answer = Answer.of(study, runs)
    assert answer.outcome[-1] == (
        "pair, wild: 2 of 2 runs diverged (a loss or parameters became infinite or NaN); "
        "they count as runs that never converge."
    )
    assert not any("diverged" in line for line in Answer.of(study, all_finite(runs)).outcome)


def all_finite(runs):
    """The same runs, none of which diverged."""
    return runs.with_columns(finite=pl.lit(True))


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (
            ["study", "rooms", "--out", "new"],
            "study 'rooms' is unknown; use one of choosing, two-goals",
        ),
        (["study", "unseen"], "--out"),
        (["study", "unseen", "--out", "full"], "full: exists already"),
        (["study", "unseen", "--out", "full", "--resume"], "full: has no studies to resume"),
        (["study", "unseen", "--out", "full/mine.txt"], "mine.txt is not a folder"),
    ],
)
def test_what_cannot_be_is_refused_in_a_line(arguments, problem, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine.txt").write_text("mine")
    assert main(arguments) == 2
    reported = capsys.readouterr()
    assert (reported.out, reported.err.count("\n")) == ("", 1)
    assert reported.err.startswith("habilis: ")
    assert problem in reported.err
    assert [path.name for path in tmp_path.rglob("*")] == ["full", "mine.txt"]
