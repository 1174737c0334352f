"""Answers of the server. A part of an answer has some of its fields."""

from typing import Annotated, Any

from msgspec import UNSET, Meta, Struct, UnsetType, field

from habilis.studio.protocol import requests
from habilis.studio.protocol.scenes import Drawn, Grid, Placement

Reached = Annotated[
    tuple[int, int, float], Meta(title="Reached", description="Row, column and probability.")
]


class Answer(Struct, kw_only=True):
    """The fields that any answer may have."""

    id: Annotated[int | None, Meta(description="the request's; null if it has none")]
    error: Annotated[str | UnsetType, Meta(description="one line")] = UNSET
    progress: Annotated[
        float | UnsetType, Meta(description="of a long computation, from 0 to 1")
    ] = UNSET
    overtaken: Annotated[
        bool | UnsetType, Meta(description="a newer request of its kind has replaced it")
    ] = UNSET


class ReadAnswer(Answer, kw_only=True):
    """The map as the library has it."""

    drawn: Drawn | UnsetType = UNSET
    text: Annotated[str | UnsetType, Meta(description="the map as text")] = UNSET


class LandscapeAnswer(Answer, kw_only=True):
    """A landscape."""

    landscape: Annotated[
        Grid | UnsetType, Meta(description="bits by the agent's cell, null where it cannot be")
    ] = UNSET
    least: float | UnsetType | None = UNSET
    most: float | UnsetType | None = UNSET
    gap: Annotated[
        float | UnsetType,
        Meta(description="bits, by how much any true value may differ at most; absent if unknown"),
    ] = UNSET
    seconds: float | UnsetType = UNSET


class Verdict(Struct, frozen=True):
    """A tool's average compared with that of none."""

    useful: bool
    better_than_none: Annotated[
        bool | None, Meta(description="null if the estimates leave it open")
    ]
    equal: Annotated[bool, Meta(description="the same as none, to the tolerance")]


class MeasureAnswer(LandscapeAnswer, kw_only=True):
    """A landscape, then averages by tool."""

    averages: Annotated[
        dict[str, float | None] | UnsetType,
        Meta(description="bits; null if there is none, and `why`"),
    ] = UNSET
    within: Annotated[
        dict[str, float] | UnsetType,
        Meta(description="half the widths of their 95 % intervals; 0 if exact"),
    ] = UNSET
    verdicts: dict[str, Verdict] | UnsetType = UNSET
    why: str | UnsetType = UNSET


class PairTool(Struct, frozen=True):
    """A tool that is compared."""

    name: str
    kind: str


class Pair(Struct, frozen=True, kw_only=True):
    """The measures of a tool with an object; `why` if they are not available."""

    tool: Annotated[int, Meta(description="its index")]
    object: Annotated[int, Meta(description="its index")]
    averages: Annotated[
        list[float] | UnsetType,
        Meta(description="average object empowerment in bits, by horizon from 1 on"),
    ] = UNSET
    range: Annotated[int | UnsetType, Meta(description="in cells")] = UNSET
    latency: Annotated[
        float | UnsetType | None, Meta(description="in actions, at best; null if there is none")
    ] = UNSET
    median_latency: Annotated[
        float | UnsetType | None, Meta(description="from a random placement, likewise")
    ] = UNSET
    persistence: Annotated[float | UnsetType, Meta(description="in bits")] = UNSET
    reliability: Annotated[
        float | UnsetType | None, Meta(description="null if there is nothing to lose")
    ] = UNSET
    why: str | UnsetType = UNSET


class PairsAnswer(Answer, kw_only=True):
    """The names, then each pair."""

    tools: Annotated[
        list[PairTool] | UnsetType,
        Meta(description="the map's own in its order, then the others, then none"),
    ] = UNSET
    objects: Annotated[list[str] | UnsetType, Meta(description="in the map's order")] = UNSET
    horizon: Annotated[int | UnsetType, Meta(description="the largest; at least 1")] = UNSET
    pair: Pair | UnsetType = UNSET


class FuturesAnswer(Answer, kw_only=True):
    """The observations that are reachable from a cell."""

    bits: float | UnsetType = UNSET
    gap: Annotated[float | UnsetType, Meta(description="of the certificate, in bits")] = UNSET
    things: Annotated[
        list[Reached] | UnsetType,
        Meta(description="the cells of the observed thing; with the sensor state, of the object"),
    ] = UNSET
    elsewhere: Annotated[
        float | UnsetType, Meta(description="the probability of cells that are not observed")
    ] = UNSET
    count: Annotated[int | UnsetType, Meta(description="of distinct observations")] = UNSET


class SolveAnswer(Answer, kw_only=True):
    """A shortest plan; all null if the goal is unreachable."""

    steps: int | UnsetType | None = UNSET
    best_return: float | UnsetType | None = field(default=UNSET, name="return")
    actions: list[int] | UnsetType | None = UNSET
    placements: list[Placement] | UnsetType | None = UNSET


