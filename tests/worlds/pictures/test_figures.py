"""Pictures show the state they are given, at the size they are asked for, the same every time."""

from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from habilis.worlds.pictures.figures import (
    colored_text,
    draw_world,
    frame,
    save_picture,
    world_figure,
)
from habilis.worlds.pictures.shapes import SHAPES, Side, facing
from habilis.worlds.tools import TOOLS
from habilis.worlds.world import Cell, World, load_world

ROOM = World.parse("#####G\n#.....\n#..AP.\n#....C\n", name="room")
SIDES: dict[Side, Cell] = {"north": (1, 3), "east": (2, 4), "south": (3, 3), "west": (2, 2)}


def pixels_of(picture: np.ndarray, cell: Cell, size: int) -> np.ndarray:
    row, column = cell
    return picture[row * size : (row + 1) * size, column * size : (column + 1) * size]


def cells_that_differ(one: World, other: World, size: int = 32) -> set[Cell]:
    first, second = frame(one, size), frame(other, size)
    return {
        (row, column)
        for row in range(one.height)
        for column in range(one.width)
        if (pixels_of(first, (row, column), size) != pixels_of(second, (row, column), size)).any()
    }


@pytest.mark.parametrize("size", [7, 24, 33, 200])
def test_a_frame_has_cell_pixels_per_cell(size: int):
    picture = frame(ROOM, size)
    assert picture.shape == (4 * size, 6 * size, 3)
    assert picture.dtype == np.uint8


def test_no_size_of_figure_loses_a_pixel():
    for cells in range(1, 40):
        world = World.parse("." * cells + "ACG")
        for size in (1, 17, 24, 31, 48, 99):
            canvas = world_figure(world, size).canvas
            assert canvas.get_width_height() == ((cells + 3) * size, size)


def test_a_wall_is_dark_and_the_floor_light():
    picture = frame(ROOM, 32)
    for cell in ROOM.walls:
        assert pixels_of(picture, cell, 32).max() < 80
    assert pixels_of(picture, (1, 1), 32)[16, 16].min() > 230


def test_rows_go_down_and_columns_to_the_right():
    walls = frozenset({(0, 2)})
    picture = frame(replace(ROOM, walls=walls), 24)
    assert pixels_of(picture, (0, 2), 24)[12, 12].max() < 80
    assert pixels_of(picture, (3, 2), 24)[12, 12].min() > 230


def test_moving_the_can_changes_its_two_cells_only():
    moved = ROOM.with_cells(object=(1, 1))
    assert cells_that_differ(ROOM, moved) == {(3, 5), (1, 1)}


def test_a_can_on_the_goal_is_seen_in_the_bin():
    delivered = ROOM.with_cells(object=ROOM.goal)
    assert cells_that_differ(ROOM, delivered) == {(3, 5), ROOM.goal}


@pytest.mark.parametrize("thing", ["agent", "tool"])
def test_the_goal_is_visible_under_another_thing(thing: str):
    moved = ROOM.with_cells(agent=ROOM.goal, tool=(3, 1))
    on_goal = moved if thing == "agent" else ROOM.with_cells(tool=ROOM.goal)
    elsewhere = on_goal.with_cells(goal=(3, 2))
    assert cells_that_differ(on_goal, elsewhere) == {ROOM.goal, (3, 2)}


def look_of_tool(tool: str, cell: Cell) -> np.ndarray:
    world = ROOM.with_tool(tool).with_cells(tool=cell)
    return pixels_of(frame(world), cell, 32).astype(int)


@pytest.mark.parametrize("tool", TOOLS)
def test_a_tool_in_hand_looks_different_on_each_side(tool: str):
    looks = [look_of_tool(tool, cell) for cell in SIDES.values()]
    for one, other in combinations(looks, 2):
        assert np.abs(one - other).max() > 100


@pytest.mark.parametrize("tool", TOOLS)
def test_a_tool_out_of_reach_is_not_turned(tool: str):
    looks = [look_of_tool(tool, cell) for cell in [(3, 2), (3, 4), (2, 5)]]
    for one, other in combinations(looks, 2):
        assert np.abs(one - other).max() <= 2  # a rounding of the same drawing


def test_the_pickers_claw_points_away_from_the_agent():
    for side, (row, column) in SIDES.items():
        away = np.array([column - ROOM.agent[1], row - ROOM.agent[0]])
        hinge = facing(SHAPES["picker"], side)[-1]  # nearer the claw than the grip
        assert (np.mean(hinge.points, axis=0) - 0.5) @ away > 0.05, side


