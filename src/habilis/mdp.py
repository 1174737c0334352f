"""A finite Markov decision process as arrays."""

import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float32, Int32
from numpy.typing import ArrayLike

from habilis.checks import is_probability
from habilis.mdp_arguments import (
    Axes,
    next_states,
    only_rows,
    rewards_and_ends,
    self_loops,
    simplest,
    transition_matrix,
)
from habilis.mdp_description import contents, described
from habilis.reprs import quietly, short, table_html, unfailing

if TYPE_CHECKING:
    from scipy.sparse import csr_array

HELD, LAID = "held", "laid"
"""The factors of a world that are no cells: which tool is in hand, and which was put down."""

_NOWHERE = -2  # a label of no state: cells are 0 and up, what a world lacks is -1


@runtime_checkable
class Origin(Protocol):
    """The environment that a table was made of."""

    @property
    def verified(self) -> int:
        """How many transitions of the table were seen in replays of the environment."""
        ...

    def restore(self, state: int | np.integer) -> Any:
        """The environment in a state."""
        ...

    def observation(self, state: int | np.integer) -> Any:
        """Its observation of a state."""
        ...


@runtime_checkable
class ModelStates(Protocol):
    """The states of the model that a table was made of."""

    def state(self, index: int) -> Any:
        """A state as the model has it."""
        ...

    def index(self, state: Any) -> int:
        """The number of a state; -1 if it is not in the table."""
        ...


