"""Puzzles and environments in the studio: what it shows of them is what the library says."""

import json
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import habilis as hb
from habilis.analysis.futures import futures
from habilis.bridges.puzzles.pushworld import PushWorld, load_pushworld
from habilis.bridges.puzzles.sokoban import load_sokoban
from habilis.studio import scene_steps
from habilis.studio.board_scenes import BoardScene
from habilis.studio.boards import PuzzleBoard
from habilis.studio.messages import MessageError, read
from habilis.studio.opening import Opened, open_source
from habilis.studio.protocol.requests import Step
from habilis.studio.protocol.scenes import Placement, Scene
from studio import page, studio

LEVELS = """\
#######
#@ $. #
# $.  #
#######

#####
#@$.#
#####
"""
PUZZLES = Path(__file__).parents[3] / "shared" / "pushworld" / "puzzles"
TOOL = PUZZLES / "level1" / "Pick A Tool.pwp"
PUSH = ". . . . .\nA M0 . . G0\nA M1 . . G1\n. AW . W .\n"


@pytest.fixture
def sokoban(tmp_path: Path) -> str:
    (tmp_path / "levels.xsb").write_text(LEVELS)
    return f"{tmp_path / 'levels.xsb'}#0"


@pytest.fixture
def pushworld(tmp_path: Path) -> str:
    (tmp_path / "push.pwp").write_text(PUSH)
    return str(tmp_path / "push.pwp")


def question(opened: Opened, **asked) -> BoardScene:
    assert opened.board is not None
    return BoardScene.of(msgspec.convert({"board": opened.board.name} | asked, Scene), opened.board)


def grid(scene: BoardScene) -> np.ndarray:
    found = scene_steps.landscape(scene)
    values = np.full((scene.height, scene.width), np.nan)
    for (row, column), bits in zip(found["cells"], found["bits"], strict=True):
        values[row, column] = bits
    return values


@pytest.mark.parametrize("sensor", ["agent", "object:b1", "state"])
def test_the_landscape_of_a_sokoban_level_is_the_librarys(sokoban, tmp_path, sensor):
    opened = open_source(sokoban, tmp_path)
    assert opened.about is not None
    assert opened.about.ground.split("\n")[0] == "#######"
    of = {"sensor": "state"}
    if sensor != "state":
        of = {"sensor": "factor", "thing": opened.about.factors.index(sensor)}
    wanted = hb.landscape(load_sokoban(tmp_path / "levels.xsb", 0), 3, sensor).values
    assert np.array_equal(grid(question(opened, horizon=3, **of)), wanted, equal_nan=True)


def test_the_landscape_of_a_puzzle_is_of_the_chosen_actions_and_placement(pushworld, tmp_path):
    opened = open_source(pushworld, tmp_path)
    puzzle = PushWorld.parse(PUSH)
    asked = question(opened, horizon=2, only=[1, 3])
    wanted = hb.landscape(puzzle, 2, "state", [1, 3]).values
    assert np.array_equal(grid(asked), wanted, equal_nan=True)
    moved = asked.with_things(Placement(agent=(1, 0), tools=[], objects=[(1, 1), (3, 2)]))
    wanted = hb.landscape(puzzle, 2, "state", [1, 3], object={"m1": (3, 2)}).values
    assert np.array_equal(grid(moved), wanted, equal_nan=True)


def test_futures_of_a_puzzle_are_marked_where_its_thing_can_come(sokoban, tmp_path):
    opened = open_source(sokoban, tmp_path)
    level = load_sokoban(tmp_path / "levels.xsb", 0)
    mdp = hb.explore(level.with_cells(agent=(2, 1)), horizon=3)
    wanted = futures(mdp, mdp.start, 3, "object:b1")
    found = scene_steps.choices(question(opened, sensor="factor", thing=2, horizon=3), (2, 1))
    assert found["bits"] == wanted.empowerment
    assert [row * 7 + column for row, column, _ in found["things"]] == list(wanted.observations)
    seen = scene_steps.choices(question(opened, sensor="state", horizon=3), (2, 1))
    assert (2, 1) in [(row, column) for row, column, _ in seen["things"]]  # where the agent may be
    with pytest.raises(ValueError, match=r"the agent cannot be in \(0, 0\)"):
        scene_steps.choices(question(opened), (0, 0))


