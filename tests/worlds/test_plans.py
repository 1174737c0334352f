"""A plan leads to a terminal state, and no other does so in fewer steps."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from habilis.mdp import TabularMDP
from habilis.worlds.plans import Plan, solve
from habilis.worlds.table import tabulate
from habilis.worlds.world import World, load_world


@st.composite
def tables(draw: st.DrawFn) -> TabularMDP:
    states, actions = draw(st.integers(1, 12)), draw(st.integers(1, 3))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    next_state = rng.integers(states, size=(states, actions))
    terminal = rng.random(states) < draw(st.sampled_from([0.0, 0.1, 0.4]))
    reward = rng.integers(-3, 4, size=(states, actions))
    return TabularMDP.deterministic(next_state, reward, terminal, start=int(rng.integers(states)))


def fewest_steps(mdp: TabularMDP, start: int) -> int | None:
    """How long the shortest way from a state into a terminal one is, by widening sets."""
    here = {start}
    for steps in range(1, mdp.states + 1):
        here = {int(to) for state in here for to in mdp.next_state[state]}
        if any(mdp.terminal[state] for state in here):
            return steps
    return None


def is_followed(plan: Plan, mdp: TabularMDP, start: int) -> None:
    """Asserts that the plan's actions lead through its states, first into a terminal at the end."""
    assert plan.steps == len(plan.actions) == len(plan.states) - 1
    assert plan.states[0] == start
    for state, action, to in zip(plan.states, plan.actions, plan.states[1:], strict=False):
        assert mdp.next_state[state, action] == to
    assert [bool(mdp.terminal[state]) for state in plan.states[1:]] == [
        *[False] * (plan.steps - 1),
        True,
    ]


@pytest.mark.parametrize(
    ("name", "tool", "steps"),
    [
        ("corridor", "picker", 15),
        ("corridor", "none", 25),
        ("yard", "picker", 11),
        ("yard", "broom", 13),
    ],
)
def test_the_built_in_worlds_have_the_shortest_plans_that_are_published(
    name: str, tool: str, steps: int
):
    mdp = tabulate(load_world(name, tool))
    plan = solve(mdp)
    assert plan is not None
    assert plan.steps == steps
    assert plan.best_return == -(steps - 1)
    is_followed(plan, mdp, mdp.start)


def test_a_plan_is_replayed_by_its_actions_to_the_goal():
    world = load_world("corridor")
    mdp = tabulate(world)
    plan = solve(mdp)
    assert plan is not None
    state = mdp.start
    for action in plan.actions:
        state = mdp.next_state[state, action]
    row, column = world.goal
    assert mdp.factor("object")[state] == row * world.width + column


def test_a_goal_out_of_reach_has_no_plan():
    assert solve(tabulate(World.parse("AC#G"))) is None
    assert solve(tabulate(World.parse("A.#CG"))) is None
    assert solve(tabulate(World.parse("AGC"))) is None
    assert solve(TabularMDP.deterministic([[1], [0]])) is None


@given(tables(), st.booleans(), st.data())
def test_no_way_is_shorter_than_the_plan(mdp: TabularMDP, own_start: bool, data: st.DataObject):
    start = mdp.start if own_start else data.draw(st.integers(0, mdp.states - 1))
    plan = solve(mdp) if own_start else solve(mdp, start)
    assert (plan and plan.steps) == fewest_steps(mdp, start)
    if plan is not None:
        is_followed(plan, mdp, start)
        rewards = [mdp.reward[s, a] for s, a in zip(plan.states, plan.actions, strict=False)]
        assert plan.best_return == sum(rewards)


def test_a_plan_begins_in_the_state_that_is_asked_for():
    mdp = TabularMDP.deterministic([[1], [2], [3], [3]], terminal=[0, 0, 0, 1], start=2)
    assert solve(mdp) == Plan((0,), (2, 3), 0.0)
    assert solve(mdp, start=0) == Plan((0, 0, 0), (0, 1, 2, 3), 0.0)


def test_a_plan_from_a_terminal_state_leaves_it_to_enter_one():
    circle = TabularMDP.deterministic([[1], [2], [0]], terminal=[1, 0, 0])
    assert solve(circle) == Plan((0, 0, 0), (0, 1, 2, 0), 0.0)
    loop = TabularMDP.deterministic([[1, 0], [1, 1]], terminal=[1, 0])
    assert solve(loop) == Plan((1,), (0, 0), 0.0)
    no_return = TabularMDP.deterministic([[1], [1]], terminal=[1, 0])
    assert solve(no_return) is None


def test_of_several_plans_the_one_through_lower_states_and_actions_is_given():
    actions = TabularMDP.deterministic([[0, 1, 1], [1, 1, 1]], terminal=[0, 1])
    assert solve(actions) == Plan((1,), (0, 1), 0.0)
    states = TabularMDP.deterministic([[2, 1], [3, 3], [3, 3], [3, 3]], terminal=[0, 0, 0, 1])
    assert solve(states) == Plan((1, 0), (0, 1, 3), 0.0)
    ends = TabularMDP.deterministic([[2, 1], [1, 1], [2, 2]], terminal=[0, 1, 1])
    assert solve(ends) == Plan((1,), (0, 1), 0.0)


@pytest.mark.parametrize("start", [-1, 3])
def test_a_start_that_is_no_state_is_refused(start: int):
    with pytest.raises(ValueError, match=f"start is {start}; use a state from 0 to 2"):
        solve(TabularMDP.deterministic([[1], [2], [2]]), start)
