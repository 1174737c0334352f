"""A table as arrays of the compiled training loop."""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Float32, Int, Int32

from habilis.learning.config import ONE_HOT
from habilis.mdp import TabularMDP
from habilis.transitions import Transitions

ROOM = 1 << 13
"""To a multiple of which `roomy` brings the number of states."""


class Dynamics(NamedTuple):
    """The data shared by all lanes; transitions are numbered as in `Transitions`."""

    transitions: Transitions
    goes_on: Int[Array, "S*A*K"]
    """Where the next step is made from: the next state, or -1 where that is terminal."""
    inputs: Int[Array, "S factors"] | Float[Array, "S coordinates"]
    """A network's observation of a state: rows of its first weights, or coordinates."""
    start: Int[Array, "*starts"]
    """Where episodes begin: one state, or any of several."""
    available: Bool[Array, "S A"] | None = None
    """The actions that may be taken in each state, all where nothing follows; `None`: all."""

    @property
    def states(self) -> int:
        return self.inputs.shape[0]

    @property
    def actions(self) -> int:
        return self.transitions.cumulative.shape[0] // self.states

    def available_in(self, state: Int[Array, "*n"]) -> Bool[Array, "*n A"] | None:
        """The actions that may be taken in some states; `None`: all."""
        return None if self.available is None else self.available[state]

    def only(self, states: Int[Array, "n"]) -> "Dynamics":
        """The same with what is shown of, and may be done in, some states alone."""
        return self._replace(inputs=self.inputs[states], available=self.available_in(states))

    def transition(
        self, state: Int[Array, "*n"], action: Int[Array, "*n"], draw: Float[Array, "*n"] | None
    ) -> Int[Array, "*n"]:
        """The outcomes, given a uniform number for each; a single outcome needs none."""
        return self.transitions.drawn(state * self.actions + action, draw)

    def state_of(self, transition: Int[Array, "*n"]) -> Int[Array, "*n"]:
        return transition // (self.actions * self.transitions.outcomes)

    def action_of(self, transition: Int[Array, "*n"]) -> Int[Array, "*n"]:
        return transition // self.transitions.outcomes % self.actions

    def begin(self, draw: Float[Array, "*n"] | None) -> Int[Array, "*n"]:
        """Where episodes begin, given a uniform number for each; the one start needs none."""
        if draw is None:
            return self.start
        place = (draw * len(self.start)).astype(jnp.int32)
        return self.start[jnp.minimum(place, len(self.start) - 1)]

    def terminated(self, transition: Int[Array, "*n"]) -> Bool[Array, "*n"]:
        return self.goes_on[transition] < 0


def make_dynamics(
    mdp: TabularMDP,
    starts: Int[np.ndarray, "starts"] | None = None,
    observation: str = ONE_HOT,
) -> tuple[Dynamics, int]:
    """The table as arrays on the device, and how many rows the network's first weights have.

    Episodes begin in any of `starts`, or in the table's own.

    A state is shown to the network by its factors, each one-hot, or by its coordinates, as in
    `coordinates`; without factors, by its index. Episodes end where nothing can be done, as in
    terminal states.

    Raises:
        ValueError: they begin in such a state.
    """
    ends = mdp.ends
    stuck = np.atleast_1d(mdp.start if starts is None else starts)
    stuck = stuck[ends[stuck] & ~mdp.terminal[stuck]]
    if len(stuck):
        raise ValueError(f"no action is available in state {stuck[0]}; give another start")
    inputs, rows = one_hot(mdp) if observation == ONE_HOT else coordinates(mdp)
    transitions = Transitions.of(mdp)
    reached = transitions.next_state
    dynamics = Dynamics(
        transitions=transitions.in_jax(),
        goes_on=jnp.asarray(np.where(ends[reached], -1, reached), jnp.int32),
        inputs=jnp.asarray(inputs),
        start=jnp.int32(mdp.start) if starts is None else jnp.asarray(starts, jnp.int32),
        available=None
        if mdp.always_available
        else jnp.asarray(mdp.available | ~mdp.available.any(axis=1, keepdims=True)),
    )
    return dynamics, rows


def one_hot(mdp: TabularMDP) -> tuple[Int32[np.ndarray, "S factors"], int]:
    """For each factor of each state the row of its value, and how many rows there are."""
    factors = list(mdp.factors.values()) or [np.arange(mdp.states)]
    inputs, rows = [], 0
    for labels in factors:
        values, compact = np.unique(labels, return_inverse=True)
        inputs.append(compact + rows)
        rows += len(values)
    return np.stack(inputs, axis=1).astype(np.int32), rows


def coordinates(mdp: TabularMDP) -> tuple[Float32[np.ndarray, "S coordinates"], int]:
    """The observation of a plain network: numbers from -1 to 1, and how many a state has.

    Row and column of each cell, from -1 at the map's upper left to 1 at its lower right; other
    factors by their labels, scaled to the range that these have.
    """
    columns = []
    for name, labels in (mdp.factors or {"": np.arange(mdp.states)}).items():
        if mdp.shape is not None and mdp.is_cell(name):
            nowhere = labels < 0
            for place, side in zip(np.divmod(labels, mdp.shape[1]), mdp.shape, strict=True):
                columns.append(np.where(nowhere, 0.0, _scaled(place, 0, side - 1)))
        else:
            columns.append(_scaled(labels, int(labels.min()), int(labels.max())))
    return np.stack(columns, axis=1).astype(np.float32), len(columns)


def _scaled(values: Int[np.ndarray, "S"], least: int, most: int) -> Float[np.ndarray, "S"]:
    return (2.0 * values - least - most) / max(most - least, 1)


def roomy(dynamics: Dynamics) -> Dynamics:
    """The same, padded with unreachable states to a multiple of `ROOM`.

    Tables of about one size, as those of one map with different starts, then share a compiled
    program; compiling takes longer than many a run.
    """
    more = -dynamics.states % ROOM
    chosen = (0, more * dynamics.actions)
    made = (0, more * dynamics.actions * dynamics.transitions.outcomes)
    next_state, reward, cumulative = dynamics.transitions
    return dynamics._replace(
        transitions=Transitions(
            next_state=jnp.pad(next_state, made),
            reward=jnp.pad(reward, made),
            cumulative=jnp.pad(cumulative, (chosen, (0, 0))),
        ),
        goes_on=jnp.pad(dynamics.goes_on, made),
        inputs=jnp.pad(dynamics.inputs, ((0, more), (0, 0))),
        available=None
        if dynamics.available is None
        else jnp.pad(dynamics.available, ((0, more), (0, 0)), constant_values=True),
    )
