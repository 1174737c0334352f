"""The table of a model: every state that can be reached, and what the model says of it."""

import random
from fractions import Fraction
from itertools import count
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import habilis as hb
from habilis.models import Model, TooManyStatesError, VectorModel, explore


class Line:
    """Five cells in a row; the agent goes left or right."""

    actions = "left", "right"
    initial = 0

    def step(self, state, action) -> Any:
        return min(max(state + (-1, 1)[action], 0), 4)


class Described(Line):
    """The same with all that a model may have."""

    def factors(self, state):
        return {"agent": (1, state), "parity": state % 2}

    def reward(self, state, action, next_state):
        return float(10 * state + next_state + 0.5 * action)

    def terminal(self, state):
        return state == 4

    def available(self, state):
        return [1] if state == 0 else [0, 1]


class Rows:
    """The same with all that a vectorised model may have."""

    actions = Line.actions
    initial = (0,)

    def step_many(self, states, actions):
        return np.clip(states + np.array([-1, 1])[actions][:, None], 0, 4)


class DescribedRows(Rows):
    def factors_many(self, states):
        ones = np.ones(len(states), int)
        return {"agent": np.stack([ones, states[:, 0]], axis=1), "parity": states[:, 0] % 2}

    def reward_many(self, states, actions, next_states):
        return 10 * states[:, 0] + next_states[:, 0] + 0.5 * actions

    def terminal_many(self, states):
        return states[:, 0] == 4

    def available_many(self, states):
        return np.stack([states[:, 0] > 0, np.full(len(states), True)], axis=1)


class RowsDescribedOneByOne(Rows):
    def factors(self, state):
        return Described().factors(*state)

    def reward(self, state, action, next_state):
        return Described().reward(state[0], action, next_state[0])

    def terminal(self, state):
        return Described().terminal(*state)

    def available(self, state):
        return Described().available(*state)


class Slippery(Described):
    def step(self, state, action):
        there = super().step(state, action)
        return [(0.75, there), (0.25, state)] if state else there


def model(step, **more):
    """A model of functions."""
    parts = {"actions": 2, "initial": 0, "step": step} | more
    plain = {name: staticmethod(part) if callable(part) else part for name, part in parts.items()}
    return type("Given", (), plain)()


def test_states_are_numbered_in_the_order_in_which_they_are_met():
    mdp = explore(Line(), states=[2])
    assert [mdp.state(place) for place in range(mdp.states)] == [2, 1, 3, 0, 4]
    assert [mdp.index(mdp.state(place)) for place in range(mdp.states)] == [0, 1, 2, 3, 4]
    assert mdp.next_state.tolist() == [[1, 2], [3, 0], [0, 4], [3, 1], [2, 4]]
    assert (mdp.start, mdp.actions) == (0, ("left", "right"))


@pytest.mark.parametrize("described", [Described, DescribedRows, RowsDescribedOneByOne])
def test_a_table_has_all_that_the_model_says(described):
    mdp = explore(described())
    assert mdp.next_state.tolist() == [[-1, 1], [0, 2], [1, 3], [2, 4], [3, 4]]
    assert mdp.reward.tolist() == [[0, 1.5], [10, 12.5], [21, 23.5], [32, 34.5], [43, 44.5]]
    assert mdp.terminal.tolist() == [False] * 4 + [True]
    assert mdp.shape == (2, 5)
    assert mdp.factor("agent").tolist() == [5, 6, 7, 8, 9]
    assert mdp.factor("parity").tolist() == [0, 1, 0, 1, 0]
    assert mdp.is_cell("agent")
    assert not mdp.is_cell("parity")
    assert mdp.find(agent=(1, 3), parity=1) == 3


def test_outcomes_are_mixed_and_rewards_are_their_means():
    mdp = explore(Slippery())
    assert mdp.is_stochastic
    assert mdp.transition(1).toarray()[1].tolist() == [0, 0.25, 0.75, 0, 0]
    assert mdp.transition(0).toarray()[0].tolist() == [0, 0, 0, 0, 0]
    assert mdp.reward[1, 1] == pytest.approx(0.75 * 12.5 + 0.25 * 11.5)
    assert mdp.entry_reward is None


