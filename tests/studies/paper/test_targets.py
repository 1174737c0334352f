"""Lists of stated numbers: their content, and errors in them."""

from dataclasses import replace

import numpy as np
import pytest

from habilis.analysis.landscape import landscape
from habilis.empowerment import empowerment
from habilis.studies.paper.numbers import measure
from habilis.studies.paper.targets import Target, load_targets, parse_targets, target_names
from habilis.studies.paper.worlds import CachedWorld
from habilis.worlds.table import tabulate
from habilis.worlds.world import World, load_world

HEAD = '[map]\nheight = 5\nwidth = 5\ntool = "picker"\nwalls = 3\n'
STEPS = '[[number]]\nkind = "steps"\ntext = "steps"\nvalue = 6\n'


YARD = CachedWorld(load_world("yard"))


@pytest.mark.parametrize(
    ("world", "name"),
    [
        ("corridor", "corridor"),
        ("corridor-b", "corridor-all"),
        ("yard", "yard-apart"),
        ("yard-b", "yard"),
    ],
)
def test_the_built_in_world_meets_every_number_of_its_list(world, name):
    scene = CachedWorld(load_world(world))
    for stated in load_targets(name).numbers:
        assert stated.miss(measure(scene, stated)) == 0, stated.text


@pytest.mark.parametrize(
    ("world", "name", "missed"),
    [
        ("corridor", "corridor-all", ["5-step FOE at the goal"]),
        ("yard", "yard", ["steps from the tool to the can", "1-step TOE", "1-step TOE"]),
        ("yard-b", "yard-all", ["1-step FOE with the can next to the tool"]),
    ],
)
def test_what_a_built_in_world_does_not_meet_is_known(world, name, missed):
    scene = CachedWorld(load_world(world))
    found = [s.text for s in load_targets(name).numbers if s.miss(measure(scene, s)) != 0]
    assert len(found) == len(missed)
    assert all(text.startswith(start) for text, start in zip(found, missed, strict=True)), found


def test_a_list_may_have_all_of_another_and_more():
    first, more = load_targets("yard"), load_targets("yard-all")
    assert more.numbers[: len(first.numbers)] == first.numbers
    assert len(more.numbers) == len(first.numbers) + 2
    assert (more.name, more.source) == ("yard", "yard-all")
    assert (more.height, more.tool, more.walls) == (first.height, first.tool, first.walls)


def test_a_rank_is_the_share_of_cells_that_are_not_higher():
    scene = CachedWorld(World.parse("A....\n.C...\n.G...\n.....\n....P\n"))
    values = landscape(scene.world, 2, "state").values
    goal = Target("landscape", "", sensor="state", horizon=2, statistic="rank", around="goal")
    there = values[np.isfinite(values)]
    expected = (there <= values[2, 1]).mean()
    assert measure(scene, replace(goal, within=0)) == pytest.approx(expected)
    assert 0 < expected < 1


def test_what_is_against_another_tool_is_the_difference():
    scene = CachedWorld(World.parse(".....\n.APC.\n.....\n....G\n"))
    broom = scene.with_tool("broom")
    gap = Target("average", "", sensor="state", horizon=2, against="broom")
    assert measure(scene, gap) == scene.average(2, "state") - broom.average(2, "state") != 0
    cells = np.abs(
        landscape(scene.world, 1, "state").values - landscape(broom.world, 1, "state").values
    )
    most = Target("landscape", "", sensor="state", horizon=1, against="broom")
    assert measure(scene, most) == np.nanmax(cells) > 0
    assert measure(broom, replace(most, tool="broom")) == 0


def test_averages_go_over_the_states_that_are_asked_for():
    world = World.parse("A..#.\n.PC#.\n...#.\n...#G\n")
    bits = empowerment(mdp := tabulate(world), 2, "object")
    reached, edge = {mdp.start}, [mdp.start]
    while edge:
        fresh = set(mdp.next_state[edge.pop()].tolist()) - reached
        reached |= fresh
        edge += fresh
    assert len(reached) < mdp.flags["equipped"].sum() < mdp.states
    for over, expected in (
        ("equipped", bits[mdp.flags["equipped"]]),
        ("all", bits),
        ("reachable", bits[sorted(reached)]),
    ):
        assert CachedWorld(world, over).average(2) == pytest.approx(expected.mean())


