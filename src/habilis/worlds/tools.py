"""The tools: how each moves the object, and nothing else.

A tool is asked only when the agent has it in hand (the two are adjacent), and only for the
object. That the tool goes with the agent, and that a move into a wall or onto another thing
leaves everything as it was, is the same for all tools and stands in `rules.py`.

Cells are flat indices (see `grid.Grid`), `step` is the distance in them of one cell's move, so
`agent + step` is the cell next to the agent. All cell arguments are integer arrays of one shape.

The picker and the broom are written against the same point as a tool of one's own, which
`own_tools.py` finds and `check_tool.py` looks over.
"""

from dataclasses import dataclass, fields
from typing import Protocol, runtime_checkable

import numpy as np

from habilis.worlds.grid import Cells, Flags
from habilis.worlds.pictures.shapes import SHAPES, Drawing


@runtime_checkable
class Tool(Protocol):
    """A kind of tool: a character, and three rules over arrays of cells.

    A tool is any object that has these; it need not inherit from this class. It is asked about
    many placements at once, in all of which agent, tool and object are in three distinct cells,
    the tool beside the agent. It may also have a `drawing` (`shapes.Drawing`), its working end to
    the south. `check_tool` says whether something is one.

    A tool with an attribute `sees = True` gets more: `carry` and `swing` also get `seen=`, the
    first cell straight on from where the tool goes, in the direction of `step`, that holds a wall
    or a thing.

    Example:
        >>> class Rake:
        ...     character = "R"
        ...     def attached(self, agent, tool, thing):
        ...         return np.zeros(thing.shape, bool)
        ...     def carry(self, agent, tool, thing, step):
        ...         pulled = (thing - tool == tool - agent) & (step == agent - tool)
        ...         return np.where(pulled, thing + step, thing)
        ...     def swing(self, agent, tool, thing, step):
        ...         return thing
        >>> isinstance(Rake(), Tool)
        True
    """

    character: str
    """The character that stands for it on a map."""

    def attached(self, agent: Cells, tool: Cells, thing: Cells) -> Flags:
        """Whether the object goes wherever the tool goes.

        Args:
            agent, tool, thing: their cells, integers of one shape.

        Returns:
            Bool of that shape.
        """
        ...

    def carry(self, agent: Cells, tool: Cells, thing: Cells, step: int) -> Cells:
        """The object's new cell when the agent moves by `step` and its tool with it.

        Args:
            agent, tool, thing: their cells, integers of one shape.
            step: the distance, in cells, of the agent's move.

        Returns:
            Cells, in that shape; those of `thing` where the tool leaves it alone.
        """
        ...

    def swing(self, agent: Cells, tool: Cells, thing: Cells, step: int) -> Cells:
        """The object's new cell when the tool is put on the side `agent + step`.

        Args:
            agent, tool, thing: their cells, integers of one shape.
            step: the distance, in cells, from the agent to that side.

        Returns:
            Cells, in that shape; those of `thing` where the tool leaves it alone.
        """
        ...


class Picker:
    """Holds an object that stands behind it in line with the agent (rules 3 to 5).

    Attached: agent, picker and object stand in one straight line in that order. Such an object goes
    with the picker, carried or swung.
    """

    character = "P"
    drawing = SHAPES["picker"]
    holds = True

    def attached(self, agent: Cells, tool: Cells, thing: Cells) -> Flags:
        return thing - tool == tool - agent

    def carry(self, agent: Cells, tool: Cells, thing: Cells, step: int) -> Cells:
        return np.where(self.attached(agent, tool, thing), thing + step, thing)

    def swing(self, agent: Cells, tool: Cells, thing: Cells, step: int) -> Cells:
        return np.where(self.attached(agent, tool, thing), agent + 2 * step, thing)


class Broom:
    """Pushes an object that it is carried into (rule 3); swinging it sweeps nothing (rule 5)."""

    character = "B"
    drawing = SHAPES["broom"]

    def attached(self, agent: Cells, tool: Cells, thing: Cells) -> Flags:
        return np.zeros(np.shape(thing), bool)

    def carry(self, agent: Cells, tool: Cells, thing: Cells, step: int) -> Cells:
        return np.where(tool + step == thing, thing + step, thing)

    def swing(self, agent: Cells, tool: Cells, thing: Cells, step: int) -> Cells:
        return thing