def test_rewards_of_entering_a_state_are_recognised():
    entering = type("Entering", (Slippery,), {"reward": lambda self, s, a, to: -float(to)})
    mdp = explore(entering())
    assert mdp.entry_reward is not None
    assert mdp.entry_reward.tolist() == [0, -1, -2, -3, -4]


def test_one_outcome_in_a_list_is_that_outcome():
    mdp = explore(model(lambda state, action: [(0.5, action), (0.5, action), (0.0, "never")]))
    assert mdp.next_state.tolist() == [[0, 1], [0, 1]]


@pytest.mark.parametrize("line", [Line(), Rows()])
def test_states_at_the_horizon_stay_where_they_are(line):
    first = 1 if isinstance(line, Line) else (1,)
    mdp = explore(line, states=[first], horizon=2)
    assert mdp.states == 4
    assert mdp.next_state.tolist() == [[1, 2], [1, 0], [0, 3], [3, 3]]
    assert explore(line, states=[first], horizon=0).next_state.tolist() == [[0, 0]]


@settings(deadline=None, max_examples=40)
@given(st.integers(1, 3), st.integers(2, 4), st.integers(0, 2**31), st.integers(0, 6))
def test_both_kinds_of_models_give_the_same_table(columns, most, seed, horizon):
    weights = np.random.default_rng(seed).integers(-9, 9, size=(3, columns, columns + 1))

    def many(self, states, actions):
        wide = np.concatenate([states, np.ones((len(states), 1), int)], axis=1)
        return np.einsum("nk,njk->nj", wide, weights[actions]) % most - 1

    def one(state, action):
        return tuple(many(None, np.array([state]), np.array([action]))[0].tolist())

    start = (0,) * columns
    rows = type("Many", (), {"actions": 3, "initial": start, "step_many": many})()
    values = type("One", (), {"actions": 3, "initial": start, "step": staticmethod(one)})()
    both = explore(rows), explore(values)
    assert both[0].next_state.tolist() == both[1].next_state.tolist()
    states = [[mdp.state(place) for place in range(mdp.states)] for mdp in both]
    assert states[0] == states[1]
    near = [explore(m, [start], horizon).next_state.tolist() for m in (rows, values)]
    assert near[0] == near[1]


def test_a_world_and_an_environment_are_explored_too():
    gymnasium = pytest.importorskip("gymnasium")
    assert explore(gymnasium.make("FrozenLake-v1")).states == 16
    world = hb.World.parse("A.C..G")
    whole = explore(world)
    assert whole.states == hb.tabulate(world).states
    at = {"agent": (0, 0), "object": (0, 2)}
    assert explore(world, [at], horizon=2).states == 3


def test_protocols_recognise_their_models():
    assert isinstance(Line(), Model)
    assert isinstance(Rows(), VectorModel)
    assert not isinstance(Line(), VectorModel)


