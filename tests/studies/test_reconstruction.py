"""The search for maps that meet stated numbers, and the maps that it found."""

import json
from itertools import combinations, islice
from random import Random

import pytest

from habilis.cli import main
from habilis.studies.maps import other_maps
from habilis.studies.measured import measured
from habilis.studies.reconstruction.annealing import Schedule
from habilis.studies.reconstruction.energy import weigh
from habilis.studies.reconstruction.moves import neighbour, random_map
from habilis.studies.reconstruction.search import LEAST_DIFFERENCE, attempts
from habilis.studies.reconstruction.shapes import difference, one_room, walls_alone
from habilis.studies.scenes import Scene
from habilis.studies.stated import load_stated, parse_stated, stated_names
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

MAPS = [world for name in stated_names() for world in other_maps(name)]


@pytest.mark.parametrize("experiment", stated_names())
def test_there_are_at_least_six_other_maps(experiment):
    assert len(other_maps(experiment)) >= 6


@pytest.mark.parametrize("world", MAPS, ids=lambda world: world.name)
def test_a_map_found_meets_every_stated_number(world):
    scene = Scene(world)
    for stated in load_stated(world.name.partition("-")[0]).numbers:
        found = measured(scene, stated)
        assert stated.miss(found) == 0, f"{stated.text}: {stated.published}, found {found}"


@pytest.mark.parametrize("experiment", stated_names())
def test_the_maps_differ_from_the_built_in_one_and_from_each_other(experiment):
    maps = [load_world(experiment), *other_maps(experiment)]
    for one, other in combinations(maps, 2):
        assert difference(one, other) >= LEAST_DIFFERENCE, f"{one.name}, {other.name}"


def test_difference_counts_what_is_drawn_and_forgives_turns():
    world = World.parse("#A.\nPC#\n..G\n")
    assert difference(world, world) == 0
    turned = World.parse(".P#\n.CA\nG#.\n")
    assert difference(world, turned) == 0
    assert difference(world, World.parse("#A.\nPC#\n.G.\n")) == pytest.approx(2 / 7)


def test_rooms_and_walls_alone_are_told():
    assert one_room(World.parse("##A\nPCG\n"))
    assert not one_room(World.parse("A##\nC.#\n###\nP.G\n"))
    assert walls_alone(World.parse("##A\nPCG\n")) == 0
    assert walls_alone(World.parse("#.A\nPC.\n##G\n")) == 1


def test_changes_keep_one_room_and_lead_anywhere():
    random = Random(1)
    stated = load_stated("corridor")
    world = begun = random_map(stated, random)
    for _ in range(300):
        after = neighbour(world, random)
        assert after != world
        assert one_room(after)
        assert walls_alone(after) == 0
        world = after
    assert difference(begun, world) > 0.5


@pytest.mark.parametrize("name", stated_names())
def test_what_is_not_computed_again_has_not_changed(name):
    random, numbers = Random(2), load_stated(name).numbers
    here = weigh(random_map(load_stated(name), random), numbers)
    assert here is not None
    for _ in range(12):
        world = neighbour(here.world, random)
        afresh, reused = weigh(world, numbers), weigh(world, numbers, before=here)
        assert afresh is not None
        assert reused is not None
        assert afresh.parts == reused.parts
        assert weigh(world, numbers, limit=afresh.energy + 1e-9) is not None
        assert weigh(world, numbers, limit=afresh.energy - 0.01) is None
        here = reused


def test_the_search_finds_an_easy_target_and_the_same_again():
    stated = parse_stated(EASY, "easy")

    def found(seed):
        tried = islice(attempts(stated, seed, schedule=Schedule(changes=500)), 3)
        return [attempt.best.world.text() for attempt in tried if attempt.found]

    maps = found(0)
    assert maps
    for text in maps:
        scene = Scene(World.parse(text))
        assert all(number.miss(measured(scene, number)) == 0 for number in stated.numbers)
    assert found(0) == maps
    assert found(1) != maps


def test_a_map_too_like_a_known_one_does_not_count():
    stated = parse_stated(EASY, "easy")
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


def test_a_number_that_no_map_meets_is_told(tmp_path, capsys):
    (tmp_path / "far.toml").write_text(EASY.replace("value = 7", "value = 700"))
    arguments = ["reconstruct", str(tmp_path / "far.toml"), "--attempts", "2", "--changes", "20"]
    assert main(arguments) == 1
    assert "0 of 1 maps found" in (told := capsys.readouterr().err)
    assert "fewest steps" in told


@pytest.mark.parametrize(
    ("arguments", "names"),
    [
        (["nowhere"], "no such list"),
        (["yard", "--count", "0"], "--count is 0"),
        (["yard", "--attempts", "-1"], "--attempts is -1"),
        (["yard", "--hot", "nan"], "--hot is nan"),
        (["yard", "--from", "nowhere"], "no such world"),
    ],
)
def test_bad_usage_is_refused_and_touches_nothing(arguments, names, capsys, tmp_path):
    assert main(["reconstruct", *arguments, "--out", str(tmp_path / "maps")]) == 2
    error = capsys.readouterr().err
    assert names in error
    assert error.count("\n") == 1
    assert not (tmp_path / "maps").exists()
