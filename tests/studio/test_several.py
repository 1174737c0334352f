"""The studio on worlds of several tools and objects."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

import habilis as hb
from habilis.analysis.averages import compare
from habilis.studio.drawn_worlds import drawn_of, world_of
from habilis.studio.protocol.scenes import Drawn, Placement
from habilis.worlds.placements import start_of
from habilis.worlds.reach import reachable
from habilis.worlds.tools import TOOLS
from studio import scene

WORLD = hb.World.parse(
    "R = rake\nD = ball\nH = goal of D\nG = goal of C\ndrop: true\nAP...\n.#C..\n.D..R\n.H..G",
    "map",
)
START = Placement(
    agent=WORLD.agent,
    tools=[tool.cell for tool in WORLD.tools],
    objects=[thing.cell for thing in WORLD.objects],
    held=0,
    laid=-1,
)


def drawn(world: hb.World, **measured):
    """As the page says it."""
    return {"drawn": msgspec.to_builtins(drawn_of(world)), "horizon": 2} | measured


def landscape(there, asked):
    answer = there.ask("landscape", scene=asked)
    return np.array([[np.nan if v is None else v for v in row] for row in answer["landscape"]])


def test_what_is_drawn_is_the_world():
    assert world_of(drawn_of(WORLD), TOOLS, "map") == WORLD
    bare = WORLD.with_tool("none").with_object("ball")
    again = world_of(drawn_of(bare), TOOLS, "map")
    assert (again.objects[0].kind, again.goal, again.tools) == ("ball", bare.goal, ())


def test_things_in_whatever_order_are_the_same_world():
    said = drawn_of(WORLD)
    turned = msgspec.structs.replace(said, tools=said.tools[::-1], objects=said.objects[::-1])
    assert world_of(turned, TOOLS, "map") == WORLD


def test_things_travel_by_their_index_in_the_drawing_whatever_its_order(there):
    asked, at = drawn(WORLD, sensor="object", thing=1), msgspec.to_builtins(START)
    turned = drawn(WORLD, sensor="object", thing=0)
    for name in ("tools", "objects"):
        turned["drawn"][name] = turned["drawn"][name][::-1]
    assert landscape(there, turned) == pytest.approx(landscape(there, asked), nan_ok=True)
    now, then = dict(at), at | {name: at[name][::-1] for name in ("tools", "objects")} | {"held": 1}
    for action in (5, 8, 1, 2, 2):
        now = there.ask("step", scene=asked, placement=now, action=action)["placement"]
        then = there.ask("step", scene=turned, placement=then, action=action)["placement"]
        assert then["agent"] == now["agent"]
        assert then["tools"] == now["tools"][::-1]
        assert then["objects"] == now["objects"][::-1]
        for hand in ("held", "laid"):
            assert then[hand] == (1 - now[hand] if now[hand] >= 0 else -1)
    plan = there.ask("solve", scene=turned)
    assert plan["placements"][-1]["objects"] == [[3, 1], [3, 4]]


def test_map_text_is_read_and_written_by_the_library(there):
    read = there.ask("read", scene={"map": WORLD.text()})
    assert msgspec.convert(read["drawn"], Drawn) == drawn_of(WORLD)
    assert hb.World.parse(read["text"], "map") == WORLD
    assert there.ask("read", scene={"drawn": read["drawn"]})["text"] == read["text"]


@pytest.mark.parametrize(
    ("sensor", "thing", "factor"),
    [
        ("object", 0, "object:can"),
        ("object", 1, "object:ball"),
        ("tool", 1, "tool:rake"),
        ("agent", 0, "agent"),
        ("state", 0, "state"),
    ],
)
def test_the_landscape_is_of_the_thing_that_is_picked(there, sensor, thing, factor):
    wanted = hb.landscape(WORLD, 2, factor).values
    found = landscape(there, drawn(WORLD, sensor=sensor, thing=thing))
    assert np.array_equal(found, wanted, equal_nan=True)


def test_averages_are_of_each_tool_alone_over_the_object_that_is_picked(there):
    averages = {}
    for answer in there.answers(
        there.send("measure", scene=drawn(WORLD, sensor="object", thing=1))
    ):
        averages |= answer.get("averages", {})
        if len(averages) == len(TOOLS) + 1:
            break
    held = replace(WORLD.with_object("ball"), drop=False)
    assert averages == compare(held, [*TOOLS, "none"], 2)


def test_play_keeps_what_is_in_hand(there):
    mdp, states = reachable(WORLD, start_of(WORLD), None)
    state = int(states[0])
    now = there.ask("step", scene=drawn(WORLD), placement=at(mdp, state), action=None)
    assert now["equipped"]
    random = np.random.default_rng(0)
    for action in random.integers(9, size=60):
        now = there.ask("step", scene=drawn(WORLD), placement=now["placement"], action=int(action))
        state = int(mdp.next_state[state, action])
        assert now["placement"] == at(mdp, state)
        assert now["ended"] == mdp.terminal[state]


def at(mdp: hb.TabularMDP, state: int) -> dict:
    """As a message has it, in the map's order."""
    agent, can, ball, picker, rake = (
        list(divmod(int(mdp.factor(name)[state]), WORLD.width))
        for name in ("agent", "object:can", "object:ball", "tool:picker", "tool:rake")
    )
    hands = {name: int(mdp.factor(name)[state]) for name in ("held", "laid")}
    return {"agent": agent, "tools": [picker, rake], "objects": [can, ball]} | hands


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"tools": []}, "placement has 0 tools and 2 objects; the scene has 2 and 2: give a cell"),
        ({"held": 2}, "held is 2; give the index of a tool, or -1 for none"),
        ({"held": 4}, "placement.held is 4; give a whole number from -1 to 3"),
        ({"tool:rake": [0, 0]}, "placement has 'tool:rake', which is unknown; it may have agent"),
        ({"objects": [[1, 2], 3]}, "placement.objects[1] has 3; give a cell as [row, column]"),
    ],
)
def test_a_placement_of_other_things_is_refused(there, change, words):
    placement = msgspec.to_builtins(START) | change
    answer = there.ask("step", scene=drawn(WORLD), placement=placement, action=0)
    assert words in answer["error"]


