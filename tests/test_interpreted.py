"""What runs as plain Python below some size has the results of what is compiled, to the bit."""

import os
import subprocess
import sys
from argparse import Namespace
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import habilis as hb
from habilis.bridges.puzzles.pushworld import PushWorld
from habilis.cli.output import compiling_announced
from habilis.compiled import INTERPRETED, Compiled, compiled, part, paths
from habilis.empowerment.tabular import beliefs, column_generation, counting, deterministic
from habilis.empowerment.tabular.open_loop import problem_of
from habilis.empowerment.tabular.persistence import persistence
from habilis.empowerment.tabular.successors import Successors, states_within
from habilis.models.interning import InternedRows

SETTINGS = settings(deadline=None, max_examples=10)  # it is compiled at first


def check(work: Callable[[], Any]) -> None:
    """Checks that results are the same as plain Python, in NumPy, and compiled."""
    plain, without, machine = (
        result_with(call, work) for call in (as_plain, as_without, as_machine)
    )
    for one, *others in zip(machine, plain, without, strict=True):
        for other in others:
            assert np.asarray(one).dtype == np.asarray(other).dtype
            assert np.array_equal(one, other)


def result_with(call: Callable[..., Any], work: Callable[[], Any]) -> Any:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Compiled, "__call__", call)
        return work()


def as_plain(self: Compiled, *args: Any) -> Any:
    with np.errstate(over="ignore"):
        return self.plain(*args)


def as_without(self: Compiled, *args: Any) -> Any:
    return self.uncompiled(*args)


def as_machine(self: Compiled, *args: Any) -> Any:
    return self.machine(*args)


def table(states: int, actions: int, seed: int, share: float = 1.0) -> hb.TabularMDP:
    """A stochastic table in which actions have one to three outcomes, or are not available."""
    random = np.random.default_rng(seed)
    P = np.zeros((states, actions, states))
    for s, a in np.ndindex(states, actions):
        if a == 0 or random.random() < share:
            outcomes = random.integers(0, states, random.integers(1, 4))
            np.add.at(P[s, a], outcomes, random.dirichlet(np.ones(len(outcomes))))
    return hb.TabularMDP.stochastic(P)


TABLES = st.builds(
    table,
    st.integers(1, 9),
    st.integers(1, 3),
    st.integers(0, 2**32 - 1),
    st.sampled_from([1.0, 0.6]),
)


def successors(mdp: hb.TabularMDP) -> Successors:
    return problem_of(mdp, 1, "state", np.arange(mdp.action_count), 1e-6).successors


@SETTINGS
@given(TABLES, st.integers(0, 4))
def test_beliefs(mdp: hb.TabularMDP, horizon: int):
    led = successors(mdp)

    def found() -> list[Any]:
        parts = []
        for start in range(mdp.states):
            after = beliefs.beliefs_after(led, start, horizon)
            dense = after.matrix if isinstance(after.matrix, np.ndarray) else after.matrix.toarray()
            parts += [after.states, dense, *(part for step in after.steps for part in step)]
            parts.append(states_within(led, start, horizon))
            parts += beliefs.distinct(np.concatenate([dense, dense[::-1]]))
        return parts

    check(found)


@SETTINGS
@given(TABLES, st.integers(1, 4), st.integers(0, 2**32 - 1))
def test_sequences_that_are_followed(mdp: hb.TabularMDP, horizon: int, seed: int):
    led, random = successors(mdp), np.random.default_rng(seed)
    draws = random.random((5, horizon))
    sequences = random.integers(0, mdp.action_count, (5, horizon)).astype(np.int32)
    check(lambda: beliefs.followed(led, 0, sequences))
    check(lambda: beliefs.wandered(led, 0, draws))


@SETTINGS
@given(TABLES, st.integers(1, 4), st.sampled_from([0, 2**18]))
def test_certified_capacities(mdp: hb.TabularMDP, horizon: int, enough: int):
    asked = problem_of(mdp, horizon, "state", np.arange(mdp.action_count), 1e-6)

    def found() -> list[Any]:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(beliefs, "ENOUGH", enough)
            patch.setattr(beliefs, "FEWER", 0.7 if enough else 0.0)
            sequences, _ = column_generation.sequences_from(asked, 0)
            every = np.arange(sequences.sequences)
            bits = column_generation.generated(asked, 0)
        return [*sequences.neg_entropies(), sequences.rows(every), np.array(bits)]

    check(found)


@SETTINGS
@given(st.integers(1, 40), st.integers(1, 4), st.integers(0, 20), st.integers(0, 2**32 - 1))
def test_counts(states: int, actions: int, horizon: int, seed: int):
    random = np.random.default_rng(seed)
    led = random.integers(0, states, (states, actions)).astype(np.int32)
    labels = random.integers(-1, 70, states).astype(np.int32)
    starts = np.unique(random.integers(0, states, 5))
    check(lambda: [counting.count_backward(led, labels, 70, horizon)])
    check(lambda: [counting.count_forward(led, labels, 70, horizon, starts)])
    check(lambda: [counting.count_forward(led, labels, 70, horizon, starts, most=3)])
    check(lambda: deterministic.neighbourhood(led, starts, horizon))
    mdp = hb.TabularMDP.deterministic(led)
    check(lambda: [persistence(mdp, "state")])


