"""A tool of one's own is one small class in one's own file, and works wherever a built-in does."""

import inspect
import json
import pickle
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from before_after import becomes, stays

import habilis as hb
from habilis.analysis.averages import average_empowerment, compare
from habilis.analysis.futures import futures
from habilis.analysis.usefulness import usefulness
from habilis.cli import main
from habilis.worlds import tools
from habilis.worlds.map_text import BINDS
from habilis.worlds.own_tools import tool_named
from habilis.worlds.pictures.figures import colored_text, frame
from habilis.worlds.pictures.shapes import SHAPES, Shape
from habilis.worlds.table import tabulate
from habilis.worlds.tools import Picker
from habilis.worlds.world import World, load_world

EXAMPLE = Path(__file__).parents[2] / "examples" / "rake.py"
RAKE = "rake.py:Rake"
ROOM = "A..\nRC.\n..G\n"


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """The working directory, with a rake in it."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(EXAMPLE, tmp_path)
    return tmp_path


def written(folder: Path, text: str, name: str = "mytools.py") -> str:
    """A file whose tools are those of the rake's file and what the text adds to them."""
    (folder / name).write_text(EXAMPLE.read_text() + text)
    return name


def refusal(name: str) -> str:
    with pytest.raises(ValueError, match=r"^tool") as caught:
        load_world("yard", tool=name)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def run(*arguments: str) -> subprocess.CompletedProcess:
    code = "import sys; from habilis.cli import main; sys.exit(main())"
    command = [sys.executable, "-c", code, *arguments]
    return subprocess.run(command, capture_output=True, text=True)


# The example, as pictures before and after


def raked(pictures: str, *actions: str) -> None:
    becomes(pictures, *actions, above=f"R = {EXAMPLE}:Rake")


def test_the_example_is_twenty_lines():
    assert len(EXAMPLE.read_text().splitlines()) <= 22
    hb.check_tool(f"{EXAMPLE}:Rake")


def test_the_rake_pulls_what_is_behind_it_when_the_agent_backs_away():
    raked(
        """
        .....   .....
        ..ARC   .ARC.
        G....   G....
        """,
        "west",
    )


def test_the_rake_pulls_again_and_again():
    raked(
        """
        ...ARC   ARC...
        G.....   G.....
        """,
        *("west", "west", "west"),
    )


def test_what_is_beside_the_rake_stays():
    raked(
        """
        ...C.   ...C.
        ..AR.   .AR..
        G....   G....
        """,
        "west",
    )


def test_the_rake_is_blocked_by_what_it_runs_into():
    stays(
        """
        ..ARC.
        G.....
        """,
        "east",
        above=f"R = {EXAMPLE}:Rake",
    )


def test_what_is_behind_the_rake_stays_when_it_goes_sideways_or_is_swung():
    for action, after in (("north", ("..AR.", "....C")), ("tool west", (".....", ".RA.C"))):
        raked(
            f"""
            .....   {after[0]}
            ..ARC   {after[1]}
            G....   G....
            """,
            action,
        )


def test_without_the_rake_in_hand_nothing_is_pulled():
    raked(
        """
        .A.RC   A..RC
        G....   G....
        """,
        "west",
    )


# Finding it


@pytest.mark.parametrize("tool", [RAKE, "./rake.py:Rake", "rake:Rake"])
def test_a_tool_is_found_in_a_file_and_in_a_module(tool, monkeypatch):
    monkeypatch.delitem(sys.modules, "rake", raising=False)
    world = load_world("yard", tool=tool)
    assert world.tool == tool
    assert type(world.tools[0].rule).__name__ == "Rake"
    monkeypatch.delitem(sys.modules, "rake", raising=False)