def test_without_a_tool_none_is_drawn():
    bare = ROOM.with_tool("none")
    assert cells_that_differ(ROOM, bare) == {ROOM.tool_cell}
    assert cells_that_differ(bare, replace(bare, vacancy=None)) == set()


def test_every_tool_has_a_drawing():
    assert set(TOOLS) <= set(SHAPES)


def test_every_drawing_stays_in_its_cell():
    for name, drawing in SHAPES.items():
        points = np.concatenate([shape.points for shape in drawing])
        margin = 0.011 if name == "wall" else 0
        assert points.min() >= -margin, name
        assert points.max() <= 1 + margin, name


def test_a_path_visits_every_point_and_closes():
    shape = SHAPES["floor"][0]
    assert shape.path == "M0 0L1 0L1 1L0 1Z"


def test_without_a_background_the_floor_is_left_out():
    ax = Figure().add_subplot()
    draw_world(ax, ROOM, background=False)
    bare = sum(len(areas.get_paths()) for areas in ax.collections)
    ax.clear()
    draw_world(ax, ROOM)
    full = sum(len(areas.get_paths()) for areas in ax.collections)
    assert full - bare == 1 + (ROOM.width + 1) + (ROOM.height + 1)  # paper, and every grid line


def test_every_wall_is_drawn_in_its_cell_and_nowhere_else():
    ax = Figure().add_subplot()
    draw_world(ax, replace(ROOM, walls=frozenset()), background=False)
    rest = len(ax.collections)
    ax.clear()
    draw_world(ax, ROOM, background=False)
    walls = ax.collections[: len(ax.collections) - rest + 2]
    drawn = {(y, x) for areas in walls for x, y in np.asarray(areas.get_offsets()).tolist()}
    assert drawn >= {(float(row), float(column)) for row, column in ROOM.walls}


def test_a_large_map_has_a_picture_that_can_be_looked_at(tmp_path: Path):
    rows = ["." * 1000 for _ in range(1000)]
    rows[0] = "APCG" + "#" * 996
    rows[-1] = "#" * 1000
    large = World.parse("\n".join(rows))
    save_picture(large, tmp_path / "large.png")
    with Image.open(tmp_path / "large.png") as picture:
        assert picture.size == (4000, 4000)
        pixels = np.asarray(picture.convert("L"))
    assert pixels[-3:, 2::4].max() < 80
    assert pixels[2:4, 18::4].max() < 80
    assert pixels[6:-6:4, 2::4].min() > 230
    for suffix in (".svg", ".pdf"):
        save_picture(large, tmp_path / f"large{suffix}")
        assert (tmp_path / f"large{suffix}").stat().st_size < 3_000_000


def test_coloured_text_of_a_large_map_is_all_of_it():
    rows = ["APCG" + "#." * 298, *[".#" * 300] * 299]
    lines = colored_text(World.parse("\n".join(rows))).plain.splitlines()
    assert [line[::2] for line in lines] == rows


@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf", ".PNG"])
def test_the_same_picture_is_the_same_bytes(suffix: str, tmp_path: Path):
    paths = [tmp_path / f"one{suffix}", tmp_path / f"two{suffix}"]
    for path in paths:
        save_picture(ROOM, path)
    assert paths[0].read_bytes() == paths[1].read_bytes()


def test_a_saved_png_has_the_size_asked_for(tmp_path: Path):
    save_picture(ROOM, tmp_path / "room.png", cell=25)
    with Image.open(tmp_path / "room.png") as picture:
        assert picture.size == (150, 100)


@pytest.mark.parametrize("name", ["room.bmp", "room", "room.svg.gz"])
def test_an_unknown_suffix_is_refused_and_named(name: str, tmp_path: Path):
    path = tmp_path / name
    with pytest.raises(ValueError, match=r"\.png, \.svg, \.pdf") as caught:
        save_picture(ROOM, path)
    assert repr(path.suffix) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert not path.exists()


def test_coloured_text_is_the_map_with_two_characters_a_cell():
    for world in (ROOM, load_world("corridor")):
        lines = colored_text(world).plain.split("\n")
        assert [line[::2] for line in lines] == world.text().splitlines()
        assert {line[1::2] for line in lines} == {" " * world.width}


def test_coloured_text_shows_the_goal_under_the_can():
    delivered = ROOM.with_cells(object=ROOM.goal)
    assert colored_text(delivered).plain.startswith("# # # # # CG\n")


def test_coloured_text_gives_each_thing_its_own_colour():
    text = colored_text(ROOM)
    styles = {text.plain[span.start]: span.style for span in text.spans if span.end > span.start}
    things = [styles[letter] for letter in "#APCG"]
    assert len(set(things)) == len(things)