@pytest.mark.parametrize("name", target_names())
def test_no_number_is_met_by_everything(name):
    """On a bare room with the tool at hand each list misses much, and each number can be missed."""
    for stated in load_targets(name).numbers:
        low, high = stated.bounds
        assert stated.miss(low - 0.01) > 0 or stated.miss(high + 0.01) > 0
        assert stated.miss(float("nan")) != 0
    room = CachedWorld(World.parse("A....\n.C...\n.G...\n.....\n....P\n", "room"))
    missed = [s for s in load_targets(name).numbers if s.miss(measure(room, s)) != 0]
    assert len(missed) > len(load_targets(name).numbers) / 2


def test_a_narrower_tolerance_is_missed():
    broom = next(s for s in load_targets("yard").numbers if s.value == 0.28)
    found = measure(YARD, broom)
    assert broom.miss(found) == 0 < replace(broom, tolerance=0.001).miss(found)
    assert replace(broom, value=0.29).miss(found) == pytest.approx(0.285 - found)


def test_kinds_are_what_they_say():
    scene = CachedWorld(World.parse("AP.C.G\n......\n......\n"))
    assert measure(scene, Target("steps", "")) == 1 - measure(scene, Target("return", ""))
    assert measure(scene, Target("apart", "")) == 1
    values = landscape(scene.world, 2, "object").values
    near = Target("landscape", "", horizon=2, around="object", within=1)
    assert measure(scene, near) == np.nanmax([values[0, 2], values[0, 4], values[1, 3]])
    far = replace(near, within=float("inf"), beyond=1, statistic="mean")
    rest = values.copy()
    rest[[0, 0, 1], [2, 4, 3]] = np.nan
    assert measure(scene, far) == pytest.approx(np.nanmean(rest))
    assert np.isnan(measure(scene, replace(far, beyond=10)))


def test_a_goal_out_of_reach_is_infinitely_far():
    scene = CachedWorld(World.parse("AC#G"))
    assert measure(scene, Target("steps", "")) == float("inf")
    assert Target("steps", "", least=16, most=60).miss(float("inf")) > 0
    assert measure(scene, Target("return", "")) == -float("inf")


def test_side_by_side_is_in_the_open():
    assert YARD.side_by_side == ((2, 6), (2, 5))
    assert CachedWorld(World.parse("AP.CG")).side_by_side is None
    placed = Target("landscape", "", horizon=1, placed=True, around="tool", within=1)
    assert np.isnan(measure(CachedWorld(World.parse("AP.CG")), placed))


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("number = 3", "has number; give one [map]"),
        ("[[", "not a TOML file"),
        (HEAD, "has map; give one [map]"),
        (HEAD.replace("5", "0") + STEPS, "no room"),
        (HEAD.replace("walls = 3", "walls = 22") + STEPS, "22 walls"),
        (HEAD.replace("walls = 3", "walls = true") + STEPS, "[map] needs"),
        (
            HEAD.replace("picker", "spoon") + STEPS,
            "'spoon'; use one of picker, broom, rake, stick, magnet, none",
        ),
        (HEAD + STEPS.replace("steps", "hops", 1), "number 1: kind is 'hops'; use one of steps"),
        (HEAD + STEPS + STEPS + "horizon = 3", "number 2: 'horizon' does not apply to steps"),
        (HEAD + STEPS.replace("6", '"six"'), "number 1: value is 'six'; give a number"),
        (HEAD + STEPS.replace("value = 6", ""), "give a value with a tolerance"),
        (HEAD + STEPS.replace("value = 6", "least = 3\nmost = 2"), "least not above the most"),
        (HEAD + STEPS + "most = 7", "or else least or most"),
        (HEAD + STEPS + "tolerance = -1", "tolerance from 0 up"),
        (HEAD + STEPS.replace('"steps"', '"average"', 1), "has no sensor"),
        (HEAD + STEPS.replace('text = "steps"', ""), "has no text"),
        (HEAD.replace("picker", "none") + STEPS.replace("steps", "apart"), "there is none"),
        (HEAD.replace("picker", "none") + STEPS + 'tool = "broom"', "no place for a broom"),
        (HEAD + 'name = "a/b"\n' + STEPS, "the name 'a/b'; give letters"),
        ('[map]\nlike = "garden"\n' + STEPS, "like 'garden'; name one of corridor"),
        ('[map]\nlike = "yard"\nwalls = 3\n' + STEPS, "leave all else but the name"),
        ('[map]\nlike = "yard"\nname = 3\n' + STEPS, "the name 3; give letters"),
    ],
)
def test_a_list_that_cannot_be_is_refused_in_one_line(text, names):
    with pytest.raises(ValueError, match="list") as refusal:
        parse_targets(text)
    assert names in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_an_unknown_list_is_refused():
    with pytest.raises(ValueError, match="name one of corridor, corridor-all, yard"):
        load_targets("nowhere.toml")
