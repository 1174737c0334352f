"""Gymnasium's RecordVideo records our environments."""

from pathlib import Path

import gymnasium
import numpy as np
from gymnasium.wrappers import RecordVideo
from gymnasium.wrappers.vector import RecordVideo as RecordVectorVideo
from video import read_mp4

import habilis  # noqa: F401  # registers its environments

ROOM = "#####G\n#..C..\n#..AP.\n#.....\n"
ACTIONS = (3, 0, 1, 1, 0)
SIZE = (6 * 32, 4 * 32)


def videos(folder: Path) -> list[Path]:
    return sorted(folder.glob("*.mp4"))


def assert_recorded(video: Path, frames: list[np.ndarray]) -> None:
    recorded = read_mp4(video, *SIZE)
    assert len(recorded) == len(frames)
    for picture, drawn in zip(recorded, frames, strict=True):
        assert np.abs(picture.astype(int) - drawn).mean() < 5


def test_recorded_episodes_show_every_state(tmp_path):
    env = gymnasium.make(
        "habilis/World-v0", world=ROOM, max_steps=len(ACTIONS), render_mode="rgb_array"
    )
    env = RecordVideo(env, str(tmp_path / "videos"), episode_trigger=lambda _: True)
    frames = []
    for _ in range(2):
        env.reset(seed=0)
        frames = [np.asarray(env.render())]
        for action in ACTIONS:
            env.step(action)
            frames.append(np.asarray(env.render()))
    env.close()
    found = videos(tmp_path / "videos")
    assert [video.name for video in found] == [f"rl-video-episode-{n}.mp4" for n in (0, 1)]
    for video in found:
        assert_recorded(video, frames)
    assert (frames[0] != frames[-1]).any()


def test_a_vector_environment_is_recorded_too(tmp_path):
    envs = gymnasium.make_vec("habilis/World-v0", num_envs=2, world=ROOM, render_mode="rgb_array")
    videos_in = tmp_path / "videos"
    envs = RecordVectorVideo(envs, str(videos_in), step_trigger=lambda n: n == 0, video_length=3)
    envs.reset(seed=0)
    for action in ACTIONS:
        envs.step(np.array([action, action]))
    envs.close()
    assert len(videos(videos_in)) == 1
