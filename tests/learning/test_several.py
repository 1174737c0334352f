"""Training on maps of several tools and objects."""

import json
import pickle
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import habilis as hb
from habilis.cli import main
from habilis.learning.config import Config
from habilis.learning.folder import load_run, read_world
from habilis.learning.intrinsic import value_table
from habilis.learning.jobs import Job, digest_of_own_tool
from habilis.learning.sources import map_of
from habilis.sweeps import sweep
from habilis.sweeps.store import read_points, results
from habilis.sweeps.training import tasks_of

EXAMPLE = Path(__file__).parents[2] / "examples" / "rake.py"
ROOM = "D = can\nG = goal of C\nH = goal of D\nAC.G\nP...\n.D.H\n"
OWN = "R = rake.py:Rake\nD = can\nG = goal of C\nH = goal of D\nAC.G\n....\n..P.\nRD.H\n"
OTHER = "\nRake.carry = lambda self, agent, tool, thing, step: thing\n"
SHORT = ("--runs", "1", "--episodes", "20", "--episode-limit", "50", "--hidden", "8")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(EXAMPLE, tmp_path)
    (tmp_path / "room.txt").write_text(ROOM)
    (tmp_path / "own.txt").write_text(OWN)
    return tmp_path


def said(capsys) -> str:
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    return err


