"""Runs with a tool of one's own go on, and are refused where it is no longer what it was."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import jax
import numpy as np
import pytest

from habilis.cli import main
from habilis.learning.config import Config
from habilis.learning.folder import load_run, read_world
from habilis.learning.jobs import Job, digest_of_own_tool
from habilis.learning.sources import map_of
from habilis.sweeps import sweep
from habilis.sweeps.store import LAYOUT, read_points, results
from habilis.sweeps.training import tasks_of
from habilis.tasks.local import processes
from habilis.worlds.tools import Picker
from habilis.worlds.world import load_world

EXAMPLE = Path(__file__).parents[2] / "examples" / "rake.py"
KILLER = Path(__file__).parents[1] / "support" / "killed.py"
ROOM = "A...\nPC..\n...G\n"
RAKE = "rake.py:Rake"
AIMLESS = ("--algorithm", "q-learning", "--epsilon", "1", "--epsilon-steps", "0", "--runs", "2")
SHORT = (*AIMLESS, "--steps", "80000", "--episodes", "1000000", "--episode-limit", "64")
OTHER = "\nRake.carry = lambda self, agent, tool, thing, step: thing\n"


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """The working directory, with a rake and a room in it."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(EXAMPLE, tmp_path)
    (tmp_path / "room.txt").write_text(ROOM)
    return tmp_path


def train(*options: str) -> list[str]:
    return ["train", "room.txt", "--tool", RAKE, *SHORT, "--out", "run", *options]


def change(folder: Path, text: str) -> None:
    (folder / "rake.py").write_text(EXAMPLE.read_text() + text)