def test_a_plan_brings_every_object_to_its_goal(there):
    answer = there.ask("solve", scene=drawn(WORLD))
    plan = hb.solve(hb.tabulate(WORLD))
    assert plan is not None
    assert answer["actions"] == list(plan.actions)
    end = answer["placements"][-1]
    assert end["objects"] == [list(thing.goal) for thing in WORLD.objects if thing.goal]


def test_a_tool_that_fails_now_and_then_fails_in_play_and_in_the_landscape(there):
    world = hb.World.parse("P = picker slip 0.5\n.....\nAP.CG\n.....\n.....", "map")
    asked = drawn(world, sensor="object", horizon=2)
    assert landscape(there, asked) == pytest.approx(
        hb.landscape(world, 2, "object").values, abs=1e-5, nan_ok=True
    )
    at = {"agent": [1, 1], "tools": [[1, 2]], "objects": [[1, 3]]}
    ends = [there.ask("step", scene=asked, placement=at, action=1)["ended"] for _ in range(40)]
    assert 5 < sum(ends) < 35  # fails once in a hundred million runs


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"tools": [{"kind": "os:path", "cell": [0, 1]}]}, "tool 'os:path' is unknown"),
        ({"tools": [{"kind": "rake", "cell": [1, 1]}]}, "the rake is at (1, 1); put it on a free"),
        ({"objects": []}, "scene.drawn.objects is []; give a list of 1 to 4"),
        ({"objects": [{"kind": "can", "cell": [1, 2]}]}, "the first object, the can, has no goal"),
        ({"agent": [0, 1]}, "share a cell; give each its own"),
        ({"ground": "..\n..."}, "ground is not a map"),
        ({"drop": 1}, "drop is 1; give true or false"),
    ],
)
def test_an_invalid_drawing_is_reported(there, change, words):
    asked = drawn(WORLD)
    asked["drawn"] |= change | ({"drop": False} if "tools" in change else {})
    assert words in there.ask("landscape", scene=asked)["error"]


def test_a_scene_has_one_map(there):
    assert "scene has no map" in there.ask("landscape", scene={})["error"]
    both = drawn(WORLD) | scene(WORLD)
    assert "scene has no map" in there.ask("landscape", scene=both)["error"]


def test_with_a_tool_that_may_fail_there_is_no_plan_and_why(there):
    for world in (hb.load_world("yard"), WORLD):
        asked = drawn(world)
        asked["drawn"]["tools"][0]["slip"] = 0.5
        error = there.ask("solve", scene=asked)["error"]
        assert "a stochastic world has no shortest plan" in error


def test_what_a_map_s_text_would_hide_is_not_lost_in_training(there):
    asked = drawn(WORLD)
    asked["drawn"]["agent"] = asked["drawn"]["objects"][0]["goal"]
    wanted = "something else is on the goal at (3, 4)"
    assert wanted in there.ask("read", scene=asked)["error"]
    settings = {"episodes": 2, "runs": 1, "intrinsic": "none"}
    assert wanted in there.ask("train", scene=asked, settings=settings)["error"]