@pytest.mark.parametrize("sensor", ["object:can", "state", "tool:picker", "held", "tool"])
def test_a_run_is_trained_read_back_and_watched(sensor, capsys):
    bonus = ("--intrinsic", sensor, "--horizon", "3", "--beta", "0.05")
    assert main(["train", "room.txt", *bonus, *SHORT, "--out", "run", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["best_return"] < 0
    assert read_world(Path("run")) == replace(hb.load_world("room.txt"))
    assert main(["train", "room.txt", *bonus, *SHORT, "--out", "run", "--resume"]) == 0
    capsys.readouterr()
    assert main(["watch", "run", "--json", "--gif", "run.gif"]) in (0, 1)
    assert Path("run.gif").read_bytes().startswith(b"GIF")


def test_a_tool_may_be_put_down_while_it_is_watched(capsys):
    Path("down.txt").write_text("drop: true\nAP.\n.C.\n..G\n")
    assert main(["train", "down.txt", *SHORT, "--out", "run"]) == 0
    capsys.readouterr()
    assert main(["watch", "run"]) in (0, 1)
    assert "steps, return" in capsys.readouterr().out


def test_one_of_several_objects_has_to_be_named(capsys):
    bonus = ("--intrinsic", "object", "--horizon", "3", "--beta", "0.05")
    assert main(["train", "room.txt", *bonus, *SHORT, "--out", "run"]) == 2
    assert "intrinsic 'object' could be several things; use one of none, count, rnd, state" in said(
        capsys
    )
    assert not Path("run").exists()


def test_a_tool_that_may_fail_among_several_is_trained_with():
    Path("slips.txt").write_text(f"P = picker slip 0.5\n{ROOM}")
    assert main(["train", "slips.txt", *SHORT, "--out", "run"]) == 0
    job, sure = Job.of(0, Config(world="slips.txt")), Job.of(0, Config(world="room.txt"))
    assert (job.dynamics[0].transitions.outcomes, sure.dynamics[0].transitions.outcomes) == (2, 1)
    assert job.best_return <= sure.best_return


# Sums and products


@pytest.mark.parametrize(
    ("intrinsic", "combined"),
    [
        ("object:can+object:can2", lambda one, other: one + other),
        ("object:can * object:can2", lambda one, other: one * other),
        ("object:can*object:can2 + object:can", lambda one, other: one * other + one),
    ],
)
def test_empowerments_of_several_objects_are_added_and_multiplied(intrinsic, combined):
    mdp = hb.tabulate(hb.load_world("room.txt"))
    bits = [hb.empowerment(mdp, 2, name) for name in ("object:can", "object:can2")]
    config = Config(world="room.txt", intrinsic=intrinsic, horizon=2, beta=0.1)
    np.testing.assert_array_equal(value_table(mdp, config), combined(*bits))
    np.testing.assert_array_equal(Job.of(0, config).table, combined(*bits))


@pytest.mark.parametrize("intrinsic", ["object:can+object:tin", "object:can*none", "object:can+"])
def test_an_unknown_part_of_a_sum_is_named(intrinsic):
    config = Config(world="room.txt", intrinsic=intrinsic, horizon=2, beta=0.1)
    part = intrinsic.replace("object:can", "").strip("+*")
    with pytest.raises(
        ValueError, match=rf"intrinsic '{part}' is unknown; use one of state, agent"
    ):
        Job.of(0, config)


# Tools of one's own


def test_of_several_tools_all_of_ones_own_are_noted():
    world = hb.load_world("own.txt")
    assert world.own_tools == ("rake.py:Rake",)
    assert [tool.own is None for tool in world.tools] == [True, False]
    assert digest_of_own_tool(world) is not None
    assert digest_of_own_tool(hb.load_world("room.txt")) is None


@pytest.mark.parametrize("verb", ["train", "watch"])
def test_a_run_is_refused_when_one_of_several_tools_does_something_else(verb, folder, capsys):
    command = ["train", "own.txt", *SHORT, "--out", "run"]
    assert main(command) == 0
    (folder / "rake.py").write_text(EXAMPLE.read_text() + OTHER)
    capsys.readouterr()
    assert main([*command, "--resume"] if verb == "train" else ["watch", "run"]) == 2
    assert "rake.py:Rake'; restore the tool's file" in said(capsys)
    (folder / "rake.py").write_text(EXAMPLE.read_text() + "# said better\n")
    assert main([*command, "--resume"]) == 0


def test_a_run_is_found_from_another_folder(folder, tmp_path_factory, monkeypatch):
    assert main(["train", "own.txt", *SHORT, "--out", "run"]) == 0
    monkeypatch.chdir(tmp_path_factory.mktemp("elsewhere"))
    assert load_run(folder / "run").map.own_tools == (f"{folder}/rake.py:Rake",)


def test_a_world_with_ones_own_tool_can_be_pickled_and_read_elsewhere(
    folder, tmp_path_factory, monkeypatch
):
    world = hb.load_world("own.txt")
    assert pickle.loads(pickle.dumps(world)).tools[1].kind == "rake.py:Rake"
    kept = pickle.dumps(world)
    monkeypatch.chdir(tmp_path_factory.mktemp("elsewhere"))
    other = pickle.loads(kept)
    mdp, again = hb.tabulate(world), hb.tabulate(other)
    np.testing.assert_array_equal(mdp.next_state, again.next_state)
    assert (other.name, other.objects) == (world.name, world.objects)


def test_what_a_tool_does_stays_the_same_while_it_is_used(folder):
    world = hb.load_world("own.txt")
    before = hb.tabulate(world).next_state
    (folder / "rake.py").write_text(EXAMPLE.read_text() + OTHER)
    np.testing.assert_array_equal(hb.tabulate(world).next_state, before)
    assert hb.load_world("own.txt") != world


def test_several_things_are_swept_over(folder):
    config = Config(world="own.txt", runs=1, episodes=20, episode_limit=50).changed(hidden=(8,))
    configs = [config, config.changed(intrinsic="object:can2", horizon=2, beta=0.1)]
    sweep(configs, "sweep")
    assert results("sweep").height == 2
    assert [map_of(world).own_tools for _, world in read_points(folder / "sweep")] == [
        (f"{folder}/rake.py:Rake",)
    ] * 2
    before = tasks_of(config)[0].name
    (folder / "rake.py").write_text(EXAMPLE.read_text() + OTHER)
    assert tasks_of(config)[0].name != before
    with pytest.raises(ValueError, match="another rule of the tool"):
        results("sweep")
