"""Pictures of worlds with several tools and objects."""

from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

import habilis as hb
from habilis.worlds.pictures.figures import colored_text, frame, object_drawings, things_of
from habilis.worlds.pictures.shapes import SHAPES, facing, placed
from habilis.worlds.pictures.tiles import Tiles
from habilis.worlds.pictures.video import save_gif
from habilis.worlds.tools import TOOLS
from habilis.worlds.world import Cell, World

ABOVE = """\
R = rake
D = can
E = ball
G = goal of C
H = goal of D
drop: true
"""
MAP = "C..D.G\n.P.R..\n..A..H\n#E....\n"
ROOM = World.parse(ABOVE + MAP, name="room")
SMALL = World.parse(
    "R = rake\nD = can\nG = goal of C\nH = goal of D\nP..RG\n.A..#\nD.C.H\n", name="small"
)
MDP = hb.tabulate(SMALL)


def pixels_of(world: World, cell: Cell, size: int = 32) -> np.ndarray:
    row, column = cell
    return frame(world, size)[row * size : (row + 1) * size, column * size : (column + 1) * size]


def test_every_thing_is_drawn_in_its_cell_by_its_kind():
    things = things_of(ROOM, ROOM.agent)
    assert things[0, 0] == SHAPES["can"]
    assert things[3, 1] == SHAPES["ball"]
    assert things[1, 1] == SHAPES["picker"]
    assert things[1, 3] == SHAPES["rake"]
    assert set(things) == {(0, 0), (0, 3), (0, 5), (1, 1), (1, 3), (2, 2), (2, 5), (3, 1)}


def test_objects_of_one_kind_have_colours_of_their_own():
    kinds = "\n".join(f"{letter} = can" for letter in "DEF")
    drawings = object_drawings(World.parse(f"{kinds}\nG = goal of C\nA.CDEFG"))
    for one, other in combinations(drawings, 2):
        assert [shape.points for shape in one] == [shape.points for shape in other]
        assert [shape.fill for shape in one] != [shape.fill for shape in other]


def test_the_tool_in_hand_alone_is_turned_even_beside_another():
    between = replace(ROOM, agent=(1, 2))  # the picker to the west, the rake to the east
    assert things_of(between, between.agent)[1, 1] == facing(SHAPES["picker"], "west")
    assert things_of(between, between.agent)[1, 3] == SHAPES["rake"]
    with_rake = replace(between, held=1)
    assert things_of(with_rake, with_rake.agent)[1, 1] == SHAPES["picker"]
    assert things_of(with_rake, with_rake.agent)[1, 3] == facing(SHAPES["rake"], "east")
    put_down = replace(between, held=-1)
    assert things_of(put_down, put_down.agent)[1, 1] == SHAPES["picker"]


def test_a_state_of_a_table_shows_which_tool_is_in_hand():
    held = MDP.factor("held")
    tools = [MDP.factor("tool:picker"), MDP.factor("tool:rake")]
    beside = [np.isin(np.abs(tool - MDP.factor("agent")), [1, 5]) for tool in tools]
    state = int(np.flatnonzero((held == 1) & beside[0] & beside[1])[0])
    assert hb.placement(SMALL, MDP, state).in_hand == 1


def test_each_bin_has_the_picture_of_its_object():
    above = ABOVE.replace("of C", "of X").replace("of D", "of C").replace("of X", "of D")
    swapped = World.parse(above + MAP)
    for goal in [(0, 5), (2, 5)]:
        assert np.abs(pixels_of(ROOM, goal).astype(int) - pixels_of(swapped, goal)).max() > 100


def test_an_only_objects_bin_needs_no_picture():
    one = World.parse("R = rake\nAP.CGR")
    assert things_of(one, one.agent)[0, 4] == SHAPES["bin"]


def test_an_object_is_in_its_own_bin_and_beside_that_of_another():
    own = ROOM.with_cells(object={"can": (0, 5)})
    other = ROOM.with_cells(object={"can": (2, 5)})
    empty = things_of(ROOM, None)[2, 5]
    assert things_of(other, None)[2, 5] == SHAPES["can"] + placed(empty, 0.56, 0.54, 0.44)
    assert things_of(own, None)[0, 5] != SHAPES["can"] + placed(empty, 0.56, 0.54, 0.44)
    assert things_of(own, None)[0, 5][0] == SHAPES["full bin"][0]  # the lid, swung open


@pytest.mark.parametrize("size", [8, 33])
def test_laid_pictures_are_the_drawn_ones(size: int):
    tiles = Tiles.of(SMALL, size)
    names = ["tool:picker", "tool:rake"], ["object:can", "object:can2"]
    states = np.random.default_rng(0).choice(MDP.states, 60, replace=False)
    tools, objects = ([MDP.factor(name)[states] for name in group] for group in names)
    laid = tiles.laid(MDP.factor("agent")[states], tools, objects, MDP.factor("held")[states])
    assert {-1, 0, 1} == set(MDP.factor("held")[states])
    for state, picture in zip(states, laid, strict=True):
        placed_so = hb.placement(SMALL, MDP, state)
        np.testing.assert_array_equal(picture, frame(placed_so, size))
        np.testing.assert_array_equal(picture, tiles.picture(placed_so))


@pytest.mark.parametrize("name", [*TOOLS, "ball", "crate"])
def test_the_drawings_are_distinguishable_at_eight_pixels(name: str):
    """With colours turned to grey, as the wholly colour-blind see them."""
    grey = {
        other: frame_of(other).astype(float) @ (0.2126, 0.7152, 0.0722)
        for other in [*TOOLS, "can", "ball", "crate", "agent", "bin"]
    }
    for other, pixels in grey.items():
        if other != name:
            assert np.abs(pixels - grey[name]).max() > 60, other


def frame_of(name: str) -> np.ndarray:
    from habilis.worlds.pictures.figures import rendered

    return rendered(World.parse("A.CG"), {(0, 1): SHAPES[name]}, 8)[:, 8:16]


def test_coloured_text_shows_every_goal_and_which_tool_is_in_hand():
    state = ROOM.with_cells(agent=(1, 2), object={"can": (2, 5)}, held=1)
    lines = colored_text(state).plain.split("\n")
    assert [line[::2] for line in lines] == list(state.rows)
    hidden = next(mark for mark in state.marks if mark.cell == (2, 5))
    assert hidden.role == "G"
    assert lines[2][10:] == f"{state.rows[2][5]}{hidden.character}"
    underlined = {
        colored_text(state).plain[span.start]
        for span in colored_text(state).spans
        if "underline" in str(span.style)
    }
    assert underlined == {"R"}


def test_a_video_is_of_one_world(tmp_path: Path):
    save_gif([ROOM, replace(ROOM, agent=(2, 3))], tmp_path / "video.gif", cell=8)
    other = World.parse((ABOVE + MAP).replace("E = ball", "E = crate"))
    with pytest.raises(ValueError, match="state 1 is of another world"):
        save_gif([ROOM, other], tmp_path / "no.gif", cell=8)
    assert not (tmp_path / "no.gif").exists()