def test_a_file_is_run_once_and_again_when_it_has_changed(folder):
    counting = "with open('count', 'a') as file:\n    file.write('.')\n"
    name = f"{written(folder, counting)}:Rake"
    first = tool_named(name)
    assert tool_named(name) is first
    assert load_world("yard", tool=name) == load_world("yard").with_tool(name)
    assert (folder / "count").read_text() == "."
    world = load_world("yard", tool=name)
    written(folder, f"{counting}Rake.character = 'H'\n")
    assert tool_named(name).character == "H"
    assert replace(world, agent=(0, 0)).tools[0].rule is first
    assert world.with_tool(name) != world
    assert (folder / "count").read_text() == ".."


def test_a_file_may_import_one_beside_it_wherever_it_is_named_from(folder, monkeypatch):
    (folder / "elsewhere").mkdir()
    (folder / "beside_mytools.py").write_text("letter = 'H'\n")
    name = written(folder, "from beside_mytools import letter\nRake.character = letter\n")
    monkeypatch.chdir(folder / "elsewhere")
    before = list(sys.path)
    assert tool_named(f"../{name}:Rake").character == "H"
    assert sys.path == before


def test_an_instance_with_arguments_can_be_named(folder):
    text = "\nclass Long(Rake):\n    def __init__(self, length):\n        self.length = length\n"
    name = written(folder, f"{text}\nlong = Long(3)\n")
    tool = load_world("yard", tool=f"{name}:long").tools[0].rule
    assert vars(tool) == {"length": 3}


@pytest.mark.parametrize(
    ("text", "name", "says"),
    [
        ("", "there.py:Rake", "there.py cannot be read (No such file or directory); give the path"),
        ("", ".py:Rake", "cannot be read"),
        ("", "mytools.py:Rack", "there is no class 'Rack' in it; it has Rake"),
        ("", "mytools.py:", "there is no class '' in it"),
        ("x = 1 / 0\n", "mytools.py:Rake", "ZeroDivisionError: division by zero (mytools.py, line"),
        ("def (\n", "mytools.py:Rake", "SyntaxError: invalid syntax (mytools.py, line"),
        ("raise SystemExit\n", "mytools.py:Rake", "mytools.py fails with SystemExit"),
        ("import nothing_here\n", "mytools.py:Rake", "No module named 'nothing_here' (mytools.py"),
        ("", "nothing_here:Rake", "No module named 'nothing_here'; name a module that Python"),
        ("", "nothing_here:Rake", "or a file as nothing_here.py:CLASS"),
        ("del Rake.swing\n", "mytools.py:Rake", "Rake has no method 'swing'; a tool has attached,"),
        ("del Rake.character\n", "mytools.py:Rake", "Rake has no character; give it one"),
        ("Rake.character = 'AB'\n", "mytools.py:Rake", "character is 'AB'; give one printable"),
        ("Rake.character = 7\n", "mytools.py:Rake", "character is 7; give one printable"),
        ("Rake.character = '\\n'\n", "mytools.py:Rake", "give one printable character"),
        ("Rake.character = 'C'\n", "mytools.py:Rake", "'C' stands for the can on a map; give ano"),
        ("Rake.character = ';'\n", "mytools.py:Rake", "stands for a comment on a map"),
        ("Rake.character = ' '\n", "mytools.py:Rake", "stands for nothing on a map"),
        (
            "Rake.__init__ = lambda s, n: 0\n",
            "mytools.py:Rake",
            "give its arguments defaults, or name",
        ),
        ("Rake = 3\n", "mytools.py:Rake", "int has no method 'attached'"),
    ],
)
def test_invalid_tools_are_refused_in_a_line_with_the_fix(text, name, says, folder, capsys):
    written(folder, text)
    assert says in refusal(name)
    assert main(["solve", "yard", "--tool", name]) == 2
    assert capsys.readouterr().err == f"habilis: {refusal(name)}\n"


def test_the_line_that_fails_is_named_and_a_fixed_file_is_read(folder):
    lines = EXAMPLE.read_text().splitlines()
    written(folder, "1 / 0\n")
    assert f"(mytools.py, line {len(lines) + 1}); fix the file" in refusal("mytools.py:Rake")
    written(folder, "")
    assert load_world("yard", tool="mytools.py:Rake").tools


