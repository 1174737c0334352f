"""A board, and the question asked about it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Int
from msgspec import UNSET

from habilis.mdp import TabularMDP
from habilis.models.limits import TooManyStatesError
from habilis.studio.boards import Board, State, with_goals
from habilis.studio.limits import BOARD_STATES
from habilis.studio.measured_kinds import OPEN, Measured
from habilis.studio.protocol import scenes as protocol
from habilis.studio.scenes import ELSEWHERE
from habilis.worlds.grid import Cell
from habilis.worlds.plans import Plan


@dataclass(frozen=True)
class BoardScene:
    """A board, and the question asked about it.

    Attributes:
        board: what is measured.
        sensor: "state", or the name of a factor.
        horizon: in actions.
        actions: the indices of those that are counted; `None` for all.
        slip: the probability that a random action replaces the chosen one.
        at: where all but the agent is.
        measured: the kind of empowerment.
    """

    board: Board
    sensor: str
    horizon: int
    actions: tuple[int, ...] | None
    slip: float
    at: State
    measured: Measured = OPEN

    @classmethod
    def of(cls, asked: protocol.Scene, board: Board | None) -> "BoardScene":
        """A scene from a message.

        Args:
            asked: as the message has it.
            board: the one that the studio shows.

        Raises:
            ValueError: there is no such board, factor or action; the message says why.
        """
        if board is None or asked.board != board.name:
            raise ValueError(
                f"there is no board {asked.board!r:.60}; start the studio with its file or ID"
            )
        if asked.map is not UNSET or asked.drawn is not UNSET or asked.tool is not UNSET:
            raise ValueError("scene has a board; leave out map, drawn and tool")
        if asked.actions != "all":
            raise ValueError("actions is for maps; of a board, give only")
        if asked.sensor not in ("state", "factor"):
            raise ValueError(f"sensor is {asked.sensor!r}; of a board, give state or factor")
        if asked.sensor == "factor" and asked.thing >= len(board.factors):
            most = len(board.factors) - 1
            raise ValueError(f"thing is {asked.thing}; give a whole number from 0 to {most}")
        only = None if asked.only is UNSET else tuple(sorted(set(asked.only)))
        if only is not None and (not only or only[-1] >= len(board.actions)):
            most = len(board.actions) - 1
            raise ValueError(f"only is {list(only)}; give indices of actions from 0 to {most}")
        sensor = "state" if asked.sensor == "state" else board.factors[asked.thing]
        return cls(board, sensor, asked.horizon, only, asked.slip, board.start, Measured.of(asked))

    @property
    def height(self) -> int:
        return self.board.height

    @property
    def width(self) -> int:
        return self.board.width

    @property
    def action_indices(self) -> Sequence[int] | None:
        return None if self.actions is None else list(self.actions)

    @property
    def is_stochastic(self) -> bool:
        return bool(self.slip) or self.board.random

    @property
    def agents(self) -> Mapping[Cell, State]:
        return self.board.agents(self.at)

    def with_things(self, at: protocol.Placement) -> "BoardScene":
        """The same scene with its things elsewhere.

        Raises:
            ValueError: there is no such state.
        """
        return replace(self, at=self.where(at))

    def around(self, places: list[Any], horizon: int) -> tuple[TabularMDP, Int[np.ndarray, "n"]]:
        """A table of what can be reached from some states, and their indices."""
        return self.board.around(places, horizon)

    def whole(self, places: list[Any]) -> tuple[TabularMDP, Int[np.ndarray, "n"]]:
        """The same of all that can ever be reached.

        Raises:
            ValueError: it is too much.
        """
        try:
            mdp, states = self.board.around(places, None)
        except TooManyStatesError:
            raise ValueError(
                f"more than {BOARD_STATES:,} states can be reached; measure open loop"
            ) from None
        to_goals = self.measured.is_to_goals and not mdp.is_stochastic
        return with_goals(mdp) if to_goals else mdp, states

    def sensed(self, mdp: TabularMDP) -> "str | Int[np.ndarray, 'S']":
        """The sensor in the library's format."""
        return self.sensor

    def seen_in(self, mdp: TabularMDP, observations: Int[np.ndarray, "m"]) -> Int[np.ndarray, "m"]:
        """The cell in which to mark each observation, `ELSEWHERE` where there is none."""
        if self.sensor == "state":
            return mdp.factor(self.board.factors[0])[observations].astype(np.int64)
        if self.sensor not in self.board.cells:
            return np.full(len(observations), ELSEWHERE)
        return np.where(observations >= 0, observations, ELSEWHERE)

    def where(self, at: protocol.Placement) -> State:
        """The state that a message means.

        Raises:
            ValueError: there is none such.
        """
        return self.board.state(at)

    def placed(self, mdp: TabularMDP, state: int) -> protocol.Placement:
        """A state of a table of `around`, for a message."""
        return self.board.placement(self.board.reached(mdp, state))

    def plan(self, at: protocol.Placement | None) -> tuple[Plan, list[protocol.Placement]] | None:
        """A shortest plan with its placements, `None` if there is none."""
        found = self.board.plan(self.at if at is None else self.where(at))
        return found and (found, [self.board.placement(state) for state in found.states])
