"""Maps are read cell by cell; what is wrong with one is said with its place and the fix."""

import string
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from habilis.worlds.things import PlacedObject, PlacedTool
from habilis.worlds.world import World, load_world, world_names

ROOM = """\
#..B
A.C.
..#G
"""


@st.composite
def map_rows(draw: st.DrawFn) -> list[str]:
    """The rows of a valid map: random walls and places, with either tool or none."""
    height, width = draw(st.integers(1, 6)), draw(st.integers(3, 6))
    things = draw(st.sampled_from(["ACG", "ACGP", "ACGB"]))
    cells = draw(st.lists(st.sampled_from("#.."), min_size=height * width, max_size=height * width))
    places = st.integers(0, len(cells) - 1)
    if len(things) > len(cells):
        things = "ACG"
    where = draw(st.lists(places, min_size=len(things), max_size=len(things), unique=True))
    for place, character in zip(where, things, strict=True):
        cells[place] = character
    return ["".join(cells[row * width : (row + 1) * width]) for row in range(height)]


def refusal(text: str, name: str = "map") -> str:
    with pytest.raises(ValueError, match=f"^{name}") as caught:
        World.parse(text, name)
    return str(caught.value)


# Reading


def test_every_character_is_read_into_its_cell():
    assert World.parse(ROOM, name="room") == World(
        name="room",
        height=3,
        width=4,
        walls=frozenset({(0, 0), (2, 2)}),
        agent=(1, 0),
        objects=(PlacedObject("can", (1, 2), goal=(2, 3)),),
        tools=(PlacedTool("broom", (0, 3)),),
    )


@pytest.mark.parametrize(
    ("text", "tool", "cell"),
    [("ACGP", "picker", (0, 3)), ("ACGB", "broom", (0, 3)), ("ACG.", "none", None)],
)
def test_the_character_of_the_tool_names_its_kind(text: str, tool: str, cell):
    world = World.parse(text)
    assert (world.tool, world.tool_cell) == (tool, cell)


@pytest.mark.parametrize(
    "text",
    [
        pytest.param(ROOM.rstrip("\n"), id="no line end after the last row"),
        pytest.param(ROOM.replace("\n", "\r\n"), id="Windows line ends"),
        pytest.param(ROOM.replace("\n", "  \n"), id="spaces after the rows"),
        pytest.param(f"\n\n{ROOM}\n \n", id="blank lines around"),
        pytest.param(f"; A comment, with #ACG.\n;\n\n{ROOM}", id="comments before"),
        pytest.param(f"{ROOM}\n; the end", id="a comment after"),
        pytest.param(ROOM.replace("\n", "\n;A\n"), id="comments between"),
    ],
)
def test_what_surrounds_the_rows_does_not_matter(text: str):
    assert World.parse(text) == World.parse(ROOM)


@given(map_rows())
def test_a_map_is_written_as_it_was_read(rows: list[str]):
    text = "\n".join(rows) + "\n"
    assert World.parse(text).text() == text


@given(map_rows())
def test_a_written_map_reads_back_as_the_same_world(rows: list[str]):
    world = World.parse("\n".join(rows))
    assert World.parse(world.text()) == world


# Refusing


