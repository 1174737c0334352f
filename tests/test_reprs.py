"""Results show themselves in a line of text, and in notebooks as pictures."""

import pickle
from dataclasses import replace
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import polars as pl
import pytest

import habilis as hb
from habilis.analysis import futures, usefulness
from habilis.bridges.puzzles.pushworld import PushWorld
from habilis.learning.curves import learning_curve
from habilis.learning.runs import Run
from habilis.reprs import bars_svg, counted, listed, number, quietly, repeated, settings, table_html
from habilis.studies.comparison import Comparison
from habilis.worlds.pictures.svg import chosen_places, world_svg

SVG = "{http://www.w3.org/2000/svg}"
HOSTILE = '<img src=x onerror="alert(1)">&\'"'
ROOM = hb.World.parse("D = ball\nG = goal of C\nA.P.\n..C.\n.D..\n...G", "room")
LEFT = np.zeros((2, 1), np.int32)
LINE = hb.World.parse("A.CG", "line")
PUZZLE = PushWorld.parse("A M0 . G0", "push")
YARD = hb.load_world("yard")


def solved(model):
    plan = hb.solve(model)
    assert plan is not None
    return plan


def cell_of(use):
    return int(use.get("y")), int(use.get("x"))


def parsed(svg):
    root = ElementTree.fromstring(svg)
    assert root.tag == f"{SVG}svg"
    used = {use.get("href") for use in root.iter(f"{SVG}use")}
    assert used <= {f"#{element.get('id')}" for element in root.iter()}
    return root


class Tags(HTMLParser):
    """The elements of HTML, and whether each is closed in turn."""

    def __init__(self, text):
        super().__init__()
        self.names, self.open, self.text = [], [], ""
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.names.append(tag)
        self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.names.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


def run_of(episodes=120, name="line"):
    steps = np.concatenate([np.linspace(40, 2, episodes), np.linspace(30, 2, episodes)])
    table = pl.DataFrame(
        {
            "run": np.repeat([0, 1], episodes).astype(np.int32),
            "episode": np.tile(np.arange(episodes), 2).astype(np.int32),
            "steps": steps.astype(np.int32),
            "return": (1 - steps).astype(np.float32),
        }
    )
    config = hb.Config(world="yard", runs=2, intrinsic="object", horizon=2, beta=0.1)
    return Run(config, replace(LINE, name=name), -1.0, table, (100, None), None)


MDP = hb.TabularMDP.deterministic([[0, 1], [1, 0]])

LINES = {
    "world": (
        ROOM,
        "<World room: 4 × 4 cells, 0 walls; agent (0, 0), picker (0, 2), can (1, 2), ball (2, 1); "
        "can's goal (3, 3)>",
    ),
    "puzzle": (
        PUZZLE,
        "<PushWorld push: 1 × 4 cells, 0 walls; agent (0, 0), m0 (0, 1); m0 to (0, 3)>",
    ),
    "plan": (solved(LINE), "<Plan: 2 steps, return -1; east ×2>"),
    "plan of a puzzle": (solved(PUZZLE), "<Plan: 2 steps, return -1; right ×2>"),
    "plan by numbers": (
        solved(hb.TabularMDP.deterministic([[1], [1]], terminal=[False, True])),
        "<Plan: 1 step, return 0; 0>",
    ),
    "bare table": (MDP, "<TabularMDP: 2 states, 2 actions, deterministic; start 0>"),
    "noisy table": (
        MDP.slippery(0.5),
        "<TabularMDP: 2 states, 2 actions, stochastic; start 0>",
    ),
    "table": (
        hb.tabulate(LINE),
        "<TabularMDP: 12 states, 4 actions, deterministic; factors agent, object; "
        "flags equipped, attached; start 1: agent (0, 0), object (0, 2)>",
    ),
    "landscape": (
        hb.landscape(LINE, 1, "object"),
        "<Landscape: line; 1-step empowerment, sensor 'object'; 0.00 to 1.00 bits in 3 cells>",
    ),
    "pairs": (
        hb.pairs(ROOM, 2),
        "<Pairs: room: average object empowerment; bits for h = 2>\n"
        "         can  ball\n"
        "picker  0.81  0.79\n"
        "none    0.41  0.37",
    ),
    "capacity": (
        hb.Capacity(0.5, 2e-9, np.array([0.5, 0.5, 0.0])),
        "<Capacity: 0.500000 bits; gap 2.0e-09; 2 of 3 inputs used>",
    ),
    "run": (
        run_of(),
        "<Run: line; a2c, object, weight 0.1; 2 runs, 240 episodes; 1 of 2 converged, after 100 "
        "episodes on average; best return -1>",
    ),
    "comparison": (
        Comparison(0.9, 0.01, 5, 4),
        "<Comparison: holds; superiority 0.90, p = 0.01; 5 and 4 runs converged>",
    ),
    "configuration": (
        hb.Config(world="yard", algorithm=hb.PPO(envs=4), intrinsic="object", horizon=3, beta=0.1),
        "Config(world='yard', algorithm=PPO(envs=4), intrinsic='object', horizon=3, beta=0.1)",
    ),
    "plain configuration": (hb.Config(), "Config()"),
    "configuration of a table": (
        hb.Config(world=MDP),
        "Config(world=<TabularMDP: 2 states, 2 actions, deterministic; start 0>)",
    ),
    "usefulness": (
        usefulness(hb.World.parse("APCG", "line"), 1),
        "<Usefulness: 0.5000 with the tool, 0.3333 without; better than none in 33% of 12 states; "
        "encumbers in 0%>",
    ),
    "futures": (
        replace(futures(MDP, 0, 1), gap=0.0),
        "<Futures: 1.0000 bits, gap 0.0e+00; 2 sequences of 1 action, 2 observations>",
    ),
}