@pytest.mark.ill_typed
def test_a_tool_is_given_as_itself_or_as_its_class():
    rake = tool_named(RAKE)
    yard = load_world("yard")
    by_name = tabulate(yard.with_tool(RAKE))
    for given in (rake, type(rake)):
        world = yard.with_tool(given)
        assert world.tool == RAKE
        assert (tabulate(world).next_state == by_name.next_state).all()
    assert load_world("yard", tool=rake).tools[0].rule is rake
    assert yard.with_tool(Picker()) == yard.with_tool("picker")
    with pytest.raises(ValueError, match="'int': int has no method 'attached'"):
        yard.with_tool(3)  # pyright: ignore[reportArgumentType]


def test_worlds_with_tools_of_one_class_are_distinguished():
    kind: type = type(tool_named(RAKE))
    one, other = load_world("yard", tool=kind()), load_world("yard", tool=kind())
    assert one.tool == other.tool
    assert one != other
    assert one == replace(one)
    assert hash(one) == hash(other)


def test_another_tool_takes_the_place_of_ones_own():
    raking = load_world("yard", tool=tool_named(RAKE))
    assert replace(raking, agent=(0, 0)).tools[0].rule is raking.tools[0].rule
    assert raking.with_tool("broom") == load_world("yard", tool="broom")
    assert raking.with_tool("none") == load_world("yard", tool="none")


# In map text


def test_a_map_with_a_tool_of_ones_own_is_written_as_it_was_read(folder):
    text = f"R = {RAKE}\n{ROOM}"
    world = World.parse(text)
    assert (world.tool, world.tool_cell) == (RAKE, (1, 0))
    assert world.text() == text
    assert World.parse(world.text()) == world
    assert world.rows == tuple(ROOM.split())
    assert world.with_tool("broom").text() == ROOM.replace("R", "B")
    assert load_world("yard", tool=RAKE).text().startswith(f"R {BINDS} {RAKE}\n....")


def test_a_character_is_bound_to_a_tool_above_the_map():
    above = f"; a rake\n\nX={RAKE}\n; the map\n\n"
    bound = World.parse(above + ROOM.replace("R", "X"))
    assert bound == World.parse(f"R = {RAKE}\n{ROOM}")
    assert World.parse(f"R = broom\n{ROOM}") == World.parse(ROOM.replace("R", "B"))
    assert World.parse(f"P = broom\n{ROOM.replace('R', 'P')}").tool == "broom"


def test_a_map_file_names_tools_beside_it_or_from_the_working_directory(folder):
    (folder / "maps").mkdir()
    (folder / "maps" / "room.txt").write_text(f"R = {RAKE}\n{ROOM}")
    assert load_world("maps/room.txt").tool == RAKE
    (folder / "rake.py").rename(folder / "maps" / "rake.py")
    assert load_world("maps/room.txt").tool == f"maps/{RAKE}"


@pytest.mark.parametrize(
    ("above", "says"),
    [
        ("R = there.py:Rake", "hall, line 1: tool 'there.py:Rake': .*there.py cannot be read"),
        ("; a rake\nR = rake.py:Rack", "hall, line 2: .*it has Rake"),
        (
            "R = spoon",
            "hall, line 1: 'R' is bound to 'spoon', which is .*; bind it to a tool .picker, broom",
        ),
        ("A = rake.py:Rake", "hall, line 1: character 'A' stands for the agent on a map"),
        (
            "R = rake.py:Rake\nR = broom",
            "hall, line 2: 'R' is bound a second time, first in line 1",
        ),
        ("H = rake.py:Rake", "hall, line 3, column 1: unknown character 'R'; use one of .* H P"),
        ("H = rake.py:Rake", "bind it above the map, as in 'R = mytools.py:Rake'"),
    ],
)
def test_a_character_bound_wrongly_is_refused_with_its_line(above, says):
    with pytest.raises(ValueError, match=says) as caught:
        World.parse(f"{above}\n{ROOM}", name="hall")
    assert "\n" not in str(caught.value)


