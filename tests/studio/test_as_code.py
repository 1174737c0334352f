"""Code of what is on the screen: run, it gives the same numbers; and films of placements."""

import base64
import io
import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from studio_code import python_of, shell, shown_grid

import habilis as hb
from studio import Page, scene

YARD = hb.load_world("yard")
BALL = hb.World.parse("D = ball\nG = goal of C\nH = goal of D\nAPC..\n.D...\n....G\n...H.")
# The agent, between two tools, comes nowhere: a scene without "tool" has both.
CLOSED = hb.World.parse("X = broom\nD = ball\nG = goal of C\nAX.C\nP..D\n...G\n....")
BOTH_TOOLS = scene(CLOSED, sensor="cells", cells=[[0, 2], [3, 3]], horizon=1)
del BOTH_TOOLS["tool"]
NUMBERS = re.compile(r"-?\d+\.\d+|\bnan\b")


QUESTIONS = [
    (YARD, {"sensor": "object", "horizon": 3}),
    (YARD, {"sensor": "state", "horizon": 2, "actions": "moves", "slip": 0.1}),
    (YARD, {"sensor": "object", "horizon": 2, "tool": "none"}),
    (YARD, {"sensor": "cells", "horizon": 3, "cells": [[9, 2], [9, 3]]}),
    (BALL, {"sensor": "object", "horizon": 2, "thing": 1}),
    (YARD, {"sensor": "tool", "horizon": 2}),
]


@pytest.mark.parametrize(("world", "question"), QUESTIONS)
def test_python_of_a_landscape_gives_its_values_and_averages(
    there: Page, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, world, question
):
    asked = scene(world, **question)
    shown = shown_grid(there.ask("landscape", scene=asked))
    tools = [] if question.get("slip") else ["picker", "none"]
    code = there.ask("code", scene=asked, view="landscape", tools=tools)
    names, printed = python_of(code["python"], tmp_path, monkeypatch)
    np.testing.assert_allclose(names["landscape"].values, shown, atol=2e-6)
    if tools:
        averages = {}
        for part in there.answers(there.send("measure", scene=asked)):
            averages |= part.get("averages", {})
            if averages.keys() >= {*tools}:
                break
        found = eval(printed.strip().splitlines()[-1])
        assert found == pytest.approx({tool: averages[tool] for tool in tools})


def test_commands_of_a_landscape_print_its_values_and_averages(there: Page, tmp_path: Path):
    for question in (
        {"sensor": "object", "horizon": 2, "actions": "moves"},
        {"sensor": "state", "horizon": 2, "tool": "none"},
    ):
        asked = scene(YARD, **question)
        shown = shown_grid(there.ask("landscape", scene=asked))
        code = there.ask("code", scene=asked, view="landscape", tools=["none"])
        printed = shell(code["command"], tmp_path)
        rows = [line.split() for line in printed.splitlines()[: YARD.height]]
        values = np.array([[float(v) if v != "." else np.nan for v in row] for row in rows])
        np.testing.assert_allclose(values, shown, atol=0.0051)
        averages = next(
            part["averages"]
            for part in there.answers(there.send("measure", scene=asked))
            if "none" in part.get("averages", {})
        )
        assert f"{averages['none']:.2f}" in printed.split("\n", YARD.height)[-1]
    cells = scene(YARD, sensor="cells", cells=[[9, 2]], horizon=1)
    assert there.ask("code", scene=cells, view="landscape")["command"] is None


