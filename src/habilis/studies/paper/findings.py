"""Numbers and statements of the paper, each beside what was recomputed."""

from dataclasses import dataclass

from habilis.studies.comparison import Outcome


@dataclass(frozen=True)
class Number:
    """A published number beside ours.

    Attributes:
        section: where the paper states it.
        text: its meaning, in our words.
        published: as printed, or the bounds that are meant.
        ours: not rounded.
        unit: "bits" or "steps", or "" for returns.
        agrees: whether ours is the published number, to the digits that were published.
    """

    section: str
    text: str
    published: str
    ours: float
    unit: str
    agrees: bool


@dataclass(frozen=True)
class Statement:
    """A statement of the paper about its worlds, beside what was found.

    Attributes:
        section: where the paper makes it.
        text: the statement, in our words.
        holds: whether it does here.
        found: the result, with figures.
    """

    section: str
    text: str
    holds: bool
    found: str


@dataclass(frozen=True)
class AgentStatement:
    """A statement of the paper about its learning agents, beside the verdict of our runs.

    Attributes:
        section: where the paper makes it.
        text: the statement, in our words.
        outcome: whether it holds here, is undecided, or comes out the other way round.
        found: the result, with figures.
        ensemble: the outcome over an ensemble of learners and maps, for orders of rows; `None`
            without one.
    """

    section: str
    text: str
    outcome: Outcome
    found: str
    ensemble: Outcome | None = None
