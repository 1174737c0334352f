"""Factors of Minigrid's states are those of the things themselves."""

from typing import Any

import gymnasium
import minigrid  # noqa: F401  # registers its environments
import numpy as np
import pytest
from minigrid.core.grid import Grid
from minigrid.core.mission import MissionSpace
from minigrid.core.world_object import Ball, Box, Key
from minigrid.minigrid_env import MiniGridEnv

import habilis as hb

T = hb.TabularMDP.from_gymnasium
RIGHT, FORWARD, PICK_UP, DROP, TOGGLE = 1, 2, 3, 4, 5


class Boxed(MiniGridEnv):
    """A row of three cells: the agent, and before it a box with a key in it."""

    def __init__(self, *things: Any) -> None:
        self.things = things or (Box("red", Key("red")),)
        mission = MissionSpace(mission_func=lambda: "open the box")
        super().__init__(mission, width=5, height=3, max_steps=100)

    def _gen_grid(self, width: int, height: int) -> None:
        self.grid = Grid(width, height)
        self.grid.wall_rect(0, 0, width, height)
        for column, thing in enumerate(self.things):
            self.put_obj(thing, 2 + column, 1)
        self.agent_pos, self.agent_dir = (1, 1), 0
        self.mission = "open the box"


def led(mdp: hb.TabularMDP, *actions: int) -> dict[str, int]:
    """The labels after some actions from the first state."""
    state = mdp.start
    for action in actions:
        state = mdp.next_state[state, action]
    return {name: int(labels[state]) for name, labels in mdp.factors.items()}


def test_a_thing_keeps_its_factor_in_a_box_in_hand_and_out_of_it():
    mdp = T(Boxed())
    cell = 7  # row 1, column 2
    assert led(mdp) == {"agent": 6, "direction": 0, "carried": 0, "box": cell, "key": -1}
    opened = led(mdp, TOGGLE)
    assert (opened["box"], opened["key"]) == (-2, cell)
    carried = led(mdp, TOGGLE, PICK_UP)
    assert (carried["box"], carried["key"], carried["carried"]) == (-2, -1, 2)
    elsewhere = led(mdp, TOGGLE, PICK_UP, FORWARD, DROP)
    assert (elsewhere["box"], elsewhere["key"], elsewhere["carried"]) == (-2, cell + 1, 0)
    boxed = led(mdp, PICK_UP)
    assert (boxed["box"], boxed["key"], boxed["carried"]) == (-1, -1, 1)


def test_a_box_that_is_gone_gives_no_bits():
    mdp = T(Boxed())
    gone = mdp.factor("box") == -2
    assert gone.any()
    assert (hb.empowerment(mdp, 4, "box")[gone] == 0).all()
    assert hb.empowerment(mdp, 1, "box", states=[mdp.start])[0] == np.log2(
        3
    )  # there, in hand, gone
    assert hb.empowerment(mdp, 1, "key")[gone].max() == 1


def test_where_a_thing_was_dropped_is_no_part_of_the_state():
    """Minigrid notes a thing's cell when it is dropped, and not when it comes out of a box."""
    mdp = T(Boxed())
    rows = list(zip(*mdp.factors.values(), mdp.terminal.tolist(), strict=True))
    assert len(set(rows)) == len(rows)


def test_things_of_one_kind_are_distinguished_by_color_or_number():
    mdp = T(Boxed(Ball("red"), Ball("blue")))
    assert list(mdp.factors)[3:] == ["red ball", "blue ball"]
    mdp = T(Boxed(Ball("red"), Ball("red")))
    assert list(mdp.factors)[3:] == ["red ball 1", "red ball 2"]


def test_indistinguishable_things_have_no_factor():
    mdp = T(Boxed(Box("red", Key("red")), Box("red", Key("red"))))
    assert list(mdp.factors)[3:] == ["red box 1", "red box 2"]


def test_the_reward_of_a_first_step_is_kept_and_later_ones_are_checked_by_minigrids_formula():
    env = gymnasium.make("MiniGrid-Empty-5x5-v0")
    mdp = T(env)
    best = mdp.reward.max()
    inner: Any = env.unwrapped
    assert best == pytest.approx(1 - 0.9 / inner.max_steps)

    class Generous(gymnasium.Wrapper):
        def step(self, action: Any) -> Any:
            shown, reward, *rest = self.env.step(action)
            return shown, min(2 * float(reward), 1.0), *rest

    with pytest.raises(
        ValueError, match=r"reward 0\S* was expected, and reward \S* came; Generous"
    ):
        T(Generous(gymnasium.make("MiniGrid-Empty-5x5-v0")))
