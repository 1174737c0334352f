"""Estimators compared with the truth, in Python and on the command line."""

import json
import pickle
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

import habilis as hb
from habilis.cli import main
from habilis.estimators import FirstAction, OnGrid, RandomSequences, VarianceProxy, contestants
from habilis.estimators.evaluation.tasks import tasks_of
from habilis.tasks.shared import packed, unpacked

OWN = """
import numpy as np

class Off:
    kind, target = "approximation", "capacity"
    def fit(self, simulator, horizon, sensor, *, seed):
        self.seed = seed
        return self
    def bits(self, states):
        return np.log2(20 + states[:, 0]) + self.seed

class Lost(Off):
    def bits(self, states):
        return np.zeros(3)

class Broken(Off):
    def bits(self, states):
        return states.nothing

class Empty:
    pass
"""


class Fixed:
    """An estimator whose values are given."""

    kind, target = "approximation", "capacity"

    def __init__(self, bits: Any):
        self.given = bits

    def fit(self, simulator, horizon, sensor="state", *, seed) -> Any:
        self.seed = seed
        return self

    def bits(self, states):
        return self.given + 0.5 * self.seed


def test_bias_error_and_rank_are_those_of_the_values():
    (case,) = hb.suite(["maze"])
    off = np.linspace(-1, 2, 100)
    rows = hb.evaluate(Fixed(case.bits + off), [case], seeds=[0, 2]).rows(named=True)
    assert len(rows) == 1
    assert rows[0]["bias"] == pytest.approx(np.mean([off.mean(), off.mean() + 1]))
    each = [np.sqrt((off**2).mean()), np.sqrt(((off + 1) ** 2).mean())]
    assert rows[0]["rmse"] == pytest.approx(np.mean(each))
    assert rows[0]["bias_low"] == pytest.approx(off.mean())
    assert rows[0]["bias_high"] == pytest.approx(off.mean() + 1)
    scipy_stats = pytest.importorskip("scipy.stats")
    expected = scipy_stats.spearmanr(case.bits.round(5), (case.bits + off).round(5)).statistic
    assert rows[0]["rank"] == pytest.approx(expected, abs=1e-9)


def test_a_truth_that_is_the_same_everywhere_has_no_order():
    pytest.importorskip("jax")
    (case,) = hb.suite(["gauss-1"])
    table = hb.evaluate(hb.Gaussian(3.0, 0.0), [case], seeds=1)
    assert table["rank"].item() is None
    assert table["rmse"].item() < 1e-6


def test_only_like_is_compared_with_like():
    cases = hb.suite(["maze", "lake-effective"])
    table = hb.evaluate({"first": FirstAction(), "all": hb.Counting()}, cases, seeds=1)
    reasons = table["reason"].to_list()
    assert reasons[0] == "estimates effective empowerment, the case is the capacity"
    assert reasons[1] is reasons[2] is None
    assert "stochastic" in reasons[3]
    assert table["rmse"].is_null().to_list() == [True, False, False, True]


def test_steps_of_the_simulator_are_counted():
    (case,) = hb.suite(["maze"])
    table = hb.evaluate(RandomSequences(30), [case], seeds=2)
    assert table["steps"].item() == 100 * 30 * 5
    assert table["seconds"].item() > 0


def test_random_sequences_are_a_lower_bound_without_noise_and_none_with_it():
    still, slips = hb.suite(["maze", "maze-slips"])
    for seed in range(3):
        found = RandomSequences(50).fit(still.simulator, 5, seed=seed)
        assert found.kind == "lower bound"
        assert (found.bits(still.states) <= still.bits + 1e-9).all()
    noisy = RandomSequences(1000).fit(slips.simulator, 2)
    assert noisy.kind == "approximation"
    assert (noisy.bits(slips.states) > slips.bits + 1).mean() > 0.9


