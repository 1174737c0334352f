"""Parameters and state of a functional environment, as trees of arrays."""

from dataclasses import dataclass, replace
from functools import partial
from typing import Any, no_type_check

import jax
from jaxtyping import Array, Bool, Float, Int32, UInt8

from habilis.transitions import Transitions

_STATE = ("index", "time")
_EMPOWERMENT = ("bits", "weights")
_PARAMS = (
    *("transitions", "terminal", "start", "max_steps_in_episode"),
    *("flags", "seen", "background", "slip", "empowerment", "available"),
)

# JAX fills trees with batches, and with what are no arrays: their attributes are not checked.


@no_type_check
@partial(jax.tree_util.register_dataclass, data_fields=_STATE, meta_fields=())
@dataclass(frozen=True)
class State:
    """The state of an environment.

    Attributes:
        index: int32, the state of the table.
        time: int32, the steps of the running episode.
    """

    index: Int32[Array, ""]
    time: Int32[Array, ""]

    def replace(self, **changes: Any) -> "State":
        """The same but for some attributes.

        Args:
            **changes: new values of attributes by name.

        Returns:
            Another one.
        """
        return replace(self, **changes)


@no_type_check
@partial(jax.tree_util.register_dataclass, data_fields=_EMPOWERMENT, meta_fields=())
@dataclass(frozen=True)
class Empowerment:
    """The bonus in the reward.

    Attributes:
        bits: float32[S], M of every state.
        weights: the numbers that `regularised` needs, "beta" among them.
    """

    bits: Float[Array, "S"]
    weights: dict[str, Any]


@no_type_check
@partial(jax.tree_util.register_dataclass, data_fields=_PARAMS, meta_fields=())
@dataclass(frozen=True)
class Params:
    """A table, and how its episodes go.

    All of them are arrays and numbers: they may change without recompilation, and
    `vmap` goes over any of them.

    Attributes:
        transitions: where actions lead, with which probabilities and rewards.
        terminal: bool[S], the states whose entry ends an episode: those without actions too.
        start: the state in which episodes begin.
        max_steps_in_episode: the length of an episode, at most.
        flags: by name, bool[S], properties of states that `info` has.
        seen: int32[S, things], what is observed of a state: numbers, or where in the background
            it has ones.
        background: uint8, the part common to all observations; `None`: observations are numbers.
        slip: the probability that an action drawn uniformly takes the place of the chosen one;
            `None`: never, and no random number is drawn.
        empowerment: the bonus in the reward; `None`: none.
        available: bool[S, A], the actions that are available in each state; others lead back to
            the state, for a reward of 0. `None`: all are everywhere.
    """

    transitions: Transitions
    terminal: Bool[Array, "S"]
    start: Any
    max_steps_in_episode: Any
    flags: dict[str, Bool[Array, "S"]]
    seen: Int32[Array, "S things"]
    background: UInt8[Array, "*shape"] | None = None
    slip: Any = None
    empowerment: Empowerment | None = None
    available: Bool[Array, "S A"] | None = None

    @property
    def actions(self) -> int:
        """A, how many actions there are."""
        return self.transitions.cumulative.shape[-2] // self.terminal.shape[-1]

    def replace(self, **changes: Any) -> "Params":
        """The same but for some attributes.

        Args:
            **changes: new values of attributes by name.

        Returns:
            Another one.
        """
        return replace(self, **changes)
