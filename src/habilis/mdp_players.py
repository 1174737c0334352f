"""The players of a table whose actions are those of several at once, and the table of one of them.

A joint action is one action of each player, numbered in mixed radix: the last player's varies
fastest, so that of players with m and n actions the joint action (a, b) is a * n + b.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Bool, Float32, Float64, Int64

from habilis.mdp_arguments import moves_of, simplest
from habilis.probabilities import as_array, row_stochastic

if TYPE_CHECKING:
    from habilis.mdp import TabularMDP

JOINS = "+"
"""Between the names of the players' actions in the name of a joint action."""

UNIFORM = "uniform"

Policy = Float64[np.ndarray, "S B"]
Joint = Int64[np.ndarray, "P B"]


def checked_players(players: Any, actions: int) -> dict[str, int]:
    """How many actions each player has, if these are all actions.

    Raises:
        ValueError: they are no names with numbers, or their product is another.
    """
    if not isinstance(players, Mapping):
        raise ValueError(f"players is {players!r:.80}; give {{'robot': 4, 'human': 5}} or the like")
    for name, count in players.items():
        if not isinstance(name, str) or not name:
            raise ValueError(f"players has {name!r:.80}; give each player a name")
        whole = isinstance(count, int | np.integer) and not isinstance(count, bool)
        if not whole or count < 1:
            raise ValueError(
                f"player {name!r} has {count!r} actions; give a whole number from 1 up"
            )
    found = {name: int(count) for name, count in players.items()}
    joint = prod(found.values())
    if found and joint != actions:
        each = " x ".join(map(str, found.values()))
        raise ValueError(
            f"players have {each} = {joint} joint actions, but there are {actions} actions; give "
            "numbers whose product is that"
        )
    return found


def of_player(self: "TabularMDP", player: str, others: Any = UNIFORM) -> "TabularMDP":
    """The table of one player, the others acting by a memoryless policy.

    What the others do is marginalised,

        P(s' | s, a) = sum over b of pi(b | s) P(s' | s, a, b)

    and rewards likewise. That is exact for any number of steps: given the state, the others' next
    actions depend on nothing else, so that the state alone, under the player's actions, is a Markov
    decision process. Every measure of one agent is one of this player then.

    Where not all joint actions are available, those that are must be all pairs of some actions of
    the player and some of the others; which of one's actions are available then does not depend on
    what the others choose.

    Args:
        player: its name, as in `players`.
        others: what the others do. "uniform": each joint action of theirs that is available with
            the same probability. float[S, B], the probability of each of their B joint actions,
            in the order of the players, the last varying fastest. Or by name, as
            `{"human": float[S, 5]}`, independently of each other; who is left out acts uniformly.

    Returns:
        A table of the same states with the player's actions, `players` the player alone, and so
        "rest" as a sensor all factors but its own; deterministic where every outcome is certain.

    Raises:
        ValueError: there is no such player, `others` is no policy of theirs or chooses what is not
            available, or whether an action is available depends on another player's.

    Example:
        >>> from habilis import TabularMDP
        >>> gate = [[0, 1], [1, 1]]  # a step gets through if the other holds the gate open
        >>> mdp = TabularMDP.deterministic(
        ...     [[0, 0, 0, 1], [1, 1, 1, 1]], players={"walker": 2, "keeper": 2}
        ... )
        >>> mdp.of_player("walker", {"keeper": [[0.0, 1.0]] * 2}).next_state.tolist() == gate
        True
        >>> mdp.of_player("walker").transition(1).toarray()
        array([[0.5, 0.5],
               [0. , 1. ]])
    """
    return table_of_player(self, player, others)


def table_of_player(
    mdp: "TabularMDP", player: str, others: Any, argument: str = "others"
) -> "TabularMDP":
    """As `of_player`; errors call the others' policy `argument`."""
    joint = joint_actions(mdp, player)
    theirs = available_to_others(mdp, player, joint)
    policy = policy_of_others(mdp, player, others, theirs, argument)
    policy = policy * theirs  # in states without actions it does not matter
    place = list(mdp.players).index(player)
    return replace(
        mdp,
        transitions=_transitions(mdp, joint, policy),
        reward=_rewards(mdp, joint, policy),
        actions=_names(mdp, place),
        players={player: len(joint)},
        origin=None,
    )


def joint_actions(mdp: "TabularMDP", player: str) -> Joint:
    """The joint action of each action of a player and each of the others' joint actions.

    Raises:
        ValueError: there is no such player.
    """
    if not mdp.players:
        raise ValueError(
            f"player is {player!r}, but the table has no players; make it with players={{'robot': "
            "4, 'human': 5}, how many actions each has, or of a map with two agents"
        )
    if player not in mdp.players:
        raise ValueError(f"player {player!r} is unknown; use one of {', '.join(mdp.players)}")
    sizes = tuple(mdp.players.values())
    place = list(mdp.players).index(player)
    every = np.arange(prod(sizes)).reshape(sizes)
    return np.moveaxis(every, place, 0).reshape(sizes[place], -1).astype(np.int64)


