"""Empowerment split into tasks: the same values, bit for bit, wherever and however they run."""

import re
import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import habilis as hb
from habilis.analysis import compare, landscape, pairs
from habilis.empowerment import splitting
from habilis.empowerment.horizons import empowerment_by_horizon
from habilis.empowerment.splitting import StatesTask
from habilis.tasks.local import processes
from habilis.tasks.session import kept_in
from habilis.tasks.task import Task, in_turn

STATES, ACTIONS = 12, 3
RNG = np.random.default_rng(0)
TABLE = hb.TabularMDP.deterministic(RNG.integers(STATES, size=(STATES, ACTIONS)))
NOISY = TABLE.slippery(0.3)
SEEN = RNG.dirichlet(np.ones(4), STATES)
AFTER = RNG.dirichlet(np.ones(4), (ACTIONS, STATES))
COST = RNG.random((STATES, ACTIONS))
BELIEFS = RNG.dirichlet(np.ones(STATES), 3)

QUESTIONS: dict[str, dict[str, Any]] = {
    "plain": {},
    "some states, one twice": {"states": [7, 2, 2, 9]},
    "flags of states": {"states": np.arange(STATES) < 5},
    "no states": {"states": []},
    "labels": {"sensor": np.arange(STATES) % 5},
    "a noisy sensor": {"sensor": SEEN},
    "a sensor by action": {"sensor": AFTER},
    "some actions": {"actions": [2, 0]},
    "sampled": {"method": hb.Sampled(samples=20, seed=3)},
    "a budget": {"cost": COST, "budget": 3},
    "a curve of budgets": {"cost": COST.tolist(), "budget": [3, 3.5]},
    "each step": {"sensor": np.arange(STATES) % 3, "sensor_at": "each step"},
    "beliefs": {"states": BELIEFS},
    "beliefs, within a budget": {"states": BELIEFS, "cost": COST, "budget": 3},
    "in nats": {"unit": "nats", "method": hb.Exact(tolerance=1e-3)},
}


@pytest.fixture(autouse=True)
def small_tasks(monkeypatch: pytest.MonkeyPatch):
    """As if there were many states: five to a task, also where nothing is noisy."""
    monkeypatch.setattr(splitting, "MOST_TASKS", 3)
    monkeypatch.setattr(splitting, "COUNTED", (3, 1))


class Backwards:
    """An executor that runs tasks in another order, on copies, and hands some over twice."""

    def __init__(self) -> None:
        self.tasks: list[Task] = []

    def __call__(self, tasks, done, stopped) -> None:
        self.tasks += tasks
        for task in reversed(tasks):
            result = task.run()
            task.check(result)
            done(task.name, result)
            done(task.name, result)


def same(one: Any, other: Any) -> bool:
    pairs = zip(one, other, strict=True)
    return all(
        a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes() for a, b in pairs
    )


@pytest.mark.parametrize("mdp", [TABLE, NOISY], ids=["certain", "noisy"])
@pytest.mark.parametrize("asked", QUESTIONS.values(), ids=QUESTIONS.keys())
def test_values_and_gaps_are_those_without_an_executor(mdp: hb.TabularMDP, asked: dict[str, Any]):
    executor = Backwards()
    here = hb.empowerment(mdp, 3, return_gap=True, **asked)
    there = hb.empowerment(mdp, 3, return_gap=True, executor=executor, **asked)
    assert same(here, there)
    states = asked.get("states")
    assert len(executor.tasks) == (1 if states is None or len(states) else 0) * min(3, len(here[0]))


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(0, 3), st.sampled_from(["exact", "sampled"]))
def test_the_values_of_any_table_do_not_depend_on_the_split(seed, horizon, kind):
    rng = np.random.default_rng(seed)
    mdp = hb.TabularMDP.stochastic(rng.dirichlet(np.full(5, 0.3), (5, 2)))
    method = hb.Exact() if kind == "exact" else hb.Sampled(samples=4, seed=seed % 7)
    some = mdp, horizon, rng.dirichlet(np.ones(3), 5)
    here = hb.empowerment(*some, method=method, return_gap=True)
    assert same(here, hb.empowerment(*some, method=method, return_gap=True, executor=in_turn))


