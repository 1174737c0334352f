"""Requests of a page."""

from typing import Annotated, Literal

from msgspec import UNSET, Meta, Struct, UnsetType

from habilis.studio.limits import FRAMES, HORIZON, TOOLS, TRAINING
from habilis.studio.protocol.scenes import Cell, Index, Placement, Scene


class Settings(Struct, frozen=True, forbid_unknown_fields=True):
    """Settings of `habilis train`, which has defaults for all of them."""

    intrinsic: str | UnsetType = UNSET
    horizon: Annotated[int, Meta(ge=0, le=HORIZON)] | UnsetType = UNSET
    beta: float | UnsetType = UNSET
    runs: Annotated[int, Meta(ge=1, le=TRAINING["runs"])] | UnsetType = UNSET
    seed: int | UnsetType = UNSET
    algorithm: str | UnsetType = UNSET
    episodes: Annotated[int, Meta(ge=1, le=TRAINING["episodes"])] | UnsetType = UNSET
    beta_schedule: str | UnsetType = UNSET
    beta_steps: int | UnsetType = UNSET
    earned: str | UnsetType = UNSET
    episode_limit: int | UnsetType = UNSET
    learning_rate: float | UnsetType = UNSET
    discount: float | UnsetType = UNSET


class Request(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="do"):
    """A message of a page."""

    id: Annotated[Index, Meta(description="the page's number for it")]


class Read(Request, frozen=True, kw_only=True, tag="read"):
    """The library's reading of a map."""

    scene: Scene


class Measure(Request, frozen=True, kw_only=True, tag="measure"):
    """The landscape; then, tool by tool, the averages."""

    scene: Scene


class Landscape(Request, frozen=True, kw_only=True, tag="landscape"):
    """The landscape alone, with things where the placement has them; by default, the map."""

    scene: Scene
    placement: Placement | UnsetType = UNSET


class Pairs(Request, frozen=True, kw_only=True, tag="pairs"):
    """Every tool with every object of a map, each pair alone, pair by pair."""

    scene: Scene


class Futures(Request, frozen=True, kw_only=True, tag="futures"):
    """The futures that the agent can reach from a cell."""

    scene: Scene
    agent: Cell


class Solve(Request, frozen=True, kw_only=True, tag="solve"):
    """A shortest plan from a placement; by default, the map's."""

    scene: Scene
    placement: Placement | UnsetType = UNSET


class Step(Request, frozen=True, kw_only=True, tag="step"):
    """The effect of an action, and the bits of the placement reached."""

    scene: Scene
    placement: Placement
    action: Annotated[Index | None, Meta(description="its index; null stays, for the bits only")]


class Train(Request, frozen=True, kw_only=True, tag="train"):
    """A training in the scene's world, with its slip."""

    scene: Scene
    settings: Settings


class Edit(Request, frozen=True, kw_only=True, tag="edit"):
    """The scene's world, edited on an embedded page, for the notebook. It has an empty answer."""

    scene: Scene
    shown: Annotated[
        Index, Meta(description="the number of the notebook's world that it was made of")
    ]


class Follow(Request, frozen=True, kw_only=True, tag="follow"):
    """The answers of a training that is under way, after its page has been loaded again."""

    name: str


class Stop(Request, frozen=True, kw_only=True, tag="stop"):
    """Ends the training of the `train` or `follow` with this id, and keeps its progress.

    It has no answer of its own.
    """


class Trainings(Request, frozen=True, kw_only=True, tag="trainings"):
    """The trainings that have a folder: their names, then one by one."""


class Curve(Request, frozen=True, kw_only=True, tag="curve"):
    """The learning curve of a training."""

    name: str


class Run(Request, frozen=True, kw_only=True, tag="run"):
    """The policy, the values and an episode of a trained agent."""

    index: Annotated[Index, Meta(description="which of the training's runs")]
    name: Annotated[
        str | UnsetType,
        Meta(description="of a training; by default, the folder that the studio was started with"),
    ] = UNSET
    placement: Annotated[
        Placement | UnsetType,
        Meta(description="in which the episode begins; by default, the map's"),
    ] = UNSET


class Film(Request, frozen=True, kw_only=True, tag="film"):
    """A film of placements of the scene's world, one after the other."""

    scene: Scene
    placements: Annotated[list[Placement], Meta(min_length=1, max_length=FRAMES)]


class Code(Request, frozen=True, kw_only=True, tag="code"):
    """Code that computes what a view shows."""

    scene: Scene
    view: Annotated[
        Literal["landscape", "pairs", "game", "training", "run"],
        Meta(title="ShownView", description="which of the scene, or of a training"),
    ]
    tools: Annotated[
        list[str], Meta(max_length=TOOLS, description="those whose exact averages are shown")
    ] = []
    placements: Annotated[
        list[Placement],
        Meta(
            max_length=FRAMES,
            description="of a game, from its start; of a run, that in which the episode begins",
        ),
    ] = []
    settings: Annotated[
        Settings | UnsetType, Meta(description="of a training that has no folder")
    ] = UNSET
    name: Annotated[
        str | UnsetType,
        Meta(description="of a training; by default, the folder that the studio was started with"),
    ] = UNSET
    index: Annotated[Index, Meta(description="which of its runs")] = 0


AnyRequest = (
    Read
    | Measure
    | Landscape
    | Pairs
    | Futures
    | Solve
    | Step
    | Film
    | Code
    | Train
    | Follow
    | Edit
    | Stop
    | Trainings
    | Curve
    | Run
)
