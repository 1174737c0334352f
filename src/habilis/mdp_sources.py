"""Methods of `TabularMDP` that read and write it: environments, other programs' files, its own."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

if TYPE_CHECKING:
    from habilis.mdp import TabularMDP


def from_gymnasium(
    cls: type["TabularMDP"],
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
        >>> from habilis import TabularMDP
        >>> lake = TabularMDP.from_gymnasium(gymnasium.make("FrozenLake-v1"))
        >>> lake.states, lake.is_stochastic, lake.actions
        (16, True, ('left', 'down', 'right', 'up'))
    """
    from habilis.bridges.gymnasium import table_of

    return table_of(env, max_states, seed, key, ignore, state, factors, show_progress)


def from_transitions(
    cls: type["TabularMDP"],
    states: ArrayLike,
    actions: ArrayLike,
    next_states: ArrayLike,
    *,
    state_count: int | None = None,
    action_count: int | None = None,
) -> "TabularMDP":
    """The table of logged transitions: probabilities are relative frequencies.

    An action that was never tried in a state is not available there, so that no measure takes a
    sequence that may come to it: what was never tried is unknown. Rewards are 0.

    Args:
        states: int[n], the state before each transition.
        actions: int[n], the action that was taken.
        next_states: int[n], the state that it led to.
        state_count: how many states there are; by default as many as are named.
        action_count: how many actions there are; by default as many as are named.

    Returns:
        A table that keeps its `counts`, from which `plug_in_interval` makes an interval.

    Raises:
        ValueError: these are no indices, are of different lengths or none, or exceed the numbers
            that are given.

    Example:
        >>> from habilis import TabularMDP
        >>> mdp = TabularMDP.from_transitions([0, 0, 0, 1], [0, 0, 0, 1], [1, 1, 0, 0])
        >>> mdp.transition(0).toarray().round(2)
        array([[0.33, 0.67],
               [0.  , 0.  ]])
        >>> mdp.available.tolist()
        [[True, False], [False, True]]
    """
    from habilis.bridges.transition_logs import table_of

    return table_of(states, actions, next_states, state_count, action_count)


def from_storm(
    cls: type["TabularMDP"],
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


def save(self: "TabularMDP", path: str | Path) -> None:
    """Writes the table to a file, which `TabularMDP.load` reads.

    All of it but what it was made of (`origin`, `model_states`, `counts`). The file holds arrays of
    NumPy without pickles; it is written whole or not at all.

    Args:
        path: ends with .npz. A file of that name is replaced.

    Raises:
        ValueError: another suffix, or the file cannot be written.

    Example:
        >>> from tempfile import mkdtemp
        >>> from habilis import TabularMDP
        >>> path = Path(mkdtemp()) / "two.npz"
        >>> TabularMDP.deterministic([[0, 1], [1, 0]]).save(path)
        >>> TabularMDP.load(path).next_state.tolist()
        [[0, 1], [1, 0]]
    """
    from habilis.bridges.table_files import save

    save(self, path)


def load(cls: type["TabularMDP"], path: str | Path) -> "TabularMDP":
    """The table in a file that `save` wrote.

    The file is read once, to check it. Arrays of a MiB and more are then mapped: they take memory
    only where they are used, and processes that load one file share it. Writing into them changes
    this table alone, not the file. Replace the file if you must (`save` does); do not overwrite it
    while a table of it is in use.

    Args:
        path: of the file.

    Returns:
        A table equal to the one saved, with its transitions, available actions, rewards,
        terminal states, factors, flags, start, cells, names of actions and players.

    Raises:
        ValueError: the file cannot be read, is damaged, or is something else.

    Example:
        >>> from tempfile import mkdtemp
        >>> from habilis import TabularMDP
        >>> path = Path(mkdtemp()) / "slippery.npz"
        >>> TabularMDP.deterministic([[0, 1], [1, 0]]).slippery(0.2).save(path)
        >>> TabularMDP.load(path).is_stochastic
        True
    """
    from habilis.bridges.table_files import load

    return load(path)