def test_sums_products_and_the_rest_are_split_too():
    world = hb.World.parse("D = ball\nG = goal of C\nA.C\n..D\n..G")
    mdp = hb.tabulate(world, 0.1)
    for sensor in ("object:can + object:ball", "object:can * agent", "rest", "agent"):
        asked = mdp, 2, sensor, None, range(0, mdp.states, 37)
        here = hb.empowerment(*asked, return_gap=True)
        assert same(here, hb.empowerment(*asked, return_gap=True, executor=in_turn)), sensor


def test_a_world_and_a_model_are_explored_once_and_then_split():
    world = hb.World.parse("AP.\n.C.\n..G")
    places = [{"agent": (0, 0), "tool": (0, 1), "object": (1, c)} for c in (1, 2)]
    asked = {"sensor": "object", "states": places}
    executor = Backwards()
    assert same(
        [hb.empowerment(world, 2, **asked)], [hb.empowerment(world, 2, executor=executor, **asked)]
    )
    first, *others = executor.tasks
    assert isinstance(first, StatesTask)
    assert all(task.table is first.table for task in others if isinstance(task, StatesTask))
    assert set(first.table.value.factors) == {"object"}


@pytest.mark.parametrize("others", ["uniform", "best", "worst"])
def test_of_a_player_states_are_split_whatever_the_others_do(others):
    rng = np.random.default_rng(1)
    mdp = hb.TabularMDP.deterministic(rng.integers(6, size=(6, 4)), players={"we": 2, "they": 2})
    for table in (mdp, mdp.slippery(0.2)):
        asked = {"player": "we", "others": others, "return_gap": True}
        here = hb.empowerment(table, 2, **asked)
        assert same(here, hb.empowerment(table, 2, executor=in_turn, **asked))


def test_analyses_pass_the_executor_on():
    world, executor = hb.World.parse("AP.\n.C.\n..G"), Backwards()
    ours = landscape(world, 2, "object", slip=0.1)
    theirs = landscape(world, 2, "object", slip=0.1, executor=executor)
    assert same([ours.values, ours.gap], [theirs.values, theirs.gap])
    assert len(executor.tasks) == 3
    tools = ["picker", "none"]
    assert compare(world, tools, 2) == compare(world, tools, 2, executor=in_turn)
    ours, theirs = pairs(world, 2, slip=0.1), pairs(world, 2, slip=0.1, executor=in_turn)
    assert same([ours.averages, ours.persistence], [theirs.averages, theirs.persistence])


def test_every_horizon_at_once_is_split_as_well():
    for mdp in (TABLE, NOISY):
        here = empowerment_by_horizon(mdp, 3, "state", states=[4, 1, 1])
        assert same(
            [here], [empowerment_by_horizon(mdp, 3, "state", states=[4, 1, 1], executor=in_turn)]
        )


def test_a_wide_gap_is_warned_of_once_with_the_same_words():
    loose = hb.Exact(tolerance=1e-15)
    said = []
    for executor in (None, in_turn):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            hb.empowerment(NOISY, 3, method=loose, executor=executor)
        said.append([(str(one.message), one.filename) for one in caught])
    assert said[0] == said[1]
    assert len(said[0]) == 1


def never(tasks, done, stopped) -> None:
    raise AssertionError("it was begun")


@pytest.mark.parametrize(
    "asked",
    [
        {"horizon": -1},
        {"sensor": "nothing"},
        {"sensor": np.zeros(3, int)},
        {"actions": [9]},
        {"states": [STATES]},
        {"states": [0.5]},
        pytest.param({"sensor_at": "noon"}, marks=pytest.mark.ill_typed),
        {"cost": COST},
        {"cost": COST[:2], "budget": 3},
        {"cost": [[1, 2], [3]], "budget": 3},
        pytest.param({"unit": "trits"}, marks=pytest.mark.ill_typed),
        {"method": hb.Sampled(), "sensor_at": "each step"},
        {"player": "we"},
    ],
)
def test_what_is_wrong_is_refused_with_the_same_words_before_any_task_runs(asked):
    asked = {"horizon": 2} | asked
    with pytest.raises(ValueError, match=" ") as here:
        hb.empowerment(TABLE, **asked)
    with pytest.raises(ValueError, match=f"^{re.escape(str(here.value))}$"):
        hb.empowerment(TABLE, executor=never, **asked)


