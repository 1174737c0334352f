"""Invalid tools are refused with the placement and the fix; valid ones pass."""

from pathlib import Path

import numpy as np
import pytest

import habilis as hb
from habilis.worlds.pictures.shapes import Shape
from habilis.worlds.table import tabulate
from habilis.worlds.tools import TOOLS, Broom, Picker, Tool
from habilis.worlds.world import World

RAKE = f"{Path(__file__).parents[2] / 'examples' / 'rake.py'}:Rake"


class Plain:
    """Moves nothing."""

    character = "X"

    def attached(self, agent, tool, thing):
        return np.zeros(thing.shape, bool)

    def carry(self, agent, tool, thing, step):
        return thing

    def swing(self, agent, tool, thing, step):
        return thing


class Magnet(Plain):
    """Draws what is in line, one cell beyond the tool, up to it: asks of nothing far away."""

    def carry(self, agent, tool, thing, step):
        forward = tool - agent
        return np.where(thing - tool == 2 * forward, thing - forward, thing)


class Remembers(Plain):
    def __init__(self):
        self.swung = False

    def carry(self, agent, tool, thing, step):
        return np.where((thing == tool + step) & self.swung, thing + step, thing)

    def swing(self, agent, tool, thing, step):
        self.swung = True
        return thing


def broken(**methods):
    """A tool that differs from a plain one in some methods."""

    def bound(method):
        return lambda _, *arguments: method(*arguments)

    own = {n: bound(m) if callable(m) else m for n, m in methods.items()}
    return type("Broken", (Plain,), own)


def at_random(agent, tool, thing, step):
    return thing + step * np.random.default_rng().integers(0, 2, thing.shape)


def writes(agent, tool, thing, step):
    thing[thing == tool + step] += step
    return thing


WRITES = writes.__code__.co_firstlineno + 1


def behind(agent, tool, thing):
    return thing - tool == tool - agent


@pytest.mark.parametrize("tool", [*TOOLS, *TOOLS.values(), Picker, Broom, Plain, Magnet, RAKE])
def test_a_tool_passes(tool):
    assert hb.check_tool(tool) is None


@pytest.mark.parametrize(
    ("tool", "says"),
    [
        pytest.param("spoon", "'spoon' is unknown; use one of picker, broom, rake", id="name"),
        pytest.param(3, "int has no method 'attached'; a tool has attached, carry", id="number"),
        pytest.param(broken(swing=None), "no method 'swing'", id="no swing"),
        pytest.param(broken(character="G"), "'G' stands for the goal", id="the goal's letter"),
        pytest.param(broken(drawing=3), "drawing is int, not a tuple of Shape", id="no drawing"),
        pytest.param(
            broken(drawing=(Shape(((0, 0), (1, 0), (1, 2)), "#000000"),)),
            "drawing leaves its cell; give a tuple of shapes.Shape",
            id="large drawing",
        ),
        pytest.param(
            broken(carry=lambda a, t, c, s: c / 1),
            "carry returns float64 of shape (1",
            id="no cells",
        ),
        pytest.param(
            broken(attached=lambda a, t, c: False), "attached returns bool of shape ()", id="one"
        ),
        pytest.param(
            broken(swing=lambda a, t, c, s: c.nothing),
            "swing fails with AttributeError",
            id="fails",
        ),
        pytest.param(
            broken(carry=lambda a, t, c, s: c + 0 * c.max()),
            "carry fails with ValueError: zero-size array",
            id="none",
        ),
        pytest.param(
            broken(carry=writes),
            f"read-only (test_check_tool.py, line {WRITES}); leave the arguments as they are",
            id="writes",
        ),
        pytest.param(
            broken(swing=lambda a, t, c, s: np.where(len(c) == 1, c + s, c)),
            "swing returns another result for one placement alone with agent (1, 0), ",
            id="alone",
        ),
        pytest.param(
            broken(carry=at_random),
            "let nothing but its arguments decide: no random numbers",
            id="random",
        ),
        pytest.param(
            Remembers,
            "carry returns another result when called again with agent (2, 0), tool (1, 0)",
            id="remembers",
        ),
        pytest.param(
            broken(carry=lambda a, t, c, s: np.where(c % 2 == 1, c + s, c)),
            "carry returns another result one cell to the east with agent (1, 0), tool (0, 0), "
            "object ",
            id="parity of the cell",
        ),
        pytest.param(
            broken(attached=lambda a, t, c: c // 12 == 4),
            "attached returns another result one cell to the south with agent",
            id="one row",
        ),
        pytest.param(
            broken(carry=lambda a, t, c, s: np.where(c == t + 12, c + s, c)),
            "carry returns another result on a map 13 columns wide with agent",
            id="another map's rows",
        ),
        pytest.param(
            broken(carry=lambda a, t, c, s: np.where(np.abs(c - t) < 6, c + s, c)),
            "columns wide with agent",
            id="rows that run into each other",
        ),
        pytest.param(
            broken(carry=lambda a, t, c, s: c + 3 * s),
            "carry puts the object at (-3, 1) with agent (1, 0), tool (0, 0), object (0, 1), north",
            id="far",
        ),
        pytest.param(
            broken(swing=lambda a, t, c, s: c + 5),
            "swing puts the object at (0, 6) with agent (1, 0)",
            id="round the border",
        ),
        pytest.param(
            broken(attached=behind),
            "carry leaves behind an object that it reports as attached with agent (2, 0), tool "
            "(1, 0), object (0, 0), north; return thing + step",
            id="left behind",
        ),
        pytest.param(
            broken(attached=behind, carry=lambda a, t, c, s: np.where(behind(a, t, c), c + s, c)),
            "swing releases an object that it reports as attached with agent (1, 0), tool (1, 1), "
            "object (1, 2), north; keep an attached object attached",
            id="lets go",
        ),
    ],
)
@pytest.mark.ill_typed
def test_invalid_tools_are_refused_with_the_placement_and_the_fix(tool, says):
    with pytest.raises(ValueError, match=r"^tool ") as caught:
        hb.check_tool(tool)
    assert says in str(caught.value)
    assert "; " in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("tool", [Plain(), Magnet(), *TOOLS.values()])
def test_what_passes_does_the_same_on_every_map(tool: Tool):
    """The guarantee of `check_tool` in tables: a map's margins change nothing."""
    small = World.parse("A....\n.X...\n..C..\n....G\n".replace("X", "P")).with_tool(tool)
    wide = World.parse("#" * 9 + "\n##A....##\n##.P...##\n##..C..##\n##....G##").with_tool(tool)
    one, other = tabulate(small), tabulate(wide)
    places = zip(*(one.factor(name) for name in ("agent", "tool", "object")), strict=True)

    def moved(cell: int) -> tuple[int, int]:
        row, column = divmod(int(cell), 5)
        return row + 1, column + 2

    same = np.array(
        [
            other.find(agent=moved(agent), tool=moved(held), object=moved(thing))
            for agent, held, thing in places
        ]
    )
    assert (other.next_state[same] == same[one.next_state]).all()
    assert (other.flags["attached"][same] == one.flags["attached"]).all()


def test_protocol_and_check_are_public():
    assert isinstance(Plain(), hb.Tool)
    assert not isinstance(3, hb.Tool)