def policy_of_others(
    mdp: "TabularMDP",
    player: str,
    others: Any,
    theirs: Bool[np.ndarray, "S B"],
    argument: str = "others",
) -> Policy:
    """The probabilities of the joint actions of all players but one.

    Args:
        mdp: the table.
        player: who is left out.
        others: as in `of_player`.
        theirs: which of the joint actions are available.
        argument: what errors call `others`.

    Raises:
        ValueError: it is no policy, or chooses what is not available.
    """
    uniform = theirs / np.maximum(theirs.sum(axis=1, keepdims=True), 1)
    if isinstance(others, str):
        if others != UNIFORM:
            raise ValueError(f"{argument} is {others!r}; use 'uniform', or give the others' policy")
        return uniform
    sizes = {name: count for name, count in mdp.players.items() if name != player}
    if not isinstance(others, Mapping):
        policy = _checked_policy(mdp, argument, others, prod(sizes.values()))
    else:
        policy = np.ones((mdp.states, 1))
        for name in others:
            if name not in sizes:
                known = f"name {', '.join(sizes)}" if sizes else "there are none"
                raise ValueError(
                    f"{argument} has {name!r}, which is none of the other players; {known}"
                )
        axes = tuple(sizes.values())
        for place, (name, count) in enumerate(sizes.items()):
            besides = tuple(1 + axis for axis in range(len(axes)) if axis != place)
            usable = theirs.reshape(-1, *axes).any(axis=besides)
            given = others.get(name, UNIFORM)
            if isinstance(given, str):
                if given != UNIFORM:
                    raise ValueError(
                        f"{argument} has {given!r} for {name!r}; use 'uniform', or a policy"
                    )
                one = usable / np.maximum(usable.sum(axis=1, keepdims=True), 1)
            else:
                one = _checked_policy(mdp, f"{argument}, {name!r}", given, count)
            policy = (policy[:, :, None] * one[:, None, :]).reshape(mdp.states, -1)
    wrong = np.argwhere((policy > 0) & ~theirs & theirs.any(axis=1, keepdims=True))
    if len(wrong):
        state, action = wrong[0]
        raise ValueError(
            f"{argument}, state {state} chooses their joint action {action}, which is not "
            "available there; give it probability 0"
        )
    return policy


def _checked_policy(mdp: "TabularMDP", name: str, given: Any, count: int) -> Policy:
    policy = as_array(name, given)
    if policy.shape != (mdp.states, count) or policy.dtype.kind not in "biuf":
        raise ValueError(
            f"{name} has shape {policy.shape} and type {policy.dtype}; give float[states, "
            f"actions], here ({mdp.states}, {count})"
        )
    return row_stochastic(name, policy, "state {}", "states").toarray()


def available_to_others(mdp: "TabularMDP", player: str, joint: Joint) -> Bool[np.ndarray, "S B"]:
    """Which joint actions of the others are available.

    Raises:
        ValueError: they decide whether an action of the player is available.
    """
    there = mdp.available[:, joint]
    own, theirs = np.asarray(there.any(axis=2)), np.asarray(there.any(axis=1))
    missing = own[:, :, None] & theirs[:, None, :] & ~there
    if missing.any():
        state, action, other = np.argwhere(missing)[0]
        raise ValueError(
            f"in state {state} action {action} of {player!r} is available with some actions of the "
            f"others, but not with their joint action {other}; give joint action "
            f"{joint[action, other]} a next state, such as {state} itself"
        )
    return theirs


def _transitions(mdp: "TabularMDP", joint: Joint, policy: Policy) -> Any:
    """Where the player's actions lead."""
    from scipy.sparse import csr_array

    actions = len(joint)
    if not mdp.is_stochastic and ((policy > 0).sum(axis=1) <= 1).all():
        chosen = joint[:, policy.argmax(axis=1)].T
        return np.take_along_axis(mdp.next_state, chosen, axis=1)
    state, other = np.nonzero(policy)
    weights = np.repeat(policy[state, other], actions)
    row = (state[:, None] * actions + np.arange(actions)).ravel()
    column = (state[:, None] * mdp.action_count + joint[:, other].T).ravel()
    shape = mdp.states * actions, mdp.states * mdp.action_count
    mixed: Any = csr_array((weights, (row, column)), shape) @ moves_of(mdp.transitions)
    found = row_stochastic("the table", mixed, "row {}", "states", empty=True)
    return simplest(found, actions)


def _rewards(mdp: "TabularMDP", joint: Joint, policy: Policy) -> Float32[np.ndarray, "S P"]:
    mean = np.einsum("spb,sb->sp", mdp.reward[:, joint].astype(np.float64), policy)
    return mean.astype(np.float32)


def _names(mdp: "TabularMDP", place: int) -> tuple[str, ...]:
    """The names of one player's actions, if those of the joint ones are made of them."""
    sizes = tuple(mdp.players.values())
    parts = [name.split(JOINS) for name in mdp.actions]
    if not parts or any(len(part) != len(sizes) for part in parts):
        return ()
    own = np.array([part[place] for part in parts], object).reshape(sizes)
    own = np.moveaxis(own, place, 0).reshape(sizes[place], -1)
    return tuple(own[:, 0]) if (own == own[:, :1]).all() else ()