def test_a_map_of_bindings_alone_is_empty():
    with pytest.raises(ValueError, match="the map is empty"):
        World.parse(f"R = {RAKE}\n")


def test_a_map_without_a_place_for_it_says_how_to_give_it_one():
    with pytest.raises(
        ValueError, match=r"put 'R' on a floor cell, and a line 'R = rake\.py:Rake'"
    ):
        World.parse("A.CG").with_tool(RAKE)


# Wherever a built-in tool works


@pytest.fixture
def copied(folder) -> str:
    """The picker's own code, in a user's file."""
    head = "import numpy as np\nfrom habilis.worlds.tools import Cells, Flags\n\n"
    code = inspect.getsource(Picker).replace('    drawing = SHAPES["picker"]\n', "")
    (folder / "copied.py").write_text(head + code.replace('"P"', '"Y"'))
    return "copied.py:Picker"


def test_a_copy_of_the_picker_has_the_pickers_table_and_numbers(copied):
    for name in ("corridor", "yard"):
        own, ours = (tabulate(load_world(name, tool)) for tool in (copied, "picker"))
        assert own.next_state.tobytes() == ours.next_state.tobytes()
        for labels in ("factors", "flags"):
            pairs = (getattr(mdp, labels) for mdp in (own, ours))
            for one, other in zip(*(arrays.values() for arrays in pairs), strict=True):
                assert one.tobytes() == other.tobytes()
        for horizon in range(1, 5):
            for sensor in ("state", "object"):
                one, other = (hb.empowerment(mdp, horizon, sensor) for mdp in (own, ours))
                np.testing.assert_array_equal(one, other)


def test_a_copy_of_the_picker_is_as_useful_and_has_its_futures(copied):
    yard = load_world("yard")
    averages = compare(yard, [copied, "picker"], 3)
    assert averages[copied] == averages["picker"]
    own, ours = (usefulness(yard.with_tool(tool), 3) for tool in (copied, "picker"))
    assert (own.better_than_none == ours.better_than_none).all()
    mdps = [tabulate(yard.with_tool(tool)) for tool in (copied, "picker")]
    own, ours = (futures(mdp, mdp.start, 3, "object") for mdp in mdps)
    assert (own.sequences == ours.sequences).all()


def test_without_a_table_the_numbers_are_the_same(folder):
    world = World.parse(f"R = {RAKE}\n{ROOM}")
    mdp = tabulate(world)
    places = {"agent": world.agent, "tool": world.tool_cell, "object": world.object}
    state = mdp.find(**places)
    for horizon in range(4):
        bits = hb.empowerment(world, horizon, "object", states=places)
        assert bits == hb.empowerment(mdp, horizon, "object", states=[state])
    assert average_empowerment(tabulate(world, slip=0.1), 2) > 0


def test_tools_that_go_by_one_name_are_not_compared():
    kind: type = type(tool_named(RAKE))
    with pytest.raises(ValueError, match=r"two of the tools have one name, 'rake\.py:Rake'"):
        compare(load_world("yard"), [kind(), kind()], 1)
    assert list(compare(load_world("yard"), [kind(), "none"], 1)) == [RAKE, "none"]