CALLS = count()
FAULTS = {
    "returns None": (lambda s, a: None, r"step\(0, 0\) returns a NoneType; return the next"),
    "an array": (lambda s, a: np.array([s]), r"step\(0, 0\) returns array\(\[0\]\), .* hashable"),
    "no pairs": (lambda s, a: [s, a], r"step\(0, 0\) has the outcome 0; give \(probability, state"),
    "half": (lambda s, a: [(0.5, s)], r"step\(0, 0\) has probabilities that sum to 0\.5; let them"),
    "none": (lambda s, a: [], r"step\(0, 0\) has probabilities that sum to 0; let them"),
    "below 0": (lambda s, a: [(-1.0, 1), (2.0, 2)], r"step\(0, 0\) has the probability -1\.0"),
    "NaN": (lambda s, a: [(float("nan"), 1)], r"step\(0, 0\) has the probability nan"),
    "a list in one": (lambda s, a: [(1.0, [2])], r"step\(0, 0\) leads to \[2\], .* not hashable"),
    "a coin": (
        lambda s, a: random.randrange(10**9) % 99,
        r"step\(.*\) has another outcome the sec",
    ),
    "a counter": (
        lambda s, a: next(CALLS) % 7,
        r"step\(.*\) has another outcome the second",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_function_that_is_no_model_is_refused_with_the_state(name):
    step, message = FAULTS[name]
    with pytest.raises(ValueError, match=message):
        explore(model(step), max_states=1000)


def test_a_random_vectorised_model_is_refused_with_the_state():
    numbers = np.random.default_rng(0)
    rows = type(
        "Random", (Rows,), {"step_many": lambda self, s, a: numbers.integers(5, size=s.shape)}
    )
    with pytest.raises(
        ValueError, match=r"step_many leads from \(\d,\) by action \d to \(\d,\) the"
    ):
        explore(rows())


def test_a_vectorised_model_cannot_change_the_states_it_is_given():
    def step_many(self, states, actions):
        states += 1
        return states

    with pytest.raises(ValueError, match="read-only"):
        explore(type("InPlace", (Rows,), {"step_many": step_many})())


@pytest.mark.parametrize("line", [Line(), Rows()])
def test_too_many_states_are_refused_with_how_far_it_came(line):
    endless = model(lambda state, action: state + 1)
    message = (
        r"more than 1,000 states can be reached; 999 of them are expanded, and the next is 999 "
        "actions from the first: raise max_states"
    )
    with pytest.raises(TooManyStatesError, match=message):
        explore(endless, max_states=1000)
    with pytest.raises(
        TooManyStatesError, match=r"more than 2 states .* within 3 actions; .* lower"
    ):
        explore(line, horizon=3, max_states=2)
    assert explore(line, max_states=5).states == 5


REFUSED = [
    ({"model": 3}, "int is not a model; give it actions and step"),
    ({"states": []}, "states is empty"),
    ({"states": [[1]]}, r"states has \[1\], which is not a hashable value"),
    ({"horizon": -1}, "horizon is -1; give a whole number from 0 up"),
    ({"horizon": 1.5}, "horizon is 1.5; give a whole number from 0 up"),
    ({"max_states": 0}, "max_states is 0; give a whole number from 1 up"),
    ({"model": model(lambda s, a: s, initial=None)}, "the model has no initial state"),
    ({"model": model(lambda s, a: s, actions=0)}, "the model's actions are 0; give different"),
    ({"model": model(lambda s, a: s, actions=("a", "a"))}, "actions are .* give different names"),
    ({"model": model(lambda s, a: s, terminal=lambda s: None)}, "terminal returns .*; return True"),
    (
        {"model": model(lambda s, a: s, reward=lambda *_: "x")},
        "reward returns 'x', or not one value for each",
    ),
    (
        {"model": model(lambda s, a: s, reward=lambda *_: 1e99)},
        "reward of action 0 in state 0 is 1e",
    ),
    (
        {"model": model(lambda s, a: s, factors=lambda s: 3)},
        r"factors\(0\) returns 3; return a dict",
    ),
    (
        {"model": model(lambda s, a: a, factors=lambda s: {"ab"[s]: 1})},
        r"factors\(1\) returns {'b': 1}; return a dict with the same names",
    ),
    (
        {"model": model(lambda s, a: s, factors=lambda s: {"x": 0.5})},
        "factor 'x' is 0.5 in state 0; give a whole number or",
    ),
    (
        {"model": model(lambda s, a: s, factors=lambda s: {"x": (0, 3)}, shape=(2, 3))},
        r"factor 'x' is the cell \(0, 3\) in state 0, which is outside the 2 x 3 cells",
    ),
    (
        {"model": type("Narrow", (Rows,), {"step_many": lambda self, s, a: s[:, 0]})()},
        r"step_many returns int64 of shape \(1,\); return integers of shape \(1, 1\)",
    ),
    (
        {"model": type("Real", (Rows,), {"step_many": lambda self, s, a: s / 2})()},
        "step_many returns float64 of shape",
    ),
    (
        {"model": type("Flags", (Rows,), {"available_many": lambda self, s: s})()},
        r"available_many returns int64 of shape \(1, 1\); return bool of shape \(1, 2\)",
    ),
]


REFUSED += [
    (
        {"model": model(lambda s, a: s, available=lambda s, given=given: given)},
        r"available\(0\) ret",
    )
    for given in ([2], [-1], [1.0], [False, True], np.array([True, False]), None, 1.5)
]
REFUSED += [
    ({"model": Line}, r"Line is a class; give an instance, as Line\(\)"),
    ({"states": 3}, "states is 3; give a list of states"),
    ({"model": Rows(), "states": [(0,), (0, 1)]}, "give a row of k integers for each state"),
    ({"model": Rows(), "states": [(0,), (1,)], "max_states": 1}, "more than 1 states"),
    (
        {"model": model(lambda s, a: (x for x in [s]))},
        r"step\(0, 0\) returns a generator; return the",
    ),
    (
        {"model": model(lambda s, a: s, factors=lambda s: {"x": 2**40})},
        "factor 'x' is 1099511627776 in state 0; labels are int32: use smaller numbers",
    ),
    (
        {"model": model(lambda s, a: s, factors=lambda s: {"x": (70000, 70000)})},
        "factor 'x' is 4900140000 in state 0; labels are int32",
    ),
    (
        {"model": model(lambda s, a: a, factors=lambda s: {"x": s if s else (0, 1)})},
        "factor 'x' has values of different kinds or lengths; give the same kind",
    ),
    (
        {"model": model(lambda s, a: s, factors=lambda s: {"x": (0, 0)}, shape=5)},
        r"the model's shape is 5; give \(rows, columns\)",
    ),
    (
        {"model": type("One", (Rows,), {"reward_many": lambda self, s, a, t: 1.0})()},
        r"reward returns 1\.0, or not one value for each transition",
    ),
    (
        {"model": type("None", (Rows,), {"factors_many": lambda self, s: 3})()},
        "factors_many returns 3; return a dict of arrays",
    ),
    (
        {
            "model": type(
                "Wide", (Rows,), {"step_many": lambda self, s, a: s.astype("u8") + 2**63}
            )()
        },
        r"step_many returns 9223372036854775808; use numbers below 2\*\*63",
    ),
]
LATER = count()
CHANGING = {
    "reward": lambda s, a, t: float(next(CALLS)),
    "terminal": lambda s: next(CALLS) % 3 == 0,
    "factors": lambda s: {"x": next(CALLS) % 1000},
    "available": lambda s: [int(next(LATER) > 9)],
}


@pytest.mark.parametrize("name", CHANGING)
def test_every_function_of_a_model_has_to_return_the_same_again(name):
    line = model(lambda s, a: min(max(s + 2 * a - 1, -9), 9), **{name: CHANGING[name]})
    with pytest.raises(ValueError, match=rf"{name}.* returns something else the second time"):
        explore(line)


def test_probabilities_may_be_of_any_type_of_number():
    for half in (np.float32(0.5), Fraction(1, 2)):
        mdp = explore(model(lambda s, a, half=half: [(half, a), (half, 1 - a)]))
        assert mdp.transition(0).toarray().tolist() == [[0.5, 0.5], [0.5, 0.5]]
    rough = model(lambda s, a: [(np.float32(0.1), 0), (np.float32(0.9), 1)])
    assert explore(rough).transition(0).toarray()[0] == pytest.approx([0.1, 0.9], abs=1e-6)


def test_states_and_the_number_of_actions_may_be_given_in_any_way():
    assert explore(Line(), states=(state for state in (1, 2))).state(1) == 2
    assert explore(model(lambda s, a: a, actions=np.int64(2))).action_count == 2


@pytest.mark.ill_typed
@pytest.mark.parametrize(("arguments", "message"), REFUSED)
def test_what_cannot_be_explored_is_refused_in_one_line(arguments, message):
    with pytest.raises(ValueError, match=message) as refusal:
        explore(**({"model": Line()} | arguments))
    assert "\n" not in str(refusal.value)


def test_a_table_of_no_model_has_no_states_of_one():
    mdp = hb.TabularMDP.deterministic([[0]])
    for asked in (lambda: mdp.state(0), lambda: mdp.index(0)):
        with pytest.raises(ValueError, match="not made of a model"):
            asked()


def test_states_that_are_not_there_are_refused():
    mdp = explore(Line())
    with pytest.raises(KeyError, match="the table has no state 7"):
        mdp.index(7)
    with pytest.raises(KeyError, match="no state"):
        mdp.index([1])
    with pytest.raises(KeyError, match="no state"):
        explore(Rows()).index((1, 2))
    with pytest.raises(ValueError, match="state is 5; use 0 to 4"):
        mdp.state(5)


@pytest.mark.parametrize("line", [Described(), DescribedRows(), RowsDescribedOneByOne()])
def test_measures_take_a_model_as_they_take_its_table(line):
    mdp, states = explore(line), [line.initial]
    for horizon in range(5):
        bits = hb.empowerment(mdp, horizon, states=[0])
        assert hb.empowerment(line, horizon, states=states) == pytest.approx(bits)
        assert hb.empowerment(line, horizon, "parity").tolist() == pytest.approx(
            hb.empowerment(mdp, horizon, "parity")
        )
    assert hb.persistence(line, "state").tolist() == hb.persistence(mdp, "state").tolist()
    assert hb.to_dataframe(line).equals(hb.to_dataframe(mdp))
    plan, same = hb.solve(line), hb.solve(mdp)
    assert plan is not None
    assert same is not None
    assert plan.actions == same.actions == (1, 1, 1, 1)
    assert plan.states == tuple(map(mdp.state, same.states))
    assert plan.best_return == same.best_return


def test_a_plan_is_found_without_exploring_further_than_it_goes():
    made = []

    def step(state, action):
        made.append(state)
        return state + (-1, 1)[action]

    endless = model(step, terminal=lambda state: state == 5)
    plan = hb.solve(endless)
    assert plan is not None
    assert plan.states == (0, 1, 2, 3, 4, 5)
    assert max(map(abs, made)) == 4
    near = hb.solve(endless, 4)
    assert near is not None
    assert near.actions == (1,)


def test_empowerment_explores_no_further_than_the_horizon():
    made = []

    def step(state, action):
        made.append(state)
        return state + (-1, 1)[action]

    assert hb.empowerment(model(step), 3, states=[0, 10]).tolist() == [2, 2]
    assert {*made} == {-2, -1, 0, 1, 2, 8, 9, 10, 11, 12}


def test_a_models_states_have_no_numbers_for_a_sensor():
    with pytest.raises(ValueError, match=r"a model's states have no numbers yet; .* or explore it"):
        hb.empowerment(Line(), 2, [0, 1, 2, 3, 4])


@pytest.mark.parametrize("start", [3, 4])
def test_a_plan_from_a_terminal_state_goes_no_further_than_it_must(start):
    forth = model(lambda s, a: s + 1 if a else s, terminal=lambda s: s >= 3)
    plan = hb.solve(forth, start, max_states=50)
    assert plan is not None
    assert plan.actions == (0,)
    away = model(lambda s, a: s + 1, terminal=lambda s: s in (0, 30))
    far = hb.solve(away, 0, max_states=100)
    assert far is not None
    assert far.steps == 30


def test_a_stochastic_model_has_no_plan():
    with pytest.raises(ValueError, match="the model is stochastic, so that no sequence of actions"):
        hb.solve(Slippery())
    with pytest.raises(ValueError, match="this MDP is stochastic, so that no sequence of actions"):
        hb.solve(hb.explore(Slippery()))


def test_an_environment_and_a_world_have_plans_too():
    gymnasium = pytest.importorskip("gymnasium")
    env = gymnasium.make("FrozenLake-v1", is_slippery=False)
    plan, of_table = hb.solve(env), hb.solve(hb.TabularMDP.from_gymnasium(env))
    assert plan is not None
    assert plan == of_table
    world = hb.World.parse("A.C..G")
    assert hb.solve(world) == hb.solve(hb.tabulate(world))
