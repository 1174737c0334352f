"""Puzzles kept: code that gives the same numbers, and films."""

import base64
import contextlib
import io
import os
import subprocess
import sys
from pathlib import Path

import msgspec
import numpy as np
import pytest
from PIL import Image

from habilis.studio import scene_steps
from habilis.studio.as_code_of_board import code
from habilis.studio.board_scenes import BoardScene
from habilis.studio.films import film
from habilis.studio.opening import open_source
from habilis.studio.protocol.scenes import Scene

LEVELS = "#######\n#@ $. #\n# $.  #\n#######\n\n#####\n#@$.#\n#####\n"
PUSH = ". . . . .\nA M0 . . G0\nA M1 . . G1\n. AW . W .\n"


@pytest.fixture(params=["levels.xsb#1", "levels.xsb", "push.pwp"])
def source(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    (tmp_path / "levels.xsb").write_text(LEVELS)
    (tmp_path / "push.pwp").write_text(PUSH)
    return str(tmp_path / request.param)


def asked(source: str, folder: Path, **question) -> BoardScene:
    board = open_source(source, folder).board
    assert board is not None
    return BoardScene.of(msgspec.convert({"board": board.name} | question, Scene), board)


def ran(python: str) -> dict:
    names: dict = {}
    with contextlib.redirect_stdout(io.StringIO()):
        exec(python, names)
    return names


@pytest.mark.parametrize(
    "question",
    [
        {"horizon": 2},
        {"horizon": 2, "sensor": "factor", "thing": 1, "only": [0, 1, 3]},
        {"horizon": 1, "slip": 0.2},
    ],
)
def test_code_of_a_puzzles_landscape_gives_its_values(source: str, tmp_path: Path, question):
    scene = asked(source, tmp_path, **question)
    found = scene_steps.landscape(scene)
    shown = np.full((scene.height, scene.width), np.nan)
    for (row, column), bits in zip(found["cells"], found["bits"], strict=True):
        shown[row, column] = bits
    written = code(scene, source, "landscape", [])
    np.testing.assert_allclose(ran(written.python)["landscape"].values, shown, atol=2e-6)
    if "only" in question or ("#" in source and question["horizon"] == 2):
        assert written.command is not None
        (tmp_path / "habilis").write_text(f'#!/bin/sh\nexec {sys.executable} -m habilis "$@"\n')
        (tmp_path / "habilis").chmod(0o755)
        environment = os.environ | {"PATH": f"{tmp_path}:{os.environ['PATH']}"}
        printed = subprocess.run(
            ["bash", "-ec", written.command], env=environment, capture_output=True, text=True
        )
        rows = [line.split() for line in printed.stdout.splitlines()]
        values = np.array([[np.nan if v == "." else float(v) for v in row] for row in rows])
        np.testing.assert_allclose(values, shown, atol=0.0051)


def test_code_and_film_of_a_game_have_all_of_its_placements(source: str, tmp_path: Path):
    scene = asked(source, tmp_path, horizon=2)
    placement = scene.board.placement(scene.board.start)
    path, bits = [], []
    for action in (None, 1, 1, 2):
        step = scene_steps.step(scene, placement, action)
        placement = step["placement"]
        path.append(placement)
        bits.append(step["bits"])
    names = ran(code(scene, source, "game", path).python)
    np.testing.assert_allclose(names["bits"], bits, atol=2e-6)
    gif = base64.b64decode(film(scene, path)["gif"])
    with Image.open(io.BytesIO(gif)) as pictures:
        assert 1 < pictures.n_frames <= len(path)  # type: ignore[attr-defined]


def test_environments_have_neither_code_nor_films_here(tmp_path: Path):
    pytest.importorskip("gymnasium")
    source = "gym:FrozenLake-v1"
    scene = asked(source, tmp_path, horizon=1)
    with pytest.raises(ValueError, match=r"TabularMDP\.from_gymnasium"):
        code(scene, source, "landscape", [])
    with pytest.raises(ValueError, match="record an environment with Gymnasium"):
        film(scene, [scene.board.placement(scene.board.start)])
