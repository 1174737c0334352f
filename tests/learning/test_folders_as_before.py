"""Folders that an earlier edition wrote go on, and every algorithm learns what it learned then.

`before/` holds two trainings that were interrupted halfway.
"""

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from digests import digest

import habilis as hb
from habilis.learning.folder import load_latest
from habilis.learning.replay import learned, play, table_of

BEFORE = Path(__file__).parent / "before"
COMMON = {"world": "room.txt", "runs": 2, "episodes": 10**6, "steps": 40_000, "episode_limit": 64}
SETTINGS: dict[str, dict[str, Any]] = {
    "a2c": {
        "hidden": (4,),
        "entropy": 9.0,
        "schedule": "episodes",
        "networks": "separate",
        "intrinsic": "count",
        "beta": 0.1,
    },
    "ppo": {"hidden": (4,), "entropy": 9.0, "intrinsic": "rnd", "beta": 0.1},
    "q-learning": {"epsilon": 1.0, "epsilon_steps": 0},
    "soft-value-iteration": {"temperature": 5.0},
}
# Episodes, a weighted sum of the policy, and mean and length of the values.
CAME_TO = {
    "a2c": ("c11e933cf2b4def1", 0.24668867, -21.217678, 307.77576),
    "ppo": ("7ebc5b9fd9db5626", 0.21383063, -36.845237, 538.05713),
    "q-learning": ("40e4d4d265c01129", 8.9821787, -0.60999829, 15.937602),
    "soft-value-iteration": ("51b3db62c3567461", 0.19293254, 335.3785, 5043.8095),
}


def config(name: str) -> hb.Config:
    return hb.Config.from_dict({"algorithm": name} | COMMON | SETTINGS[name])


def check(run, name: str) -> None:
    """Whether a run came to what it came to before."""
    episodes, of_policy, mean, length = CAME_TO[name]
    columns = [run.episodes[column].to_numpy() for column in run.episodes.columns]
    assert digest(*run.episodes.columns, *columns) == episodes
    policy, values = learned(run, table_of(run), 1)
    weighted = policy.ravel() @ np.sin(np.arange(policy.size))
    found = [weighted, values.mean(dtype=float), np.linalg.norm(values)]
    np.testing.assert_allclose(found, [of_policy, mean, length], rtol=1e-4)


@pytest.fixture(autouse=True)
def room(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(BEFORE / "a2c" / "world.txt", "room.txt")


@pytest.mark.parametrize("name", SETTINGS)
def test_every_algorithm_learns_what_it_learned(name):
    check(hb.train(config(name)), name)


@pytest.mark.parametrize("name", ["a2c", "q-learning"])
def test_an_interrupted_training_of_before_is_watched_and_resumed(name):
    shutil.copytree(BEFORE / name, "run")
    halfway = load_latest("run")
    assert halfway.config == config(name)
    assert 700 < halfway.episodes.height < 800
    assert play(halfway, 1).actions
    check(hb.train(config(name), out="run", resume=True), name)
