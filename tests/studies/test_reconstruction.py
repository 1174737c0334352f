"""The search for maps that meet stated numbers, and the maps that it found."""

import json
from itertools import combinations, islice
from pathlib import Path
from random import Random

import pytest

from habilis.cli import main
from habilis.studies.maps import map_names, world_source
from habilis.studies.paper.numbers import measure
from habilis.studies.paper.targets import load_targets, parse_targets, target_names
from habilis.studies.paper.worlds import CachedWorld
from habilis.studies.reconstruction.annealing import Schedule
from habilis.studies.reconstruction.energy import weigh
from habilis.studies.reconstruction.moves import neighbour, random_map
from habilis.studies.reconstruction.search import LEAST_DIFFERENCE, attempts
from habilis.studies.reconstruction.shapes import difference, one_room, walls_alone
from habilis.worlds.tools import Reading
from habilis.worlds.world import World, load_world

EASY = """
[map]
height = 5
width = 5
tool = "none"
walls = 4

[[number]]
kind = "steps"
text = "fewest steps"
value = 7

[[number]]
kind = "average"
text = "average"
sensor = "object"
horizon = 2
value = 0.4
tolerance = 0.05
"""

EXPERIMENTS = ("corridor", "yard")


def maps_of(experiment):
    return [load_world(world_source(name)) for name in map_names(experiment)]


MAPS = [world for name in EXPERIMENTS for world in maps_of(name)]


@pytest.mark.parametrize(("experiment", "least"), [("corridor", 12), ("yard", 10)])
def test_there_are_many_other_maps_numbered_on(experiment, least):
    names = map_names(experiment)
    assert len(names) >= least
    assert names == [f"{experiment}-{number:02}" for number in range(1, len(names) + 1)]


def list_of(name):
    """The list by which a map was found: later ones have more of what the paper states."""
    experiment, _, number = name.partition("-")
    first, later = {"corridor": ("corridor", "corridor-all"), "yard": ("yard-apart", "yard")}[
        experiment
    ]
    return first if int(number) <= {"corridor": 8, "yard": 6}[experiment] else later


@pytest.mark.parametrize("world", MAPS, ids=lambda world: Path(world.name).stem)
def test_a_map_found_meets_every_stated_number(world):
    scene = CachedWorld(world)
    for stated in load_targets(list_of(Path(world.name).stem)).numbers:
        found = measure(scene, stated)
        assert stated.miss(found) == 0, f"{stated.text}: {stated.published}, found {found}"


@pytest.mark.parametrize("experiment", EXPERIMENTS)
def test_the_maps_differ_from_the_built_in_ones_and_from_each_other(experiment):
    maps = [load_world(experiment), load_world(f"{experiment}-b"), *maps_of(experiment)]
    for one, other in combinations(maps, 2):
        assert difference(one, other) >= LEAST_DIFFERENCE, f"{one.name}, {other.name}"


def test_difference_counts_what_is_drawn_and_forgives_turns():
    world = World.parse("#A.\nPC#\n..G\n")
    assert difference(world, world) == 0
    turned = World.parse(".P#\n.CA\nG#.\n")
    assert difference(world, turned) == 0
    assert difference(world, World.parse("#A.\nPC#\n.G.\n")) == pytest.approx(2 / 7)


def test_only_rooms_and_walls_are_reported():
    assert one_room(World.parse("##A\nPCG\n"))
    assert not one_room(World.parse("A##\nC.#\n###\nP.G\n"))
    assert walls_alone(World.parse("##A\nPCG\n")) == 0
    assert walls_alone(World.parse("#.A\nPC.\n##G\n")) == 1


def test_changes_keep_one_room_and_lead_anywhere():
    random = Random(1)
    stated = load_targets("corridor")
    world = begun = random_map(stated, random)
    for _ in range(300):
        after = neighbour(world, random)
        assert after != world
        assert one_room(after)
        assert walls_alone(after) == 0
        world = after
    assert difference(begun, world) > 0.5


@pytest.mark.parametrize(
    ("name", "over"),
    [*((name, "equipped") for name in target_names()), ("yard", "reachable"), ("yard", "all")],
)
def test_what_is_not_computed_again_has_not_changed(name, over):
    random, numbers = Random(2), load_targets(name).numbers
    here = weigh(random_map(load_targets(name), random), numbers, over=over)
    assert here is not None
    for _ in range(12):
        world = neighbour(here.world, random)
        afresh = weigh(world, numbers, over=over)
        reused = weigh(world, numbers, before=here, over=over)
        assert afresh is not None
        assert reused is not None
        assert afresh.parts == reused.parts
        assert weigh(world, numbers, limit=afresh.energy + 1e-9, over=over) is not None
        assert weigh(world, numbers, limit=afresh.energy - 0.01, over=over) is None
        here = reused


def test_the_search_finds_an_easy_target_and_the_same_again():
    stated = parse_targets(EASY, "easy")

    def found(seed):
        tried = islice(attempts(stated, seed, schedule=Schedule(changes=500)), 3)
        return [attempt.best.world.text() for attempt in tried if attempt.found]

    maps = found(0)
    assert maps
    for text in maps:
        scene = CachedWorld(World.parse(text))
        assert all(number.miss(measure(scene, number)) == 0 for number in stated.numbers)
    assert found(0) == maps
    assert found(1) != maps


