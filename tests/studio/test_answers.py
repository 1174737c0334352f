"""The studio's answers agree with the library."""

import re

import msgspec
import numpy as np
import pytest

import habilis as hb
from habilis.analysis.averages import compare
from habilis.analysis.futures import futures
from habilis.analysis.usefulness import usefulness
from habilis.studio.drawn_worlds import world_of
from habilis.studio.protocol.scenes import Drawn
from habilis.worlds.tools import TOOLS
from studio import page, printing_rake, scene, studio

WALLED = hb.World.parse("AP...\n.#C..\n.#..#\n....G", "map")


def values(answer):
    return np.array([[np.nan if v is None else v for v in row] for row in answer["landscape"]])


def test_a_page_gets_the_available_choices(there):
    assert there.hello["version"] == hb.__version__
    assert there.hello["tools"] == [*TOOLS, "none"]
    assert there.hello["objects"] == ["can", "ball", "crate"]
    assert there.hello["limits"]["side"] == [4, 30]
    assert len(there.hello["actions"]) == 9
    for name, drawn in there.hello["worlds"].items():
        assert world_of(msgspec.convert(drawn, Drawn), TOOLS, name) == hb.load_world(name)
    path, fill = there.hello["shapes"]["can"][0]
    assert path.startswith("M")
    assert fill.startswith("#")


@pytest.mark.parametrize("tool", ["picker", "broom", "none"])
@pytest.mark.parametrize("sensor", ["state", "object", "agent"])
@pytest.mark.parametrize("horizon", [0, 1, 4])
def test_a_landscape_is_the_librarys(there, tool, sensor, horizon):
    world = WALLED.with_tool(tool)
    answer = there.ask("measure", scene=scene(world, sensor=sensor, horizon=horizon))
    wanted = hb.landscape(world, horizon, sensor).values
    assert np.array_equal(values(answer), wanted, equal_nan=True)
    assert (answer["least"], answer["most"]) == (np.nanmin(wanted), np.nanmax(wanted))


@pytest.mark.parametrize("tool", ["picker", "none"])
def test_a_landscape_may_be_asked_for_alone_and_with_things_elsewhere(there, tool):
    world = WALLED.with_tool(tool)
    asked = scene(world, sensor="object", horizon=3)
    at = {"agent": [3, 4], "tools": [[3, 3]] if tool != "none" else [], "objects": [[0, 2]]}
    alone = there.send("landscape", scene=asked)
    assert "landscape" in next(there.answers(alone))
    elsewhere = there.send("landscape", scene=asked, placement=at)
    answer = there.receive()  # the first of them has said all there was to say
    assert answer["id"] == elsewhere
    at_tool = (3, 3) if tool != "none" else None
    moved = world.with_cells(agent=(3, 4), object=(0, 2), tool=at_tool)
    wanted = hb.landscape(moved, 3, "object").values
    assert np.array_equal(values(answer), wanted, equal_nan=True)
    at["objects"] = [[1, 1]]
    refusal = there.ask("landscape", scene=asked, placement=at)["error"]
    assert "the can is at (1, 1); put it on a free cell" in refusal


@pytest.mark.parametrize(("actions", "indices"), [("moves", range(4)), ("tool", range(4, 8))])
def test_actions_are_those_that_are_chosen(there, actions, indices):
    world = hb.load_world("corridor")
    answer = there.ask("measure", scene=scene(world, sensor="object", horizon=5, actions=actions))
    wanted = hb.landscape(world, 5, "object", list(indices)).values
    assert np.array_equal(values(answer), wanted, equal_nan=True)


def test_chosen_cells_are_distinguished_and_all_others_are_one(there):
    mdp = hb.tabulate(WALLED)
    cells = [mdp.label((1, 2)), mdp.label((1, 3))]
    labels = np.where(np.isin(mdp.factor("object"), cells), mdp.factor("object"), -1)
    asked = scene(WALLED, sensor="cells", cells=[[1, 2], [1, 3]], horizon=4)
    wanted = hb.landscape(WALLED, 4, labels, mdp=mdp).values
    assert np.array_equal(values(there.ask("measure", scene=asked)), wanted, equal_nan=True)
    seen = there.ask("futures", scene=asked, agent=[0, 2])
    probability = {(r, c): p for r, c, p in seen["things"]}
    assert set(probability) <= {(1, 2), (1, 3)}
    assert sum(probability.values()) + seen["elsewhere"] == pytest.approx(1)


def test_a_landscape_may_be_stochastic(there):
    world = WALLED.with_tool("none")
    progress, answer = [], {}
    number = there.send("measure", scene=scene(world, sensor="object", horizon=2, slip=0.2))
    for answer in there.answers(number):
        if "landscape" in answer:
            break
        progress.append(answer["progress"])
    wanted = hb.landscape(world, 2, "object", slip=0.2).values
    assert np.allclose(values(answer), wanted, atol=1e-6, equal_nan=True)
    assert progress == sorted(progress)
    assert progress[-1] == 1


