"""Pictures of puzzles: looked at pixel by pixel, where it matters."""

import numpy as np
import pytest
from PIL import Image, ImageSequence

import habilis as hb
from habilis.bridges import PushWorld
from habilis.bridges.puzzles.sokoban import parsed_level
from habilis.worlds.pictures import save_picture
from habilis.worlds.pictures.figures import colored_text, frame
from habilis.worlds.pictures.shapes import BLUE, LEAF, PAPER, RED

CELL = 40
# A ring around a hole, whose right side touches M2; the agent has two cells.
RING = """\
M1 M1 M1 M2 .  A
M1 .  M1 M2 .  A
M1 M1 M1 AW W  .
M0 .  G0 .  .  .
"""


def pixels(puzzle):
    return frame(puzzle, CELL)


def colour(picture, row, column):
    """At a place in cells, as "#rrggbb"."""
    return "#" + "".join(f"{int(c):02x}" for c in picture[int(row * CELL), int(column * CELL)])


def test_a_body_is_outlined_as_one_shape():
    picture = pixels(PushWorld.parse(RING))
    own = colour(picture, 0.15, 0.5)
    assert own not in (PAPER, colour(picture, 3.5, 1.5 + 2))
    for row, column in [(0.5, 1.0), (1.0, 0.5), (2.5, 1.0), (2.0, 2.5)]:  # between its cells
        assert colour(picture, row, column) == own
    assert colour(picture, 1.3, 1.3) == PAPER  # the hole
    between = {colour(picture, 0.5, 3 + away) for away in np.linspace(-0.2, 0.2, 17)}
    assert own in between  # M1 and M2, and what separates them
    assert colour(picture, 0.3, 3.3) in between
    assert len(between) > 3


def test_the_agent_of_several_cells_is_one_blue_body():
    picture = pixels(PushWorld.parse(RING))
    assert colour(picture, 1.0, 5.5) == BLUE
    assert colour(picture, 1.5, 5.5) == BLUE


def test_a_movable_has_the_colour_of_its_goal_and_green_about_it_when_it_is_there():
    puzzle = PushWorld.parse("M0 . . G0 A")
    before = pixels(puzzle)
    assert colour(before, 0.2, 0.5) == RED
    assert colour(before, 0.12, 3.5) == RED
    after = pixels(puzzle.at((4, 3)))
    assert colour(after, 0.2, 3.5) == RED
    assert colour(after, 0.1, 3.5) == LEAF
    assert colour(after, 0.5, 0.5) == PAPER


def test_an_agents_wall_is_no_wall_and_no_floor():
    picture = pixels(PushWorld.parse(RING))
    stripes = {colour(picture, 2.5, 3 + away) for away in np.linspace(0.05, 0.95, 19)}
    assert PAPER not in stripes
    assert colour(picture, 2.5, 4.5) not in stripes


def test_a_picture_has_any_format_and_size(tmp_path):
    for suffix in (".png", ".svg", ".pdf"):
        save_picture(PushWorld.parse(RING), tmp_path / f"ring{suffix}", cell=20)
        assert (tmp_path / f"ring{suffix}").stat().st_size > 1000
    with Image.open(tmp_path / "ring.png") as picture:
        assert picture.size == (6 * 20, 4 * 20)
    with pytest.raises(ValueError, match="unknown suffix"):
        save_picture(PushWorld.parse(RING), tmp_path / "ring.gif")


def test_a_plan_becomes_a_video(tmp_path):
    puzzle = PushWorld.parse("A M0 . G0\n. . . .")
    mdp = hb.explore(puzzle)
    plan = hb.solve(mdp)
    assert plan is not None
    states = [puzzle.at(mdp.state(state)) for state in plan.states]
    hb.save_video(states, tmp_path / "plan.gif", cell=CELL)
    with Image.open(tmp_path / "plan.gif") as video:
        frames = [np.asarray(image.convert("RGB")) for image in ImageSequence.Iterator(video)]
    assert len(frames) == len(states) == 3
    for image, state in zip(frames, states, strict=True):
        assert np.abs(image.astype(int) - pixels(state)).mean() < 2


def test_a_video_of_several_puzzles_is_refused(tmp_path):
    states = [PushWorld.parse("A M0 ."), PushWorld.parse("A M0 W")]
    with pytest.raises(ValueError, match="state 1 is of another puzzle than state 0"):
        hb.save_video(states, tmp_path / "plan.gif")
    assert not [*tmp_path.iterdir()]


def test_the_text_shows_everything():
    text = colored_text(PushWorld.parse("A+G0 M10 M0 AW\nW . M10+G3 M3"))
    assert text.plain == "AG100 //\n##. 103 "
    assert PushWorld.parse("M0 . G0 A").colored_text().plain == "0 . G0A "
    assert parsed_level("#@$.*#").colored_text().plain == "##A 0 G 1G##"
