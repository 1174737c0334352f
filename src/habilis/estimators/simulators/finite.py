"""A table as a simulator."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from jaxtyping import Float64, Int64

from habilis.estimators.protocol import Random, check_length
from habilis.mdp import TabularMDP
from habilis.transitions import Transitions


class FiniteSimulator:
    """A table as a simulator: a state is its index, float[n, 1], an action too.

    The observation is the state's index, then the label of each factor; the names are those of the
    factors ("object" stands for "object:can" where that is the only object).

    Attributes:
        mdp: the table.
        actions: float64[A, 1], the indices of the actions.
        names: the factors' entries of the observation.

    Example:
        >>> ring = TabularMDP.deterministic([[(s - 1) % 5, (s + 1) % 5] for s in range(5)])
        >>> FiniteSimulator(ring).step(np.array([[0.0], [4.0]]), np.array([[1.0], [1.0]])).tolist()
        [[1.0], [0.0]]
    """

    in_jax = False
    is_finite = True

    def __init__(self, mdp: TabularMDP):
        """
        Args:
            mdp: the table, deterministic or stochastic.

        Raises:
            ValueError: some action is not available in some state: a simulator takes every action
                in every state.
        """
        if not mdp.always_available:
            state, action = np.argwhere(~mdp.available)[0]
            raise ValueError(
                f"action {action} is not available in state {state}, and a simulator takes every "
                f"action everywhere: let next_state[{state}, {action}] lead somewhere, as to "
                "itself, or ask hb.empowerment without an estimator, which keeps to what is "
                "available"
            )
        self.mdp = mdp
        self.actions = np.arange(mdp.action_count, dtype=np.float64)[:, None]
        self.names: Mapping[str, int] = _columns(mdp)
        self._transitions = Transitions.of(mdp)
        labels = [np.arange(mdp.states), *mdp.factors.values()]
        self._observations = np.stack(labels, axis=1).astype(np.float64)

    @property
    def is_stochastic(self) -> bool:
        """Whether some action has more than one possible outcome."""
        return self.mdp.is_stochastic

    def step(
        self,
        states: Float64[np.ndarray, "n 1"],
        actions: Float64[np.ndarray, "n 1"],
        key: Random = None,
    ) -> Float64[np.ndarray, "n 1"]:
        """One step of many states at once.

        Args:
            states: indices.
            actions: indices, one for each.
            key: a NumPy generator; `None` of a deterministic table.

        Returns:
            The next states.
        """
        count = self.mdp.action_count
        choice = self.indices(states) * count + actions[:, 0].astype(np.int64)
        draw = key.random(len(choice)) if self.is_stochastic else None
        made = self._transitions.drawn(choice, draw)
        return self._transitions.next_state[made].astype(np.float64)[:, None]

    def observe(self, states: Float64[np.ndarray, "n 1"]) -> Float64[np.ndarray, "n o"]:
        """The observations of states.

        Args:
            states: indices.

        Returns:
            Index and labels, one state a row.
        """
        return self._observations[self.indices(states)]

    def indices(self, states: Float64[np.ndarray, "n d"]) -> Int64[np.ndarray, "n"]:
        """The rows of the table that states are.

        Args:
            states: indices, as numbers of any kind.

        Returns:
            int64[n].

        Raises:
            ValueError: a state is none of the table's.
        """
        check_length(states, 1)
        rows = states[:, 0].astype(np.int64)
        outside = (rows != states[:, 0]) | (rows < 0) | (rows >= self.mdp.states)
        if outside.any():
            raise ValueError(
                f"states has {states[outside][0, 0]:g}; use indices from 0 to {self.mdp.states - 1}"
            )
        return rows

    def random_states(
        self, count: int, generator: np.random.Generator
    ) -> Float64[np.ndarray, "n 1"]:
        """States drawn uniformly.

        Args:
            count: n.
            generator: to draw from.

        Returns:
            Indices.
        """
        return generator.integers(self.mdp.states, size=(count, 1)).astype(np.float64)


def _columns(mdp: TabularMDP) -> dict[str, Any]:
    """The entry of each factor by its name, and by what only it begins with."""
    columns = {name: index + 1 for index, name in enumerate(mdp.factors)}
    kinds = [name.partition(":")[0] for name in mdp.factors]
    short = {
        kind: columns[name]
        for kind, name in zip(kinds, mdp.factors, strict=True)
        if kinds.count(kind) == 1
    }
    return short | columns
