"""The engine, on tasks that have nothing to do with learning."""

import os
import pickle
import re
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

import habilis.tasks
from habilis.interruption import Interrupted
from habilis.tasks.local import processes
from habilis.tasks.session import Layout, kept_in, opened
from habilis.tasks.shared import Shared, packed, read, unpacked, write
from habilis.tasks.task import Executor, Task, in_turn, results_of

LAYOUT = Layout("squares", mark="squares.txt")


@dataclass(frozen=True)
class Square:
    """The square of a number."""

    number: int

    @property
    def name(self) -> str:
        return f"square-{self.number}"

    @property
    def label(self) -> str:
        return f"the square of {self.number}"

    @property
    def size(self) -> float:
        return self.number

    def run(self):
        return {"number": np.array(self.number), "square": np.array(self.number**2)}

    def rehearse(self) -> None:
        self.run()

    def check(self, result) -> None:
        if int(result["number"]) != self.number:
            raise ValueError(f"holds the square of {result['number']}")


SQUARES = [Square(number) for number in range(5)]


def squares(results):
    return {name: int(result["square"]) for name, result in results.items()}


ALL = {task.name: task.number**2 for task in SQUARES}


def test_the_engine_knows_nothing_of_what_it_computes():
    sources = [path.read_text() for path in Path(habilis.tasks.__file__ or "").parent.glob("*.py")]
    assert len(sources) > 3
    imported = {name for text in sources for name in re.findall(r"habilis\.([a-z]+)", text)}
    assert imported == {"files", "interruption", "lazy", "tasks"}


def test_a_task_and_an_executor_are_protocols():
    assert isinstance(SQUARES[0], Task)
    assert isinstance(in_turn, Executor)


def test_results_are_kept_and_not_computed_again(tmp_path):
    progress, computed = [], []

    def executor(tasks, done, stopped):
        computed.extend(task.name for task in tasks)
        in_turn(tasks, done, stopped)

    folder = tmp_path / "squares"
    with opened(folder, LAYOUT, executor, resume=False) as session:
        session.compute(SQUARES[:2])
        session.compute(SQUARES[:3], lambda done, known: progress.append((done, known)))
        assert squares(session.results) == {task.name: task.number**2 for task in SQUARES[:3]}
    assert computed == ["square-0", "square-1", "square-2"]
    assert progress == [(2, 3), (3, 3)]
    kept = {path: path.read_bytes() for path in (folder / "tasks").iterdir()}
    with opened(folder, LAYOUT, executor, resume=True) as session:
        session.compute(SQUARES)
        assert squares(session.results) == ALL
    assert computed == [task.name for task in SQUARES]
    assert {path: path.read_bytes() for path in kept} == kept


def test_an_interrupted_session_reports_how_to_continue(tmp_path):
    def one(tasks, done, stopped):
        in_turn(tasks[:1], done, stopped)

    folder = tmp_path / "squares"
    with opened(folder, LAYOUT, one, resume=False) as session:
        with pytest.raises(Interrupted, match=rf"1 of 5 tasks are kept in {folder}: continue with"):
            session.compute(SQUARES)
        session.stopped = lambda: 15
        with pytest.raises(Interrupted, match="1 of 5 tasks") as stop:
            session.compute(SQUARES)
        assert stop.value.signal == 15
    calls = []
    in_turn(SQUARES, lambda name, result: calls.append(name), lambda: len(calls) == 2)
    assert calls == ["square-0", "square-1"]


def test_a_file_of_another_task_is_damage(tmp_path, capsys):
    folder = tmp_path / "squares"
    with opened(folder, LAYOUT, in_turn, resume=False) as session:
        session.compute(SQUARES)
    one, other = (folder / "tasks" / f"square-{number}.npz" for number in (2, 3))
    one.write_bytes(other.read_bytes())
    with opened(folder, LAYOUT, in_turn, resume=True) as session:
        session.compute(SQUARES)
        assert squares(session.results) == ALL
    line = f"habilis: {one}: is damaged (holds the square of 3); it is computed again\n"
    assert capsys.readouterr().err == line