def test_a_plan_of_a_puzzle_is_played_action_by_action(pushworld, tmp_path):
    opened = open_source(pushworld, tmp_path)
    assert opened.about is not None
    scene, now = question(opened, horizon=2), opened.about.start
    plan = scene_steps.plan(scene)
    wanted = hb.solve(PushWorld.parse(PUSH))
    assert wanted is not None
    assert plan["actions"] == list(wanted.actions)
    ended = False
    for action, then in zip(plan["actions"], plan["placements"][1:], strict=True):
        assert not ended
        answer = scene_steps.step(scene, now, action)
        now, ended = answer["placement"], answer["ended"]
        assert now == then
        assert answer["reward"] == (0 if ended else -1)
    assert ended
    goals = [thing.goals for thing in opened.about.objects]
    assert all(cell in goal for cell, goal in zip(now.objects, goals, strict=True))
    assert scene_steps.step(scene, now, None)["ended"]


@pytest.mark.skipif(not TOOL.exists(), reason="needs the puzzles of PushWorld")
def test_a_puzzle_of_pushworlds_own_is_shown(tmp_path):
    opened = open_source(str(TOOL), tmp_path)
    assert opened.about is not None
    assert len(opened.about.objects) == 5
    assert opened.about.agent.drawing  # of several cells
    wanted = hb.landscape(load_pushworld(TOOL), 2, "object:m0").values
    thing = opened.about.factors.index("object:m0")
    found = grid(question(opened, sensor="factor", thing=thing, horizon=2))
    assert np.array_equal(found, wanted, equal_nan=True)


def test_frozen_lake_is_stochastic_and_drawn_by_itself(tmp_path):
    pytest.importorskip("pygame")
    opened = open_source("gym:FrozenLake-v1", tmp_path)
    assert opened.about is not None
    assert opened.about.random
    assert opened.about.image is not None
    assert opened.image is not None
    assert opened.about.image.startswith("data:image/png;base64,")
    assert opened.image(0) != opened.image(1)
    scene = question(opened, sensor="factor", horizon=2)
    assert scene.is_stochastic
    wanted = hb.landscape(hb.TabularMDP.from_gymnasium(lake()), 2, "agent").values
    assert np.allclose(grid(scene), wanted, atol=1e-6)
    with pytest.raises(ValueError, match="stochastic: it has no shortest plan"):
        scene_steps.plan(scene)


def lake():
    import gymnasium

    return gymnasium.make("FrozenLake-v1")


