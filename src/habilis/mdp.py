"""A finite Markov decision process as arrays."""

import operator
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Bool, Float32, Int32
from numpy.typing import ArrayLike

from habilis.probabilities import as_array, as_flags, is_sparse, row_stochastic, shape_of

if TYPE_CHECKING:
    from scipy.sparse import csr_array

HELD, LAID = "held", "laid"
"""The factors of a world that are no cells: which tool is in hand, and which was put down."""

_NOWHERE = -2  # a label of no state: cells are 0 and up, what a world lacks is -1


@dataclass(frozen=True, eq=False)
class TabularMDP:
    """A finite MDP; state and action are indices.

    Made by `deterministic`, `stochastic`, `from_gymnasium` or, from a world, `tabulate`.

    Attributes:
        transitions: where actions lead. Deterministic: int32[S, A], the next state. Stochastic:
            sparse float64[S * A, S], in row `s * A + a` the probabilities of the next states.
            Terminal states have successors too: the dynamics do not know of episodes.
        reward: float32[S, A]; in a stochastic MDP the mean over next states.
        terminal: bool[S], the states whose entry ends an episode.
        factors: by name, an int32[S] label of what the state says of one thing in it. In a
            world: "agent", "tool", "object", each `row * width + column`; of several things see
            `tabulate`.
        flags: by name, a bool[S] property of the state. In a world: "equipped", "attached".
        start: the state in which episodes begin.
        shape: (rows, columns) of the world whose cells the factors name; `None` without one.
        actions: the names of the actions.
    """

    transitions: "Int32[np.ndarray, 'S A'] | csr_array"
    reward: Float32[np.ndarray, "S A"]
    terminal: Bool[np.ndarray, "S"]
    factors: Mapping[str, Int32[np.ndarray, "S"]] = field(default_factory=dict)
    flags: Mapping[str, Bool[np.ndarray, "S"]] = field(default_factory=dict)
    start: int = 0
    shape: tuple[int, int] | None = None
    actions: tuple[str, ...] = ()

    @classmethod
    def deterministic(
        cls,
        next_state: ArrayLike,
        reward: ArrayLike | None = None,
        terminal: ArrayLike | None = None,
        start: int = 0,
    ) -> "TabularMDP":
        """An MDP from its transition table.

        Args:
            next_state: int[S, A], the state that each action leads to.
            reward: float[S, A]; zero everywhere if left out.
            terminal: bool[S]; nowhere if left out.
            start: the state in which episodes begin.

        Returns:
            The MDP, without factors.

        Raises:
            ValueError: the arrays do not fit each other, are empty, or name a state that
                does not exist.

        Example:
            >>> TabularMDP.deterministic([[0, 1], [1, 0]]).states
            2
        """
        table = as_array("next_state", next_state)
        if table.ndim != 2 or table.size == 0 or not np.issubdtype(table.dtype, np.integer):
            raise ValueError(
                f"next_state has shape {table.shape} and type {table.dtype}; "
                "give integers of shape [states, actions]"
            )
        outside = np.argwhere((table < 0) | (table >= len(table)))
        if len(outside):
            state, action = outside[0]
            raise ValueError(
                f"next_state[{state}, {action}] is {table[state, action]}; "
                f"use states 0 to {len(table) - 1}"
            )
        return cls(
            np.array(table, np.int32, order="C"),
            *_rewards_and_ends(table.shape, reward, terminal, start),
            start=int(start),
        )

    @classmethod
    def stochastic(
        cls,
        P: Any,
        reward: ArrayLike | None = None,
        terminal: ArrayLike | None = None,
        start: int = 0,
    ) -> "TabularMDP":
        """An MDP from its transition probabilities.

        Args:
            P: float[S, A, S], the probability of each next state, or a sequence of A scipy.sparse
                matrices [S, S]. (Dense matrices, one an action: `np.stack(matrices, axis=1)`.)
            reward: float[S, A], the mean over next states; zero everywhere if left out.
            terminal: bool[S]; nowhere if left out.
            start: the state in which episodes begin.

        Returns:
            The MDP; a deterministic one if every action in every state has one outcome.

        Raises:
            ValueError: the arrays do not fit each other or are empty, or a state's
                probabilities under an action do not sum to one.

        Example:
            >>> wet = TabularMDP.stochastic([[[0.9, 0.1], [0.1, 0.9]], [[0.0, 1.0], [0.0, 1.0]]])
            >>> wet.is_stochastic
            True
        """
        from scipy.sparse import csr_array, vstack

        if is_sparse(P):
            raise ValueError("P is one sparse matrix; give a sequence of them, one an action")
        if not isinstance(P, Sequence) or not any(is_sparse(matrix) for matrix in P):
            table = as_array("P", P)
            if table.ndim != 3 or 0 in table.shape or len(table) != table.shape[2]:
                raise ValueError(
                    f"P has shape {table.shape}; give [states, actions, states], "
                    "or a sequence of scipy.sparse matrices [states, states], one an action"
                )
            P = list(np.moveaxis(table, 1, 0))
        each = [row_stochastic(f"P, action {a}", m, "state {}") for a, m in enumerate(P)]
        states = shape_of(each[0])[0]
        for action, matrix in enumerate(each):
            if matrix.shape != (states, states):
                raise ValueError(
                    f"P, action {action} has shape {matrix.shape}; give {(states, states)}"
                )
        by_action = np.arange(states * len(each)).reshape(len(each), states)
        stacked = csr_array(vstack(each, format="csr"))[by_action.T.ravel()]
        return cls(
            _next_states(stacked, len(each)),
            *_rewards_and_ends((states, len(each)), reward, terminal, start),
            start=int(start),
        )

    @classmethod
    def from_gymnasium(
        cls,
        env: Any,
        *,
        max_states: int = 100_000,
        seed: int | None = 0,
        key: Callable[[Any], Hashable] | None = None,
        factors: Mapping[str, Callable[[Any], int]] | None = None,
        show_progress: bool = False,
    ) -> "TabularMDP":
        """The table of a Gymnasium environment; the environment itself is left as it is.

        From its own table `P` if it has one, as FrozenLake, CliffWalking and Taxi do. Otherwise
        it must be deterministic, and every state that can be reached from the first is stepped
        through, on copies. Counters of steps are no part of a state: every step is made as if it
        were the first, and truncation is not an end. Terminal states are not stepped out of.

        Args:
            env: what `gymnasium.make` returns, wrapped or not.
            max_states: how many states to accept before giving up.
            seed: of the reset that makes the first state; `None`: the state that env is in.
            key: what makes two states of the (unwrapped) environment the same; by default all
                that it holds but random numbers, pictures and counters of steps.
            factors: further factors by name: a whole number for the (unwrapped) environment in a
                state. Not for environments that have a `P`.
            show_progress: whether to draw a progress bar on standard error.

        Returns:
            A table with the rewards, terminal states and first state of the environment. Factors:
            FrozenLake and CliffWalking "agent"; Taxi "taxi", "passenger", "destination";
            Minigrid "agent", "direction", "carried" and every thing by its kind, such as "key".

        Raises:
            ValueError: it is no such environment, chance decides on a step, it has more states
                than max_states, or it cannot be copied or compared.

        Example:
            >>> import gymnasium
            >>> lake = TabularMDP.from_gymnasium(gymnasium.make("FrozenLake-v1"))
            >>> lake.states, lake.is_stochastic, lake.actions
            (16, True, ('left', 'down', 'right', 'up'))
        """
        from habilis.gymnasium_tables import table_of

        return table_of(env, max_states, seed, key, factors, show_progress)

    def slippery(self, slip: float) -> "TabularMDP":
        """This MDP when the chosen action may be replaced (rule 7 of the worlds).

        Args:
            slip: the probability that an action drawn uniformly from all of them, the chosen
                one among them, takes the place of the chosen one.

        Returns:
            The MDP with `(1 - slip) P + slip * (mean of P over actions)`, rewards likewise; or
            this one, if slip is 0.

        Raises:
            ValueError: slip is no probability.

        Example:
            >>> TabularMDP.deterministic([[0, 1], [0, 1]]).slippery(0.2).transition(0).toarray()
            array([[0.9, 0.1],
                   [0.9, 0.1]])
        """
        if isinstance(slip, bool) or not isinstance(slip, int | float) or not 0 <= slip <= 1:
            raise ValueError(f"slip is {slip!r}; give a probability from 0 to 1")
        if slip == 0:
            return self
        intended = [self.transition(action) for action in range(self.action_count)]
        any_action = sum(intended[1:], intended[0]) * (slip / self.action_count)
        mixed = [(1 - slip) * one + any_action for one in intended]
        reward = (1 - slip) * self.reward + slip * self.reward.mean(axis=1, keepdims=True)
        slipping = TabularMDP.stochastic(mixed)
        return replace(self, transitions=slipping.transitions, reward=reward.astype(np.float32))

    @property
    def is_stochastic(self) -> bool:
        """Whether some action has more than one possible outcome."""
        return not isinstance(self.transitions, np.ndarray)

    @property
    def next_state(self) -> Int32[np.ndarray, "S A"]:
        """int32[S, A], the state that each action leads to.

        Raises:
            ValueError: the MDP is stochastic.
        """
        if not isinstance(self.transitions, np.ndarray):
            raise ValueError("this MDP is stochastic: it has no next_state; use transition(action)")
        return self.transitions

    def transition(self, action: int) -> "csr_array":
        """The transition matrix of an action.

        Args:
            action: its index, from 0 to A - 1.

        Returns:
            Sparse float64[S, S]; row s has the probabilities of the states that follow s.
        """
        from scipy.sparse import csr_array

        if isinstance(self.transitions, np.ndarray):
            ends = np.ascontiguousarray(self.transitions[:, action])
            ones = np.ones(self.states)
            return csr_array((ones, ends, np.arange(self.states + 1)), (self.states,) * 2)
        return self.transitions[action :: self.action_count]

    @property
    def states(self) -> int:
        """S, how many states there are."""
        return self.reward.shape[0]

    @property
    def action_count(self) -> int:
        """A, how many actions there are."""
        return self.reward.shape[1]

    def factor(self, name: str) -> Int32[np.ndarray, "S"]:
        """The label of one thing in every state.

        Args:
            name: of the factor, as "object". Where there is only one of them, "object" stands for
                "object:can" too, and "tool" for "tool:picker".

        Returns:
            int32[S]; in a world the cell of the thing, `row * columns + column`.

        Raises:
            ValueError: the MDP has no such factor, or several that could be meant; the message
                lists those it has.
        """
        return self.factors[self.factor_named(name)]

    def factor_named(self, name: str, what: str = "factor", besides: Sequence[str] = ()) -> str:
        """The whole name of a factor: "object" is "object:can" where that is the only object.

        Args:
            name: of the factor, or what stands before the colon in it.
            what: to call it in the message.
            besides: what else there is to choose.

        Returns:
            A key of `factors`.

        Raises:
            ValueError: as in `factor`.
        """
        if name in self.factors:
            return name
        meant = [one for one in self.factors if one.partition(":")[0] == name]
        if len(meant) == 1:
            return meant[0]
        problem = "could be several things" if meant else "is unknown"
        known = ", ".join([*besides, *self.factors]) or "none"
        mend = f"use one of {known}" if besides else f"this MDP has: {known}"
        raise ValueError(f"{what} {name!r} {problem}; {mend}")

    def is_cell(self, name: str) -> bool:
        """Whether a factor's labels are cells of a map.

        Args:
            name: of the factor, in full.

        Returns:
            Not for "held" and "laid", and in an MDP without a map for none.
        """
        return self.shape is not None and name not in (HELD, LAID)

    def label(self, cell: tuple[int, int]) -> int:
        """The label that factors have for a cell, `row * columns + column`.

        Args:
            cell: (row, column), from 0.

        Returns:
            A label; one that no state has for a cell outside the map.

        Raises:
            ValueError: the MDP has no cells, or this is none.
        """
        if self.shape is None:
            raise ValueError("this MDP has no cells; only a world's table has")
        try:
            row, column = (operator.index(part) for part in cell)
        except (TypeError, ValueError):
            raise ValueError(f"cell is {cell!r}; give (row, column)") from None
        inside = 0 <= row < self.shape[0] and 0 <= column < self.shape[1]
        return row * self.shape[1] + column if inside else _NOWHERE

    def find(self, **cells: tuple[int, int] | int) -> int:
        """The state in which things are at given cells.

        Args:
            **cells: for each factor the (row, column) of the thing; its label if it is no cell, as
                `find(**{"agent": (0, 0), "object:can": (1, 0), "held": -1})`.

        Returns:
            The state's index.

        Raises:
            KeyError: no state, or more than one, has everything there.
            ValueError: the MDP has no such factor.
        """
        found = np.ones(self.states, bool)
        for name, cell in cells.items():
            label = self._label_of(name, cell)
            found &= self.factor(name) == label
        matches = np.flatnonzero(found)
        if len(matches) != 1:
            where = ", ".join(f"{name}={cell}" for name, cell in cells.items())
            raise KeyError(f"{len(matches) or 'no'} states have {where}")
        return int(matches[0])

    def _label_of(self, name: str, value: Any) -> int:
        if self.shape is None or self.is_cell(self.factor_named(name)):
            return self.label(value)
        return operator.index(value)