def test_averages_and_verdicts_are_the_librarys(there):
    world = hb.load_world("yard")
    number = there.send("measure", scene=scene(world, horizon=3))
    averages, verdicts = {}, {}
    for answer in there.answers(number):
        averages |= answer.get("averages", {})
        verdicts |= answer.get("verdicts", {})
        if len(averages) == len(TOOLS) + 1 and len(verdicts) == len(TOOLS):
            break
    assert averages == compare(world, [*TOOLS, "none"], 3)
    for tool, verdict in verdicts.items():
        judged = usefulness(world.with_tool(tool), 3)
        assert verdict["useful"] == judged.useful_on_average
        assert verdict["better_than_none"] == judged.better_than_none_on_average


def test_where_no_tool_makes_a_difference_each_is_a_tie(there):
    yard = hb.load_world("yard")
    found = reported(there, scene(yard, horizon=0), tools=len(TOOLS) + 1)
    assert set(found["averages"].values()) == {0.0}
    tie = {"useful": False, "better_than_none": False, "equal": True}
    assert found["verdicts"] == dict.fromkeys(TOOLS, tie)


def test_a_map_without_a_tool_has_the_average_of_the_bare_agent(there):
    world = hb.World.parse("AC..\n....\n....\n...G")
    answers = there.answers(there.send("measure", scene=scene(world)))
    averages = next(a["averages"] for a in answers if "averages" in a)
    assert averages == compare(world, ["none"], 2)


def test_a_tool_that_cannot_be_held_has_no_average(there):
    world = hb.World.parse("A#P#\n#C##\n####\n###G").with_tool("picker")
    averages, whys = {}, set()
    for answer in there.answers(there.send("measure", scene=scene(world))):
        averages |= answer.get("averages", {})
        whys |= {answer["why"]} if "why" in answer else set()
        if len(averages) == len(TOOLS) + 1:
            break
    assert averages == dict.fromkeys(TOOLS) | {"none": 0.0}
    assert whys == {"there is no room to hold the tool; leave two free cells side by side"}


def test_what_takes_too_long_says_so_in_the_words_of_the_page(there):
    number = there.send("measure", scene=scene(hb.load_world("yard"), horizon=9, slip=0.3))
    refusal = next(a for a in there.answers(number) if "error" in a)["error"]
    assert re.fullmatch(r"with slip, 9 steps ahead take too long here; up to \d do not", refusal)


def test_averages_of_a_small_stochastic_world_are_exact(there):
    world = hb.World.parse("AP..\n.C..\n...G\n####")
    found = reported(there, scene(world, horizon=2, slip=0.2), tools=len(TOOLS) + 1)
    wanted = compare(world, [*TOOLS, "none"], 2, slip=0.2)
    assert found["averages"] == pytest.approx(wanted, abs=1e-5)
    assert set(found["within"].values()) == {0.0}
    for tool, verdict in found["verdicts"].items():
        better = wanted[tool] > wanted["none"]
        assert verdict == {"useful": True, "better_than_none": better, "equal": False}


def reported(there, asked: dict, tools: int) -> dict[str, dict]:
    """The averages, once all tools have one."""
    found: dict[str, dict] = {"averages": {}, "within": {}, "verdicts": {}}
    for answer in there.answers(there.send("measure", scene=asked)):
        for name, known in found.items():
            known |= answer.get(name, {})
        if len(found["averages"]) == tools:
            return found
    raise AssertionError(found)


@pytest.mark.parametrize("sensor", ["state", "object", "tool", "agent"])
def test_futures_are_the_librarys(there, sensor):
    mdp = hb.tabulate(WALLED)
    state = mdp.find(agent=(0, 2), tool=(0, 1), object=(1, 2))
    wanted = futures(mdp, state, 3, sensor)
    answer = there.ask("futures", scene=scene(WALLED, sensor=sensor, horizon=3), agent=[0, 2])
    assert answer["bits"] == wanted.empowerment
    assert answer["count"] == len(wanted.observations)
    factor = mdp.factor("object")[wanted.observations] if sensor == "state" else wanted.observations
    probability = np.bincount(factor, wanted.seen, 20).reshape(4, 5)
    reported = np.zeros((4, 5))
    for row, column, share in answer["things"]:
        reported[row, column] = share
    assert np.allclose(reported, probability)


