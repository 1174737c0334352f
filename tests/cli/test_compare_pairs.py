"""habilis compare --pairs: what it prints, writes and refuses."""

import json
from pathlib import Path

import numpy as np
import pytest

import habilis as hb
from habilis.analysis.pairs import pairs
from habilis.cli import main

ROOM = "R = rake\nD = ball\nG = goal of C\nA.P..\n..CR.\n.#..D\n....G\n"


@pytest.fixture
def room(tmp_path: Path) -> str:
    path = tmp_path / "room.txt"
    path.write_text(ROOM)
    return str(path)


def answer(capsys, *arguments):
    assert main(["compare", *arguments, "--pairs", "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_json_has_every_pair_by_its_names(capsys, room):
    reported = answer(capsys, room, "--horizon", "3")
    found = pairs(hb.load_world(room), 3)
    assert (reported["horizon"], reported["unit"]) == (3, "bits")
    assert [*reported["averages"]] == ["picker", "rake", "none"]
    for row, tool in enumerate(found.tools):
        for column, thing in enumerate(found.objects):
            assert reported["averages"][tool][thing] == found.averages[-1, row, column]
            pair = reported["pairs"][tool][thing]
            assert pair["averages"] == found.averages[:, row, column].tolist()
            assert pair["range"] == found.range[row, column]
            assert pair["persistence"] == found.persistence[row, column]


def test_what_is_infinite_or_no_number_is_null(capsys, tmp_path):
    (tmp_path / "walled.txt").write_text("A#C#G\n")
    pair = answer(capsys, str(tmp_path / "walled.txt"))["pairs"]["none"]["can"]
    assert (pair["range"], pair["latency"], pair["reliability"]) == (0, None, None)
    assert main(["compare", str(tmp_path / "walled.txt"), "--pairs"]) == 0
    assert capsys.readouterr().out.splitlines()[-2].split()[:7] == (
        ["none", "can", "0", "-", "-", "0.0000", "-"]
    )


def test_the_matrix_and_a_line_for_each_pair_are_printed(capsys, room):
    assert main(["compare", room, "--pairs", "--horizon", "2"]) == 0
    lines = capsys.readouterr().out.splitlines()
    found = pairs(hb.load_world(room), 2)
    assert lines[0] == "average 2-step object empowerment, in bits"
    assert lines[1].split() == ["can", "ball"]
    for line, tool, row in zip(lines[2:5], found.tools, found.averages[-1], strict=True):
        assert line.split() == [tool, *(f"{bits:.4f}" for bits in row)]
    heads, *rest, units = lines[7:]
    assert units.startswith("range in cells; latency, least and median, in actions (-: over 2); ")
    assert len(rest) == 6
    assert len({len(line) for line in lines[7:-1]}) == 1
    for number, line in enumerate(rest):
        row, column = divmod(number, 2)
        words = line.split()
        assert words[:2] == [found.tools[row], found.objects[column]]
        assert words[-2:] == [f"{bits:.4f}" for bits in found.averages[:, row, column]]
    assert heads.endswith("reliability   h = 1   h = 2")


def test_a_map_with_one_tool_is_compared_with_the_usual_ones(capsys, tmp_path):
    assert [*answer(capsys, "yard", "--horizon", "1")["averages"]] == ["picker", "broom", "none"]
    (tmp_path / "rake.txt").write_text("R = rake\nA.R.\n..C.\n...G\n")
    reported = answer(capsys, str(tmp_path / "rake.txt"))
    assert reported["horizon"] == 6
    assert [*reported["averages"]] == ["rake", "picker", "broom", "none"]
    reported = answer(capsys, str(tmp_path / "rake.txt"), "--tools", "none,stick", "--horizon", "1")
    assert [*reported["averages"]] == ["none", "stick"]


def test_slip_and_nats_are_heeded(capsys, tmp_path):
    (tmp_path / "small.txt").write_text("Q = picker slip 0.3\nA.C.\nP..G\n..Q.\n")
    small = (str(tmp_path / "small.txt"), "--horizon", "2")
    sure, noisy = answer(capsys, *small), answer(capsys, *small, "--slip", "0.2")
    nats = answer(capsys, *small, "--unit", "nats")
    for tool, by_object in sure["averages"].items():
        assert noisy["averages"][tool]["can"] < by_object["can"]
        assert nats["averages"][tool]["can"] == pytest.approx(by_object["can"] * np.log(2))
        assert noisy["pairs"][tool]["can"]["reliability"] < 1
    reliable = {tool: pair["can"]["reliability"] for tool, pair in sure["pairs"].items()}
    assert reliable["picker2"] < reliable["picker"] == reliable["none"] == 1


def test_pictures_and_tables_are_written_in_one_go(capsys, room, tmp_path):
    picture, table = tmp_path / "pairs.svg", tmp_path / "pairs.csv"
    arguments = ["compare", room, "--pairs", "--horizon", "2"]
    assert main([*arguments, "--out", str(picture), "--out", str(table)]) == 0
    assert f"written to {picture}\nwritten to {table}\n" in capsys.readouterr().out
    for path in (picture, table):
        expected = tmp_path / f"expected{path.suffix}"
        pairs(hb.load_world(room), 2).save(expected)
        assert path.read_bytes() == expected.read_bytes()


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--pairs", "--horizon", "0"], "horizon is 0; give a whole number from 1 up"),
        (["--pairs", "--tools", ""], "no tools to compare"),
        (["--pairs", "--tools", "spoon"], "tool 'spoon' is unknown"),
        (["--pairs", "--slip", "2"], "slip is 2.0; give a probability"),
        (["--pairs", "--out", "pairs.bmp"], "pairs.bmp: unknown suffix"),
        (["--pairs", "--out", "pairs.csv", "--out", "x.bmp"], "x.bmp: unknown suffix"),
        (["--pairs", "--out", "pairs.csv", "--out", "no/x.png"], "there is no folder no"),
        (["--horizon", "2", "--out", "pairs.png"], "add --pairs"),
        (["--horizon", "2"], "several objects, can, ball; add --pairs"),
        ([], "no horizon; give --horizon"),
    ],
)
def test_bad_input_is_one_line_and_nothing_on_disk(
    arguments, says, capsys, room, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    assert main(["compare", room, *arguments]) == 2
    out, err = capsys.readouterr()
    assert says in err
    assert err.count("\n") == 1
    assert out == ""
    assert [path.name for path in tmp_path.iterdir()] == ["room.txt"]
