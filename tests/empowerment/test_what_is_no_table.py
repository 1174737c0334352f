"""Measures of tables, asked about something else, say how to make a table of it."""

from typing import Any

import numpy as np
import pytest

import habilis as hb


class Line:
    """A model."""

    actions = 2
    initial = 0

    def step(self, state, action):
        return min(max(state + 2 * action - 1, 0), 3)


class Drift:
    """A simulator."""

    actions = np.array([[-1.0], [1.0]])
    is_stochastic = False

    def step(self, states, actions, key):
        return states + actions


class Box(Drift):
    """A simulator of whatever actions."""

    actions: Any = hb.estimators.ActionBox([-1.0], [1.0])


MEASURES = {
    "closed-loop": lambda model: hb.closed_loop_empowerment(model, 2),
    "effective": lambda model: hb.effective_empowerment(model, "uniform", 0.5),
    "goal-directed": lambda model: hb.goal_directed_empowerment(model, 2),
    "assistance": lambda model: hb.assistance(model, "robot", "human", 2),
}


@pytest.mark.ill_typed
@pytest.mark.parametrize("measure", MEASURES)
@pytest.mark.parametrize(
    ("model", "message"),
    [
        (hb.World.parse("A.C\n..G\n"), r"^World is no table; give hb\.tabulate\(world\)$"),
        (Line(), r"^Line is no table; give hb\.explore\(model\)$"),
        (np.eye(2), r"^ndarray is no table; give a hb\.TabularMDP$"),
        (
            Drift(),
            r"^Drift is a simulator, .*; name an estimator, as .*method=hb\.Counting\(0\.1\)",
        ),
    ],
    ids=["world", "model", "array", "simulator"],
)
def test_every_kind_says_how_to_make_a_table(measure, model, message):
    with pytest.raises(ValueError, match=message):
        MEASURES[measure](model)


@pytest.mark.parametrize("simulator", [Drift(), Box()], ids=["finite", "box"])
@pytest.mark.parametrize(
    "measure",
    [
        lambda one: hb.empowerment(one, 2),
        lambda one: hb.empowerment(one, 2, states=[[0.0]]),
        lambda one: hb.landscape(one, 2),
        hb.explore,
    ],
)
def test_a_simulator_without_an_estimator_is_refused_in_one_line(simulator, measure):
    with pytest.raises(ValueError, match=r"is a simulator, .* name an estimator") as refusal:
        measure(simulator)
    assert "\n" not in str(refusal.value)


@pytest.mark.ill_typed
def test_the_class_of_an_estimator_is_refused_by_its_name():
    with pytest.raises(ValueError, match=r"the class Counting; use hb\.Counting\(\)"):
        hb.empowerment(Drift(), 2, states=[[0.0]], method=hb.Counting)  # type: ignore[call-overload]


def test_where_beliefs_do_not_go_the_message_says_where_they_do():
    mdp = hb.TabularMDP.deterministic([[0, 1], [1, 0]]).slippery(0.1)
    belief = np.array([[0.5, 0.5]])
    for refused in (
        lambda: hb.closed_loop_empowerment(mdp, 1, states=belief),
        lambda: hb.empowerment(mdp, 1, states=belief[0]),
    ):
        with pytest.raises(
            ValueError, match=r"hb\.empowerment alone takes beliefs, as float\[n, S\]"
        ):
            refused()
