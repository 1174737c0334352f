"""Gymnasium's RecordVideo films our frames."""

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium.wrappers import RecordVideo
from video import read_mp4

import habilis as hb
from habilis.worlds.tiles import Tiles

ROOM = hb.World.parse("#####G\n#..C..\n#..AP.\n#.....\n", name="room")
ACTIONS = (3, 0, 1, 1, 0)


class Watched(gymnasium.Env):
    """A world that plays a list of actions, whatever it is told."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 5}  # noqa: RUF012
    observation_space = gymnasium.spaces.Discrete(1)
    action_space = gymnasium.spaces.Discrete(1)
    render_mode = "rgb_array"

    def __init__(self, world: hb.World) -> None:
        self.mdp, self.tiles = hb.tabulate(world), Tiles.of(world)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None):
        super().reset(seed=seed)
        self.state, self.steps = self.mdp.start, 0
        return 0, {}

    def step(self, action: int):
        self.state = self.mdp.next_state[self.state, ACTIONS[self.steps]]
        self.steps += 1
        return 0, -1.0, self.steps == len(ACTIONS), False, {}

    def render(self) -> np.ndarray:
        cells = (self.mdp.factor(name)[self.state] for name in ("agent", "tool", "object"))
        return self.tiles.frame(*map(int, cells))


def test_recorded_episodes_show_every_state(tmp_path: Path):
    watched = Watched(ROOM)
    env = RecordVideo(watched, str(tmp_path / "films"), episode_trigger=lambda _: True)
    frames: list[np.ndarray] = []
    for _ in range(2):
        env.reset()
        frames, ended = [watched.render()], False
        while not ended:
            ended = env.step(0)[2]
            frames.append(watched.render())
    env.close()
    films = sorted((tmp_path / "films").glob("*.mp4"))
    assert [film.name for film in films] == [f"rl-video-episode-{n}.mp4" for n in (0, 1)]
    for film in films:
        filmed = read_mp4(film, 6 * 32, 4 * 32)
        assert len(filmed) == len(frames) == 1 + len(ACTIONS)
        for picture, drawn in zip(filmed, frames, strict=True):
            assert np.abs(picture.astype(int) - drawn).mean() < 5
    assert (frames[0] != frames[-1]).any()