class Rake:
    """Pulls an object beyond it, in line with the agent, when the agent backs away from it."""

    character = "R"
    drawing = SHAPES["rake"]

    def attached(self, agent: Cells, tool: Cells, thing: Cells) -> Flags:
        return np.zeros(np.shape(thing), bool)

    def carry(self, agent: Cells, tool: Cells, thing: Cells, step: int) -> Cells:
        pulled = (thing - tool == tool - agent) & (step == agent - tool)
        return np.where(pulled, thing + step, thing)

    def swing(self, agent: Cells, tool: Cells, thing: Cells, step: int) -> Cells:
        return thing


class Stick:
    """A broom two cells long: pushes what it, or its end one cell further on, is carried into.

    Its end is in line with the agent and takes up no room: walls and things do not stop it.
    """

    character = "S"
    drawing = SHAPES["stick"]

    def attached(self, agent: Cells, tool: Cells, thing: Cells) -> Flags:
        return np.zeros(np.shape(thing), bool)

    def carry(self, agent: Cells, tool: Cells, thing: Cells, step: int) -> Cells:
        end = 2 * tool - agent
        return np.where((tool + step == thing) | (end + step == thing), thing + step, thing)

    def swing(self, agent: Cells, tool: Cells, thing: Cells, step: int) -> Cells:
        return thing


class Magnet:
    """Put on a side, draws the first thing straight on from there one cell closer.

    Put on the side where it is, it draws again. What is beside it comes no closer, and what stands
    behind a wall or another thing is not drawn.
    """

    character = "M"
    drawing = SHAPES["magnet"]
    sees = True

    def attached(self, agent: Cells, tool: Cells, thing: Cells) -> Flags:
        return np.zeros(np.shape(thing), bool)

    def carry(
        self, agent: Cells, tool: Cells, thing: Cells, step: int, seen: Cells | None = None
    ) -> Cells:
        return thing

    def swing(
        self, agent: Cells, tool: Cells, thing: Cells, step: int, seen: Cells | None = None
    ) -> Cells:
        return np.where((thing == seen) & (thing != agent + 2 * step), thing - step, thing)


@dataclass(frozen=True)
class Reading:
    """How rules 3 to 5 are read where the paper leaves them open; as `Reading()`, our reading.

    It is a property of a tool on a map and stands there in words, as in `P = picker pushes`. What
    these words do is the same for every tool, and stands in `rules.py`.

    Attributes:
        pushes: rule 3: a tool that is carried into an object it does not hold pushes it; if not,
            it is blocked, unless it is a tool that pushes anyway.
        shoves: rule 5: a tool that is put into the cell of an object it does not hold pushes it
            away from the agent; if not, it is blocked.
        sweeps: rule 5: all cells over which the tool, and an object that it holds, turn on their
            way must be free of walls; if not, they are there in an instant.
        sticky: rule 4: a tool that holds objects holds those beside it, too; if not, only one in
            line with the agent.

    Example:
        >>> Reading(pushes=True, sweeps=True).words
        'pushes sweeps'
        >>> Reading.of("picker pushes")
        ('picker', Reading(pushes=True, shoves=False, sweeps=False, sticky=False))
    """

    pushes: bool = False
    shoves: bool = False
    sweeps: bool = False
    sticky: bool = False

    @property
    def words(self) -> str:
        """Those that stand for it, in order; "" for our reading."""
        return " ".join(one.name for one in fields(self) if getattr(self, one.name))

    @classmethod
    def of(cls, said: str) -> "tuple[str, Reading]":
        """The text before the words at its end, and the reading that these denote."""
        known, found = {one.name for one in fields(cls)}, set()
        while (word := said.rpartition(" ")[2]) in known and " " in said:
            found.add(word)
            said = said.rpartition(" ")[0].rstrip()
        return said, cls(**dict.fromkeys(found, True))


OURS = Reading()
"""How Habilis reads the rules, unless a map says otherwise."""


TOOLS: dict[str, Tool] = {
    "picker": Picker(),
    "broom": Broom(),
    "rake": Rake(),
    "stick": Stick(),
    "magnet": Magnet(),
}
UNBOUND = ("picker", "broom")
"""Those whose characters stand for them on every map; others are bound above it."""


def name_of(tool: Tool) -> str:
    """The name of a tool: a built-in one's kind, or "module:Class" for one's own."""
    for kind, known in TOOLS.items():
        if type(tool) is type(known):
            return kind
    return f"{type(tool).__module__}:{type(tool).__qualname__}"


def drawing_of(tool: Tool) -> Drawing:
    """How a tool is drawn, its working end to the south: as it says, or as any tool."""
    return getattr(tool, "drawing", SHAPES["tool"])