@pytest.mark.parametrize(
    ("text", "place", "fix"),
    [
        pytest.param("A.CG\n...\n....", "line 2, column 4", "same length", id="a short row"),
        pytest.param("A.CG\n.....\n....", "line 2, column 5", "same length", id="a long row"),
        pytest.param("A.CG\n\n....", "line 2, column 1", "same length", id="a blank row inside"),
        pytest.param("A.CG\n..x.", "line 2, column 3", "# . A B C G P", id="unknown character"),
        pytest.param("a.CG\n....", "line 1, column 1", "# . A B C G P", id="a small letter"),
        pytest.param("....\n A.CG", "line 2, column 5", "same length", id="an indented row"),
        pytest.param(" A.CG", "line 1, column 1", "# . A B C G P", id="an indented map"),
        pytest.param("A.CG\n...A", "line 2, column 4", "keep one", id="two agents"),
        pytest.param("A.CG\n.C..", "line 2, column 2", "keep one", id="two cans"),
        pytest.param("AGCG\n....", "line 1, column 4", "keep one", id="two goals"),
        pytest.param("APCG\n..P.", "line 2, column 3", "keep one", id="two pickers"),
        pytest.param("..CG\n....", "no agent", "put one 'A'", id="no agent"),
        pytest.param("A..G\n....", "no can", "put one 'C'", id="no can"),
        pytest.param("A.C.\n....", "no goal", "put one 'G'", id="no goal"),
        pytest.param("", "empty", "draw at least one row", id="nothing"),
        pytest.param("\n  \n\n", "empty", "draw at least one row", id="blank lines alone"),
        pytest.param("; A.CG\n;", "empty", "draw at least one row", id="comments alone"),
    ],
)
def test_a_malformed_map_is_refused_with_its_place_and_the_fix(text: str, place: str, fix: str):
    message = refusal(text, name="hall")
    assert place in message
    assert fix in message
    assert "\n" not in message


@pytest.mark.parametrize(
    ("text", "what"),
    [("AACG", "agent"), ("ACCG", "can"), ("ACGG", "goal"), ("ACGBB", "tool")],
)
def test_of_two_of_a_kind_both_places_are_named(text: str, what: str):
    message = refusal(f"......\n.{text}".replace("......", "." * (len(text) + 1)))
    first = text.index(max(text, key=text.count))
    assert f"second {what}" in message
    assert f"line 2, column {first + 2}" in message
    assert f"line 2, column {first + 3}" in message


def test_the_error_of_a_ragged_row_has_both_lengths():
    message = refusal("A.CG\n......")
    assert "6 cells" in message
    assert "4" in message


def test_lines_are_counted_with_comments_and_blank_lines():
    assert "line 6, column 2" in refusal("; one\n\n; two\nA.CG\n; three\n.?..")
    assert "line 5, column 4" in refusal("; one\n\nA.CG\n;\n...")
    message = refusal("; one\n; two\nA.CG\n; three\n..A.")
    assert "line 3, column 1" in message
    assert "line 5, column 3" in message


@given(map_rows(), st.data())
def test_an_unknown_character_is_found_wherever_it_stands(rows: list[str], data: st.DataObject):
    row = data.draw(st.integers(0, len(rows) - 1))
    column = data.draw(st.integers(0, len(rows[0]) - 1))
    unknown = data.draw(st.sampled_from(sorted(set(string.printable.strip()) - set("#.ABCGP;"))))
    comments = data.draw(st.integers(0, 3))
    rows[row] = rows[row][:column] + unknown + rows[row][column + 1 :]
    message = refusal("; a comment\n" * comments + "\n".join(rows))
    assert f"line {comments + row + 1}, column {column + 1}:" in message
    assert repr(unknown) in message


# Another tool


def test_another_tool_takes_the_place_of_the_map_s_own():
    room = World.parse(ROOM)
    assert room.with_tool("picker").tools == (PlacedTool("picker", (0, 3), name="picker"),)
    assert replace(room.with_tool("picker"), tools=room.tools) == room
    assert room.with_tool("picker").text() == ROOM.replace("B", "P")
    assert room.with_tool("broom") == room


def test_without_its_tool_a_map_has_plain_floor_there():
    room = World.parse(ROOM).with_tool("none")
    assert room.tool == "none"
    assert room.tools == ()
    assert room.text() == ROOM.replace("B", ".")


def test_a_tool_can_come_back_after_none():
    room = World.parse(ROOM)
    assert room.with_tool("none").with_tool("broom") == room


def test_an_unknown_tool_is_refused_with_the_known_ones():
    with pytest.raises(ValueError, match=r"'spoon'.*picker, broom, rake, stick, magnet, none"):
        World.parse(ROOM).with_tool("spoon")


@pytest.mark.parametrize("tool", ["picker", "broom"])
def test_a_map_without_a_tool_has_no_place_for_one(tool: str):
    with pytest.raises(ValueError, match=f"room.*no tool.*put '{tool[0].upper()}' on a floor"):
        World.parse("A.CG", name="room").with_tool(tool)