def test_a_tool_is_drawn_as_it_says_or_as_any_tool(folder):
    red = "from habilis.worlds.pictures.shapes import Shape\n"
    red += "Rake.drawing = (Shape(((0, 0.5), (1, 0.5), (1, 1), (0, 1)), '#ff0000'),)\n"
    room = World.parse("....G\n.AP..\n....C\n")
    plain, own = (
        frame(room.with_tool(name))[32:64, 64:96] for name in (RAKE, f"{written(folder, red)}:Rake")
    )
    assert (own == (255, 0, 0)).all(axis=2)[:, 17:].all()  # turned: away from the agent
    assert not (own == (255, 0, 0)).all(axis=2)[:, :15].any()
    for known in ("picker", "broom"):
        assert (frame(room.with_tool(known))[32:64, 64:96] != plain).any()
    assert tools.drawing_of(tool_named(RAKE)) == SHAPES["tool"]
    assert all(isinstance(shape, Shape) for shape in SHAPES["tool"])


def test_a_tool_is_shown_in_coloured_text_without_what_is_above_the_map():
    text = colored_text(World.parse(f"R = {RAKE}\n{ROOM}"))
    assert text.plain.split("\n") == ["A . . ", "R C . ", ". . G "]
    style = {text.plain[span.start]: span.style for span in text.spans if span.end > span.start}
    assert style["R"] not in (style["."], style["A"], style["C"], style["G"])


def test_a_world_goes_to_another_process_and_to_another_folder(folder, tmp_path_factory):
    world = load_world("yard", tool=RAKE)
    (folder / "world.pickle").write_bytes(pickle.dumps(world))
    assert pickle.loads(pickle.dumps(world)).tool == RAKE
    code = (
        "import pickle, sys, habilis as hb; world = pickle.load(open(sys.argv[1], 'rb'));"
        "print(world.tool, hb.tabulate(world).next_state.sum())"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, folder / "world.pickle"],
        **{"cwd": tmp_path_factory.mktemp("elsewhere"), "capture_output": True, "text": True},
    )
    assert done.stdout.split() == [RAKE, str(tabulate(world).next_state.sum())], done.stderr


# Answers that no map has a place for


@pytest.mark.parametrize(
    ("method", "body", "says"),
    [
        ("carry", "thing + 3 * step", r"carry puts the object at \(.*\) with agent .*, north; let"),
        ("carry", "thing + 5", r"carry .*let it land within 2 rows and columns of the agent"),
        ("carry", "thing - 10**9", r"carry puts the object at"),
        ("swing", "agent * 0", r"swing puts the object at \(-2, -2\)"),
        ("carry", "thing / 2", r"carry returns float64 of shape \(\d+,\).*integer cells of that"),
        ("swing", "thing[:1]", r"swing returns int64 of shape \(1,\) for cells of shape"),
        ("swing", "None", r"swing returns object of shape \(\)"),
        ("attached", "thing", r"attached returns int64 of shape .*; return bool of that shape"),
        ("attached", "False", r"attached returns bool of shape \(\)"),
        (
            "carry",
            "thing.nothing",
            r"carry fails with AttributeError: .* \(rake\.py, line 2[0-9]\)",
        ),
        ("carry", "thing.sort()", r"carry fails with ValueError: .*read-only"),
    ],
)
@pytest.mark.ill_typed
def test_an_answer_without_a_place_on_the_map_is_an_error_with_a_name(method, body, says, folder):
    step = "" if method == "attached" else ", step"
    text = f"\n\ndef answer(self, agent, tool, thing{step}):\n    return {body}\n\n\n"
    written(folder, f"{text}Rake.{method} = answer\n", "rake.py")
    world = load_world("yard", tool=RAKE)
    with pytest.raises(ValueError, match=rf"tool 'rake\.py:Rake': {says}") as caught:
        tabulate(world)
    assert "\n" not in str(caught.value)
    places = {"agent": (3, 1), "tool": (3, 0), "object": (4, 0)}
    with pytest.raises(ValueError, match=r"tool 'rake\.py:Rake'"):
        hb.empowerment(world, 2, states=places)