class StepAnswer(Answer, kw_only=True):
    """The placement that an action leads to."""

    placement: Placement | UnsetType = UNSET
    bits: float | UnsetType = UNSET
    equipped: bool | UnsetType = UNSET
    attached: bool | UnsetType = UNSET
    reward: float | UnsetType | None = UNSET
    ended: bool | UnsetType = UNSET
    image: Annotated[
        str | UnsetType, Meta(description="of an environment: its picture, as a data URI")
    ] = UNSET


class LearningCurve(Struct, frozen=True):
    """The mean return of some runs with its 95 % interval, over episodes."""

    x: list[float]
    mean: list[float]
    low: list[float]
    high: list[float]
    runs: int
    carried_on: Annotated[int, Meta(description="runs that ended earlier, with their last return")]


class CurveAnswer(Answer, kw_only=True):
    """The progress of a training."""

    curve: Annotated[
        LearningCurve | UnsetType | None,
        Meta(description="null until every run has finished an episode"),
    ] = UNSET
    episodes: Annotated[int | UnsetType, Meta(description="of all runs")] = UNSET
    steps: Annotated[int | UnsetType, Meta(description="of all runs")] = UNSET
    converged_at: Annotated[
        list[int | None] | UnsetType, Meta(description="each run's episodes to convergence")
    ] = UNSET
    best_return: float | UnsetType | None = UNSET


class Done(Struct, frozen=True):
    """A training that has ended."""

    name: str
    runs: int
    converged_at: list[int | None]
    best_return: float | None


class TrainAnswer(CurveAnswer, kw_only=True):
    """A training: its name, then its progress, at last with `done`."""

    name: Annotated[str | UnsetType, Meta(description="of its folder")] = UNSET
    share: Annotated[float | UnsetType, Meta(description="of the budget, from 0 to 1")] = UNSET
    steps_per_second: float | UnsetType = UNSET
    done: Done | UnsetType = UNSET


class KeptTraining(Struct, frozen=True):
    """A training that has a folder; `error` if there is nothing to watch or it is damaged."""

    name: str
    under_way: bool
    error: str | UnsetType = UNSET
    runs: int | UnsetType = UNSET
    config: dict[str, Any] | UnsetType = UNSET
    drawn: Drawn | UnsetType = UNSET
    ended: bool | UnsetType = UNSET
    converged_at: list[int | None] | UnsetType | None = UNSET
    best_return: float | UnsetType | None = UNSET


class TrainingsAnswer(Answer, kw_only=True):
    """The names of trainings, then each of them."""

    names: Annotated[list[str] | UnsetType, Meta(description="newest first")] = UNSET
    left_out: Annotated[
        int | UnsetType, Meta(description="the number of older ones that are not listed")
    ] = UNSET
    kept: KeptTraining | UnsetType = UNSET


class Policy(Struct, frozen=True):
    """Action probabilities: along the episode, and by the agent's cell."""

    episode: list[list[float]]
    cells: list[list[list[float] | None]]


class Episode(Struct, frozen=True, kw_only=True):
    """An episode of the greedy policy."""

    placements: list[Placement]
    actions: list[int]
    values: list[float]
    episode_return: float = field(name="return")
    finished: bool
    best_return: Annotated[
        float | None, Meta(description="from the same start; null if the goal is unreachable")
    ]


class RunAnswer(CurveAnswer, kw_only=True):
    """A trained agent."""

    drawn: Drawn | UnsetType = UNSET
    policy: Policy | UnsetType = UNSET
    values: Annotated[Grid | UnsetType, Meta(description="of states, by the agent's cell")] = UNSET
    episode: Episode | UnsetType = UNSET


class FilmAnswer(Answer, kw_only=True):
    """A film."""

    gif: Annotated[str | UnsetType, Meta(description="the file, as base64")] = UNSET


class CodeAnswer(Answer, kw_only=True):
    """Code that computes what a view shows."""

    python: Annotated[str | UnsetType, Meta(description="a script")] = UNSET
    command: Annotated[
        str | UnsetType | None, Meta(description="lines for a shell; null if no command does it")
    ] = UNSET


ANSWER_OF: dict[type[requests.Request], type[Answer]] = {
    requests.Read: ReadAnswer,
    requests.Measure: MeasureAnswer,
    requests.Landscape: LandscapeAnswer,
    requests.Pairs: PairsAnswer,
    requests.Futures: FuturesAnswer,
    requests.Solve: SolveAnswer,
    requests.Step: StepAnswer,
    requests.Film: FilmAnswer,
    requests.Code: CodeAnswer,
    requests.Train: TrainAnswer,
    requests.Edit: Answer,
    requests.Follow: TrainAnswer,
    requests.Stop: Answer,
    requests.Trainings: TrainingsAnswer,
    requests.Curve: CurveAnswer,
    requests.Run: RunAnswer,
}
"""The answer of each request."""