def test_minigrid_is_measured_with_everything_but_the_agent_where_it_is(tmp_path):
    pytest.importorskip("minigrid")
    opened = open_source("gym:minigrid:MiniGrid-DoorKey-5x5-v0", tmp_path)
    assert opened.about is not None
    assert opened.about.actions[2] == "forward"
    scene = question(opened, sensor="state", horizon=2)
    mdp = scene.board.around([], 0)[0]
    start = opened.about.start
    assert isinstance(start.state, int)
    bits = hb.empowerment(mdp, 2, states=[start.state])[0]
    assert grid(scene)[start.agent] == bits
    answer = scene_steps.step(scene, start, 1)
    assert answer["placement"].agent == start.agent
    assert answer["placement"].state == mdp.next_state[start.state, 1]
    direction = opened.about.factors.index("direction")
    seen = scene_steps.choices(
        question(opened, sensor="factor", thing=direction, horizon=1), (3, 1)
    )
    assert (seen["things"], seen["elsewhere"], seen["count"]) == ([], 1.0, 3)
    plan = scene_steps.plan(scene)
    assert plan["steps"] == 11
    assert mdp.terminal[plan["placements"][-1].state]


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("gym:Taxi-v4", "shows environments that have a factor agent on a grid"),
        ("gym:Blackjack-v1", "gym:Blackjack-v1"),
        ("none.pwp", "none.pwp"),
        ("levels.xsb#7", "level is 7; the file has 2"),
        ("wide.xsb", "has 3 x 61 cells; the studio shows up to 60 a side"),
        ("many.xsb", "factors; the studio shows up to 64"),
        ("large.txt", "has 4 x 31 cells; draw 4 to 30 a side"),
        ("other.txt", "the page cannot represent the reading 'pushes'"),
        ("five.txt", "the studio shows up to 4 tools and objects"),
        ("none.txt", "none.txt"),
    ],
)
def test_what_cannot_be_shown_is_refused_in_a_line(tmp_path, monkeypatch, source, words):
    monkeypatch.chdir(tmp_path)
    Path("levels.xsb").write_text(LEVELS)
    Path("wide.xsb").write_text(f"{'#' * 61}\n#@$.{' ' * 56}#\n{'#' * 61}\n")
    boxes = "$" * 30
    Path("many.xsb").write_text(f"{'#' * 32}\n#@{boxes}\n#{boxes}\n#{boxes}.\n{'#' * 32}\n")
    Path("large.txt").write_text(f"AC{'.' * 28}G\n" + f"{'.' * 31}\n" * 3)
    Path("other.txt").write_text("P = picker pushes\nAP..\n.C.G\n....\n....\n")
    binds = "".join(f"{mark} = picker\n" for mark in "QRSTU")
    Path("five.txt").write_text(f"{binds}G = goal of C\nAQRST\nUC.G.\n.....\n.....\n")
    with pytest.raises(ValueError, match=r".") as refused:
        open_source(source, tmp_path)
    assert words in str(refused.value)
    assert len(str(refused.value).splitlines()) == 1


@pytest.mark.parametrize("terminal", [True, False])
def test_a_terminal_shows_the_progress_of_an_environment(tmp_path, monkeypatch, terminal):
    asked = []

    def table_named(name, max_states, **options):
        asked.append(options)
        raise ValueError("too large")

    monkeypatch.setattr("habilis.bridges.gymnasium.named.table_named", table_named)
    monkeypatch.setattr("sys.stderr.isatty", lambda: terminal, raising=False)
    with pytest.raises(ValueError, match="too large"):
        open_source("gym:CartPole-v1", tmp_path)
    assert asked == [{"show_progress": terminal}]


def test_a_map_s_file_is_the_world_that_pages_begin_with(tmp_path):
    (tmp_path / "map.txt").write_text("AP..\n.C.G\n....\n....\n")
    opened = open_source(str(tmp_path / "map.txt"), tmp_path)
    assert opened.world is not None
    assert opened.world.object == (1, 1)
    assert open_source("yard", tmp_path).world == hb.load_world("yard")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"board": "other"}, "there is no board 'other'; start the studio with"),
        ({"map": "AC.G"}, "scene has a board; leave out map, drawn and tool"),
        ({"sensor": "tool"}, "sensor is 'tool'; of a board, give state or factor"),
        ({"sensor": "factor", "thing": 3}, "thing is 3; give a whole number from 0 to 2"),
        ({"actions": "moves"}, "actions is for maps; of a board, give only"),
        ({"only": []}, "only is []; give indices of actions from 0 to 3"),
        ({"only": [4]}, "only is [4]; give indices of actions from 0 to 3"),
        ({"horizon": 11}, "scene.horizon is 11; give a whole number from 0 to 10"),
    ],
)
def test_an_invalid_question_about_a_board_is_one_line(sokoban, tmp_path, change, words):
    board = open_source(sokoban, tmp_path).board
    assert board is not None
    asked = {"id": 1, "do": "measure", "scene": {"board": board.name} | change}
    with pytest.raises(MessageError, match=r".") as refused:
        read(msgspec.json.encode(asked).decode(), (), board)
    assert words in str(refused.value)


