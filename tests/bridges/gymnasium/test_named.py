"""Environments by their names on the command line."""

import json
import sys
from pathlib import Path

import pytest

from habilis.cli import main

LINE = """
import gymnasium as gym
from gymnasium.envs.registration import register


class Line(gym.Env):
    observation_space = gym.spaces.Discrete(3)
    action_space = gym.spaces.Discrete(2)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.at = 0
        return self.at, {}

    def step(self, action):
        self.at = min(max(self.at + 2 * int(action) - 1, 0), 2)
        return self.at, 0.0, False, False, {}


register("Line-v0", entry_point=Line)
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def refusal(capsys: pytest.CaptureFixture[str], name: str) -> str:
    assert main(["empowerment", name, "--horizon", "1"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    return err


def test_a_module_of_the_working_directory_registers_its_environment(folder, capsys):
    (folder / "my_line.py").write_text(LINE)
    before = list(sys.path)
    assert main(["empowerment", "gym:my_line:Line-v0", "--horizon", "2", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["states"] == 3
    assert sys.path == before


@pytest.mark.parametrize(
    ("source", "why"),
    [
        ("\n1 / 0\n", "(ZeroDivisionError: division by zero, mine.py, line 2)"),
        ("def\n", "(SyntaxError: invalid syntax, mine.py, line 1)"),
        ("import sys\nsys.exit(3)\n", "(SystemExit: 3, mine.py, line 2)"),
    ],
)
def test_a_module_that_fails_is_refused_in_a_line_with_its_place(folder, capsys, source, why):
    (folder / "mine.py").write_text(source)
    assert f"gym:mine:Line-v0 cannot be made {why}; " in refusal(capsys, "gym:mine:Line-v0")


def test_an_unknown_environment_is_told_that_a_module_may_register_it(folder, capsys):
    said = refusal(capsys, "gym:MyMaze-v0")
    assert "with the module that registers it, as gym:minigrid:MiniGrid-Empty-5x5-v0" in said


def test_a_module_that_is_not_there_is_refused_in_a_line(folder, capsys):
    assert "gym:not_there:Line-v0 cannot be made (" in refusal(capsys, "gym:not_there:Line-v0")
