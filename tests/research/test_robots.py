"""The arm of Gymnasium's, and the study of learning, are what the page on robots says."""

from pathlib import Path

import numpy as np
import polars as pl
import pytest

from habilis.statistics import bootstrap_interval

mujoco = pytest.importorskip("mujoco")
from research import pusher, pushing  # noqa: E402

PAGE = " ".join(
    (Path(__file__).parents[2] / "docs/explanation/robots.md").read_text("utf-8").split()
)


def test_the_lowered_fork_is_at_the_objects_height_and_the_initial_one_far_above():
    world = pusher.simulator()
    data = mujoco.MjData(world.model)
    height = {}
    for pose in pusher.POSES:
        state = pusher.placed(world, pose, np.array([[0.3, -0.1]]))[0]
        mujoco.mj_setState(world.model, data, state, mujoco.mjtState.mjSTATE_PHYSICS)
        mujoco.mj_kinematics(world.model, data)
        place = data.body("object").xpos
        np.testing.assert_allclose(place[:2], [0.3, -0.1], atol=1e-9)
        height[pose] = data.body("tips_arm").xpos[2] - place[2]
    assert abs(height["lowered"]) < 0.02
    assert height["initial"] > 0.2


def test_the_page_has_the_landscape_as_it_was_computed():
    bits = pusher.averages(pl.read_csv(pusher.RESULTS))
    assert not bits["initial"].any()
    free = bits["lowered"][~np.isnan(bits["lowered"])]
    low, high = bootstrap_interval(free)
    assert f"{free.mean():.2f} bits on average" in PAGE
    assert f"{low:.2f} to {high:.2f}), up to {free.max():.2f}" in PAGE
    assert f"in {(free >= 0.5).mean():.0%} of the {len(free)} places".replace("%", " %") in PAGE
    for angle in pusher.POSES["lowered"]:
        assert f"{angle:g}" in PAGE


def test_the_page_has_the_study_as_it_was_run():
    table = pl.read_csv(pushing.RESULTS)
    assert " ".join(pushing.as_table(table).split()) in PAGE
    assert (table.group_by("condition", "seed").len()["len"] == 20).all()


def test_the_study_learns_in_an_environment_with_a_sparse_reward():
    env = pushing.environment("plain")
    observation, _ = env.reset(seed=0)
    assert observation.shape == (6,)
    assert env.step(0)[1] == -1.0
    assert len(pushing.starts()) == 32
