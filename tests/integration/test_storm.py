"""Models in PRISM's language and Storm's formats are the tables that Storm itself checks.

Runs where stormpy is installed: `make test-integration`.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import habilis as hb
from habilis.mdp import TabularMDP

stormpy = pytest.importorskip("stormpy")
files = pytest.importorskip("stormpy.examples.files")

ROOMS = """
mdp
const int N;
const double p = 0.25;
module agent
    place : [0..N] init 0;
    lit : bool init false;
    [right] place < N -> 1-p: (place'=place+1) + p: true;
    [left] place > 0 & place < N -> (place'=place-1);
    [lamp] place = 0 -> (lit'=true);
    [lamp] place = 0 -> (lit'=!lit);
    [] place = 1 -> true;
endmodule
rewards "steps"
    [right] true : 1;
    place = 0 : 0.5;
endrewards
rewards "light" lit : 1; endrewards
label "home" = place = 0;
label "end" = place = N;
"""


def rooms(folder: Path, text: str = ROOMS) -> Path:
    (folder / "rooms.nm").write_text(text)
    return folder / "rooms.nm"


def test_choices_become_actions_variables_factors_and_labels_flags(tmp_path: Path):
    mdp = TabularMDP.from_storm(rooms(tmp_path), "N=2", reward="steps")
    assert mdp.states == 6
    assert set(mdp.actions) == {"right", "left", "lamp", "lamp 2", "[]"}
    place, lit = mdp.factor("place"), mdp.factor("lit")
    available = {name: mdp.available[:, i] for i, name in enumerate(mdp.actions)}
    assert np.array_equal(available["right"], place < 2)
    assert np.array_equal(available["left"], place == 1)
    assert np.array_equal(available["lamp"], place == 0)
    assert np.array_equal(available["lamp 2"], place == 0)
    assert np.array_equal(available["[]"], place == 1)
    assert np.array_equal(mdp.flags["home"], place == 0)
    assert np.array_equal(mdp.flags["deadlock"], place == 2)
    assert not mdp.available[place == 2].any()
    assert (place[mdp.start], lit[mdp.start]) == (0, 0)
    right = mdp.actions.index("right")
    for s in np.flatnonzero(place < 2):
        (on,) = np.flatnonzero((place == place[s] + 1) & (lit == lit[s]))
        assert mdp.transition(right).toarray()[s, [s, on]].tolist() == [0.25, 0.75]
        assert mdp.reward[s, right] == 1 + 0.5 * (place[s] == 0)
    lamps = [mdp.actions.index("lamp"), mdp.actions.index("lamp 2")]
    dark = mdp.start
    assert all(lit[mdp.transition(a).indices[mdp.transition(a).indptr[dark]]] == 1 for a in lamps)


def test_an_end_with_a_label_is_terminal_and_stays_where_it_is(tmp_path: Path):
    mdp = TabularMDP.from_storm(rooms(tmp_path), "N=2", reward="light", terminal="end")
    assert np.array_equal(mdp.terminal, mdp.factor("place") == 2)
    assert mdp.available[mdp.terminal].all()
    assert np.array_equal(mdp.reward[~mdp.terminal].max(axis=1), mdp.factor("lit")[~mdp.terminal])


class Slipgrid:
    """The published model `slipgrid.nm`, written once more from its text."""

    actions = "north", "south", "east", "west"
    initial = 1, 1

    def available(self, state: tuple[int, int]) -> list[int]:
        x, y = state
        return [i for i, free in enumerate((x > 1, x < 4, y > 1, y < 4)) if free]

    def step(self, state: tuple[int, int], action: int) -> list[tuple[float, tuple[int, int]]]:
        x, y = state
        dx, dy = ((-1, 0), (1, 0), (0, -1), (0, 1))[action]
        return [(0.6, (x + dx, y + dy)), (0.4, (x, y))]


def test_a_published_grid_is_that_of_its_text(tmp_path: Path):
    found = TabularMDP.from_storm(files.prism_mdp_slipgrid, terminal="goal")
    written = hb.explore(Slipgrid())
    assert found.states == written.states == 16
    place = [written.index(one) for one in zip(found.factor("x"), found.factor("y"), strict=True)]
    column = [found.actions.index(name) for name in written.actions]
    assert np.array_equal(found.available[:, column], written.available[place])
    for number, action in enumerate(column):
        ours = found.transition(action).toarray()
        assert np.allclose(ours, written.transition(number).toarray()[np.ix_(place, place)])
    assert found.reward.min() == 0
    assert (found.reward[found.available] == 1).all()
    for horizon in (1, 3):
        bits = hb.empowerment(found, horizon)
        assert np.allclose(bits, hb.empowerment(written, horizon)[place], atol=2e-6)


def least_cost(mdp: TabularMDP, goal: np.ndarray) -> np.ndarray:
    """The least expected sum of rewards until the goal, by plain value iteration."""
    value = np.zeros(mdp.states)
    each = [mdp.transition(action).toarray() for action in range(mdp.action_count)]
    for _ in range(3000):
        cost = mdp.reward + np.stack([one @ value for one in each], axis=1)
        value = np.where(goal, 0, np.where(mdp.available, cost, np.inf).min(axis=1))
    return value


def most_likely(mdp: TabularMDP, goal: np.ndarray) -> np.ndarray:
    """The largest probability that the goal is reached."""
    value = goal.astype(float)
    each = [mdp.transition(action).toarray() for action in range(mdp.action_count)]
    for _ in range(3000):
        chance = np.stack([one @ value for one in each], axis=1)
        value = np.where(goal, 1, np.where(mdp.available, chance, 0).max(axis=1))
    return value


@pytest.mark.parametrize(
    ("path", "formula", "goal", "solve"),
    [
        (files.prism_mdp_slipgrid, 'Rmin=? [F "goal"]', "goal", least_cost),
        (files.prism_mdp_maze, 'Rmin=? [F "goal"]', "goal", least_cost),
        (files.prism_mdp_coin_2_2, 'Pmax=? [F "agree"]', "agree", most_likely),
        (files.prism_dtmc_die, 'P=? [F "six"]', "six", most_likely),
    ],
)
def test_storm_finds_the_values_that_the_table_has(
    path: str,
    formula: str,
    goal: str,
    solve: Callable[[TabularMDP, np.ndarray], np.ndarray],
):
    program = stormpy.parse_prism_program(path)
    model = stormpy.build_model(program, options=stormpy.BuilderOptions(build_full=True))
    result = stormpy.model_checking(model, stormpy.parse_property(formula, program))
    mdp = TabularMDP.from_storm(model)
    value = solve(mdp, mdp.flags[goal])
    storms = [float(result.get_value(state)) for state in range(mdp.states)]
    assert np.allclose(value, storms, atol=1e-4)


def test_a_pomdp_has_its_observations_as_a_factor_and_a_drn_its_states():
    maze = TabularMDP.from_storm(files.prism_pomdp_maze)
    assert maze.states == 15
    assert len(np.unique(maze.factor("observation"))) == 8
    explicit = TabularMDP.from_storm(files.drn_pomdp_maze)
    assert explicit.states == 15
    assert list(explicit.factors) == ["observation"]
    assert hb.empowerment(maze, 2, "observation").max() > 0


def test_a_chain_has_one_action_and_no_empowerment(tmp_path: Path):
    die = TabularMDP.from_storm(files.prism_dtmc_die)
    assert (die.states, die.action_count, die.actions) == (13, 1, ())
    assert die.always_available
    assert not hb.empowerment(die, 3).any()
    assert TabularMDP.from_storm(files.jani_dtmc_die).states == 13
    labelled = "dtmc module m x : [0..2] init 0; [a] x=0 -> 0.5:(x'=1)+0.5:(x'=2); [b] x>0 -> true;"
    (tmp_path / "labelled.pm").write_text(f"{labelled} endmodule")
    chain = TabularMDP.from_storm(tmp_path / "labelled.pm")
    assert (chain.action_count, chain.actions) == (1, ())
    assert chain.always_available


@pytest.mark.parametrize(
    ("make", "reason"),
    [
        (lambda path: TabularMDP.from_storm(path), r"without a value \(N\); give .*'N=4'"),
        (lambda path: TabularMDP.from_storm(path, "N=two"), r"rooms\.nm: Storm refuses it: "),
        (lambda path: TabularMDP.from_storm(path, "N=2"), "several reward models; name one of 'li"),
        (lambda path: TabularMDP.from_storm(path, "N=2", reward="no"), "reward is 'no', which the"),
        (
            lambda path: TabularMDP.from_storm(path, "N=2", reward="light", terminal="no"),
            "terminal is 'no', which is not a label; the model has deadlock, end, home",
        ),
        (lambda path: TabularMDP.from_storm(path.with_name("none.nm")), "there is no such file"),
        (lambda path: TabularMDP.from_storm(__file__), "Storm refuses it: .*Parsing error"),
        (lambda path: TabularMDP.from_storm(files.drn_ctmc_dft), "the model is a CTMC; give one"),
        (lambda path: TabularMDP.from_storm(files.drn_pdtmc_die), "Storm refuses it: .*parametric"),
        (lambda path: TabularMDP.from_storm(files.drn_pomdp_maze, "N=2"), "an explicit model has"),
        (lambda path: TabularMDP.from_storm(7), "int is not a model of Storm's; give a path"),
    ],
)
def test_what_is_no_such_model_is_refused_in_one_line(tmp_path: Path, make: Callable, reason: str):
    with pytest.raises(ValueError, match=reason) as caught:
        make(rooms(tmp_path))
    assert "\n" not in str(caught.value)
