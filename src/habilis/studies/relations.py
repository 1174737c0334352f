"""What a statement of the paper comes to when it is recomputed."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Relation:
    """A statement of the paper, in our words.

    Attributes:
        section: where the paper makes it.
        text: the statement.
        holds: whether it does here.
        found: what we found, with figures.
    """

    section: str
    text: str
    holds: bool
    found: str
