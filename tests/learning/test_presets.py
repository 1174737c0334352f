"""Published learners by name: their values, their runs, and what reads these."""

import json
from pathlib import Path

import numpy as np
import pytest

import habilis as hb
from habilis.cli import main
from habilis.learning.algorithms.a2c import A2C
from habilis.learning.config import Config
from habilis.learning.folder import load_run
from habilis.learning.networks import Separate
from habilis.learning.presets import PRESETS, preset
from habilis.learning.replay import learned, success, table_of
from habilis.studio import run_steps

ROOM = "A.\nC.\n..\nG.\n"


@pytest.fixture(scope="module")
def room(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("world") / "room.txt"
    path.write_text(ROOM)
    return path


def test_they_are_those_of_the_book():
    """SLM-Lab 4.1.1's a2c_gae_cartpole, a2c_gae_lunar, a2c_nstep_lunar and gridworld."""
    book = {
        "networks": "separate",
        "schedule": "steps",
        "reward_scale": 1.0,
        "learning_rate_steps": 0,
        "entropy_steps": 0,
        "entropy_hold": 0,
    }
    lander = book | {
        "envs": 8,
        "hidden": (64, 64, 32),
        "activation": "relu",
        "initialisation": "orthogonal",
        "optimizer": "adam",
        "learning_rate": 2e-3,
        "learning_rate_every": 0,
        "clip": 0.5,
        "discount": 0.99,
        "entropy": 0.01,
        "value": 1.0,
    }
    standardised = {"normalise": True, "unbiased": True}
    wanted = {
        "book-cartpole": book
        | standardised
        | {
            "envs": 4,
            "rollout": 32,
            "hidden": (64,),
            "activation": "selu",
            "initialisation": "pytorch",
            "optimizer": "rmsprop-torch",
            "learning_rate": 5e-3,
            "learning_rate_every": 0,
            "clip": 0.5,
            "discount": 0.99,
            "gae_lambda": 0.95,
            "entropy": 0.001,
            "value": 0.5,
        },
        "book-lander-gae": lander | standardised | {"rollout": 128, "gae_lambda": 0.95},
        "book-lander-nstep": lander
        | {"rollout": 5, "gae_lambda": 1.0, "normalise": False, "unbiased": False},
        "book-gridworld": book
        | standardised
        | {
            "envs": 1,
            "rollout": 0,
            "hidden": (200,),
            "activation": "sigmoid",
            "initialisation": "pytorch",
            "optimizer": "adam",
            "learning_rate": 0.01,
            "learning_rate_decay": 0.9,
            "learning_rate_every": 500,
            "clip": 0.0,
            "discount": 0.999,
            "gae_lambda": 0.97,
            "entropy": 0.0,
            "value": 1.0,
        },
    }
    assert PRESETS.keys() == wanted.keys()
    for name, fields in wanted.items():
        config = hb.preset(name)
        assert isinstance(config.algorithm, A2C)
        assert config.limit_is_terminal
        found = config.as_dict()
        assert {key: found[key] for key in fields} == fields


def test_what_is_given_takes_precedence():
    config = preset("book-cartpole", world="yard", activation="tanh", limit_is_terminal=False)
    assert (config.world, config.limit_is_terminal) == ("yard", False)
    found, book = vars(config.algorithm), vars(preset("book-cartpole").algorithm)
    assert found == book | {"activation": "tanh"}


@pytest.mark.ill_typed
@pytest.mark.parametrize(
    ("name", "changes", "says"),
    [
        ("book", {}, "preset 'book' is unknown; use one of book-cartpole, book-lander-gae"),
        (["book-cartpole"], {}, "is unknown"),
        ("book-cartpole", {"algorithm": "ppo"}, "is for algorithm 'a2c', not 'ppo'"),
        ("book-cartpole", {"normalise": False}, "turn on normalise, or turn off unbiased"),
        ("book-lander-gae", {"episode_limit": 100}, "rollout is 128 and episode_limit 100"),
        ("book-cartpole", {"epochs": 3}, "epochs is a setting of ppo, not of a2c"),
    ],
)
def test_what_does_not_go_together_is_refused(name, changes, says):
    with pytest.raises(ValueError, match=says):
        preset(name, **changes)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--preset", "book"], "argument --preset: invalid choice: 'book'"),
        (["--unbiased"], "--unbiased is True and normalise False"),
        (["--algorithm", "ppo", "--rollout", "0"], "--rollout is 0; give at least 1"),
        (["--preset", "book-cartpole", "--algorithm", "ppo"], "is for algorithm 'a2c', not 'ppo'"),
        (["--activation", "gelu"], "activation 'gelu' is unknown; use one of tanh, relu"),
        (["--observation", "pixels"], "observation 'pixels' is unknown; use one of one-hot"),
        (["--learning-rate-decay", "0"], "--learning-rate-decay is 0.0; give a number above 0"),
    ],
    ids=str,
)
def test_the_command_line_refuses_them_in_one_line(options, says, tmp_path, capsys):
    assert main(["train", "corridor", *options, "--out", str(tmp_path / "run")]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert says in err
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("name", PRESETS)
def test_a_run_with_a_preset_is_kept_read_back_and_watched(name, room, tmp_path, capsys):
    folder = tmp_path / "run"
    options = ["--preset", name, "--runs", "2", "--episodes", "60", "--episode-limit", "130"]
    options += ["--observation", "coordinates"] if name == "book-gridworld" else []
    assert main(["train", str(room), *options, "--out", str(folder)]) == 0
    run = load_run(folder)
    seen = {"observation": "coordinates"} if name == "book-gridworld" else {}
    wanted = preset(name, world=str(room), runs=2, episodes=60, episode_limit=130, **seen)
    assert run.config == wanted
    assert isinstance(run.parameters, Separate)
    assert list((folder / "tensorboard").iterdir())
    policy, values = learned(run, table_of(run), 1)
    np.testing.assert_allclose(policy.sum(axis=1), 1, atol=1e-5)
    assert np.isfinite(values).all()
    assert 0 <= success(run, 1).seen <= 1
    capsys.readouterr()
    assert main(["watch", str(folder), "--run", "1", "--json"]) in (0, 1)
    assert json.loads(capsys.readouterr().out)["ended"] is True
    assert len(run_steps.view(str(folder), 1)["values"]) == 4
    assert run_steps.kept(str(folder))["ended"] is True


def test_both_kinds_of_observation_are_trained_side_by_side(room):
    """In batches of their own, though all else is the same."""
    config = Config(world=str(room), runs=1, episodes=30, episode_limit=20)
    configs = [config, config.changed(observation="coordinates")]
    together, alone = hb.train(configs), [hb.train(one) for one in configs]
    for one, other in zip(together, alone, strict=True):
        assert one.episodes.equals(other.episodes)
