"""A finite Markov decision process as arrays."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Bool, Float32, Int32
from numpy.typing import ArrayLike

from habilis import mdp_players, mdp_sources, mdp_states
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
from habilis.mdp_players import checked_players
from habilis.mdp_states import HELD as HELD
from habilis.mdp_states import LAID as LAID
from habilis.mdp_states import ModelStates as ModelStates
from habilis.mdp_states import Origin as Origin
from habilis.reprs import quietly, short, table_html, unfailing

if TYPE_CHECKING:
    from scipy.sparse import csr_array


@dataclass(frozen=True, eq=False)
class TabularMDP:
    """A finite MDP; state and action are indices.

    Made by `deterministic`, `stochastic`, `from_gymnasium`, `from_storm`, `from_transitions`, of a
    model by `explore`, of a world by `tabulate`, or read by `load` and `load_pomdp`.

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
        players: how many actions each of several players has, by name, where an action is one of
            each of them: the joint action (a, b) is `a * n + b`, n the number of actions of the
            last. Empty where one agent chooses.
        counts: of a table of logged transitions (`from_transitions`), sparse int64[S * A, S], how
            often each was logged.
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
    players: Mapping[str, int] = field(default_factory=dict)
    counts: "csr_array | None" = field(default=None, repr=False)

    def __post_init__(self) -> None:
        """Checks the players.

        Raises:
            ValueError: the product of their numbers of actions is not that of the table.
        """
        object.__setattr__(self, "players", checked_players(self.players, self.action_count))

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
        players: Mapping[str, int] | None = None,
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
            players: how many actions each player has, as `{"robot": 4, "human": 5}`, where
                actions are joint ones, the last player's varying fastest.

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
        return cls(table, reward, terminal, start=int(start), players=players or {})

    @classmethod
    def stochastic(
        cls,
        P: Any,
        reward: ArrayLike | None = None,
        terminal: ArrayLike | None = None,
        start: int = 0,
        available: ArrayLike | None = None,
        axes: Axes | None = None,
        players: Mapping[str, int] | None = None,
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
            players: as in `deterministic`.

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
        transitions = simplest(stacked, actions)
        return cls(transitions, reward, terminal, start=int(start), players=players or {})

    from_gymnasium = classmethod(mdp_sources.from_gymnasium)
    from_storm = classmethod(mdp_sources.from_storm)
    from_transitions = classmethod(mdp_sources.from_transitions)
    load = classmethod(mdp_sources.load)
    save = mdp_sources.save

    restore = mdp_states.restore
    observation = mdp_states.observation
    state = mdp_states.state
    index = mdp_states.index
    factor = mdp_states.factor
    factor_named = mdp_states.factor_named
    is_cell = mdp_states.is_cell
    label = mdp_states.label
    find = mdp_states.find

    of_player = mdp_players.of_player

    def __getstate__(self) -> dict[str, Any]:
        """For pickles: the environment or map that a table was made of stays behind."""
        return vars(self) | {"origin": None, "drawn": None}

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

    @property
    def nbytes(self) -> int:
        """How many bytes its arrays take, those in a file included.

        With A actions, F factors and G flags a state of a deterministic table takes 8 A + 1 + 4 F
        + G bytes; one of a stochastic table with k outcomes of an action A (12 k + 8) + 1 + 4 F
        + G, or where SciPy has chosen indices of 64 bits A (16 k + 12) + 1 + 4 F + G. Where there
        is an `entry_reward`, as in worlds, it takes 4 more.
        """
        arrays = [self.reward, self.terminal, *self.factors.values(), *self.flags.values()]
        if self.entry_reward is not None:
            arrays.append(self.entry_reward)
        if isinstance(self.transitions, np.ndarray):
            arrays.append(self.transitions)
        else:
            csr = self.transitions
            arrays += [csr.data, csr.indices, csr.indptr]
        return sum(array.nbytes for array in arrays)
