"""TensorBoard event files, read back."""

from itertools import groupby

import numpy as np
import pytest
from events import read_events, scalars

from habilis.learning.algorithms.a2c import A2C
from habilis.learning.config import Config
from habilis.learning.jobs import STRETCH
from habilis.learning.runner import train
from habilis.learning.tensorboard import TAGS


@pytest.fixture
def config(tmp_path):
    (tmp_path / "room.txt").write_text("A..\nPC.\n..G\n")
    return Config(
        world=str(tmp_path / "room.txt"),
        algorithm=A2C(hidden=(8,), entropy=9.0),
        intrinsic="object",
        horizon=1,
        beta=0.5,
        beta_schedule="linear",
        beta_steps=100_000,
        runs=2,
        steps=80_000,
        episode_limit=60,
    )


def test_each_run_has_a_point_for_every_stretch_and_its_settings_once(config, tmp_path):
    run = train(config, out=tmp_path / "run")
    for k in range(2):
        place = tmp_path / "run" / "tensorboard" / f"run-{k}"
        points = scalars(place)
        steps = [step for step, _ in groupby(step for step, _, _ in points)]
        assert steps == [STRETCH, 2 * STRETCH, 3 * STRETCH, 4 * STRETCH]
        assert len(set(points)) == len(points) == 4 * len(TAGS)
        last = {tag: value for step, tag, value in points if step == steps[-1]}
        episodes = run.episodes.filter(run=k)
        recent = episodes.tail(100)
        assert last["episode/number"] == len(episodes)
        assert last["episode/return"] == pytest.approx(np.mean(recent["return"].to_numpy()))
        assert last["episode/length"] == pytest.approx(np.mean(recent["steps"].to_numpy()))
        assert last["intrinsic/beta"] == pytest.approx(0.5 * (1 - 0.8))
        assert 0.5 * np.log(8) < last["learning/entropy"] <= np.log(8) + 1e-6
        assert 0 < last["intrinsic/bonus"] < 3
        assert last["speed/steps_per_second"] > 0
        tags = [value.tag for event in read_events(place) for value in event.summary.value]
        assert tags.count("config/text_summary") == 1
        assert tags.count("_hparams_/session_start_info") == 1
        (text,) = (
            value.tensor.string_val[0].decode()
            for event in read_events(place)
            for value in event.summary.value
            if value.tag == "config/text_summary"
        )
        assert "| beta | 0.5 |" in text
        assert "| hidden | (8,) |" in text


def test_a_session_that_goes_on_neither_loses_nor_doubles_a_point(config, tmp_path):
    class StopError(Exception):
        pass

    calls = 0

    def stop(_):
        nonlocal calls
        calls += 1
        if calls == 3:
            raise StopError

    # One checkpoint after two stretches, whose points the files have; the third is lost.
    with pytest.raises(StopError):
        train(config, stop, out=tmp_path / "cut", checkpoint_seconds=0)
    place = tmp_path / "cut" / "tensorboard" / "run-0"
    (begun,) = place.iterdir()
    assert {step for step, _, _ in scalars(place)} == {STRETCH, 2 * STRETCH}
    begun.write_bytes(begun.read_bytes()[:-7])  # the kill came while a point was written
    (place / f".{begun.name}.partial").write_bytes(b"half")
    train(config, out=tmp_path / "cut", resume=True)
    train(config, out=tmp_path / "whole")
    (now,) = place.iterdir()
    assert now.name > begun.name  # so that a TensorBoard that looks on takes it up
    for k in range(2):
        cut, whole = (
            scalars(tmp_path / name / "tensorboard" / f"run-{k}", but=("speed/steps_per_second",))
            for name in ("cut", "whole")
        )
        assert cut == whole


def test_without_a_folder_nothing_is_written(config, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    before = sorted(tmp_path.rglob("*"))
    train(config.changed(steps=1))
    assert sorted(tmp_path.rglob("*")) == before


def test_without_an_intrinsic_reward_it_has_no_points(config, tmp_path):
    plain = config.changed(intrinsic="none", beta=0.0, horizon=0, steps=1, runs=1)
    train(plain, out=tmp_path / "run")
    tags = {tag for _, tag, _ in scalars(tmp_path / "run" / "tensorboard" / "run-0")}
    assert tags == {tag for tag in TAGS if not tag.startswith("intrinsic/")}
