"""The server's greeting."""

from typing import Annotated, Any

from msgspec import Meta, Struct

from habilis.studio.protocol.scenes import Cell, Drawn, Placement

Drawing = Annotated[
    list[tuple[str, str]],
    Meta(
        title="Drawing",
        description="Path and colour of each part, in a unit cell, from back to front.",
    ),
]


class TrainingLimits(Struct, frozen=True):
    """The largest values of a training."""

    runs: int
    episodes: int
    seed: int
    placements: int
    at_once: Annotated[int, Meta(description="trainings in parallel")]
    waiting: Annotated[int, Meta(description="trainings that wait for that")]


class Limits(Struct, frozen=True):
    """The limits that a page has to know."""

    side: Annotated[
        tuple[int, int], Meta(description="the fewest and the most rows, and columns, of a map")
    ]
    things: Annotated[int, Meta(description="tools of a map, and objects")]
    horizon: int
    discount: float
    slack: int
    slip: float
    tool_slip: float
    message: Annotated[int, Meta(description="characters")]
    training: TrainingLimits


class FirstSettings(Struct, frozen=True):
    """The settings that a page shows first."""

    intrinsic: str
    horizon: int
    beta: float
    runs: int
    seed: int
    algorithm: str
    episodes: int


class Offered(Struct, frozen=True):
    """The choices of a training, with labels."""

    intrinsic: dict[str, str]
    algorithms: dict[str, str]
    without_horizon: Annotated[
        list[str], Meta(description="the intrinsic rewards that have no horizon")
    ]
    first: FirstSettings


class RunAbout(Struct, frozen=True):
    """A trained run that can be watched."""

    name: str
    runs: int
    drawn: Drawn
    config: dict[str, Any]


class Shown(Struct, frozen=True):
    """A world that a notebook shows on the pages embedded in it."""

    drawn: Drawn
    number: Annotated[int, Meta(description="how often it has set one")]


class Movable(Struct, frozen=True):
    """A thing on a board that is drawn where placements have it."""

    name: str
    drawing: Drawing
    filled: Annotated[Drawing | None, Meta(description="in one of its goals")]
    goals: list[Cell]


class Still(Struct, frozen=True):
    """A part of a board that stays in its cell."""

    cell: Cell
    drawing: Drawing


class BoardAbout(Struct, frozen=True):
    """A puzzle or environment, which can be played and measured as it is.

    It is drawn by its cells, or by an image of each state.
    """

    name: str
    ground: Annotated[str, Meta(description="rows of # (wall) and . (floor)")]
    actions: list[str]
    factors: Annotated[list[str], Meta(description="that can be observed")]
    start: Placement
    random: Annotated[bool, Meta(description="whether its actions have random outcomes")]
    agent: Annotated[Movable, Meta(description="without a drawing, the studio's own is used")]
    objects: Annotated[list[Movable], Meta(description="in the order of placements")]
    still: Annotated[list[Still], Meta(description="from back to front")]
    states: Annotated[int | None, Meta(description="their number, if it is known")]
    image: Annotated[str | None, Meta(description="of its first state, as a data URI")]


class Hello(Struct, frozen=True):
    """The studio and its choices."""

    version: str
    worlds: dict[str, Drawn]
    tools: Annotated[list[str], Meta(description="all kinds, and none")]
    objects: Annotated[list[str], Meta(description="all kinds")]
    actions: Annotated[list[str], Meta(description="their names, by index")]
    limits: Limits
    training: Offered
    shapes: dict[str, Drawing]
    run: Annotated[
        RunAbout | None, Meta(description="of the folder that the studio was started with")
    ]
    board: Annotated[
        BoardAbout | None, Meta(description="that the studio was started with, if any")
    ]
    world: Annotated[
        Drawn | None, Meta(description="the map that the studio was started with, if any")
    ]
    kept: Annotated[
        str | None, Meta(description="the folder in which trainings outlive the studio")
    ]
    shown: Annotated[Shown | None, Meta(description="the notebook's, of an embedded page")]


class Greeting(Struct, frozen=True):
    """The first message."""

    hello: Hello


class Show(Struct, frozen=True):
    """A message without a request: a notebook has set another world."""

    show: Shown
