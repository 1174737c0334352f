"""The controller that follows estimates, and estimates that are interpolated."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike

from habilis.estimators import ActionBox, Counting, Gaussian, OnGrid, follow, on_grid
from habilis.estimators.protocol import Kind, Target
from habilis.estimators.simulators import JaxSimulator, cart_pole, pendulum

LINE = JaxSimulator(lambda state, action: state + action, [[-1.0], [0.0], [1.0]])


@dataclass(frozen=True)
class Given:
    """Estimates that are a function of states."""

    function: Callable[[np.ndarray], np.ndarray]
    kind: Kind = "approximation"
    target: Target = "capacity"

    def bits(self, states: ArrayLike) -> np.ndarray:
        return self.function(np.asarray(states))


HILL = Given(lambda states: -np.abs(states[:, 0] - 3))
"""Largest at 3."""


def test_it_goes_to_the_largest_estimate_and_stays_there():
    went = follow(HILL, LINE, [[0.0], [5.0]], 4)
    np.testing.assert_array_equal(went.states[:, 0, 0], [0, 1, 2, 3, 3])
    np.testing.assert_array_equal(went.states[:, 1, 0], [5, 4, 3, 3, 3])
    np.testing.assert_array_equal(went.actions[:, 0, 0], [1, 1, 1, 0])
    np.testing.assert_array_equal(went.bits[:, 0], [-2, -1, 0, 0])


def test_every_start_goes_where_it_goes_alone():
    together = follow(HILL, LINE, [[0.0], [5.0]], 3)
    alone = follow(HILL, LINE, [5.0], 3)
    np.testing.assert_array_equal(together.states[:, 1:], alone.states)
    assert follow(HILL, LINE, [5.0], 0).states.shape == (1, 1, 1)


def test_with_noise_it_averages_over_what_may_come():
    # Staying is sure; a step to the right leads to 1 or to -9.
    def step(state: Any, action: Any, drawn: Any) -> Any:
        return state + action * (drawn * 0 + (drawn > 0) * 10 - 9)

    risky = JaxSimulator(step, [[0.0], [1.0]], noise=1)
    went = follow(HILL, risky, [2.0], 5, samples=200)
    np.testing.assert_array_equal(went.actions, np.zeros((5, 1, 1)))
    again = follow(HILL, risky, [2.0], 5, samples=200)
    np.testing.assert_array_equal(went.states, again.states)


def test_five_values_of_each_component_of_a_box_are_tried():
    tried = []

    def noted(states: np.ndarray) -> np.ndarray:
        tried.append(states)
        return np.zeros(len(states))

    plane = JaxSimulator(lambda state, action: state + action, ActionBox([-1, -2], [1, 2]))
    follow(Given(noted), plane, [0.0, 0.0], 1)
    expected = [[x, 2 * y] for x in np.linspace(-1, 1, 5) for y in np.linspace(-1, 1, 5)]
    np.testing.assert_allclose(tried[0], expected)


@pytest.mark.parametrize(
    ("actions", "words"),
    [
        (ActionBox([-np.inf], [1.0]), "the action box is unbounded"),
        (ActionBox([-1.0] * 6, [1.0] * 6), "6 components, too many"),
    ],
)
def test_actions_that_cannot_all_be_tried_are_refused(actions: ActionBox, words: str):
    with pytest.raises(ValueError, match=words):
        follow(HILL, replace(LINE, actions=actions), [0.0], 1)


def test_the_pendulum_swings_up_and_stays_upright_without_a_reward():
    world = pendulum()
    starts = np.array([np.pi, 0]) + np.random.default_rng(0).uniform(-0.3, 0.3, (10, 2))
    went = follow(Gaussian(power=1, noise=0.1).fit(world, 5), world, starts, 120)
    assert (np.cos(went.states[0, :, 0]) < -0.9).all()
    upright = np.cos(went.states[-50:, :, 0]) > np.cos(0.3)
    assert upright.all(axis=0).sum() >= 9


def test_the_pole_is_balanced_without_a_reward():
    world = cart_pole()
    starts = np.random.default_rng(0).uniform(-0.1, 0.1, (10, 4))
    went = follow(Gaussian(power=1, noise=0.1).fit(world, 5), world, starts, 100)
    assert (np.abs(went.states[:, :, 2]) < 0.3).all()


def test_a_grid_interpolates_and_wraps():
    swing = Given(lambda states: np.cos(states[:, 0]) + states[:, 1])
    axes = np.linspace(-np.pi, np.pi, 5), np.array([0.0, 2.0])
    table = on_grid(swing, axes, [2 * np.pi, 0])
    asked = [[0.0, 1.0], [2 * np.pi, 1.0], [np.pi / 4, 0.5], [-2.75 * np.pi, 0.0], [0.0, 9.0]]
    np.testing.assert_allclose(table.bits(asked), [2.0, 2.0, 1.0, -0.5, 3.0], atol=1e-12)
    with pytest.raises(ValueError, match="let it span its period"):
        on_grid(swing, axes, [3.0, 0])
    with pytest.raises(ValueError, match="does not increase"):
        on_grid(swing, [np.zeros(2), np.arange(2.0)])
    with pytest.raises(ValueError, match="method is the class Counting; give an instance"):
        OnGrid(Counting, axes).fit(pendulum(), 1)  # pyright: ignore[reportArgumentType]
    with pytest.raises(ValueError, match="states have 1 components, the grid 2"):
        table.bits([[0.0]])


def test_a_component_of_one_value_has_no_influence_and_a_tabulated_estimator_is_one():
    axes = [0.0, 1.0, 3.0], [0.0]
    tabulated = OnGrid(Counting(0.05, 50), axes).fit(pendulum(), 2, seed=1)
    fitted = Counting(0.05, 50).fit(pendulum(), 2, seed=1)
    corners = fitted.bits([[angle, 0.0] for angle in axes[0]])
    asked = [[0.0, 9.0], [1.5, 0.0], [9.0, -9.0]]
    expected = [corners[0], 0.75 * corners[1] + 0.25 * corners[2], corners[2]]
    np.testing.assert_allclose(tabulated.bits(asked), expected)


def test_the_most_cells_are_in_reach_where_the_pendulum_is_upright():
    world = replace(pendulum(), actions=[[-5.0], [0.0], [5.0]])
    asked = [[angle, 0.0] for angle in (0.0, 1.0, 2.0, 3.0)]
    bits = Counting([0.2, 0.5], 300).fit(world, 5).bits(asked)
    assert bits.argmax() == 0
