"""The tools: how each moves the object, and nothing else.

A tool is asked only when the agent has it in hand (the two are adjacent), and only for the
object. That the tool goes with the agent, and that a move into a wall or onto another thing
leaves everything as it was, is the same for all tools and stands in `rules.py`.

Cells are flat indices (see `rules.Grid`), `step` is the distance in them of one cell's move, so
`agent + step` is the cell next to the agent. All cell arguments are integer arrays of one shape.
"""

from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Integer

Cells = Integer[np.ndarray, "*states"]
Flags = Bool[np.ndarray, "*states"]


@runtime_checkable
class Tool(Protocol):
    """What a kind of tool must say of itself."""

    character: str
    """The character that stands for it on a map."""

    def attached(self, agent: Cells, tool: Cells, thing: Cells) -> Flags:
        """Whether the object goes wherever the tool goes."""
        ...

    def carry(self, agent: Cells, tool: Cells, thing: Cells, step: int) -> Cells:
        """The object's new cell when the agent moves by `step` and its tool with it."""
        ...

    def swing(self, agent: Cells, tool: Cells, thing: Cells, step: int) -> Cells:
        """The object's new cell when the tool is put on the side `agent + step`."""
        ...


class Picker:
    """Holds an object that stands behind it in line with the agent (rules 3 to 5)."""

    character = "P"

    def attached(self, agent: Cells, tool: Cells, thing: Cells) -> Flags:
        """Agent, picker and object stand in one straight line in that order (rule 4)."""
        return thing - tool == tool - agent

    def carry(self, agent: Cells, tool: Cells, thing: Cells, step: int) -> Cells:
        return np.where(self.attached(agent, tool, thing), thing + step, thing)

    def swing(self, agent: Cells, tool: Cells, thing: Cells, step: int) -> Cells:
        return np.where(self.attached(agent, tool, thing), agent + 2 * step, thing)


class Broom:
    """Pushes an object that it is carried into (rule 3); swinging it sweeps nothing (rule 5)."""

    character = "B"

    def attached(self, agent: Cells, tool: Cells, thing: Cells) -> Flags:
        return np.zeros(np.shape(thing), bool)

    def carry(self, agent: Cells, tool: Cells, thing: Cells, step: int) -> Cells:
        return np.where(tool + step == thing, thing + step, thing)

    def swing(self, agent: Cells, tool: Cells, thing: Cells, step: int) -> Cells:
        return thing


TOOLS: dict[str, Tool] = {"picker": Picker(), "broom": Broom()}


def tool_named(name: str) -> Tool:
    """The tool of that name.

    Raises:
        ValueError: there is none; the message lists those there are.
    """
    if name not in TOOLS:
        raise ValueError(f"tool {name!r} is unknown; use one of {', '.join(TOOLS)}, none")
    return TOOLS[name]
