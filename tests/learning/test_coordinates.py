"""States shown as coordinates."""

from dataclasses import replace

import numpy as np
import pytest

from habilis.learning.dynamics import coordinates, make_dynamics, one_hot, roomy
from habilis.mdp import HELD, LAID, TabularMDP
from habilis.worlds.table import placement, tabulate
from habilis.worlds.world import World

SEVERAL = "D = ball\nG = goal of C\nH = goal of D\nR = rake\ndrop: true\nAC.G\nP..R\n.D.H\n"


def table(text: str) -> TabularMDP:
    return tabulate(World.parse(text))


def by_hand(cell: tuple[int, int], height: int, width: int) -> list[float]:
    scaled = zip(cell, (height, width), strict=True)
    return [0.0 if side == 1 else -1 + 2 * place / (side - 1) for place, side in scaled]


@pytest.mark.parametrize("text", ["A.C\nP..\n..G\n.#.\n", "A.C.G\n", "A\n.\nC\nG\n"])
def test_they_are_row_and_column_from_minus_one_to_one(text):
    world = World.parse(text)
    mdp = tabulate(world)
    found, count = coordinates(mdp)
    assert found.dtype == np.float32
    assert found.shape == (mdp.states, count) == (mdp.states, 2 * len(mdp.factors))
    for state in range(mdp.states):
        placed = placement(world, mdp, state)
        cells = [np.divmod(mdp.factors[name][state], world.width) for name in mdp.factors]
        assert tuple(map(int, cells[0])) == placed.agent
        wanted = [x for cell in cells for x in by_hand(cell, world.height, world.width)]
        np.testing.assert_allclose(found[state], wanted, atol=1e-6)


def test_of_several_things_all_are_shown_and_no_two_states_look_the_same():
    mdp = table(SEVERAL)
    found, count = coordinates(mdp)
    cells = len(mdp.factors.keys() - {HELD, LAID})
    assert {HELD, LAID} <= mdp.factors.keys()
    assert count == 2 * cells + 2
    assert np.abs(found).max() == 1
    assert len(np.unique(found, axis=0)) == mdp.states
    held = mdp.factors[HELD]
    np.testing.assert_allclose(
        found[:, list(mdp.factors).index(HELD) * 2], 2 * (held + 1) / (held.max() + 1) - 1
    )


def test_without_cells_labels_are_scaled_and_without_factors_the_index():
    mdp = TabularMDP.deterministic([[1], [2], [3], [4], [4]])
    np.testing.assert_array_equal(coordinates(mdp)[0], [[-1.0], [-0.5], [0.0], [0.5], [1.0]])
    labels = {"taxi": np.array([3, 3, 7, 5, 7], np.int32), "same": np.full(5, 4, np.int32)}
    labelled = replace(mdp, factors=labels)
    found, count = coordinates(labelled)
    assert count == 2
    np.testing.assert_array_equal(found, [[-1, 0], [-1, 0], [1, 0], [0, 0], [1, 0]])


def test_unreachable_states_have_an_observation():
    dynamics, count = make_dynamics(table("A.C\nP..\n..G\n"), observation="coordinates")
    assert count == dynamics.inputs.shape[1]
    room = roomy(dynamics)
    assert room.inputs.dtype == np.float32
    assert np.isfinite(room.inputs).all()
    np.testing.assert_array_equal(room.inputs[: dynamics.states], dynamics.inputs)


def test_one_hot_stays_what_is_shown_otherwise():
    mdp = table("A.C\nP..\n..G\n")
    np.testing.assert_array_equal(make_dynamics(mdp)[0].inputs, one_hot(mdp)[0])
