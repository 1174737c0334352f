"""habilis compare of a MuJoCo file: what it prints, writes and refuses."""

import json
from pathlib import Path

import polars as pl
import pytest

from habilis.cli import main
from habilis.robots import Reach, compare_tools

pytest.importorskip("mujoco")

QUICK = ("--horizon", "3", "--side", "2", "--seeds", "1", "--sequences", "50")


def test_json_has_the_table_of_the_library(capsys):
    assert main(["compare", "reach.xml", "--tools", "none,hook", *QUICK, "--json"]) == 0
    reported = json.loads(capsys.readouterr().out)
    found = compare_tools("reach.xml", ["none", "hook"], 3, side=2, seeds=1)
    assert [row["tool"] for row in reported["tools"]] == found.frame()["tool"].to_list()
    assert [row["bits"] for row in reported["tools"]] == found.frame()["bits"].to_list()
    assert (reported["placements"], reported["seeds"], reported["horizon"]) == (4, 1, 3)


def test_a_file_of_ones_own_is_read_and_files_are_written(capsys, tmp_path: Path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("reach.xml").write_text(Reach(tool=0.2).xml())
    out = ("--out", "tools.png", "--out", "tools.csv")
    assert main(["compare", "reach.xml", "--tools", "none,stick", *QUICK, *out]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("average 3-step object empowerment of the puck over 4 placements")
    assert lines[0].endswith("(1 search each)")
    assert {line.split()[0] for line in lines[2:4]} == {"none", "stick"}
    assert pl.read_csv("tools.csv")["tool"].to_list() == [line.split()[0] for line in lines[2:4]]
    assert Path("tools.png").stat().st_size > 1000


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (
            ["reach.xml", "--tools", "rake"],
            "has no tool 'rake' in the hand; use one of stick, hook",
        ),
        (["reach.xml", "--slip", "0.1"], "--slip is for worlds"),
        (["reach.xml", "--unit", "nats"], "leave out --unit"),
        (["reach.xml", "--out", "a.npz"], "end it with"),
        (["yard", "--horizon", "1", "--seeds", "2"], "--seeds is for MuJoCo files"),
        (["none-such.xml"], "none-such.xml: no such file; give the path of a MuJoCo file"),
    ],
)
def test_bad_input_is_one_line(capsys, arguments: list[str], words: str):
    assert main(["compare", *arguments]) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert words in shown.err
    assert len(shown.err.splitlines()) == 1


def test_a_model_without_a_puck_is_refused(capsys, tmp_path: Path):
    path = tmp_path / "hand.xml"
    path.write_text("<mujoco><worldbody><body name='hand'/></worldbody></mujoco>")
    assert main(["compare", str(path)]) == 2
    assert "has no body 'puck'" in capsys.readouterr().err
