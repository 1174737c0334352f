"""Enumerated tables that come from the disk."""

import gymnasium
import minigrid  # noqa: F401  # registers its environments
import numpy as np
import pytest

import habilis as hb
from habilis.gymnasium_tables import keeping
from habilis.gymnasium_tables.enumeration import enumerate_states
from habilis.gymnasium_tables.identity import digest

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
        same(keeping.kept_states(make(), 1000, 0).mdp, hb.TabularMDP.from_gymnasium(make()))
    assert len(counted) == 1


def test_another_first_state_or_limit_is_another_table(counted):
    for begin, limit in [(0, 10), (1, 10), (0, 11)]:
        keeping.kept_states(Line(begin), limit, 0)
    assert len(counted) == 3


def test_a_table_that_the_environment_no_longer_follows_is_made_again(counted, monkeypatch):
    keeping.kept_states(Line(), 10, 0)
    monkeypatch.setitem(RULE, "prize", 2.0)
    assert keeping.kept_states(Line(), 10, 0).mdp.reward.max() == 2
    assert len(counted) == 2


def test_other_code_is_another_table(counted):
    keeping.kept_states(Line(), 10, 0)
    source = "class Other(Line):\n    'No source to read.'\n"
    names = {"Line": Line, "__name__": __name__}
    exec(source, names)
    for _ in range(2):
        keeping.kept_states(names["Other"](), 10, 0)
    assert len(counted) == 3  # nothing is kept of classes whose code cannot be read


def test_digests_do_not_depend_on_the_order_of_a_set():
    one, other = frozenset("abcdefgh"), frozenset("hgfedcba")
    assert digest((1, one)) == digest((1, other))
    assert digest((1, one)) != digest((1, frozenset("abcdefg")))