def contents(folder: Path) -> dict[str, bytes]:
    return {str(p): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def said(capsys) -> str:
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    return err


@pytest.fixture
def begun(folder):
    """A run that was killed after its first checkpoint."""
    plan = [str(folder / "run"), "checkpoint:6", *train("--checkpoint-seconds", "0")]
    plan[plan.index("run", 2)] = str(folder / "run")
    subprocess.run([sys.executable, "-W", "ignore", KILLER, *plan], check=True)
    assert list((folder / "run").glob("checkpoint-*.npz"))
    assert not (folder / "run" / "summary.json").exists()
    return folder / "run"


def test_a_run_goes_on_in_its_folder_and_is_watched_from_anywhere(
    begun, folder, tmp_path_factory, monkeypatch, capsys
):
    change(folder, "# said better\n")
    assert main(train("--resume")) == 0
    assert main(["plot", "run", "--json"]) == 0
    monkeypatch.chdir(tmp_path_factory.mktemp("elsewhere"))
    capsys.readouterr()
    assert main(["watch", str(begun), "--json", "--gif", "run.gif"]) in (0, 1)
    assert json.loads(capsys.readouterr().out)["ended"]
    assert Path("run.gif").read_bytes().startswith(b"GIF")
    world = map_of(read_world(begun))
    assert world.tool == f"{folder / 'rake.py'}:Rake"
    assert (
        (begun / "world.txt").read_text() == world.text() == f"R = {world.tool}\nA...\nRC..\n...G\n"
    )


@pytest.mark.parametrize("verb", ["train", "watch", "plot"])
def test_with_a_tool_that_does_something_else_a_run_is_refused(verb, begun, folder, capsys):
    change(folder, OTHER)
    before = contents(begun)
    command = train("--resume") if verb == "train" else [verb, "run"]
    assert main(command) == 2
    assert "rake.py:Rake'; restore the tool's file" in said(capsys)
    assert contents(begun) == before
    change(folder, "")
    assert main([*command, "--json"]) in (0, 1)


def test_a_finished_run_is_refused_with_a_tool_that_does_something_else(folder):
    assert main(train()) == 0
    change(folder, OTHER)
    assert main(train("--resume")) == 2
    with pytest.raises(ValueError, match="another rule of the tool"):
        load_run("run")


def test_without_the_tools_file_it_is_named(begun, folder, capsys):
    (folder / "rake.py").unlink()
    assert main(["watch", "run"]) == 2
    error = said(capsys)
    assert (
        f"run/world.txt: room.txt, line 1: tool '{folder}/rake.py:Rake': {folder}/rake.py cannot"
        in error
    )
    assert "damaged" not in error


def test_a_folder_without_the_digest_of_its_table_is_read(begun):
    config = json.loads((begun / "config.json").read_text())
    assert len(config["map"].pop("table")) == 32
    (begun / "config.json").write_text(json.dumps(config))
    assert map_of(read_world(begun)).tool.endswith("rake.py:Rake")


def test_a_built_in_tool_is_not_noted(folder):
    world = load_world("room.txt")
    assert digest_of_own_tool(world) is None
    assert main([*train(), "--tool", "picker"]) == 0
    assert json.loads(Path("run/config.json").read_text())["map"] == {
        "name": "room.txt",
        "tool": "picker",
    }


def test_a_copy_of_the_picker_is_learned_with_as_the_picker_is(folder):
    (folder / "copied.py").write_text(
        "from habilis.worlds.tools import Picker\nclass Copy(Picker): ...\n"
    )
    config = Config(world="room.txt", runs=1, intrinsic="object", horizon=2, beta=0.1)
    own, ours = (Job.of(0, config.changed(tool=tool)) for tool in ("copied.py:Copy", "picker"))
    assert isinstance(map_of(own.world).tools[0].rule, Picker)
    assert map_of(own.world).tool == "copied.py:Copy"
    assert own.table.tobytes() == ours.table.tobytes()
    assert own.best_return == ours.best_return
    same = jax.tree.map(np.array_equal, own.dynamics[0], ours.dynamics[0])
    assert all(jax.tree.leaves(same))


# Sweeps

GRID = """
[config]
world = "room.txt"
runs = 1
episodes = 20
episode_limit = 50
hidden = [8]
[grid]
tool = ["rake.py:Rake", "broom", "none"]
"""


def test_tools_are_swept_over(folder, capsys):
    (folder / "grid.toml").write_text(GRID)
    assert main(["sweep", "grid.toml", "--out", "sweep", "--json"]) == 0
    frame = results("sweep")
    assert frame["tool"].to_list() == [RAKE, "broom", "none"]
    assert [map_of(world).tool for _, world in read_points(folder / "sweep")][1:] == [
        "broom",
        "none",
    ]
    before = contents(folder / "sweep")
    assert main(["sweep", "grid.toml", "--out", "sweep", "--resume"]) == 0
    assert contents(folder / "sweep").keys() == before.keys()


def test_what_was_swept_with_another_rule_is_trained_again(folder):
    config = Config(world="room.txt", tool=RAKE, runs=1, episodes=20).changed(hidden=(8,))
    (first,) = tasks_of(config)
    sweep([config], "sweep")
    change(folder, "# said better\n")
    assert tasks_of(config)[0].name == first.name
    change(folder, OTHER)
    assert tasks_of(config)[0].name != first.name
    with pytest.raises(ValueError, match=r"sweep: was started with another rule of the tool"):
        results("sweep")
    sweep([config], "sweep", resume=True)
    assert len(list((folder / "sweep" / LAYOUT.results).iterdir())) == 2
    assert results("sweep").height == 1
    (folder / "rake.py").unlink()
    with pytest.raises(ValueError, match=r"points\.json: .*rake\.py cannot be read"):
        results("sweep")


def test_a_tool_goes_to_processes_of_a_sweep(folder):
    config = Config(world="room.txt", tool=RAKE, runs=1, episodes=20).changed(hidden=(8,))
    here = sweep([config], "here").drop("seconds")
    with processes(1) as executor:
        there = sweep([config], "there", executor=executor).drop("seconds")
    assert there.equals(here)