def test_a_map_without_a_tool_may_be_asked_for_none():
    room = World.parse("A.CG")
    assert room.with_tool("none") == room


# Loading


@pytest.mark.parametrize("name", ["corridor", "corridor-b", "yard", "yard-b"])
def test_a_built_in_world_is_the_file_of_that_name_in_the_package(name: str):
    text = (files("habilis.worlds") / "builtin" / f"{name}.txt").read_text("utf-8")
    assert load_world(name) == World.parse(text, name)
    assert name in world_names()


def test_every_built_in_world_loads_by_its_name():
    assert world_names() == sorted(world_names())
    for name in world_names():
        assert load_world(name).name == name


def test_a_map_is_read_from_a_file(tmp_path: Path):
    path = tmp_path / "room.txt"
    path.write_text(f"; Größe 4 × 3\n{ROOM}", "utf-8")
    assert load_world(path) == World.parse(ROOM, name="room.txt")
    assert load_world(str(path)) == load_world(path)


def test_a_loaded_world_takes_the_tool_it_is_given(tmp_path: Path):
    path = tmp_path / "room.txt"
    path.write_text(ROOM)
    assert load_world(path).tool == "broom"
    assert load_world(path, tool="picker") == load_world(path).with_tool("picker")
    assert load_world(path, tool="none").tool == "none"
    assert load_world("yard", tool="broom").tool == "broom"


def test_a_loaded_world_refuses_a_tool_it_cannot_take(tmp_path: Path):
    path = tmp_path / "bare.txt"
    path.write_text("A.CG")
    with pytest.raises(ValueError, match=r"bare\.txt.*no tool"):
        load_world(path, tool="picker")
    with pytest.raises(ValueError, match="'spoon' is unknown"):
        load_world("yard", tool="spoon")


def test_an_unknown_world_is_refused_with_the_known_ones(tmp_path: Path):
    with pytest.raises(
        ValueError, match="corridor, corridor-b, yard, yard-b, or the path of a map file"
    ):
        load_world(tmp_path / "garden")
    with pytest.raises(ValueError, match="garden: no such world"):
        load_world("garden")


def test_a_folder_is_not_a_world(tmp_path: Path):
    with pytest.raises(ValueError, match=tmp_path.name):
        load_world(tmp_path)


def test_a_file_that_is_not_text_is_not_a_world(tmp_path: Path):
    path = tmp_path / "picture.png"
    path.write_bytes(b"\x89PNG\r\n\x1a\n\xff\xfe\x00")
    with pytest.raises(ValueError, match=r"picture\.png: not a text file; give a map"):
        load_world(path)


@pytest.mark.parametrize("name", ["lift.npz", "lift.drn", "lift.py", "lift.py:Lift", "lift.xml"])
def test_a_table_or_a_model_is_no_world_and_is_told_where_it_belongs(name: str):
    """Whether there is such a file or not: a module could be read as a map otherwise."""
    why = "it is Python; of a model in it" if ".py" in name else "it is a table, which"
    why = "it is a MuJoCo model, .* habilis compare lift.xml" if ".xml" in name else why
    with pytest.raises(ValueError, match=rf"^{name}: no such world \({why}.*name one of corridor"):
        load_world(name)


def test_a_malformed_file_is_named_with_the_place_in_it(tmp_path: Path):
    path = tmp_path / "room.txt"
    path.write_text("; a comment\nA.CG\n..?.\n")
    with pytest.raises(ValueError, match=r"^room\.txt, line 3, column 3: unknown character '\?'"):
        load_world(path)


def test_a_byte_order_mark_is_no_cell(tmp_path: Path):
    (tmp_path / "map.txt").write_text("\ufeff; saved by an editor\nAPCG\n", "utf-8")
    assert load_world(tmp_path / "map.txt").agent == (0, 0)