@pytest.mark.parametrize("name", LINES)
def test_a_result_is_a_line_with_its_names_and_numbers(name):
    thing, line = LINES[name]
    assert repr(thing) == line


def test_a_world_is_printed_as_its_map():
    assert str(YARD) == YARD.text().rstrip("\n")
    assert hb.World.parse(str(ROOM), "room") == ROOM
    assert str(LINE.with_cells(object=(0, 3))) == "A..C"  # a can on its goal hides that


def test_the_line_of_a_world_does_not_depend_on_the_order_of_its_walls():
    cells = [(row, column) for row in range(3) for column in range(4)]
    world = hb.World.parse("A.CG\n" + "####\n" * 3)
    walls = frozenset((row + 1, column) for row, column in reversed(cells))
    other = replace(world, walls=walls)
    assert repr(other) == repr(world)
    assert other._repr_svg_() == world._repr_svg_()


@pytest.mark.parametrize("world", [YARD, ROOM, LINE, PUZZLE], ids=lambda world: world.name)
def test_a_notebook_draws_worlds_and_puzzles(world):
    root = parsed(world._repr_svg_())
    assert root.findtext(f"{SVG}title") == world.name
    assert root.get("viewBox") == f"0 0 {world.width} {world.height}"
    assert world._repr_svg_() == world._repr_svg_()


def test_every_wall_and_thing_is_in_its_cell():
    root = parsed(YARD._repr_svg_())
    things = {cell_of(use) for use in root.findall(f"{SVG}use")}  # walls are in the background
    assert things == {(0, 0), YARD.agent, YARD.tool_cell, YARD.object, YARD.goal}
    groups = root.iter(f"{SVG}g")
    assert {cell_of(use) for group in groups for use in group.findall(f"{SVG}use")} == YARD.walls


def test_a_plan_is_a_strip_of_its_states_with_the_actions_below():
    plan = solved(hb.tabulate(LINE))
    tags = Tags(plan._repr_html_())
    assert tags.names.count("title") == plan.steps + 1
    assert tags.text == "line" + "east" + "line" + "east" + "line" + "return -1"
    assert Tags(solved(PUZZLE)._repr_html_()).names.count("title") == 3
    explored = solved(hb.explore(PUZZLE))
    assert explored._repr_html_() == solved(PUZZLE)._repr_html_()


def test_a_long_plan_shows_its_beginning_and_its_end():
    assert chosen_places(12) == list(range(12))
    assert chosen_places(40) == [*range(6), *range(34, 40)]
    far = hb.World.parse(f"A{'.' * 30}CG")
    tags = Tags(solved(far)._repr_html_())
    assert tags.names.count("title") == 12
    assert "…" in tags.text


def test_a_plan_of_what_has_no_map_is_text():
    assert solved(hb.TabularMDP.deterministic([[1], [1]], terminal=[0, 1]))._repr_html_() is None