@SETTINGS
@given(st.integers(1, 3), st.sampled_from([3, 2**20, 2**61]), st.integers(0, 2**32 - 1))
def test_interned_rows(columns: int, size: int, seed: int):
    random = np.random.default_rng(seed)
    parts = [random.integers(-size, size, (20, columns)) for _ in range(3)]

    def found() -> list[Any]:
        rows = InternedRows(columns)
        numbers = [rows.add(part) for part in parts]
        return [*numbers, rows.rows(), rows.find(parts[0]), rows.find(parts[0] + 1)]

    check(found)


PUZZLE = """
A  .  .  .  .  .
.  M1 M1 .  M2 .
.  M0 .  M2 M2 G0
.  .  .  W  .  .
"""


@SETTINGS
@given(st.integers(0, 2**32 - 1), st.sampled_from([1, None]))
def test_bodies_that_push_each_other(seed: int, most: int | None):
    random = np.random.default_rng(seed)
    puzzle = PushWorld.parse(PUZZLE.strip())
    states = np.array([puzzle.initial])
    walk = [states]
    for action in random.integers(0, 4, 12):
        walk.append(puzzle.step_many(walk[-1], np.array([action])))
    visited = np.concatenate(walk)
    actions = random.integers(0, 4, len(visited))
    check(lambda: [puzzle.step_many(visited, actions)])


# When a function is compiled


def double(values: np.ndarray) -> int:
    return 2 * len(values)


def test_a_function_is_compiled_for_much_work_at_once():
    function = Compiled(double, lambda values: len(values))
    assert function(np.zeros(9)) == 18
    assert function._dispatcher is None
    assert function(np.zeros(INTERPRETED + 1)) == 2 * INTERPRETED + 2
    assert function(np.zeros(9)) == 18
    assert function._dispatcher is not None


def test_a_function_is_compiled_once_its_calls_have_taken_long_together(monkeypatch):
    clock = iter([k / 10 for k in range(100)])
    monkeypatch.setattr("habilis.compiled.time.thread_time", lambda: next(clock))
    function = Compiled(double, lambda values: len(values))
    for compiled_by_then in (False, False, True):
        assert function(np.zeros(9)) == 18
        assert (function._dispatcher is not None) == compiled_by_then


def test_a_function_whose_work_is_not_known_is_compiled_at_once():
    function = compiled()(double)
    assert isinstance(function, Compiled)
    assert function(np.zeros(1)) == 2
    assert function._dispatcher is not None


@pytest.mark.parametrize("branching", [1, 2, 5])
@pytest.mark.parametrize("length", [0, 1, 4, 64])
def test_paths_of_a_tree(branching: int, length: int):
    assert paths(branching, length) == pytest.approx(
        sum(branching**k for k in range(1, length + 1))
    )


def test_a_part_still_runs_as_plain_python_when_another_function_is_compiled():
    @compiled(lambda values: len(values))
    def total(values):
        return squared(values[0]) + 1

    @compiled()
    def again(values):
        return squared(values[0]) + 1

    assert again(np.array([3.0])) == total(np.array([3.0])) == 10


@part
def squared(value):
    return value * value


def test_small_models_need_no_compiler(tmp_path):
    code = (
        "import sys, habilis as hb\n"
        "mdp = hb.tabulate(hb.load_world('yard'))\n"
        "assert hb.empowerment(mdp, 2, 'state', states=[0, 9]).min() > 0\n"
        "assert hb.empowerment(mdp.slippery(0.2), 1, 'object', states=[0]).min() >= 0\n"
        "sys.exit('numba' in sys.modules)\n"
    )
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    assert subprocess.run([sys.executable, "-c", code], env=environment).returncode == 0


def fresh_function() -> Compiled:
    """A function that Numba cannot have kept on disk."""
    names: dict[str, Any] = {}
    exec("def fresh(values):\n    return 2 * len(values)\n", names)
    return Compiled(names["fresh"])


@pytest.mark.parametrize(
    ("terminal", "json", "said"),
    [(True, False, "compiling (first use only)\n"), (True, True, ""), (False, False, "")],
)
def test_a_terminal_says_once_that_it_compiles(monkeypatch, capsys, terminal, json, said):
    monkeypatch.setattr("sys.stderr.isatty", lambda: terminal)
    with compiling_announced(Namespace(json=json)):
        assert fresh_function()(np.zeros(3)) == fresh_function()(np.zeros(3)) == 6
    assert fresh_function()(np.zeros(3)) == 6
    assert capsys.readouterr().err == said
