"""Kinds of empowerment, as the studio measures them."""

from dataclasses import dataclass

from msgspec import UNSET

from habilis.empowerment.kinds import (
    CLOSED_LOOP,
    EFFECTIVE,
    GOAL_DIRECTED,
    OPEN_LOOP,
    WHOLE,
    checked_kind,
)
from habilis.studio.protocol import scenes as protocol


@dataclass(frozen=True)
class Measured:
    """A kind of empowerment with its settings, as in `habilis.landscape`.

    Attributes:
        kind: its name.
        discount: of effective empowerment.
        slack: of goal-directed empowerment.
    """

    kind: str = OPEN_LOOP
    discount: float | None = None
    slack: int | None = None

    @classmethod
    def of(cls, asked: protocol.Scene) -> "Measured":
        """A kind from a message.

        Raises:
            ValueError: it lacks a setting, or has one of another kind, or actions although it is
                over all.
        """
        discount = None if asked.discount is UNSET else asked.discount
        slack = None if asked.slack is UNSET else asked.slack
        checked_kind(asked.kind, discount, slack)
        if asked.kind in WHOLE and (asked.actions != "all" or asked.only is not UNSET):
            raise ValueError(f"kind {asked.kind!r} is over all actions; leave out actions")
        return cls(asked.kind, discount, slack)

    @property
    def is_open(self) -> bool:
        """Whether it is plain empowerment."""
        return self.kind == OPEN_LOOP

    @property
    def is_closed(self) -> bool:
        """Whether the agent looks after every step."""
        return self.kind == CLOSED_LOOP

    @property
    def is_effective(self) -> bool:
        """Whether it is of an agent that acts at random."""
        return self.kind == EFFECTIVE

    @property
    def is_to_goals(self) -> bool:
        """Whether it counts futures on the way to the goal."""
        return self.kind == GOAL_DIRECTED

    @property
    def needs_whole(self) -> bool:
        """Whether it looks farther ahead than the horizon."""
        return self.kind in WHOLE

    def keywords(self) -> str:
        """The arguments of `habilis.landscape`, with a comma before each."""
        given = {"kind": self.kind, "discount": self.discount, "slack": self.slack}
        named = {name: value for name, value in given.items() if value is not None}
        return "" if self.is_open else "".join(f", {n}={v!r}" for n, v in named.items())

    def options(self) -> list[str]:
        """The options of `habilis landscape`."""
        if self.is_open:
            return []
        given = {"--kind": self.kind, "--discount": self.discount, "--slack": self.slack}
        return [part for n, v in given.items() if v is not None for part in (n, str(v))]

    def expression(self, mdp: str, horizon: int, sensor: str, actions: str, states: str) -> str:
        """A call that gives the values of states, as Python.

        Args:
            mdp, sensor, states: expressions.
            horizon: in actions.
            actions: ", actions=...", or nothing for all.
        """
        if self.is_open:
            return f"hb.empowerment({mdp}, {horizon}, {sensor}{actions}, states={states})"
        if self.is_closed:
            asked = f"{mdp}, {horizon}, {sensor}, {states}{actions}"
            return f"hb.closed_loop_empowerment({asked})"
        if self.is_effective:
            asked = f'{mdp}, "uniform", {self.discount}, {sensor}, {states}'
            return f"hb.effective_empowerment({asked})"
        asked = f"{mdp}, {horizon}, slack={self.slack or 0}, sensor={sensor}, states={states}"
        return f"hb.goal_directed_empowerment({asked})"


OPEN = Measured()
"""Plain empowerment."""
