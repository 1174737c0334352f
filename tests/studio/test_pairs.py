"""Which tool for which object, in the studio: the values are those of `pairs`."""

import msgspec
import numpy as np
import pytest

import habilis as hb
from habilis.studio.drawn_worlds import drawn_of
from habilis.studio.limits import PAIR
from habilis.studio.pairs import pair, rows_of
from habilis.studio.protocol.scenes import Scene as Asked
from habilis.studio.scenes import Scene
from habilis.worlds.tools import TOOLS
from studio import scene

WORLD = hb.World.parse(
    "R = rake slip 0.3\nD = ball\nG = goal of C\nAP...\n.#C..\n.D..R\n....G", "map"
)
OTHERS = tuple(name for name in TOOLS if name not in ("picker", "rake"))
MEASURES = ("range", "latency", "median_latency", "persistence", "reliability")


def drawn(world: hb.World, **asked):
    return {"drawn": msgspec.to_builtins(drawn_of(world)), "horizon": 3} | asked


def scene_of(world: hb.World, **asked) -> Scene:
    return Scene.of(msgspec.convert(drawn(world, **asked), Asked), TOOLS)


@pytest.mark.parametrize(("tool", "object"), [("rake", "can"), ("none", "ball"), ("broom", "ball")])
def test_a_pair_is_the_librarys(tool, object):
    wanted = hb.pairs(WORLD, 2, [tool], [object])
    found = pair(scene_of(WORLD, horizon=2), tool, object)
    assert found["averages"] == wanted.averages[:, 0, 0].tolist()
    for name in MEASURES:
        value = getattr(wanted, name)[0, 0]
        assert found[name] == (value if np.isfinite(value) else None)


def test_rows_are_the_maps_own_tools_then_all_others_then_none():
    rows = rows_of(scene_of(WORLD), tuple(TOOLS))
    assert [row.name for row in rows] == ["picker", "rake", *OTHERS, "none"]
    two = hb.World.parse("Q = picker slip 0.5\nG = goal of C\nAPQ.\n.C..\n....\n...G", "map")
    rows = rows_of(scene_of(two), tuple(TOOLS))
    assert [row.name for row in rows[:2]] == ["picker", "picker2"]
    assert [row.kind for row in rows[:2]] == ["picker", "picker"]
    assert rows[0].acts != rows[1].acts  # one may fail
    bare = hb.World.parse("AC..\n....\n....\n...G", "map")
    assert [row.name for row in rows_of(scene_of(bare), tuple(TOOLS))] == ["none"]


def test_without_steps_ahead_a_comparison_begins_with_one():
    assert len(pair(scene_of(WORLD, horizon=0), "picker", "can")["averages"]) == 1


def test_slip_lowers_reliability():
    room = hb.World.parse("AP..\n.C..\n...G\n####", "map")
    found = pair(scene_of(room, slip=0.2, horizon=2), "picker", "can")
    wanted = hb.pairs(room, 2, ["picker"], slip=0.2)
    assert found["reliability"] == pytest.approx(float(wanted.reliability[0, 0]), abs=1e-5)
    assert 0 < found["reliability"] < 1


def test_a_map_that_is_too_large_for_a_comparison_is_refused_with_the_way_out():
    rows = ["AP.CG" + "." * 25] + ["." * 30] * 29
    large = hb.World.parse("\n".join(rows), "map")
    with pytest.raises(ValueError, match="use habilis compare --pairs") as refused:
        pair(scene_of(large), "picker", "can")
    assert f"up to {PAIR:,}" in str(refused.value)
    assert "3,240,000 placements" in str(refused.value)


def received(there, **asked):
    """The names, and the pairs by tool and object."""
    found, names = {}, None
    for answer in there.answers(there.send("pairs", **asked)):
        assert "error" not in answer, answer
        names = answer if "tools" in answer else names
        if "pair" in answer:
            found[answer["pair"]["tool"], answer["pair"]["object"]] = answer["pair"]
        if names and len(found) == len(names["tools"]) * len(names["objects"]):
            return names, found
    raise AssertionError


def test_a_page_gets_every_pair_in_the_order_of_its_drawing(there):
    asked = drawn(WORLD, horizon=2)
    for name in ("tools", "objects"):
        asked["drawn"][name] = asked["drawn"][name][::-1]
    names, found = received(there, scene=asked)
    assert [tool["name"] for tool in names["tools"]] == ["rake", "picker", *OTHERS, "none"]
    assert (names["objects"], names["horizon"]) == (["ball", "can"], 2)
    wanted = hb.pairs(WORLD, 2, [tool["name"] for tool in names["tools"]], names["objects"])
    for (tool, thing), one in found.items():
        assert one["averages"] == wanted.averages[:, tool, thing].tolist()
        assert one["persistence"] == wanted.persistence[tool, thing]


def test_tools_of_one_kind_that_fail_differently_have_values_of_their_own(there):
    two = hb.World.parse("Q = picker slip 0.5\nG = goal of C\nAPQ.\n.C..\n....\n...G", "map")
    names, found = received(there, scene=drawn(two, horizon=2))
    sure, unsure = (
        [tool["name"] for tool in names["tools"]].index(n) for n in ("picker", "picker2")
    )
    wanted = hb.pairs(two, 2, ["picker", "picker2"]).averages[:, :, 0]
    assert found[sure, 0]["averages"] == pytest.approx(wanted[:, 0], abs=1e-5)
    assert found[unsure, 0]["averages"] == pytest.approx(wanted[:, 1], abs=1e-5)
    assert found[sure, 0]["averages"] != pytest.approx(found[unsure, 0]["averages"], abs=1e-2)


def test_a_pair_that_is_not_available_says_why_and_the_others_come(there):
    world = hb.World.parse("A#P#\n#C##\n####\n###G", "map")
    _, found = received(there, scene=drawn(world))
    *tools, bare = (found[key] for key in sorted(found))
    assert all("no room to hold the tool" in one["why"] for one in tools)
    assert bare["averages"] == [0, 0, 0]
    assert (bare["latency"], bare["reliability"]) == (None, None)


def test_a_newer_comparison_overtakes_an_older_one(there):
    first = there.send("pairs", scene=drawn(WORLD, horizon=9))
    second = there.send("pairs", scene=scene(hb.load_world("yard")))
    answers = {first: [], second: []}
    while not any("pair" in answer for answer in answers[second]):
        answer = there.receive()
        answers[answer["id"]].append(answer)
    assert answers[first][-1] == {"id": first, "overtaken": True}