def test_what_cannot_be_split_is_refused_in_one_line():
    with pytest.raises(ValueError, match=r"an estimator takes no .* or executor; leave them out"):
        hb.empowerment(TABLE, 2, method=hb.Counting(), executor=never)
    world = hb.World.parse("A.C\n..G")
    with pytest.raises(
        ValueError, match="'effective' is of all states at once; leave out executor"
    ):
        landscape(world, 2, kind="effective", discount=0.5, executor=never)
    with pytest.raises(ValueError, match="the executor did not run it, nor 2 others"):
        hb.empowerment(NOISY, 2, executor=lambda tasks, done, stopped: None)


def test_a_cheap_budget_is_reported_by_the_state_and_not_its_place_in_a_task():
    with pytest.raises(ValueError, match=r"cheapest sequence of 2 actions from state 11 costs"):
        hb.empowerment(
            NOISY,
            2,
            states=[3, 11],
            cost=COST,
            budget=0,
            executor=lambda tasks, done, stopped: tasks[-1].run(),
        )


def test_names_are_those_of_the_question_and_no_other():
    def names(mdp: Any = NOISY, horizon: Any = 2, **asked: Any) -> list[str]:
        executor = Backwards()
        hb.empowerment(mdp, horizon, executor=executor, **asked)
        return [task.name for task in executor.tasks]

    first = names()
    assert first == names()
    assert first == names(method=hb.Exact(max_gib=1, max_seconds=9, threads=2))
    others = [
        {"horizon": 3},
        {"mdp": TABLE.slippery(0.31)},
        {"mdp": replace(NOISY, players={"we": ACTIONS, "they": 1})},
        {"mdp": replace(NOISY, players={"they": 1, "we": ACTIONS})},
        {"sensor": SEEN},
        {"sensor": np.roll(SEEN, 1, axis=0)},
        {"actions": [0, 1]},
        {"states": range(6, 11)},
        {"unit": "nats"},
        {"method": hb.Exact(tolerance=1e-5)},
        {"method": hb.Sampled()},
        {"method": hb.Sampled(seed=1)},
        {"sensor_at": "each step"},
        {"cost": COST, "budget": 3},
        {"cost": COST, "budget": 4},
    ]
    each = [first, *(names(**asked) for asked in others)]
    assert len({name for found in each for name in found}) == sum(map(len, each))


def test_finished_tasks_are_kept_and_a_damaged_or_exchanged_one_is_computed_again(tmp_path, capsys):
    executor, here = Backwards(), hb.empowerment(NOISY, 2)
    with kept_in(tmp_path / "work", executor) as kept:
        assert same([here], [hb.empowerment(NOISY, 2, executor=kept)])
    assert len(executor.tasks) == 3
    with kept_in(tmp_path / "work", never, resume=True) as kept:
        assert same([here], [hb.empowerment(NOISY, 2, executor=kept)])
    one, other, third = sorted((tmp_path / "work" / "tasks").iterdir())
    one.write_bytes(other.read_bytes())
    third.write_bytes(b"")
    again = Backwards()
    with kept_in(tmp_path / "work", again, resume=True) as kept:
        assert same([here], [hb.empowerment(NOISY, 2, executor=kept)])
    assert len(again.tasks) == 2
    said = capsys.readouterr().err
    assert "is damaged (holds other states); it is computed again" in said
    with pytest.raises(ValueError, match="exists already"), kept_in(tmp_path / "work", never):
        pass


def test_processes_compute_the_same_and_an_error_comes_back_as_it_was():
    with processes(2) as executor:
        for mdp in (TABLE, NOISY):
            here = hb.empowerment(mdp, 3, return_gap=True)
            assert same(here, hb.empowerment(mdp, 3, return_gap=True, executor=executor))
        costly = hb.Exact(max_gib=1e-6)
        with pytest.raises(ValueError, match=r"horizon 9 .*the largest horizon that fits is"):
            hb.empowerment(NOISY, 9, method=costly, executor=executor)
