"""An algorithm in a file of its own is trained, resumed, replayed and offered like any other."""

import json
import os
import signal
from dataclasses import dataclass, replace
from typing import Any

import jax
import numpy as np
import pytest
from expected_sarsa import ExpectedSarsa

from habilis.checks import setting
from habilis.cli import main
from habilis.interruption import Interrupted
from habilis.learning.algorithms import ALGORITHMS
from habilis.learning.algorithms.a2c import A2C
from habilis.learning.algorithms.protocol import Algorithm, bound, hyperparams_of, static_part
from habilis.learning.algorithms.q_learning import QLearning
from habilis.learning.algorithms.soft_value_iteration import SoftValueIteration
from habilis.learning.config import Config
from habilis.learning.folder import load_latest, load_run
from habilis.learning.lanes import advance
from habilis.learning.replay import learned, play, table_of
from habilis.learning.runner import train
from habilis.studio.training_settings import offered
from habilis.sweeps.spec import read_spec

NAME, LABEL = "expected-sarsa", "Expected SARSA"
LEARN = {"runs": 2, "episodes": 100_000, "episode_limit": 50, "steps": 400_000, "seed": 1}


@pytest.fixture(autouse=True)
def registered(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "room.txt").write_text("A.\nC.\n..\nG.\n")
    ALGORITHMS.register(NAME, "expected_sarsa:ExpectedSarsa", LABEL)
    yield
    ALGORITHMS.unregister(NAME)


def config(**changes: Any) -> Config:
    return Config.from_dict({"algorithm": NAME, "world": "room.txt"} | LEARN | changes)


def test_it_is_stopped_and_resumed():
    undecided = config(softness=100.0, steps=60_000)
    whole = train(undecided)

    def stop(progress):
        os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(Interrupted):
        train(undecided, stop, out="run")
    assert load_latest("run").episodes.height < whole.episodes.height
    resumed = train(undecided, out="run", resume=True)
    assert resumed.episodes.equals(whole.episodes)
    np.testing.assert_array_equal(resumed.parameters, whole.parameters)


def test_it_is_trained_kept_and_replayed():
    assert None not in train(config(), out="run").converged_at
    run = load_run("run")
    assert run.config == config()
    assert play(run, 1).episode_return == run.best_return == -1
    policy, values = learned(run, table_of(run), 0)
    np.testing.assert_allclose(policy.sum(axis=1), 1, atol=1e-5)
    assert np.isfinite(values).all()