def test_a_table_has_its_sizes_and_the_picture_of_its_start():
    tags = Tags(hb.tabulate(ROOM)._repr_html_())
    assert {"table", "img"} <= {*tags.names}
    assert "8: north, east, south, west, tool north" in tags.text
    assert "agent (0, 0), tool:picker (0, 2), object:can (1, 2)" in tags.text
    assert "img" not in Tags(MDP._repr_html_()).names


def test_tables_travel_without_their_map():
    mdp = hb.tabulate(LINE)
    assert mdp.drawn == LINE
    copy = pickle.loads(pickle.dumps(mdp))
    assert copy.drawn is None
    assert repr(copy) == repr(mdp)
    assert solved(copy)._repr_html_() is None


def test_a_run_is_its_learning_curve_and_a_capacity_its_distribution():
    root = parsed_figure(run_of()._repr_svg_())
    assert "line (2 runs)" in root
    assert run_of()._repr_svg_() == run_of()._repr_svg_()
    assert repr(learning_curve(run_of())).startswith("<Curve: mean return -")
    tags = Tags(hb.capacity(np.eye(3))._repr_html_())
    assert "1.584963" in tags.text
    assert "3 of 3" in tags.text


def parsed_figure(svg):
    return "".join(ElementTree.fromstring(svg.encode()).itertext())


def test_a_run_that_has_no_curve_yet_is_text():
    assert run_of(episodes=0)._repr_svg_() is None


def test_names_cannot_become_markup():
    world = replace(LINE, name=HOSTILE)
    assert parsed(world._repr_svg_()).findtext(f"{SVG}title") == HOSTILE
    mdp = replace(hb.tabulate(world), actions=(HOSTILE,) * 4)
    for thing in (mdp, solved(mdp)):
        tags = Tags(thing._repr_html_())
        assert HOSTILE in tags.text
        assert tags.names.count("img") == (thing is mdp)  # the picture of the start
        assert "onerror" not in thing._repr_html_().replace("onerror=&quot;alert", "")
    assert HOSTILE in parsed_figure(run_of(name=HOSTILE)._repr_svg_())
    assert Tags(table_html(HOSTILE, {HOSTILE: HOSTILE})).names.count("img") == 0


def test_names_cannot_break_the_line_or_move_the_cursor():
    mdp = replace(hb.TabularMDP.deterministic(LEFT), factors={"a\nb\x1b[2J\u202e": LEFT[:, 0]})
    assert "factors a\\nb\\x1b[2J\\u202e;" in repr(mdp)
    assert repr(replace(LINE, name="é\n≤")).startswith("<World é\\n≤: ")


def test_a_map_too_large_to_draw_unasked_is_text():
    large = replace(LINE, height=200, width=200)
    assert world_svg(large) is None
    assert large._repr_svg_() is None
    assert "200 × 200 cells" in repr(large)


def test_what_cannot_be_drawn_is_text_and_no_traceback():
    broken = replace(hb.tabulate(LINE), start=10**6)
    assert broken._repr_html_() is None
    assert repr(broken).startswith("<habilis.mdp.TabularMDP object at 0x")
    assert repr(hb.Config.__new__(hb.Config)).startswith("<habilis.learning.config.Config object")

    class Thing:
        @quietly
        def _repr_html_(self):
            return 1 / 0

    assert Thing()._repr_html_() is None


def test_words_of_numbers_and_lists():
    assert counted(0, "state") == "0 states"
    assert counted(2, "entry", "entries") == "2 entries"
    assert number(-0.0) == "0"
    assert number(-12345.0) == "-12,345"
    assert number(0.12345) == "0.1235"
    assert number(float("-inf")) == "-inf"
    assert repeated([]) == ""
    assert listed(str(k) for k in range(15)).endswith("11, and 3 more")
    ElementTree.fromstring(bars_svg(np.zeros(0)))
    assert len(bars_svg(np.full(10_000, 1e-4))) < 5000


def test_the_line_of_a_configuration_makes_it():
    config = hb.Config(world="yard", algorithm=hb.QLearning(learning_rate=0.3), runs=4, seed=2)
    assert eval(repr(config), vars(hb) | {"Config": hb.Config, "QLearning": hb.QLearning}) == config
    assert settings(config, ("algorithm",)) == repr(config)