@pytest.mark.parametrize(
    ("at", "words"),
    [
        (Placement((1, 1), [], [(1, 3)]), "placement has 0 tools and 1 objects"),
        (Placement((1, 1), [], [(1, 3), (9, 9)]), r"the cell \(9, 9\) is outside the board"),
        (Placement((1, 1), [], [(1, 3), (1, 3)]), "levels.xsb#0"),
    ],
)
def test_a_placement_that_no_puzzle_has_is_refused(sokoban, tmp_path, at, words):
    with pytest.raises(ValueError, match=words):
        scene_steps.step(question(open_source(sokoban, tmp_path)), at, 0)


NUMBERS = st.integers(-2, 9) | st.sampled_from([2**31, 2**53, 0.5, None, "x", []])
CELLS = st.lists(NUMBERS, max_size=3)


@settings(max_examples=300, deadline=None)
@given(
    st.fixed_dictionaries(
        {},
        optional={
            "sensor": st.sampled_from(["state", "factor", "object", "agent"]),
            "thing": NUMBERS,
            "only": CELLS,
            "horizon": st.integers(-1, 3),
            "slip": st.sampled_from([0, 0.1, 2]),
        },
    ),
    st.fixed_dictionaries(
        {"agent": CELLS, "tools": st.just([]), "objects": st.lists(CELLS, max_size=3)},
        optional={"state": NUMBERS, "held": NUMBERS},
    ),
    NUMBERS,
)
def test_whatever_is_asked_of_a_board_is_answered_or_one_line_of_error(asked, at, action):
    board = PuzzleBoard(PushWorld.parse(PUSH, "push"))
    scene = {"board": "push"} | asked
    message = {"id": 1, "do": "step", "scene": scene, "placement": at, "action": action}
    try:
        request, found = read(json.dumps(message), (), board)
        assert isinstance(request, Step)
        assert found is not None
        answer = scene_steps.step(found, request.placement, request.action)
        said = ""
        assert board.state(answer["placement"])
    except ValueError as error:
        said = str(error)
    assert len(said.splitlines()) <= 1
    assert len(said) < 500


def test_a_studio_answers_about_its_board_and_about_maps(sokoban):
    with studio(sokoban) as address, page(address) as there:
        about = there.hello["board"]
        asked = {"board": about["name"], "sensor": "state", "horizon": 2}
        answer = there.ask("measure", scene=asked)
        level = load_sokoban(sokoban.partition("#")[0], 0)
        values = [[np.nan if v is None else v for v in row] for row in answer["landscape"]]
        assert np.array_equal(values, hb.landscape(level, 2).values, equal_nan=True)
        found = there.ask("step", scene=asked, placement=about["start"], action=1)
        assert found["placement"]["agent"] == [1, 2]
        assert there.ask("solve", scene=asked)["steps"] == 4
        assert "bits" in there.ask("futures", scene=asked, agent=[1, 1])
        assert "a board has no map" in there.ask("read", scene=asked)["error"]
        assert "a board has no map" in there.ask("train", scene=asked, settings={})["error"]
        yard = {"drawn": there.hello["worlds"]["yard"], "horizon": 3}
        numbers = {there.send("measure", scene=one) for one in (yard, asked)}
        while numbers:  # neither overtakes the other
            answer = there.receive()
            assert "overtaken" not in answer
            numbers -= {answer["id"]} if "landscape" in answer else set()


def test_a_studio_sends_the_picture_of_every_state_of_an_environment():
    pytest.importorskip("pygame")
    with studio("gym:FrozenLake-v1?is_slippery=false") as address, page(address) as there:
        about = there.hello["board"]
        asked = {"board": about["name"], "sensor": "state", "horizon": 2}
        found = there.ask("step", scene=asked, placement=about["start"], action=2)
        assert found["placement"]["agent"] == [0, 1]
        assert found["image"].startswith("data:image/png;base64,")
        assert found["image"] != about["image"]
        assert there.ask("solve", scene=asked)["steps"] == 6