def test_code_of_pairs_gives_their_averages(
    there: Page, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    asked = scene(BALL, horizon=2)
    tools = ["picker", "broom", "none"]
    answers = there.answers(there.send("pairs", scene=asked))
    names = next(answers)
    shown = {}
    while len(shown) < len(names["tools"]) * len(names["objects"]):
        pair = next(answers)["pair"]
        tool, object = names["tools"][pair["tool"]]["name"], names["objects"][pair["object"]]
        shown[tool, object] = pair["averages"][-1]
    code = there.ask("code", scene=asked, view="pairs", tools=tools)
    found = python_of(code["python"], tmp_path, monkeypatch)[0]["pairs"]
    for row, tool in enumerate(tools):
        for column, object in enumerate(names["objects"]):
            assert found.averages[-1, row, column] == pytest.approx(shown[tool, object], abs=2e-6)
    printed = shell(code["command"], tmp_path)
    for tool in tools:
        assert f"{shown[tool, 'ball']:.4f}" in printed


@pytest.mark.parametrize("world", [YARD, BALL, BALL.with_tool("none")])
def test_code_of_a_game_gives_the_bits_along_it(
    there: Page, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, world
):
    asked = scene(world, sensor="object", horizon=2)
    placement = {
        "agent": world.agent,
        "tools": [tool.cell for tool in world.tools],
        "objects": [thing.cell for thing in world.objects],
    }
    path, bits = [], []
    for action in (None, 1, 2, 2):
        step = there.ask("step", scene=asked, placement=placement, action=action)
        placement = step["placement"]
        path.append(placement)
        bits.append(step["bits"])
    code = there.ask("code", scene=asked, view="game", placements=path)
    names, _ = python_of(code["python"], tmp_path, monkeypatch)
    np.testing.assert_allclose(names["bits"], bits, atol=2e-6)
    assert (code["command"] is None) == ("held" in placement)  # for which there is no option
    if code["command"] is None:
        return
    rows = [line.split() for line in shell(code["command"], tmp_path).splitlines()]
    row, column = placement["agent"]
    assert float(rows[row][column]) == pytest.approx(bits[-1], abs=0.0051)


def test_code_counts_where_the_agent_cannot_come(
    there: Page, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    for slip in (0.0, 0.1):
        asked = BOTH_TOOLS | {"slip": slip}
        shown = shown_grid(there.ask("landscape", scene=asked))
        code = there.ask("code", scene=asked, view="landscape", tools=[])
        names, _ = python_of(code["python"], tmp_path, monkeypatch)
        np.testing.assert_allclose(names["landscape"].values, shown, atol=2e-6)
    placement = {"agent": [3, 0], "tools": [[0, 1], [1, 0]], "objects": [[0, 3], [1, 3]]}
    step = there.ask("step", scene=BOTH_TOOLS, placement=placement, action=None)
    code = there.ask("code", scene=BOTH_TOOLS, view="game", placements=[step["placement"]])
    names, _ = python_of(code["python"], tmp_path, monkeypatch)
    np.testing.assert_allclose(names["bits"], [step["bits"]], atol=2e-6)


def test_a_film_has_a_frame_for_every_placement(there: Page):
    asked = scene(YARD)
    placements = there.ask("solve", scene=asked)["placements"]
    gif = base64.b64decode(there.ask("film", scene=asked, placements=placements)["gif"])
    with Image.open(io.BytesIO(gif)) as film:
        assert film.n_frames == len(placements)  # type: ignore[attr-defined]
        assert film.size == (480, 480)
    error = there.ask("film", scene=asked, placements=[])["error"]
    assert "give a list of 1 to" in error


def test_code_of_a_training_trains_the_same(
    there: Page, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    pytest.importorskip("jax")
    small = hb.World.parse("A...\nP.C.\n...G\n....", "small")
    settings = {"intrinsic": "object", "horizon": 2, "beta": 0.1, "runs": 1, "episodes": 200}
    answers = there.answers(there.send("train", scene=scene(small), settings=settings))
    end = next(answer for answer in answers if "done" in answer)
    name = end["done"]["name"]
    of_form = there.ask("code", scene=scene(small), view="training", settings=settings)
    of_folder = there.ask("code", scene=scene(small), view="training", name=name)
    names, _ = python_of(of_form["python"], tmp_path, monkeypatch)
    assert list(names["run"].converged_at) == end["converged_at"]
    assert len(names["run"].episodes) == end["episodes"]
    assert int(names["run"].episodes["steps"].sum()) == end["steps"]
    shell(of_folder["command"] or "", tmp_path)
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["best_return"] == end["best_return"]
    of_run = there.ask("code", scene=scene(small), view="run", name=name, index=0)
    shown = there.ask("run", index=0, name=name)["episode"]
    names, _ = python_of(of_run["python"], tmp_path, monkeypatch)
    assert list(names["episode"].actions) == shown["actions"]
    start = {"agent": [0, 3], "tools": [[1, 3]], "objects": [[1, 2]]}
    elsewhere = there.ask(
        "code", scene=scene(small), view="run", name=name, index=0, placements=[start]
    )
    assert elsewhere["command"] is None
    shown = there.ask("run", index=0, name=name, placement=start)["episode"]
    names, _ = python_of(elsewhere["python"], tmp_path, monkeypatch)
    assert list(names["episode"].actions) == shown["actions"]
