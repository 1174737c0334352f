"""Enumerated tables that come from the disk."""

from typing import Any

import gymnasium
import minigrid  # noqa: F401  # registers its environments
import numpy as np
import pytest

import habilis as hb
from habilis.bridges.gymnasium import keeping
from habilis.bridges.gymnasium.enumeration import enumerate_states
from habilis.bridges.gymnasium.snapshots import Identity

RULE = {"prize": 1.0}


class Line(gymnasium.Env):
    """Five cells in a row; what its end is worth is written elsewhere than in this class."""

    observation_space = gymnasium.spaces.Discrete(5)
    action_space = gymnasium.spaces.Discrete(2)

    def __init__(self, begin=0):
        self.cell = self.begin = begin

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.cell = self.begin
        return self.cell, {}

    def step(self, action):
        self.cell = min(4, max(0, self.cell + (1 if action else -1)))
        return self.cell, RULE["prize"] * (self.cell == 4), self.cell == 4, False, {}


@pytest.fixture
def counted(tmp_path, monkeypatch):
    """How often states were enumerated, with an empty cache."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    calls = []

    def enumerated(*arguments):
        calls.append(arguments)
        return enumerate_states(*arguments)

    monkeypatch.setattr(keeping, "enumerate_states", enumerated)
    return calls


def kept(env, limit):
    return keeping.kept_states(env, limit, 0, Identity())


def same(one, other):
    assert np.array_equal(one.next_state, other.next_state)
    assert np.array_equal(one.reward, other.reward)
    assert np.array_equal(one.terminal, other.terminal)
    assert one.factors.keys() == other.factors.keys()
    assert all(np.array_equal(one.factors[name], other.factors[name]) for name in one.factors)
    assert one.actions == other.actions


@pytest.mark.parametrize("make", [Line, lambda: gymnasium.make("MiniGrid-DoorKey-5x5-v0")])
def test_the_table_from_the_disk_is_the_enumerated_one(counted, make):
    for _ in range(2):
        same(kept(make(), 1000).mdp, hb.TabularMDP.from_gymnasium(make()))
    assert len(counted) == 1


def test_another_first_state_or_limit_is_another_table(counted):
    for begin, limit in [(0, 10), (1, 10), (0, 11)]:
        kept(Line(begin), limit)
    assert len(counted) == 3


def test_a_table_that_the_environment_no_longer_follows_is_made_again(counted, monkeypatch):
    kept(Line(), 10)
    monkeypatch.setitem(RULE, "prize", 2.0)
    assert kept(Line(), 10).mdp.reward.max() == 2
    assert len(counted) == 2


def test_other_code_is_another_table(counted):
    kept(Line(), 10)
    source = "class Other(Line):\n    'No source to read.'\n"
    names = {"Line": Line, "__name__": __name__}
    exec(source, names)
    for _ in range(2):
        kept(names["Other"](), 10)
    assert len(counted) == 3  # nothing is kept of classes whose code cannot be read


class Slowed(gymnasium.Wrapper):
    """A step goes nowhere where the environment inside is in the last cell but one."""

    def step(self, action):
        line: Any = self.unwrapped
        if line.cell == 3:
            return 3, 0.0, False, False, {}
        return self.env.step(action)


def test_wrappers_are_part_of_what_a_table_is_kept_for(counted):
    kept(Line(), 10)
    with pytest.raises(ValueError, match="Slowed changes what a step does"):
        kept(Slowed(Line()), 10)


def test_ignored_attributes_are_part_of_what_a_table_is_kept_for(counted):
    for ignore in [(), ("begin",), ("begin",)]:
        keeping.kept_states(Line(), 10, 0, Identity(ignore=ignore))
    assert len(counted) == 2


def test_nothing_is_kept_where_functions_say_what_a_state_is(counted):
    for _ in range(2):
        keeping.kept_states(Line(), 10, 0, Identity(key=lambda env: env.cell))
    assert len(counted) == 2