def test_the_variance_depends_on_how_states_are_numbered():
    (case,) = hb.suite(["maze"])
    mdp = case.simulator.mdp  # pyright: ignore[reportAttributeAccessIssue]
    columns = np.arange(100).reshape(10, 10).T.ravel()
    renumbered = np.empty_like(mdp.next_state)
    renumbered[columns] = columns[mdp.next_state]
    proxy = VarianceProxy(500)
    one = hb.empowerment(mdp, 5, method=proxy)
    other = hb.empowerment(hb.TabularMDP.deterministic(renumbered), 5, method=proxy)[columns]
    assert np.abs(one - other).max() > 1


def test_ten_samples_of_a_first_action_say_too_much():
    (case,) = hb.suite(["choices-effective"])
    few = FirstAction(10).fit(case.simulator, 1, seed=1).bits(case.states)
    assert (few - case.bits).mean() > 0.5
    many = FirstAction(3000).fit(case.simulator, 1, seed=1).bits(case.states[::16])
    assert many == pytest.approx(case.bits[::16], abs=0.05)


def test_samplers_have_the_same_numbers_for_the_same_seed_whatever_else_is_asked():
    (case,) = hb.suite(["frozen-lake"])
    for sampler in (RandomSequences(40), VarianceProxy(40), FirstAction(4)):
        fitted = sampler.fit(case.simulator, 3, seed=5)
        whole = fitted.bits(case.states)
        assert np.array_equal(whole[3:5], sampler.fit(case.simulator, 3, seed=5).bits([[3], [4]]))
        assert not np.array_equal(whole, sampler.fit(case.simulator, 3, seed=6).bits(case.states))


def test_a_contestant_is_there_for_every_case():
    (case,) = hb.suite(["maze"])
    for name, make in contestants(quick=True).items():
        assert callable(make(case).fit), name


@pytest.mark.parametrize(
    ("estimators", "seeds", "message"),
    [
        (3, 1, "estimator 'int' has no method fit"),
        ({"mine": hb.Counting}, 1, "estimator 'mine' has no method fit"),
        (hb.Counting(), 0, "seeds is 0"),
        (hb.Counting(), [], "seeds is empty"),
        (hb.Counting(), [-1], "seed is -1"),
    ],
)
@pytest.mark.ill_typed
def test_what_is_no_estimator_is_refused(estimators, seeds, message):
    with pytest.raises(ValueError, match=message):
        hb.evaluate(estimators, hb.suite(["maze"]), seeds=seeds)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "mine.py").write_text(OWN)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_ones_own_estimator_is_held_against_the_maze(folder: Path, capsys):
    command = "estimators --estimator mine.py:Off --estimator counting --cases maze --seeds 2"
    assert main([*command.split(), "--out", "found.csv", "--out", "found.svg"]) == 0
    shown = capsys.readouterr().out
    assert "maze: Klyubin's maze, no noise; h = 5, 4.78 bits" in shown
    assert "mine.py:Off  bias" in shown
    table = pl.read_csv(folder / "found.csv")
    assert table["estimator"].to_list() == ["mine.py:Off", "counting"]
    assert table["bias_high"][0] - table["bias_low"][0] == pytest.approx(1)
    assert (folder / "found.svg").read_text().startswith("<?xml")


