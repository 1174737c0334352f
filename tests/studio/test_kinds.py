"""Kinds of empowerment on the page: their values, their limits, and code that gives the same."""

from pathlib import Path

import msgspec
import numpy as np
import pytest
from studio_code import python_of, shell, shown_grid

import habilis as hb
from habilis.studio import scene_steps
from habilis.studio.as_code_of_board import code
from habilis.studio.board_scenes import BoardScene
from habilis.studio.opening import open_source
from habilis.studio.protocol.scenes import Scene
from studio import Page, scene

ROOM = hb.World.parse("A...\nP#..\n.C..\n...G", "room")
TWO = hb.World.parse("D = ball\nG = goal of C\nH = goal of D\nAPC.\n.D..\n...G\n..H.", "two")
DROP = hb.World.parse("drop: true\nA...\nP#..\n.C..\n...G", "drop")
EFFECTIVE = {"kind": "effective", "discount": 0.8}
GOAL = {"kind": "goal-directed", "slack": 2}
CLOSED = {"kind": "closed-loop"}
NOISY = {"slip": 0.1}


@pytest.mark.parametrize("kind", [EFFECTIVE, EFFECTIVE | NOISY, GOAL, CLOSED, CLOSED | NOISY])
def test_landscapes_have_the_values_of_their_kind_and_code_gives_the_same(
    there: Page, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind
):
    asked = scene(ROOM, sensor="object", horizon=2, **kind)
    answer = there.ask("landscape", scene=asked)
    shown = shown_grid(answer)
    found = hb.landscape(ROOM, 2, "object", **kind)
    np.testing.assert_allclose(shown, found.values, atol=2e-6)
    assert np.nanmax(shown) > 0
    assert answer["gap"] <= 2e-6
    written = there.ask("code", scene=asked, view="landscape")
    names, _ = python_of(written["python"], tmp_path, monkeypatch)
    np.testing.assert_allclose(names["landscape"].values, shown, atol=2e-6)
    assert names["landscape"].kind == kind["kind"]


@pytest.mark.parametrize("kind", [EFFECTIVE, GOAL])
def test_commands_print_the_values_of_a_kind(there: Page, tmp_path: Path, kind):
    asked = scene(ROOM, sensor="object", horizon=2, **kind)
    shown = shown_grid(there.ask("landscape", scene=asked))
    printed = shell(there.ask("code", scene=asked, view="landscape")["command"], tmp_path)
    rows = [line.split() for line in printed.splitlines()]
    values = np.array([[float(v) if v != "." else np.nan for v in row] for row in rows])
    np.testing.assert_allclose(values, shown, atol=0.0051)


@pytest.mark.parametrize(("world", "kind"), [(TWO, EFFECTIVE), (DROP, EFFECTIVE), (DROP, GOAL)])
def test_code_of_several_things_counts_where_the_agent_cannot_come(
    there: Page, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, world, kind
):
    asked = scene(world, sensor="object", horizon=2, **kind)
    shown = shown_grid(there.ask("landscape", scene=asked))
    assert np.nanmax(shown) > 0
    written = there.ask("code", scene=asked, view="landscape")
    assert written["command"] is None  # its table is of what can be reached from the map
    names, _ = python_of(written["python"], tmp_path, monkeypatch)
    np.testing.assert_allclose(names["landscape"].values, shown, atol=2e-6)


@pytest.mark.parametrize("kind", [EFFECTIVE, GOAL, CLOSED])
@pytest.mark.parametrize("world", [ROOM, DROP])
def test_code_of_a_game_gives_the_bits_of_its_kind(
    there: Page, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, world, kind
):
    asked = scene(world, sensor="object", horizon=2, **kind)
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
    written = there.ask("code", scene=asked, view="game", placements=path)
    names, _ = python_of(written["python"], tmp_path, monkeypatch)
    np.testing.assert_allclose(names["bits"], bits, atol=2e-6)


@pytest.mark.parametrize(
    ("question", "message"),
    [
        (GOAL | NOISY, "goal-directed empowerment is defined without noise only"),
        ({"kind": "effective"}, "discount is None and kind 'effective'; give discount="),
        ({"slack": 1}, "slack is 1 and kind 'open-loop', which has none"),
        (EFFECTIVE | {"actions": "moves"}, "is over all actions; leave out actions"),
        (EFFECTIVE | {"discount": 0.99}, "scene.discount is 0.99; give a finite number from 0 to"),
        ({"kind": "best"}, "scene.kind is 'best'; give one of"),
    ],
)
def test_what_a_kind_cannot_do_is_said_in_one_line(there: Page, question, message):
    assert message in there.ask("landscape", scene=scene(ROOM, **question))["error"]


def test_a_goal_out_of_reach_leaves_nothing(there: Page):
    walled = hb.World.parse("A..#\nP#.#\n.C.#\n###G", "walled")
    answer = there.ask("landscape", scene=scene(walled, sensor="object", **GOAL))
    assert answer["most"] == 0
    assert answer["most"] == np.nanmax(hb.landscape(walled, 2, "object", **GOAL).values)


def test_what_takes_too_long_is_refused_at_once(there: Page):
    wide = hb.World.parse("\n".join([*["." * 12] * 11, "AP...C.....G"]), "wide")
    noisy = scene(wide, sensor="state", horizon=3, **CLOSED, **NOISY)
    error = there.ask("landscape", scene=noisy)["error"]
    assert "with feedback and random outcomes, 3 steps ahead take too long here" in error
    error = there.ask("landscape", scene=scene(wide, sensor="state", **EFFECTIVE))["error"]
    assert "takes too long here; observe a single thing, or make the map smaller" in error


@pytest.mark.parametrize("kind", [EFFECTIVE, GOAL, CLOSED])
def test_code_of_a_puzzles_kinds_gives_their_values(tmp_path: Path, kind):
    path = tmp_path / "level.xsb"
    path.write_text("######\n#@ $.#\n#    #\n######\n")
    board = open_source(str(path), tmp_path).board
    assert board is not None
    question = {"board": board.name, "horizon": 3, "sensor": "factor", "thing": 1, **kind}
    asked = BoardScene.of(msgspec.convert(question, Scene), board)
    found = scene_steps.landscape(asked)
    assert max(found["bits"]) > 0
    for view in ("landscape", "game"):
        names: dict = {}
        exec(code(asked, str(path), view, []).python, names)
        bits = names["bits"] if "bits" in names else names["landscape"].values
        if view == "game":
            row, column = asked.board.placement(asked.board.start).agent
            expected = [found["bits"][found["cells"].index((row, column))]]
        elif "bits" in names:
            expected = found["bits"]
        else:
            expected, bits = found["bits"], bits[np.isfinite(bits)]
        np.testing.assert_allclose(bits, expected, atol=2e-6)


def test_a_frozen_lake_that_is_not_slippery_leads_to_its_goal_not_to_its_holes(tmp_path: Path):
    board = open_source("gym:FrozenLake-v1?is_slippery=False", tmp_path).board
    assert board is not None
    asked = msgspec.convert({"board": board.name, "horizon": 2, **GOAL}, Scene)
    found = scene_steps.landscape(BoardScene.of(asked, board))
    at = dict(zip(found["cells"], found["bits"], strict=True))
    assert at[2, 2] > 0
    assert at[1, 1] == 0  # a hole, from which the goal cannot be reached
