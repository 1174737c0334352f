"""Puzzles as Gymnasium environments, one at a time and many at once."""

from pathlib import Path
from typing import Any, cast

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

import habilis as hb
from habilis.bridges import PushWorld
from habilis.envs import PushWorldEnv, PushWorldVectorEnv

ROD = PushWorld.parse("A M1 M1 AW M0 G0 .\n. . . W . . .\nM2 . . . . . .")
SHARED = Path(__file__).parents[2] / "../shared/pushworld"


def test_it_passes_gymnasiums_check_and_is_made_by_its_name(tmp_path):
    (tmp_path / "rod.pwp").write_text("A M0 G0\n")
    env = gymnasium.make("habilis/PushWorld-v0", puzzle=tmp_path / "rod.pwp")
    check_env(env.unwrapped, skip_render_check=True)
    assert env.spec is not None
    assert env.spec.max_episode_steps == 500
    (tmp_path / "boxes.xsb").write_text("#####\n#@$.#\n#####\n")
    boxes = gymnasium.make("habilis/PushWorld-v0", puzzle=str(tmp_path / "boxes.xsb"))
    boxes.reset()
    assert boxes.step(1)[1:4] == (0.0, True, False)


def test_steps_are_the_puzzles_and_solving_it_ends_the_episode():
    env, state = PushWorldEnv(ROD), ROD.initial
    assert env.reset(seed=0)[0].tolist() == list(state)
    for action in np.random.default_rng(0).integers(4, size=200).tolist():
        state = ROD.step(state, action)
        observation, reward, terminated, truncated, _ = env.step(action)
        assert observation in env.observation_space
        assert tuple(observation.tolist()) == env.state == state
        assert (reward, terminated) == (ROD.solved(state) - 1.0, ROD.solved(state))
        assert not truncated


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_many_at_once_are_as_gymnasiums_own_vector_of_single_ones(mode):
    ours = PushWorldVectorEnv(3, ROD, max_episode_steps=7, autoreset_mode=mode)
    single = [lambda: gymnasium.wrappers.TimeLimit(PushWorldEnv(ROD), 7)] * 3
    theirs = gymnasium.vector.SyncVectorEnv(single, autoreset_mode=mode)
    assert (ours.reset(seed=0)[0] == theirs.reset(seed=0)[0]).all()
    ended = np.zeros(3, bool)
    for actions in np.random.default_rng(1).integers(4, size=(60, 3)):
        actions[0] = 1  # which solves the puzzle
        if mode is AutoresetMode.DISABLED and ended.any():
            options = {"reset_mask": ended}
            assert (ours.reset(options=options)[0] == theirs.reset(options=options)[0]).all()
        one, other = ours.step(actions), theirs.step(actions)
        for mine, its in zip(one[:4], other[:4], strict=True):
            np.testing.assert_array_equal(mine, its)
        ended = one[2] | one[3]
        if mode is AutoresetMode.SAME_STEP and ended.any():
            for mine, its in zip(one[4]["final_obs"], other[4]["final_obs"], strict=True):
                np.testing.assert_array_equal(mine, its)
    assert gymnasium.make_vec("habilis/PushWorld-v0", num_envs=2, puzzle=ROD).num_envs == 2


def test_empowerment_is_added_to_the_reward():
    env = gymnasium.make("habilis/PushWorld-v0", puzzle=ROD)
    shaped = hb.EmpowermentReward(env, horizon=2, beta=0.5)
    shaped.reset(seed=0)
    reward = shaped.step(0)[1]
    (bits,) = hb.empowerment(ROD, 2, states=[ROD.initial])
    assert reward == pytest.approx(-1 + 0.5 * bits)


def test_it_is_drawn_as_text_and_as_a_picture():
    text = PushWorldEnv(ROD, render_mode="ansi")
    text.reset()
    assert "A" in text.render()
    picture = PushWorldEnv(ROD, render_mode="rgb_array")
    picture.reset()
    assert picture.render().shape == (96, 224, 3)
    both = PushWorldVectorEnv(2, ROD, render_mode="rgb_array").render()
    assert both is not None
    assert np.array_equal(both[0], picture.render())


@pytest.mark.ill_typed
@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: PushWorldEnv(cast(Any, 3)), "puzzle is 3; give a puzzle, or the path"),
        (lambda: PushWorldEnv("map.txt"), "puzzle is 'map.txt'; give a puzzle, or the path"),
        (lambda: PushWorldEnv("missing.pwp"), "missing.pwp"),
        (lambda: PushWorldEnv(ROD, render_mode="sound"), "render_mode 'sound' is unknown"),
        (lambda: PushWorldEnv(ROD).step(4), "action is 4; use 0 to 3"),
        (lambda: PushWorldVectorEnv(0, ROD), "num_envs is 0; give a whole number of at least 1"),
        (lambda: PushWorldVectorEnv(2, ROD).step(np.array([0, 9])), "action 9 of environment 1"),
    ],
)
def test_what_is_no_puzzle_mode_or_action_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.skipif(not SHARED.is_dir(), reason="the puzzles of PushWorld are not here")
def test_a_large_puzzle_needs_no_table():
    path = SHARED / "puzzles/level2" / min(p.name for p in (SHARED / "puzzles/level2").iterdir())
    envs = PushWorldVectorEnv(64, path)
    observations, _ = envs.reset(seed=0)
    for actions in np.random.default_rng(0).integers(4, size=(100, 64)):
        observations = envs.step(actions)[0]
    assert observations in envs.observation_space
