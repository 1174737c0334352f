"""Scenes and placements, as messages have them."""

from typing import Annotated, Literal

from msgspec import UNSET, Meta, Struct, UnsetType

from habilis.studio.limits import (
    DISCOUNT,
    FACTORS,
    HORIZON,
    SIDES,
    SLACK,
    SLIP,
    THINGS,
    TOOL_SLIP,
)

GIVE = "give"
"""In the `extra` of a type: the words in which an error asks for it."""

Coordinate = Annotated[int, Meta(ge=-(2**31), lt=2**31)]
Cell = Annotated[
    tuple[Coordinate, Coordinate],
    Meta(
        title="Cell",
        description="Row and column, from 0.",
        extra={GIVE: "a cell as [row, column]"},
    ),
]
LARGEST = 2**53  # up to here JavaScript represents integers exactly
Index = Annotated[int, Meta(ge=0, le=LARGEST)]
Hand = Annotated[int, Meta(ge=-1, lt=THINGS)]
Grid = Annotated[
    list[list[float | None]],
    Meta(title="Grid", description="A value for each cell, row by row; null where there is none."),
]
Sensor = Annotated[
    Literal["state", "object", "tool", "agent", "cells", "factor"],
    Meta(
        title="Sensor",
        description="`cells` observes the object in the scene's cells only; `factor` is a board's.",
    ),
]
Kind = Annotated[
    Literal["open-loop", "effective", "closed-loop", "goal-directed"],
    Meta(
        title="Kind",
        description="Of empowerment. `effective` is under the uniform policy and has no horizon; "
        "`goal-directed` goes to the terminal states.",
    ),
]
ActionSet = Annotated[Literal["all", "moves", "tool"], Meta(title="ActionSet")]


class PlacedTool(Struct, frozen=True, forbid_unknown_fields=True):
    """A tool on a map."""

    kind: str
    cell: Cell
    slip: Annotated[
        float, Meta(ge=0, le=TOOL_SLIP, description="the probability that its effect fails")
    ] = 0.0


class PlacedObject(Struct, frozen=True, forbid_unknown_fields=True):
    """An object on a map."""

    kind: str
    cell: Cell
    goal: Cell | None = None


class Drawn(Struct, frozen=True, forbid_unknown_fields=True):
    """A map. Its tools and objects may be in any order, in which placements then list them."""

    ground: Annotated[str, Meta(description="rows of # (wall) and . (floor)")]
    agent: Cell
    tools: Annotated[list[PlacedTool], Meta(max_length=THINGS)]
    objects: Annotated[list[PlacedObject], Meta(min_length=1, max_length=THINGS)]
    drop: Annotated[bool, Meta(description="whether a tool can be dropped")]


class Scene(Struct, frozen=True, forbid_unknown_fields=True):
    """A world, as `map` or as `drawn`, or a board; and the question asked about it."""

    map: Annotated[
        str | UnsetType,
        Meta(
            description="the map as text, as in a file; objects that have goals count first, "
            "otherwise things are in its reading order"
        ),
    ] = UNSET
    drawn: Drawn | UnsetType = UNSET
    board: Annotated[str | UnsetType, Meta(description="the name of the board in `Hello`")] = UNSET
    tool: Annotated[
        str | UnsetType,
        Meta(description="one of those in `Hello`, which replaces the map's; none removes them"),
    ] = UNSET
    sensor: Sensor = "state"
    thing: Annotated[
        int,
        Meta(
            ge=0,
            lt=FACTORS,
            description="the observed object or, with the sensors tool and factor, tool or factor",
        ),
    ] = 0
    cells: Annotated[list[Cell], Meta(max_length=SIDES[1] ** 2)] = []
    kind: Kind = "open-loop"
    discount: (
        Annotated[
            float, Meta(ge=0, le=DISCOUNT, description="of the kind `effective`, which needs it")
        ]
        | UnsetType
    ) = UNSET
    slack: (
        Annotated[
            int,
            Meta(
                ge=0, le=SLACK, description="of the kind `goal-directed`, in actions; by default 0"
            ),
        ]
        | UnsetType
    ) = UNSET
    horizon: Annotated[int, Meta(ge=0, le=HORIZON, description="in actions")] = 0
    actions: ActionSet = "all"
    only: Annotated[
        list[Index] | UnsetType,
        Meta(description="of a board, the indices of the actions; by default all"),
    ] = UNSET
    slip: Annotated[
        float,
        Meta(
            ge=0,
            le=SLIP,
            description="the probability that a random action replaces the chosen one",
        ),
    ] = 0.0


class Placement(Struct, frozen=True, forbid_unknown_fields=True):
    """The cells of all things: tools and objects by their index in the scene's map."""

    agent: Cell
    tools: list[Cell]
    objects: list[Cell]
    held: Annotated[
        Hand | UnsetType,
        Meta(
            description="the index of the tool in hand, -1 for none; absent if the cells imply it"
        ),
    ] = UNSET
    laid: Annotated[
        Hand | UnsetType,
        Meta(description="of the tool that was dropped and not left since, likewise"),
    ] = UNSET
    state: Annotated[
        Index | UnsetType, Meta(description="of an environment: its state's index, which decides")
    ] = UNSET