@dataclass(frozen=True, eq=False)
class TabularMDP:
    """A finite MDP; state and action are indices.

    Made by `deterministic`, `stochastic`, `from_gymnasium`, `from_storm`, of a model by `explore`,
    of a world by `tabulate`, or read by `load` and `load_pomdp`.

    Attributes:
        transitions: where actions lead. Deterministic: int32[S, A], the next state. Stochastic:
            sparse float64[S * A, S], in row `s * A + a` the probabilities of the next states.
            Where an action is not available: -1, and an empty row. Terminal states have
            successors too: the dynamics do not know of episodes.
        reward: float32[S, A]; in a stochastic MDP the mean over next states; 0 where an action is
            not available.
        terminal: bool[S], the states whose entry ends an episode.
        factors: by name, an int32[S] label of what the state says of one thing in it. In a
            world: "agent", "tool", "object", each `row * width + column`; of several things see
            `tabulate`.
        flags: by name, a bool[S] property of the state. In a world: "equipped", "attached".
        start: the state in which episodes begin.
        shape: (rows, columns) of the world whose cells the factors name; `None` without one.
        actions: the names of the actions.
        origin: the environment that the table was made of, if any.
        entry_reward: float32[S], the reward of entering each state, for the outcomes of stochastic
            actions. Where `reward` is not its mean over next states, and without it, every outcome
            earns `reward`.
        cells: the factors whose labels are cells of `shape`; `None`: all but "held" and "laid".
        model_states: the states of the model that `explore` made the table of, or the names that a
            file has for them, if any.
        drawn: the world or puzzle that it is the table of, which pictures of its states take.
    """

    transitions: "Int32[np.ndarray, 'S A'] | csr_array"
    reward: Float32[np.ndarray, "S A"]
    terminal: Bool[np.ndarray, "S"]
    factors: Mapping[str, Int32[np.ndarray, "S"]] = field(default_factory=dict)
    flags: Mapping[str, Bool[np.ndarray, "S"]] = field(default_factory=dict)
    start: int = 0
    shape: tuple[int, int] | None = None
    actions: tuple[str, ...] = ()
    origin: "Origin | None" = field(default=None, repr=False)
    entry_reward: Float32[np.ndarray, "S"] | None = None
    cells: frozenset[str] | None = None
    model_states: "ModelStates | None" = field(default=None, repr=False)
    drawn: Any = field(default=None, repr=False)

    @unfailing
    def __repr__(self) -> str:
        return short("TabularMDP", *described(self))

    @quietly
    def _repr_html_(self) -> str:
        """What there is of it, and of a map the picture of its start, for notebooks."""
        from habilis.worlds.pictures.states import start_image

        picture = start_image(self)
        return table_html("TabularMDP", contents(self), *([] if picture is None else [picture]))

    @classmethod
    def deterministic(
        cls,
        next_state: ArrayLike,
        reward: ArrayLike | None = None,
        terminal: ArrayLike | None = None,
        start: int = 0,
        available: ArrayLike | None = None,
    ) -> "TabularMDP":
        """An MDP from its transition table.

        Args:
            next_state: int[S, A], the state that each action leads to; -1 for an action that is
                not available in that state.
            reward: float[S, A]; zero everywhere if left out.
            terminal: bool[S]; nowhere if left out. A terminal state without actions gets
                self-loops with reward 0.
            start: the state in which episodes begin.
            available: bool[S, A], which actions are available in each state; what next_state and
                reward have elsewhere is ignored. By default those whose next state is not -1.

        Returns:
            The MDP, without factors.

        Raises:
            ValueError: the arrays do not fit each other, are empty, or name a state that
                does not exist.

        Example:
            >>> TabularMDP.deterministic([[0, 1], [1, 0]]).states
            2
            >>> TabularMDP.deterministic([[0, 1], [-1, 0]]).available
            array([[ True,  True],
                   [False,  True]])
        """
        table = next_states(next_state, available)
        there = table >= 0
        reward, terminal = rewards_and_ends(there, reward, terminal, start)
        if not there.all():
            still = terminal & ~there.any(axis=1)
            table[still] = np.flatnonzero(still)[:, None]
        return cls(table, reward, terminal, start=int(start))

    @classmethod
    def stochastic(
        cls,
        P: Any,
        reward: ArrayLike | None = None,
        terminal: ArrayLike | None = None,
        start: int = 0,
        available: ArrayLike | None = None,
        axes: Axes | None = None,
    ) -> "TabularMDP":
        """An MDP from its transition probabilities.

        Args:
            P: the probability of each next state: an array or nested lists, float[S, A, S]; or a
                list of A matrices [S, S], one an action, dense or scipy.sparse. A row of zeros is
                an action that is not available in that state.
            reward: float[S, A], the mean over next states; zero everywhere if left out.
            terminal: bool[S]; nowhere if left out. A terminal state without actions gets
                self-loops with reward 0.
            start: the state in which episodes begin.
            available: bool[S, A], which actions are available in each state; what P and reward
                have elsewhere is ignored. By default those whose row of P is not zero.
            axes: what the axes of P are, "SAS" for [states, actions, next states] or "ASS" for
                [actions, states, next states]; by default as said of P. A list of as many dense
                matrices as there are states could be either, and needs it.

        Returns:
            The MDP; a deterministic one if no action in any state has several outcomes.

        Raises:
            ValueError: the arrays do not fit each other or are empty, a state's probabilities
                under an action do not sum to one, or P could be by state or by action.

        Example:
            >>> left, right = np.array([[1.0, 0.0], [0.9, 0.1]]), np.array([[0.1, 0.9], [0.0, 1.0]])
            >>> wet = TabularMDP.stochastic([left, right], axes="ASS")
            >>> wet.is_stochastic
            True
        """
        stacked, actions = transition_matrix(P, available, axes)
        there = (np.diff(stacked.indptr) > 0).reshape(-1, actions)
        reward, terminal = rewards_and_ends(there, reward, terminal, start)
        still = np.flatnonzero(terminal & ~there.any(axis=1))
        if len(still):
            stacked = stacked + self_loops(still, actions, len(there))
        return cls(simplest(stacked, actions), reward, terminal, start=int(start))

    @classmethod
    def from_gymnasium(
        cls,
        env: Any,
        *,
        max_states: int = 100_000,
        seed: int | None = 0,
        key: Callable[[Any], Any] | None = None,
        ignore: Sequence[str] = (),
        state: tuple[Callable[[Any], Any], Callable[[Any, Any], Any]] | None = None,
        factors: Mapping[str, Callable[[Any], int]] | None = None,
        show_progress: bool = False,
    ) -> "TabularMDP":
        """The table of a Gymnasium environment; the environment itself is left as it is.

        From its own table `P` if it has one, as FrozenLake, CliffWalking and Taxi do. Otherwise
        it must be deterministic, and every state that can be reached from the first is stepped
        through, on copies. A state is the value of all that the (unwrapped) environment holds:
        see "Is the number right?" in the documentation. Terminal states are not stepped out of; a
        situation that is reached both with and without the end of an episode is two states.

        Then the table is checked against the environment as it was passed, with its wrappers: in
        replayed episodes every step must be the table's, or the environment is refused. Where
        `P` is read, or steps are enumerated, and it cannot be copied, it is reset afterwards.

        Args:
            env: what `gymnasium.make` returns, wrapped or not.
            max_states: how many states to accept before giving up.
            seed: of the reset that makes the first state; `None`: the state that env is in.
            key: what makes two states of the (unwrapped) environment the same, in the place of
                all that it holds.
            ignore: attributes of the (unwrapped) environment that are no part of its state, such
                as a counter of steps, "simulator.time" those of an attribute. Every step is made
                with what they are in the first state; in the replays they run on, so that
                an environment whose transitions depend on one is refused.
            state: `(save, load)`, two functions of the wrapped environment: `save(env)` returns
                the value of its state, `load(env, value)` restores it. For environments that
                cannot be copied, and for wrappers that change what a step does: steps are then
                made through all wrappers. They take precedence over `P`.
            factors: further factors by name: a whole number for the (unwrapped) environment in a
                state. Not for environments that have a `P`.
            show_progress: whether to draw a progress bar on standard error.

        Returns:
            A table with the rewards, terminal states and first state of the environment, whose
            `observation` and `restore` lead back to it. Factors: FrozenLake and CliffWalking
            "agent"; Taxi "taxi", "passenger", "destination"; Minigrid "agent", "direction",
            "carried" and every thing by its kind, such as "key".

        Raises:
            ValueError: it is no such environment, is random, does not follow its table, has more
                states than max_states, or cannot be copied or compared; the message says what to
                do.

        Example:
            >>> import gymnasium
            >>> lake = TabularMDP.from_gymnasium(gymnasium.make("FrozenLake-v1"))
            >>> lake.states, lake.is_stochastic, lake.actions
            (16, True, ('left', 'down', 'right', 'up'))
        """
        from habilis.bridges.gymnasium import table_of

        return table_of(env, max_states, seed, key, ignore, state, factors, show_progress)

    @classmethod
    def from_storm(
        cls,
        model: Any,
        constants: str = "",
        *,
        reward: str | None = None,
        terminal: str | None = None,
    ) -> "TabularMDP":
        """The table of a DTMC, MDP or POMDP in a language that the model checker Storm reads.

        Needs `habilis[storm]`. Actions are the labels of choices; of several choices with one label
        in a state the second is an action of its own, as in "move 2"; those without a label are
        "[]", "[] 2", ... A DTMC has one action. An action is available in the states that have such
        a choice. In a deadlock, where Storm adds a self-loop, none is.

        Args:
            model: the path of a model: `.jani`; `.drn`; `.tra`, with the `.lab` of the same name
                beside it; or else in PRISM's language. Or a PrismProgram, a JaniModel or a sparse
                model of `stormpy`.
            constants: the values of constants that the model leaves open, as "N=4,p=0.1".
            reward: the name of the reward model; by default the only one, if there is one. Rewards
                of states and of actions are added.
            terminal: the label of the states in which episodes end; by default none does.

        Returns:
            A table in Storm's order of states. Factors are the variables of the model, and of a
            POMDP "observation"; flags are its labels of states.

        Raises:
            ValueError: Storm refuses the model, a constant has no value, it has several initial
                states, is parametric or in continuous time, or lacks what is named.
            MissingExtraError: stormpy is not installed.
        """
        from habilis.bridges.storm import table_of

        return table_of(model, constants, reward, terminal)

    def save(self, path: str | Path) -> None:
        """Writes the table to a file, which `TabularMDP.load` reads.

        All of it but the environment or model that it was made of (`origin`, `model_states`). The
        file holds arrays of NumPy without pickles; it is written whole or not at all.

        Args:
            path: ends with .npz. A file of that name is replaced.

        Raises:
            ValueError: another suffix, or the file cannot be written.

        Example:
            >>> from tempfile import mkdtemp
            >>> path = Path(mkdtemp()) / "two.npz"
            >>> TabularMDP.deterministic([[0, 1], [1, 0]]).save(path)
            >>> TabularMDP.load(path).next_state.tolist()
            [[0, 1], [1, 0]]
        """
        from habilis.bridges.table_files import save

        save(self, path)

    @classmethod
    def load(cls, path: str | Path) -> "TabularMDP":
        """The table in a file that `save` wrote.

        Args:
            path: of the file.

        Returns:
            A table equal to the one saved, with its transitions, available actions, rewards,
            terminal states, factors, flags, start, cells and names of actions.

        Raises:
            ValueError: the file cannot be read, is damaged, or is something else.

        Example:
            >>> from tempfile import mkdtemp
            >>> path = Path(mkdtemp()) / "slippery.npz"
            >>> TabularMDP.deterministic([[0, 1], [1, 0]]).slippery(0.2).save(path)
            >>> TabularMDP.load(path).is_stochastic
            True
        """
        from habilis.bridges.table_files import load

        return load(path)

    def __getstate__(self) -> dict[str, Any]:
        """For pickles: the environment or map that a table was made of stays behind."""
        return vars(self) | {"origin": None, "drawn": None}

    def restore(self, state: int | np.integer) -> Any:
        """An environment in a state of a table that `from_gymnasium` made.

        Args:
            state: its index.

        Returns:
            A copy of the environment that was passed, with its wrappers, led there along a shortest
            path or, of a `P`, put there; with `state=(save, load)`, or an environment's own
            `set_state`, that environment itself.

        Raises:
            ValueError: the table was not made from an environment, there is no such state, or the
                wrappers do not let it be reached.

        Example:
            >>> import gymnasium
            >>> lake = TabularMDP.from_gymnasium(gymnasium.make("FrozenLake-v1"))
            >>> int(lake.restore(7).unwrapped.s)
            7
        """
        return self._environment(state).restore(int(state))

    def observation(self, state: int | np.integer) -> Any:
        """The observation of a state by the environment of `from_gymnasium`, with its wrappers.

        Args:
            state: its index.

        Returns:
            An observation, as `step` returns it.

        Raises:
            ValueError: as in `restore`.

        Example:
            >>> import gymnasium
            >>> lake = TabularMDP.from_gymnasium(gymnasium.make("FrozenLake-v1"))
            >>> lake.observation(7)
            7
        """
        return self._environment(state).observation(int(state))

    def state(self, index: int | np.integer) -> Any:
        """A state of the model that `explore` made this table of.

        Args:
            index: its number here.

        Returns:
            The state as the model has it.

        Raises:
            ValueError: the table was not made of a model, or there is no such state.

        Example:
            >>> class Coin:
            ...     actions, initial = ("turn",), "heads"
            ...
            ...     def step(self, state, action):
            ...         return "tails" if state == "heads" else "heads"
            >>> from habilis.models import explore
            >>> explore(Coin()).state(1)
            'tails'
        """
        states = self._of_model()
        self._check_index(index)
        return states.state(int(index))

    def index(self, state: Any) -> int:
        """The number of a state of the model that `explore` made this table of.

        Args:
            state: as the model has it.

        Returns:
            Its index.

        Raises:
            KeyError: it was not reached.
            ValueError: the table was not made of a model.

        Example:
            >>> class Coin:
            ...     actions, initial = ("turn",), "heads"
            ...
            ...     def step(self, state, action):
            ...         return "tails" if state == "heads" else "heads"
            >>> from habilis.models import explore
            >>> explore(Coin()).index("tails")
            1
        """
        found = self._of_model().index(state)
        if found < 0:
            raise KeyError(f"the table has no state {state!r:.80}: it is not reached")
        return found

    def _of_model(self) -> "ModelStates":
        if self.model_states is None:
            raise ValueError("this table was not made of a model; habilis.explore makes one of it")
        return self.model_states

    def _check_index(self, state: Any) -> None:
        if not isinstance(state, int | np.integer) or not 0 <= state < self.states:
            raise ValueError(f"state is {state!r}; use 0 to {self.states - 1}")

    def _environment(self, state: int | np.integer) -> "Origin":
        if self.origin is None:
            raise ValueError(
                "this table was not made from an environment; TabularMDP.from_gymnasium makes one"
            )
        self._check_index(state)
        return self.origin

    def slippery(self, slip: float) -> "TabularMDP":
        """This MDP when the chosen action may be replaced (rule 7 of the worlds).

        Args:
            slip: the probability that an action drawn uniformly from those available in the
                state, the chosen one among them, takes the place of the chosen one.

        Returns:
            The MDP with `(1 - slip) P + slip * (mean of P over available actions)`, rewards
            likewise; or this one, if slip is 0. The same actions are available.

        Raises:
            ValueError: slip is no probability.

        Example:
            >>> TabularMDP.deterministic([[0, 1], [0, 1]]).slippery(0.2).transition(0).toarray()
            array([[0.9, 0.1],
                   [0.9, 0.1]])
        """
        if not is_probability(slip):
            raise ValueError(f"slip is {slip!r}; give a probability from 0 to 1")
        slip = float(slip)  # a narrower type would round all that is multiplied by it
        if slip == 0:
            return self
        there = self.available
        counts = np.maximum(there.sum(axis=1), 1)
        intended = [self.transition(action) for action in range(self.action_count)]
        any_action = sum(intended[1:], intended[0]).copy()
        any_action.data *= np.repeat(slip / counts, np.diff(any_action.indptr))
        if there.all():
            mixed = [(1 - slip) * one + any_action for one in intended]
        else:
            mixed = [
                (1 - slip) * one + only_rows(any_action, there[:, action])
                for action, one in enumerate(intended)
            ]
        mean = self.reward.sum(axis=1, keepdims=True) / counts.astype(np.float32)[:, None]
        reward = np.where(there, (1 - slip) * self.reward + slip * mean, 0)
        slipping = TabularMDP.stochastic(mixed)
        return replace(self, transitions=slipping.transitions, reward=reward.astype(np.float32))

    @property
    def is_stochastic(self) -> bool:
        """Whether some action has more than one possible outcome."""
        return not isinstance(self.transitions, np.ndarray)

    @property
    def next_state(self) -> Int32[np.ndarray, "S A"]:
        """int32[S, A], the state that each action leads to; -1 where it is not available.

        Raises:
            ValueError: the MDP is stochastic.
        """
        if not isinstance(self.transitions, np.ndarray):
            raise ValueError("this MDP is stochastic: it has no next_state; use transition(action)")
        return self.transitions

    @property
    def available(self) -> Bool[np.ndarray, "S A"]:
        """bool[S, A], the actions A(s) that are available in each state."""
        if isinstance(self.transitions, np.ndarray):
            return self.transitions >= 0
        return (np.diff(self.transitions.indptr) > 0).reshape(-1, self.action_count)

    @property
    def always_available(self) -> bool:
        """Whether every action is available in every state."""
        if isinstance(self.transitions, np.ndarray):
            return self.transitions.size == 0 or int(self.transitions.min()) >= 0
        return bool((np.diff(self.transitions.indptr) > 0).all())

    @property
    def ends(self) -> Bool[np.ndarray, "S"]:
        """bool[S], the states in which an episode ends: terminal ones and those without actions."""
        if self.always_available:
            return self.terminal
        return self.terminal | ~self.available.any(axis=1)

    def transition(self, action: int | np.integer) -> "csr_array":
        """The transition matrix of an action.

        Args:
            action: its index, from 0 to A - 1.

        Returns:
            Sparse float64[S, S]; row s has the probabilities of the states that follow s, and is
            empty where the action is not available.
        """
        from scipy.sparse import csr_array

        if isinstance(self.transitions, np.ndarray):
            reached = self.transitions[:, action]
            there = reached >= 0
            first = np.concatenate([[0], np.cumsum(there)])
            reached = reached[there]
            return csr_array((np.ones(len(reached)), reached, first), (self.states,) * 2)
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
        fix = f"use one of {known}" if besides else f"this MDP has: {known}"
        raise ValueError(f"{what} {name!r} {problem}; {fix}")

    def is_cell(self, name: str) -> bool:
        """Whether a factor's labels are cells of a map.

        Args:
            name: of the factor, in full.

        Returns:
            Not for "held" and "laid", and in an MDP without a map for none; see `cells`.
        """
        if self.cells is not None:
            return name in self.cells
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
            raise ValueError("this MDP has no cells; only the table of a world has them")
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
        if (self.shape is None and self.cells is None) or self.is_cell(self.factor_named(name)):
            return self.label(value)
        return operator.index(value)
