"""Every number that the paper states about its maps holds on ours, to the digits that we print."""

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest

from habilis.empowerment import empowerment
from habilis.mdp import TabularMDP
from habilis.worlds.plans import solve
from habilis.worlds.table import tabulate
from habilis.worlds.world import Cell, load_world


@dataclass(frozen=True)
class Landscape:
    """Values for the agent cells, tool and can at their cells of the map.

    Attributes:
        bits: float[n].
        from_tool, from_can: int[n], Manhattan distance of the agent.
    """

    bits: np.ndarray
    from_tool: np.ndarray
    from_can: np.ndarray

    @property
    def next_to_tool(self) -> np.ndarray:
        return self.bits[self.from_tool == 1]

    @property
    def next_to_can(self) -> np.ndarray:
        return self.bits[self.from_can == 1]

    @property
    def at_maximum(self) -> np.ndarray:
        return self.bits == self.bits.max()


@cache
def table(name: str, tool: str) -> TabularMDP:
    return tabulate(load_world(name, tool))


def average(name: str, tool: str, horizon: int) -> float:
    """Mean object empowerment: over all placements with the tool in hand, or all without one."""
    mdp = table(name, tool)
    bits = empowerment(mdp, horizon, "object")
    return float(bits.mean() if tool == "none" else bits[mdp.flags["equipped"]].mean())


@cache
def landscape(name: str, horizon: int, sensor: str) -> Landscape:
    world = load_world(name)
    mdp = table(name, world.tool)

    def distance(cell: Cell, labels: np.ndarray) -> np.ndarray:
        row, column = np.divmod(labels, world.width)
        return abs(row - cell[0]) + abs(column - cell[1])

    assert world.tool_cell is not None
    tool, can = (distance(world.tool_cell, mdp.factor("tool")), mdp.factor("object"))
    fixed = np.flatnonzero((tool == 0) & (distance(world.object, can) == 0))
    agent = mdp.factor("agent")[fixed]
    return Landscape(
        bits=empowerment(mdp, horizon, sensor, states=fixed),
        from_tool=distance(world.tool_cell, agent),
        from_can=distance(world.object, agent),
    )


def test_a_landscape_has_a_value_for_every_free_cell_but_those_of_tool_and_can():
    world = load_world("corridor")
    free = world.height * world.width - len(world.walls)
    assert len(landscape("corridor", 1, "state").bits) == free - 2


# The corridor: first experiment


def test_the_corridor_takes_15_steps_with_the_picker_and_25_without():
    with_picker, without = solve(table("corridor", "picker")), solve(table("corridor", "none"))
    assert with_picker is not None
    assert without is not None
    assert (with_picker.steps, without.steps) == (15, 25)


@pytest.mark.parametrize(("tool", "bits"), [("none", 0.6211), ("picker", 1.3886)])
def test_average_6_step_object_empowerment_in_the_corridor(tool: str, bits: float):
    assert average("corridor", tool, 6) == pytest.approx(bits, abs=5e-5)


def test_1_step_foe_next_to_the_picker_counts_6_to_8_states():
    foe = landscape("corridor", 1, "state")
    assert foe.next_to_tool.min() == np.log2(6)
    assert foe.next_to_tool.max() == 3
    assert foe.bits[foe.from_tool > 1].max() < foe.next_to_tool.min()


def test_5_step_foe_is_greatest_near_the_picker_and_counts_125_states():
    foe = landscape("corridor", 5, "state")
    assert foe.bits.max() == np.log2(125) == pytest.approx(6.966, abs=5e-4)
    assert foe.from_tool[foe.at_maximum].max() <= 2


def test_5_step_foe_is_high_around_picker_and_can_alike():
    foe = landscape("corridor", 5, "state")
    assert foe.next_to_tool.max() == pytest.approx(6.67, abs=5e-3)
    assert foe.next_to_can.max() == pytest.approx(6.97, abs=5e-3)


def test_1_step_toe_is_one_bit_next_to_the_can_and_nothing_elsewhere():
    toe = landscape("corridor", 1, "object")
    assert toe.bits.max() == 1
    assert (toe.from_can[toe.at_maximum] == 1).all()
    assert (toe.bits[toe.from_can > 1] == 0).all()


def test_6_step_toe_is_greatest_next_to_the_picker_and_counts_20_can_cells():
    toe = landscape("corridor", 6, "object")
    assert toe.bits.max() == np.log2(20) == pytest.approx(4.322, abs=5e-4)
    assert (toe.from_tool[toe.at_maximum] == 1).all()


def test_6_step_toe_next_to_the_can_counts_12_can_cells_at_most():
    toe = landscape("corridor", 6, "object")
    assert toe.next_to_can.max() == np.log2(12) == pytest.approx(3.585, abs=5e-4)


# The yard: second experiment


@pytest.mark.parametrize(("tool", "best_return"), [("picker", -10), ("broom", -12)])
def test_best_return_in_the_yard(tool: str, best_return: float):
    plan = solve(table("yard", tool))
    assert plan is not None
    assert plan.best_return == best_return
    assert plan.steps == 1 - best_return


def test_the_yard_begins_with_the_tool_in_hand():
    for tool in ("picker", "broom"):
        mdp = table("yard", tool)
        assert mdp.flags["equipped"][mdp.start]


@pytest.mark.parametrize(
    ("tool", "bits"), [("none", 0.2303), ("broom", 0.2761), ("picker", 0.5241)]
)
def test_average_3_step_object_empowerment_in_the_yard(tool: str, bits: float):
    assert average("yard", tool, 3) == pytest.approx(bits, abs=5e-5)


@pytest.mark.parametrize(("tool", "bits"), [("picker", 3), ("broom", 1)])
def test_1_step_toe_with_the_tool_in_hand_in_the_yard_at_most(tool: str, bits: float):
    mdp = table("yard", tool)
    toe = empowerment(mdp, 1, "object")
    assert toe[mdp.flags["equipped"]].max() == bits
    assert toe.max() == bits