def test_an_estimator_that_gives_too_few_values_has_a_reason(folder: Path, capsys):
    command = "estimators --estimator mine.py:Lost --cases maze --quick --json"
    assert main(command.split()) == 0
    (row,) = json.loads(capsys.readouterr().out)["results"]
    assert row["reason"] == "gives bits of shape (3,) for 100 states"
    assert row["bias"] is None


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("--estimator mine.py:Empty", "estimator 'mine.py:Empty': it has no method fit"),
        ("--estimator mine.py:Other", "there is no class 'Other' in it; it has Off, Lost, "),
        ("--estimator none.py:Off", "none.py cannot be read"),
        ("--estimator no.such:Off", "importing 'no.such' fails with ModuleNotFoundError"),
        ("--estimator best", "estimator 'best' is unknown; use counting"),
        ("--estimator mine.py:Broken --cases maze", "'nothing' (mine.py, line 18)"),
        ("--cases amaze", "case 'amaze' is unknown"),
        ("--out found.npz", "found.npz"),
        ("--seeds 0 --cases maze --estimator counting", "seeds is 0"),
    ],
)
def test_refusals_are_one_line(arguments: str, message: str, folder: Path, capsys):
    assert main(["estimators", *arguments.split()]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


def carried_over(tasks, done, stopped) -> None:
    """An executor that runs a task as another process would receive it."""
    for task in tasks:
        content, values = packed(task)
        there = {key: pickle.loads(pickle.dumps(one.value)) for key, one in values.items()}
        result = unpacked(content, there.__getitem__).run()
        task.check(result)
        done(task.name, result)


def test_tasks_give_the_same_table_but_for_the_seconds():
    cases = hb.suite(["maze", "lake-effective"])
    some = {name: contestants(True)[name] for name in ("counting", "first-action")}
    here = hb.evaluate(some, cases, seeds=2)
    there = hb.evaluate(some, cases, seeds=2, executor=carried_over)
    assert here["reason"].is_not_null().sum() == 2
    assert there.drop("seconds").equals(here.drop("seconds"))


def test_a_continuous_case_is_carried_too(capsys):
    command = ["estimators", "--estimator", "gaussian", "--cases", "gauss-2", "--quick", "--json"]
    whole = [sys.executable, "-m", "habilis", *command, "--processes", "1"]
    there = json.loads(subprocess.run(whole, capture_output=True, check=True).stdout)["results"]
    assert main(command) == 0
    here = json.loads(capsys.readouterr().out)["results"]
    assert [row | {"seconds": 0} for row in there] == [row | {"seconds": 0} for row in here]


def test_what_cannot_be_carried_is_a_reason():
    (maze,) = hb.suite(["maze"])
    locked = Fixed(threading.Lock())
    (row,) = hb.evaluate(locked, [maze], seeds=1, executor=carried_over).rows(named=True)
    assert row["reason"].startswith("Fixed cannot be carried to another process (")


def test_names_of_tasks_are_those_of_estimator_case_and_seed():
    maze, other = hb.suite(["maze", "maze-10"])

    counting = hb.Counting()
    fine = np.linspace(0, 1, 2001)  # of which repr shows a part
    shifted = np.where(np.arange(2001) == 1000, fine + 1e-4, fine)

    def names(estimator: Any = counting, case=maze, seeds=(0,)) -> list[str]:
        return [task.name for task in tasks_of("any name", estimator, case, seeds)]

    assert names() == names()
    each = [
        names(hb.Counting(sequences=7)),
        names(case=other),
        names(case=replace(maze, bits=maze.bits + 1)),
        names(case=replace(maze, simulator=other.simulator, sensor="agent")),
        names(seeds=(1, 2)),
        names(Fixed(maze.bits)),
        names(Fixed(maze.bits + 1)),
        *(names(hb.Variational(states=states)) for states in (None, [[0.0]], [[1.0]])),
        *(names(OnGrid(hb.Counting(), [axis])) for axis in (fine, shifted)),
        names(OnGrid(Fixed(maze.bits), [fine])),
    ]
    assert len({*names(), *(name for found in each for name in found)}) == 15
    assert names(hb.Variational(show_progress=True)) == names(hb.Variational())


def test_ones_own_estimator_is_carried_to_processes_that_do_not_have_its_file(folder: Path, capsys):
    command = ["estimators", "--estimator", "mine.py:Off", "--cases", "maze", "--json"]
    assert main(command) == 0
    here = json.loads(capsys.readouterr().out)["results"]
    assert main([*command, "--processes", "1", "--work", "work"]) == 0
    there = json.loads(capsys.readouterr().out)["results"]
    assert [row | {"seconds": 0} for row in there] == [row | {"seconds": 0} for row in here]
    assert len(list((folder / "work" / "tasks").glob("*.npz"))) == 3
