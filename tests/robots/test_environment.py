"""Pushing the puck to a goal: the environment, and the bonus that it may carry."""

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import habilis as hb
from habilis.estimators import Counting, OnGrid
from habilis.robots import PushingEnv, PushingSimulator

pytest.importorskip("mujoco")

NORTH = 3
STICK = PushingSimulator("reach.xml", "stick", threads=1)


def pushing(**settings: Any) -> PushingEnv:
    return PushingEnv(STICK, [0.0, 0.8], [[0.0, 0.7], [0.2, 0.7]], **settings)


@pytest.mark.filterwarnings("ignore:.*infinity. This is probably too")
@pytest.mark.filterwarnings("ignore:.*different from the unwrapped version")
def test_it_is_an_environment_as_gymnasium_has_them():
    check_env(pushing(), skip_render_check=True)


def test_only_the_goal_is_rewarded_and_it_ends_the_episode():
    env = pushing()
    starts = {env.reset(seed=seed)[0][2] for seed in range(8)}
    assert starts == {np.float32(0.0), np.float32(0.2)}
    while env.reset()[0][2]:
        pass
    assert env.step(NORTH)[1:4] == (-1.0, False, False)
    observation, *ends, info = env.step(NORTH)
    assert ends == [0.0, True, False]
    assert info["is_success"]
    np.testing.assert_array_equal(observation, env.state.astype(np.float32))
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(NORTH)


def test_an_episode_is_cut_off():
    env = pushing(max_steps=2)
    env.reset(seed=0)
    assert [env.step(0)[1:4] for _ in range(2)] == [(-1.0, False, False), (-1.0, False, True)]


@pytest.mark.parametrize("action", [-1, 5, 1.7, [1]])
def test_what_is_no_action_is_refused(action: Any):
    env = pushing()
    env.reset(seed=0)
    with pytest.raises(ValueError, match=r"action is .*; give one from 0 to 4"):
        env.step(action)
    assert env.step(np.array(0))[1] == -1.0, "as agents of others give it"


def test_a_tabulated_bonus_is_the_estimate_at_the_points_of_its_grid():
    axes = [0.0], [0.0], [0.0, 0.2], [0.7, 0.8], *([0.0],) * 4
    method = OnGrid(Counting(0.05, 50), axes)
    given: dict[str, Any] = {"simulator": STICK, "state": lambda env: env.state, "beta": 0.5}
    env = hb.EmpowermentReward(pushing(), 2, "puck", method=method, **given)
    _, info = env.reset(seed=1)
    inside: Any = env.unwrapped
    fitted = Counting(0.05, 50).fit(STICK, 2, "puck", seed=0)
    assert info["empowerment"] == fitted.bits(inside.state[None])[0] > 0
    _, reward, *_, info = env.step(0)
    assert reward == -1 + 0.5 * info["empowerment"]


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"goal": [0.0]}, r"goal has shape \(1,\); give float\[2\]"),
        ({"positions": []}, "positions has shape"),
        ({"positions": np.zeros((0, 2))}, "positions is empty"),
        ({"radius": 0}, "radius is 0"),
        ({"max_steps": 0}, "max_steps is 0"),
    ],
)
def test_impossible_settings_are_refused(settings: dict[str, Any], words: str):
    given: dict[str, Any] = {"goal": [0.0, 0.9], "positions": [[0.0, 0.7]], **settings}
    with pytest.raises(ValueError, match=words):
        PushingEnv(STICK, **given)
