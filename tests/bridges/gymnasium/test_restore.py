"""From the states of a table back to the environment."""

import re
from typing import Any

import gymnasium
import minigrid  # noqa: F401  # registers its environments
import numpy as np
import pytest
from minigrid.wrappers import ImgObsWrapper

import habilis as hb
from habilis.bridges.gymnasium.snapshots import Identity
from tests.bridges.gymnasium.test_environments_of_others import (
    Cells,
    Forgetful,
    Frozen,
    WithP,
    listed,
    place,
    put,
)

T = hb.TabularMDP.from_gymnasium


@pytest.mark.parametrize("make", [Cells, Frozen, Forgetful])
@pytest.mark.parametrize("options", [{}, {"seed": None}, {"state": (place, put)}])
def test_every_state_can_be_restored(make: Any, options: dict[str, Any]):
    env = make()
    env.reset(seed=0)
    mdp = T(env, factors={"at": place}, **options)
    for state in range(mdp.states):
        assert mdp.restore(state).unwrapped.at == mdp.factor("at")[state]
        if state or options.get("seed", 0) is not None:
            assert mdp.observation(state) == mdp.factor("at")[state]


@pytest.mark.parametrize("name", ["MiniGrid-DoorKey-5x5-v0"])
def test_a_minigrid_is_restored_with_its_wrappers(name: str):
    mdp = T(ImgObsWrapper(gymnasium.make(name)))
    for state in range(0, mdp.states, 40):
        env = mdp.restore(state)
        assert isinstance(env, ImgObsWrapper)
        inner: Any = env.unwrapped
        column, row = inner.agent_pos
        assert mdp.factor("agent")[state] == row * 5 + column
        shown = env.observation(inner.gen_obs())
        assert np.array_equal(mdp.observation(state), shown)
        digest = Identity().of(env).digest
        assert digest == Identity().of(mdp.restore(state)).digest


def test_the_states_of_a_table_p_are_put_there():
    mdp = T(gymnasium.make("FrozenLake-v1", render_mode="rgb_array"))
    for state in (0, 5, 15):
        env = mdp.restore(state)
        assert env.unwrapped.s == state
        assert mdp.observation(state) == state
    assert mdp.restore(5).render().ndim == 3
    hot = gymnasium.wrappers.TransformObservation(
        gymnasium.make("FrozenLake-v1"), lambda s: np.eye(16)[s], gymnasium.spaces.Box(0, 1, (16,))
    )
    assert T(hot).observation(3).tolist() == np.eye(16)[3].tolist()


def test_our_own_environments_are_restored_too():
    mdp = T(gymnasium.make("habilis/Yard-v0"))
    env = mdp.restore(100)
    assert env.unwrapped.state == 100
    expected = [mdp.factor(name)[100] for name in ("agent", "tool", "object")]
    assert mdp.observation(100).tolist() == expected


def test_the_environment_that_was_passed_is_left_alone():
    env = Cells()
    env.reset(seed=0)
    env.step(1)
    mdp = T(env)
    mdp.restore(4).step(0)
    assert env.at == 1


@pytest.mark.parametrize(
    ("mdp", "state", "message"),
    [
        (hb.TabularMDP.deterministic([[0]]), 0, "this table was not made from an environment"),
        (T(Cells()), 5, "state is 5; use 0 to 4"),
        (T(Cells()), "a", "state is 'a'; use 0 to 4"),
        (T(Cells(), seed=None), 0, "the observation of the first state is unknown with seed=None"),
        (T(WithP(listed(), s=False)), 0, "no attribute s with which to restore a state"),
    ],
)
@pytest.mark.ill_typed
def test_what_cannot_be_restored_is_refused(mdp: hb.TabularMDP, state: Any, message: str):
    ask = mdp.observation if "observation" in message else mdp.restore
    with pytest.raises(ValueError, match=re.escape(message)):
        ask(state)


def test_a_state_that_wrappers_cut_off_is_refused():
    class Restarts(gymnasium.Wrapper):
        count = 0

        def step(self, action: Any) -> Any:
            self.count += 1
            returned = self.env.step(action)
            return (*returned[:3], self.count > 2, *returned[4:])

    mdp = T(gymnasium.wrappers.Autoreset(Restarts(Cells(9))))
    with pytest.raises(ValueError, match="the shortest path to state 8 does not lead there"):
        mdp.restore(8)


def test_ten_states_of_highest_empowerment_can_be_drawn():
    env = gymnasium.make("MiniGrid-Empty-5x5-v0", render_mode="rgb_array")
    mdp = T(env)
    best = np.argsort(-hb.empowerment(mdp, 3, "agent"))[:10]
    pictures = [mdp.restore(state).render() for state in best]
    assert len(pictures) == 10
    assert len({picture.tobytes() for picture in pictures}) == 10