def test_a_folder_of_something_else_is_refused_and_one_of_ours_is_not(tmp_path):
    other = tmp_path / "other"
    other.mkdir()
    (other / "letters.txt").write_text("mine")
    with pytest.raises(ValueError, match="exists already"):
        LAYOUT.check(other, resume=False)
    with pytest.raises(ValueError, match="other: has no squares to resume; name another"):
        LAYOUT.check(other, resume=True)
    (other / LAYOUT.mark).write_text("")
    LAYOUT.check(other, resume=True)
    with opened(tmp_path / "begun", LAYOUT, in_turn, resume=True):
        pass
    LAYOUT.check(tmp_path / "begun", resume=True)


@dataclass(frozen=True)
class Slow(Square):
    """One that marks when it begins and ends, and which process computes it."""

    folder: Path = Path()

    def run(self):
        began, end = time.time(), self.folder / f"ended-{self.number}"
        time.sleep(0.1)
        end.write_text(str(os.getpid()))
        return super().run() | {"began": np.array(began)}


def test_processes_compute_what_this_process_would(tmp_path):
    tasks = [Slow(number, tmp_path) for number in range(5)]
    with processes(2) as executor, opened(tmp_path / "f", LAYOUT, executor, False) as session:
        session.compute(tasks)
        assert squares(session.results) == ALL
    computed_by = {int((tmp_path / f"ended-{task.number}").read_text()) for task in tasks}
    assert os.getpid() not in computed_by
    assert 1 <= len(computed_by) <= 2


@dataclass(frozen=True)
class Lost(Square):
    def run(self):
        os._exit(1)


def test_a_task_that_loses_process_after_process_is_given_up(tmp_path):
    with processes(1) as executor, opened(tmp_path / "f", LAYOUT, executor, False) as session:
        line = "the square of 7: 3 processes were lost at this task; give fewer --processes"
        with pytest.raises(ValueError, match=line):
            session.compute([Lost(7)])


def test_the_error_of_an_unguarded_script_names_the_guard(tmp_path):
    """Each process imports the script, and would start processes in turn."""
    script = tmp_path / "script.py"
    script.write_text(
        "from habilis import TabularMDP, empowerment\n"
        "from habilis.tasks import processes\n"
        "with processes(2) as executor:\n"
        "    empowerment(TabularMDP.deterministic([[0, 1]] * 2), 1, executor=executor)\n"
    )
    ended = subprocess.run([sys.executable, script], capture_output=True, text=True, check=False)
    assert ended.returncode == 1
    guard = 'in a script, start processes under `if __name__ == "__main__":`'
    assert f"a process that is being started cannot start others; {guard}" in ended.stderr
    assert ended.stderr.splitlines()[-1].endswith(f"free some memory, or, {guard}")


class TwoPartsError(Exception):
    """One that pickle cannot make again."""

    def __init__(self, one: str, other: str):
        super().__init__(one + other)


@dataclass(frozen=True)
class Failing(Square):
    def rehearse(self) -> None:
        pass

    def run(self):
        if self.number == 0:
            raise TwoPartsError("no ", "square")
        time.sleep(60)
        return super().run()


def test_processes_go_on_with_other_tasks_after_one_has_failed():
    with processes(2) as executor:
        with pytest.raises(RuntimeError, match=r"^TwoPartsError: no square$"):
            results_of([Failing(0), Failing(1)], executor)
        progress = []
        again = results_of(SQUARES, executor, lambda *pair: progress.append(pair))
        assert squares(again) == ALL
        assert progress == [(done, 5) for done in range(6)]


@dataclass(frozen=True)
class Total(Square):
    """One that adds up many numbers that others add up too."""

    numbers: Shared[np.ndarray] = field(default_factory=lambda: Shared("none", np.zeros(0)))

    def run(self):
        base = self.numbers.value
        while isinstance(base, np.ndarray):
            base = base.base
        found = {"number": self.number, "square": self.numbers.value.sum()}
        return {
            name: np.array(value) for name, value in (found | {"in": type(base).__name__}).items()
        }