def test_a_search_goes_on_with_a_later_attempt_as_it_would_have():
    stated, schedule = parse_targets(EASY, "easy"), Schedule(changes=40)
    whole = [a.best.world for a in islice(attempts(stated, 0, schedule=schedule), 3)]
    rest = [a.best.world for a in islice(attempts(stated, 0, schedule=schedule, first=2), 2)]
    assert whole[1:] == rest


def test_a_map_too_like_a_known_one_does_not_count():
    stated = parse_targets(EASY, "easy")
    first = next(a for a in attempts(stated, 0, schedule=Schedule(changes=500)) if a.found)
    known = [first.best.world]
    stays = attempts(stated, 0, known, begin=first.best.world, schedule=Schedule(changes=1))
    assert not next(stays).found
    goes_on = attempts(stated, 0, known, begin=first.best.world, schedule=Schedule(changes=500))
    other = next(attempt for attempt in goes_on if attempt.found)
    assert difference(other.best.world, first.best.world) >= LEAST_DIFFERENCE


def test_the_command_writes_maps_that_load(tmp_path, capsys):
    (tmp_path / "easy.toml").write_text(EASY)
    arguments = ["reconstruct", str(tmp_path / "easy.toml"), "--count", "2", "--seed", "3"]
    assert main([*arguments, "--out", str(tmp_path / "maps"), "--json"]) == 0
    maps = json.loads(capsys.readouterr().out)["maps"]
    for found in maps:
        path = tmp_path / "maps" / f"{found['name']}.txt"
        assert load_world(path).text().splitlines() == found["map"]
        assert "--seed 3" in path.read_text()
        assert found["numbers"]["fewest steps"] == 7
    assert main([*arguments, "--out", str(tmp_path / "maps")]) == 2
    assert "easy-01.txt: exists" in capsys.readouterr().err
    assert main(arguments) == 0
    assert "fewest steps" in capsys.readouterr().out


def test_the_command_goes_on_after_the_maps_of_an_earlier_search(tmp_path, capsys):
    (tmp_path / "easy.toml").write_text(EASY)
    out = str(tmp_path / "maps")
    arguments = ["reconstruct", str(tmp_path / "easy.toml"), "--seed", "3", "--out", out, "--json"]
    assert main([*arguments, "--count", "2"]) == 0
    assert main([*arguments, "--after", out]) == 0
    capsys.readouterr()
    names = [f"easy-0{number}.txt" for number in (1, 2, 3)]
    assert sorted(path.name for path in (tmp_path / "maps").iterdir()) == names
    maps = [load_world(tmp_path / "maps" / name) for name in names]
    assert all(difference(*two) >= LEAST_DIFFERENCE for two in combinations(maps, 2))
    assert f"--after {out}" in (tmp_path / "maps" / names[2]).read_text()


def test_the_command_searches_under_another_reading(tmp_path, capsys):
    text = EASY.replace('"none"', '"picker"').replace("value = 7", "least = 1\nmost = 90")
    (tmp_path / "easy.toml").write_text(text)
    arguments = ["reconstruct", str(tmp_path / "easy.toml"), "--out", str(tmp_path / "maps")]
    assert main([*arguments, "--reading", "sweeps pushes", "--over", "reachable", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["maps"][0]
    path = tmp_path / "maps" / "easy-01.txt"
    world = load_world(path)
    assert world.tools[0].reading == Reading(pushes=True, sweeps=True)
    assert found["numbers"]["average"] == CachedWorld(world, "reachable").average(2)
    assert '--reading "pushes sweeps" --over reachable' in path.read_text()


def test_a_number_that_no_map_meets_is_reported(tmp_path, capsys):
    (tmp_path / "far.toml").write_text(EASY.replace("value = 7", "value = 700"))
    arguments = ["reconstruct", str(tmp_path / "far.toml"), "--attempts", "2", "--changes", "20"]
    assert main(arguments) == 1
    assert "0 of 1 maps found" in (reported := capsys.readouterr().err)
    assert "fewest steps" in reported


@pytest.mark.parametrize(
    ("arguments", "names"),
    [
        (["nowhere"], "no such list"),
        (["yard", "--count", "0"], "--count is 0"),
        (["yard", "--attempts", "-1"], "--attempts is -1"),
        (["yard", "--hot", "nan"], "--hot is nan"),
        (["yard", "--from", "nowhere"], "no such world"),
        (["yard", "--after", "nowhere"], "nowhere: no such folder"),
        (["yard", "--reading", "pulls"], "--reading is 'pulls'; give some of pushes shoves"),
    ],
)
def test_bad_usage_is_refused_and_touches_nothing(arguments, names, capsys, tmp_path):
    assert main(["reconstruct", *arguments, "--out", str(tmp_path / "maps")]) == 2
    error = capsys.readouterr().err
    assert names in error
    assert error.count("\n") == 1
    assert not (tmp_path / "maps").exists()