def test_the_command_line_offers_its_settings(capsys):
    with pytest.raises(SystemExit):
        main(["train", "--help"])
    text = " ".join(capsys.readouterr().out.split())
    assert f"soft-value-iteration,{NAME}}}" in text
    assert "temperature of the policy (expected-sarsa: 0.2)" in text
    assert "passes over a rollout (expected-sarsa: 1)" in text
    options = [f"--{name.replace('_', '-')}={value}" for name, value in LEARN.items()]
    options += ["--algorithm", NAME, "--softness", "0.1", "--passes", "2"]
    assert main(["train", "room.txt", *options, "--out", "run"]) == 0
    assert load_run("run").config == config(softness=0.1, passes=2)
    capsys.readouterr()
    assert main(["watch", "run", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["return"] == -1
    assert main(["train", "room.txt", "--softness", "1", "--out", "other"]) == 2
    assert "softness is a setting of expected-sarsa, not of a2c" in capsys.readouterr().err


def test_the_studio_and_sweeps_offer_it():
    assert offered().algorithms[NAME] == LABEL
    with open("sweep.toml", "w") as file:
        file.write(f'[config]\nworld = "room.txt"\nalgorithm = "{NAME}"\n[grid]\nsoftness = [1, 2]')
    found = [point.algorithm for point in read_spec("sweep.toml").grid]
    assert found == [ExpectedSarsa(softness=1.0), ExpectedSarsa(softness=2.0)]


def test_runs_with_other_hyperparameters_share_a_compiled_program():
    train(config(steps=1))
    before = advance._cache_size()  # pyright: ignore[reportAttributeAccessIssue]
    soft, hard = train([config(steps=1, softness=2.0), config(steps=1, softness=0.01)])
    assert advance._cache_size() == before  # pyright: ignore[reportAttributeAccessIssue]
    assert not np.array_equal(soft.parameters, hard.parameters)


def test_hyperparameters_are_bound_and_static_settings_stay():
    one = ExpectedSarsa(passes=3, softness=0.7)
    assert static_part(one) == ExpectedSarsa(passes=3)
    assert hyperparams_of(one)["softness"] == 0.7
    assert "passes" not in hyperparams_of(one)
    values = dict.fromkeys(hyperparams_of(one), -1.0)  # as an array, not checked again
    assert (bound(one, values).softness, bound(one, values).passes) == (-1.0, 3)
    assert one.softness == 0.7


@pytest.mark.parametrize("name", [*ALGORITHMS])
def test_every_algorithm_is_one_and_knows_its_name(name):
    algorithm = ALGORITHMS[name]()
    assert isinstance(algorithm, Algorithm)
    assert ALGORITHMS.name_of(algorithm) == name
    assert Config(algorithm=algorithm).as_dict()["algorithm"] == name
    assert ALGORITHMS.labels()[name]
    assert set(algorithm.ignores) <= vars(Config()).keys()
    assert jax.tree.leaves(algorithm) == [algorithm]


@dataclass(frozen=True)
class WithBeta(ExpectedSarsa):
    beta: float = setting(0.5, "of the algorithm")


@dataclass(frozen=True)
class WithoutHelp(ExpectedSarsa):
    more: int = 3


class NoDataclass:
    pass


@dataclass(frozen=True)
class NoUpdate:
    envs: int = setting(1, "environments", static=True)


@dataclass(frozen=True)
class TextRollout(ExpectedSarsa):
    hidden: int = setting(8, "units", static=True)


@pytest.mark.ill_typed
@pytest.mark.parametrize(
    ("kind", "says"),
    [
        (WithBeta, "algorithm 'x': beta is a setting of every run already; rename it"),
        (WithoutHelp, "algorithm 'x': more has no help; make it with habilis.checks.setting"),
        (NoDataclass, "is not a frozen dataclass; make it one"),
        (NoUpdate, "algorithm 'x': NoUpdate has no init; add it"),
    ],
)
def test_what_is_no_algorithm_is_refused(kind, says):
    with pytest.raises(ValueError, match=says):
        ALGORITHMS.register("x", kind, "X")
    assert "x" not in ALGORITHMS


def test_a_name_is_given_once_and_an_option_has_one_type(capsys):
    with pytest.raises(ValueError, match="'a2c' is registered already; give another name"):
        ALGORITHMS.register("a2c", A2C, "A2C")
    ALGORITHMS.register("x", TextRollout, "X")
    try:
        assert main(["train", "room.txt", "--out", "run"]) == 2
    finally:
        ALGORITHMS.unregister("x")
    assert "algorithm 'x': hidden is of another type in a2c; rename it" in capsys.readouterr().err


@pytest.mark.ill_typed
def test_an_algorithm_that_is_not_registered_is_refused():
    class Other(ExpectedSarsa):
        pass

    values: list[Any] = [Other(), "a2c", None]
    for value in values:
        with pytest.raises(ValueError, match=r"algorithm is .*; give a registered one"):
            Config(algorithm=value)


@pytest.mark.parametrize(
    ("algorithm", "name", "value", "default"),
    [
        (QLearning(), "observation", "coordinates", "one-hot"),
        (SoftValueIteration(), "observation", "coordinates", "one-hot"),
        (SoftValueIteration(), "limit_is_terminal", True, "False"),
    ],
)
def test_settings_that_play_no_part_in_an_algorithm_are_refused(
    algorithm, name, value, default, capsys
):
    of = ALGORITHMS.name_of(algorithm)
    says = rf"{name} is {value!r}, which plays no part in {of}; leave it at .*{default}"
    with pytest.raises(ValueError, match=says):
        replace(Config(algorithm=algorithm), **{name: value})
    option = [f"--{name.replace('_', '-')}", *([value] if isinstance(value, str) else [])]
    assert main(["train", "room.txt", "--algorithm", of, *option, "--out", "run"]) == 2
    assert f"{option[0]} is {value!r}, which plays no part in {of}" in capsys.readouterr().err
    assert Config(limit_is_terminal=True, algorithm=QLearning()).limit_is_terminal


def test_runs_that_were_saved_with_such_a_setting_are_still_read():
    plain = Config(world="room.txt", algorithm=SoftValueIteration(), runs=1, steps=20_000)
    train(plain, out="run")
    with open("run/config.json") as file:
        saved = json.load(file)
    with open("run/config.json", "w") as file:
        json.dump(saved | {"observation": "coordinates", "limit_is_terminal": True}, file)
    assert load_run("run").config == plain