def test_the_shortest_plan_is_the_librarys_and_stepping_through_it_ends_at_the_goal(there):
    world = hb.load_world("corridor")
    asked = scene(world, sensor="object", horizon=3)
    plan, wanted = there.ask("solve", scene=asked), hb.solve(hb.tabulate(world))
    assert wanted is not None
    assert (plan["steps"], plan["actions"]) == (wanted.steps, list(wanted.actions))
    mdp, now = hb.tabulate(world), plan["placements"][0]
    bits = hb.empowerment(mdp, 3, "object")
    then_all = plan["placements"][1:]
    for action, state, then in zip(plan["actions"], wanted.states[1:], then_all, strict=True):
        answer = there.ask("step", scene=asked, placement=now, action=action)
        now = answer["placement"]
        assert now == then
        assert answer["bits"] == bits[state]
        assert answer["equipped"] == mdp.flags["equipped"][state]
        assert answer["attached"] == mdp.flags["attached"][state]
        assert (answer["ended"], answer["reward"]) == (
            (True, 0) if then == plan["placements"][-1] else (False, -1)
        )


def test_no_action_requests_the_bits_of_a_placement(there):
    at = {"agent": [0, 0], "tools": [[0, 1]], "objects": [[1, 2]]}
    answer = there.ask("step", scene=scene(WALLED, sensor="object"), placement=at, action=None)
    assert answer["placement"] == at
    assert answer["reward"] is None
    assert answer["bits"] == hb.empowerment(WALLED, 2, "object", states=[WALLED_AT])[0]


WALLED_AT = {"agent": (0, 0), "tool": (0, 1), "object": (1, 2)}


def test_a_goal_out_of_reach_has_no_plan(there):
    world = hb.World.parse("AC#G\n..##\n....\n....")
    assert there.ask("solve", scene=scene(world))["steps"] is None


def test_a_newer_request_overtakes_an_older_one_of_its_kind_and_no_other(there):
    large = hb.World.parse("\n".join(["AP.CG" + "." * 25] + ["." * 30] * 29))
    slow = scene(large, horizon=10, slip=0.0)
    first = there.send("measure", scene=slow)
    hover = there.send("futures", scene=scene(WALLED), agent=[0, 2])
    second = there.send("measure", scene=scene(WALLED))
    answers = {first: [], hover: [], second: []}
    while not any("landscape" in a for a in answers[second]) or not answers[hover]:
        answer = there.receive()
        answers[answer["id"]].append(answer)
    assert answers[first][-1] == {"id": first, "overtaken": True}
    assert "bits" in answers[hover][0]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"map": "AP?CG"}, "map, line 1, column 3: unknown character '?'"),
        ({"map": "AP.CG\n..."}, "the row has 3 cells and the first row has 5"),
        ({"map": "AP.CG"}, "has 1 x 5 cells; draw 4 to 30 a side"),
        ({"map": "A..CG\n" + ".....\n" * 4}, "the map has no tool whose place a picker could take"),
        ({"map": "R = os:path\nAR.CG"}, "line 1: binds a character to a file"),
        ({"tool": "os:path"}, "tool 'os:path' is unknown; use one of picker, broom, rake"),
        ({"horizon": 11}, "horizon is 11; give a whole number from 0 to 10"),
        ({"horizon": 2.5}, "horizon is 2.5; give a whole number"),
        ({"slip": 0.6}, "slip is 0.6; give a finite number from 0 to 0.5"),
        (
            {"sensor": "smell"},
            "sensor is 'smell'; give one of agent, cells, factor, object, state, tool",
        ),
        ({"tool": "none", "actions": "tool"}, "actions has 4; use indices from 0 to 3"),
        ({"sensor": "factor"}, "the sensor 'factor' is for boards; give another"),
        ({"only": [0]}, "only is for boards; give actions"),
        ({"colour": 1}, "scene has 'colour', which is unknown"),
    ],
)
def test_an_invalid_scene_gets_the_librarys_error(there, change, words):
    answer = there.ask("measure", scene=scene(WALLED) | change)
    assert words in answer["error"]
    assert "\n" not in answer["error"]


def test_a_step_from_where_nothing_can_be_is_refused(there):
    at = {"agent": [1, 1], "tools": [[0, 1]], "objects": [[1, 2]]}
    answer = there.ask("step", scene=scene(WALLED), placement=at, action=0)
    assert answer["error"] == "the agent's cell (1, 1) is a wall; give a free one"


def test_a_tool_of_ones_own_is_as_good_as_any(tmp_path):
    name = printing_rake(tmp_path)
    with studio("--tool", name) as address, page(address) as there:
        assert there.hello["tools"] == [*TOOLS, name, "none"]
        world = WALLED.with_tool(name)
        answer = there.ask("measure", scene=scene(world, sensor="object", horizon=3))
        wanted = hb.landscape(world, 3, "object").values
        assert f"R = {name}" in scene(world)["map"]
        assert np.array_equal(values(answer), wanted, equal_nan=True)
        picker = there.ask(
            "measure", scene=scene(world, sensor="object", horizon=3) | {"tool": "picker"}
        )
        wanted = hb.landscape(WALLED.with_tool("picker"), 3, "object").values
        assert np.array_equal(values(picker), wanted, equal_nan=True)