def test_a_tool_is_not_asked_about_placements_in_which_it_is_not_in_hand(folder):
    text = "\nasked = []\n\n\ndef carry(self, agent, tool, thing, step):\n"
    text += "    asked.append((agent, tool, thing))\n    return thing\n\n\nRake.carry = carry\n"
    written(folder, text, "rake.py")
    world = World.parse(f"R = {RAKE}\nA...\n..CR\n...G\n")
    tabulate(world)
    hb.empowerment(world, 2, states={"agent": (0, 0), "tool": (1, 3), "object": (1, 2)})
    asked = [np.concatenate(cells) for cells in zip(*sys.modules["rake.py"].asked, strict=True)]
    agent, tool, thing = asked
    assert len(agent)
    assert set(np.abs(agent - tool)) == {1, 4 + 4}
    assert ((thing != agent) & (thing != tool)).all()


# On the command line


def test_a_tool_is_compared_in_a_process_of_its_own():
    done = run("compare", "yard", "--tools", f"{RAKE},broom,none", "--horizon", "3", "--json")
    averages = json.loads(done.stdout)["averages"]
    assert list(averages) == [RAKE, "broom", "none"]
    assert averages == compare(load_world("yard"), [RAKE, "broom", "none"], 3)
    assert averages["none"] < averages["broom"] < averages[RAKE]


def test_a_tool_goes_through_the_verbs_that_look_at_a_world(folder, capsys):
    assert main(["solve", "corridor", "--tool", RAKE]) == 0
    assert main(["worlds", "yard", "--tool", RAKE, "--out", "yard.png", "--json"]) == 0
    shown = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert shown["tool"] == RAKE
    assert shown["map"] == list(load_world("yard", RAKE).rows)
    for verb in ("landscape", "futures"):
        arguments = ["--tool", RAKE, "--sensor", "object", "--horizon", "2", "--out"]
        assert main([verb, "yard", *arguments, f"{verb}.png"]) == 0
        assert (folder / f"{verb}.png").read_bytes().startswith(b"\x89PNG")
    (folder / "room.txt").write_text(f"R = {RAKE}\n{ROOM}")
    assert main(["empowerment", "room.txt", "--sensor", "object", "--horizon", "2"]) == 0
    assert main(["worlds", "room.txt"]) == 0
    assert capsys.readouterr().out.endswith("A . . \nR C . \n. . G \n")


def test_a_tool_that_fails_when_asked_is_one_line_on_the_command_line(folder, capsys):
    written(folder, "Rake.carry = lambda *_: 1 / 0\n", "rake.py")
    assert main(["solve", "yard", "--tool", RAKE]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert "carry fails with ZeroDivisionError: division by zero (rake.py, line" in err


# What the documentation says


def test_the_page_about_it_runs_and_its_rake_is_the_example(folder, monkeypatch):
    root = EXAMPLE.parents[1]
    page = (root / "docs" / "how-to" / "own-tool.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    assert blocks[0].split("class")[1] == EXAMPLE.read_text().split("class")[1]
    shutil.copytree(root / "examples", folder / "examples")
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", "\n".join(blocks)], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert "leaves behind an object that it reports as attached" in done.stdout
    assert sorted(path.name for path in folder.iterdir()) == ["examples", "rake.py"]


ILL_BEHAVED = """
import sys
from habilis.worlds.tools import Broom
class Character(Broom):
    @property
    def character(self): raise RuntimeError("no")
class Drawing(Broom):
    @property
    def drawing(self): raise RuntimeError("no")
class Made(Broom):
    def __init__(self): sys.exit(0)
class Asked(Broom):
    def carry(self, agent, tool, thing, step): sys.exit(0)
"""


@pytest.mark.parametrize("name", ["Character", "Drawing", "Made", "Asked"])
def test_a_tool_that_leaves_or_fails_in_a_property_is_one_line(name, tmp_path, capsys):
    (tmp_path / "ill.py").write_text(ILL_BEHAVED)
    verb = ["landscape", "yard", "--horizon", "1", "--tool", f"{tmp_path / 'ill.py'}:{name}"]
    assert main(verb) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert f":{name}" in said
    assert "fails with" in said