def test_what_tasks_share_is_no_part_of_what_is_sent_for_each():
    numbers = Shared("ones", np.ones(1_000_000))
    content, values = packed(Total(3, numbers))
    assert len(content) < 500
    assert values == {"ones": numbers}
    again = unpacked(content, {"ones": np.ones(5)}.__getitem__)
    assert again.number == 3
    assert again.numbers.key == "ones"
    assert again.run()["square"] == 5
    assert packed(Square(3)) == (pickle.dumps(Square(3), 5), {})


@pytest.mark.parametrize("value", [{"some": np.arange(7), "none": np.zeros(0), "text": "a"}, 5, []])
def test_a_shared_value_is_read_from_its_file_as_it_was(tmp_path, value):
    path = tmp_path / "value"
    with path.open("wb") as file:
        write(value, file)
    found = read(path)
    assert type(found) is type(value)
    assert repr(found) == repr(value)
    if isinstance(value, dict):
        found["some"][0] = 9  # a copy of this process
        assert read(path)["some"][0] == 0


def test_processes_map_what_tasks_share_and_leave_nothing_behind(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    first, second = Shared("ones", np.ones(300)), Shared("twos", np.full(300, 2.0))
    results = {}
    with processes(1) as executor:
        for shared in (first, second, second):
            tasks = [Total(number, shared) for number in range(4)]
            results[shared.key] = results_of(tasks, executor)
        (folder,) = tmp_path.iterdir()
        assert [path.stat().st_size > 2400 for path in folder.iterdir()] == [True], (
            "of the last two"
        )
    totals = {key: {int(one["square"]) for one in each.values()} for key, each in results.items()}
    assert totals == {"ones": {300}, "twos": {600}}
    bases = {str(one["in"]) for each in results.values() for one in each.values()}
    assert bases == {"memoryview"}
    assert list(tmp_path.iterdir()) == []


def test_results_are_those_of_every_task_once(tmp_path):
    progress = []
    results = results_of([*SQUARES, *SQUARES], in_turn, lambda *pair: progress.append(pair))
    assert squares(results) == ALL
    assert progress == [(done, 5) for done in range(6)]
    line = "the square of 3: the executor did not run it, nor 1 others; let it call done"
    with pytest.raises(ValueError, match=line):
        results_of(SQUARES, lambda tasks, done, stopped: in_turn(tasks[:3], done))


@pytest.mark.parametrize(
    ("name", "result", "line"),
    [
        ("square-9", {"number": np.array(9)}, "square-9: the executor was given no such task"),
        ("square-3", {"number": np.array(2)}, "the square of 3: .* not the task's .holds the sq"),
        ("square-3", {}, "the square of 3: the executor's result is not the task's .'number'"),
    ],
)
def test_a_result_that_is_not_the_tasks_is_refused(name, result, line):
    with pytest.raises(ValueError, match=line):
        results_of(SQUARES, lambda tasks, done, stopped: done(name, result))


def test_an_executor_that_is_kept_stops_when_asked(tmp_path):
    results = {}
    with kept_in(tmp_path / "work", in_turn) as kept:
        kept(SQUARES, results.__setitem__, lambda: len(results) == 2)
        assert squares(results) == {"square-0": 0, "square-1": 1}
        assert squares(results_of(SQUARES, kept)) == ALL


def test_an_executor_that_is_kept_runs_no_task_again(tmp_path):
    ran = []

    def executor(tasks, done, stopped):
        ran.extend(task.number for task in tasks)
        in_turn(tasks, done, stopped)

    with kept_in(tmp_path / "work", executor) as kept:
        assert squares(results_of(SQUARES[:2], kept)) == {"square-0": 0, "square-1": 1}
        assert squares(results_of(SQUARES[:3], kept)) == {
            "square-0": 0,
            "square-1": 1,
            "square-2": 4,
        }
    with kept_in(str(tmp_path / "work"), executor, resume=True) as kept:
        assert squares(results_of(SQUARES, kept)) == ALL
    assert ran == [0, 1, 2, 3, 4]
    idle = kept_in(tmp_path / "other", lambda tasks, done, stopped: None)
    with idle as kept, pytest.raises(Interrupted, match="0 of 5 tasks are kept in"):
        results_of(SQUARES, kept)