def _rewards_and_ends(
    shape: tuple[int, int], reward: ArrayLike | None, terminal: ArrayLike | None, start: int
) -> tuple[Float32[np.ndarray, "S A"], Bool[np.ndarray, "S"]]:
    """What an MDP has besides its transitions, checked against their shape [S, A]."""
    states = shape[0]
    reward = np.zeros(shape) if reward is None else as_array("reward", reward)
    terminal = np.zeros(states, bool) if terminal is None else as_flags("terminal", terminal)
    if reward.shape != shape:
        raise ValueError(f"reward has shape {reward.shape}; give {shape}, [states, actions]")
    if reward.dtype.kind not in "biuf" or not (abs(reward) <= np.finfo(np.float32).max).all():
        raise ValueError("reward has entries that are not finite (in float32); give numbers")
    if terminal.shape != (states,):
        raise ValueError(f"terminal has shape {terminal.shape}; give ({states},)")
    if not isinstance(start, int | np.integer) or not 0 <= start < states:
        raise ValueError(f"start is {start}; use a state from 0 to {states - 1}")
    return reward.astype(np.float32), terminal.astype(bool)


def _next_states(stacked: "csr_array", actions: int) -> "Int32[np.ndarray, 'S A'] | csr_array":
    """Transitions in their simplest form: one next state each where there is but one."""
    if (np.diff(stacked.indptr) == 1).all():
        return stacked.indices.astype(np.int32).reshape(-1, actions)
    return stacked