@pytest.mark.parametrize("name", ["AP.CG\n.....\n", "nul\0byte"])
def test_what_is_no_name_is_refused_in_one_line(name: str):
    with pytest.raises(ValueError, match="no such world") as error:
        load_world(name)
    assert str(error.value).isprintable()


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"agent": (0, 2)}, "share a cell"),
        ({"agent": (1, 0)}, "the agent is at \\(1, 0\\); put it on a free cell of the 2 x 4 map"),
        ({"goal": (5, 5)}, "the goal is at"),
        ({"object": (0, 1)}, "share a cell"),
        ({"tool": (1, 0)}, "the tool is at \\(1, 0\\); put it on a free cell of the 2 x 4 map"),
    ],
)
def test_a_world_whose_things_are_not_on_free_cells_of_their_own_is_refused(
    change: dict[str, object], says: str
):
    world = World.parse("APC.\n#..G\n")
    with pytest.raises(ValueError, match=says):
        world.with_cells(**change)  # pyright: ignore[reportArgumentType]


def test_only_files_are_read(tmp_path: Path):
    with pytest.raises(ValueError, match="is not a file"):
        load_world(tmp_path)


# Several things


SHOP = "R = rake\nD = can\nG = goal of C\n.PRA\nC.D.\n..G.\n"


def test_things_are_named_by_their_kinds_and_numbered():
    world = World.parse(SHOP)
    assert [tool.name for tool in world.tools] == ["picker", "rake"]
    assert [thing.name for thing in world.objects] == ["can", "can2"]
    given = replace(world, objects=(replace(world.objects[0], name="tin"), world.objects[1]))
    assert [thing.name for thing in given.objects] == ["tin", "can2"]
    with pytest.raises(ValueError, match="two of can2, can2 have one name; give each its own"):
        replace(world, objects=(replace(world.objects[0], name="can2"), world.objects[1]))


def test_what_is_said_of_the_only_thing_is_said_of_the_first():
    world = World.parse(SHOP)
    assert (world.tool, world.tool_cell) == ("picker", (0, 1))
    assert (world.object, world.goal) == ((1, 0), (2, 2))
    assert not world.single
    assert world.with_tool("rake").with_object("can2").single


def test_a_tool_or_an_object_alone_loses_its_number():
    world = World.parse(SHOP.replace("rake", "picker"))
    assert world.with_tool(world.tools[1]).tools[0].name == "picker"
    alone = world.with_object("can2").objects
    assert [(thing.name, thing.cell, thing.goal) for thing in alone] == [("can", (1, 2), (2, 2))]


def test_things_are_put_into_other_cells_by_their_names():
    world = World.parse(SHOP)
    moved = world.with_cells(tool={"rake": (2, 0)}, object={"can2": (0, 3), "can": (0, 2)})
    assert [tool.cell for tool in moved.tools] == [(0, 1), (2, 0)]
    assert [thing.cell for thing in moved.objects] == [(0, 2), (0, 3)]
    assert moved.agent == (0, 0)  # the first free cell, as a can is where the agent was
    assert world.with_cells() == world
    assert world.with_cells(agent=(1, 1), held=1).in_hand == 1


@pytest.mark.parametrize(
    ("where", "says"),
    [
        ({"object": (0, 0)}, "several objects, can, can2; specify which is at .* as can=0,0"),
        ({"object": {"tin": (0, 0)}}, "map has no object 'tin'; name one of can, can2"),
        ({"tool": {"rake": (1, 0)}}, "share a cell"),
    ],
)
def test_cells_of_nothing_or_taken_are_refused(where: dict[str, Any], says: str):
    with pytest.raises(ValueError, match=says):
        World.parse(SHOP).with_cells(**where)
    with pytest.raises(ValueError, match="map has no tool here; leave out its cell"):
        World.parse("A.CG").with_cells(tool=(0, 1))


def test_a_world_has_an_object_with_a_goal_first():
    world = World.parse(SHOP)
    with pytest.raises(ValueError, match="map: the first object, the can2, has no goal; give"):
        replace(world, objects=world.objects[::-1])
    with pytest.raises(ValueError, match="map: it has no object; give it one"):
        replace(world, objects=())
