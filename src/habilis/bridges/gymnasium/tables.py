"""The table of an environment, whatever kind it is of."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import gymnasium
import numpy as np

from habilis.bridges.gymnasium.access import access
from habilis.bridges.gymnasium.enumeration import (
    Enumerated,
    action_count,
    enumerate_states,
    made_step,
)
from habilis.bridges.gymnasium.indexed import Indexed, deep_copy_or_own
from habilis.bridges.gymnasium.indexed import verified as verified_index
from habilis.bridges.gymnasium.randomness import left_alone
from habilis.bridges.gymnasium.snapshots import Access, Identity, reset, short, unwrapped
from habilis.bridges.gymnasium.transition_dict import has_table, listed_table
from habilis.bridges.gymnasium.verification import changes, step_changers, verified
from habilis.mdp import TabularMDP


def table_of(
    env: Any,
    max_states: int,
    seed: int | None,
    identity: Identity,
    factors: Mapping[str, Callable[[Any], int]] | None,
    show_progress: bool,
) -> TabularMDP:
    """The table of an environment, with its `origin`; see `TabularMDP.from_gymnasium`."""
    if isinstance(max_states, bool) or not isinstance(max_states, int) or max_states < 1:
        raise ValueError(f"max_states is {max_states!r}; give a whole number from 1 up")
    check_environment(env, identity)
    if is_indexed(env, identity):
        found = indexed(env, max_states)
        return replace(found.mdp, origin=found)
    with access(env, seed, identity) as states:
        try:
            table = enumerate_states(states, action_count(env), max_states, factors, show_progress)
        except ValueError as error:
            raise ValueError(f"{error}{_hint(env)}") from None
        seen = verified(states, table, env, identity, show_progress)
        return replace(table.mdp, origin=Enumeration(states, table, seen))


def _hint(env: Any) -> str:
    array = isinstance(getattr(unwrapped(env), "P", None), np.ndarray)
    return " (its P is an array, which is not read: TabularMDP.stochastic may take it)" * array


def is_indexed(env: Any, identity: Identity) -> bool:
    """Whether an environment has its own table, and the row that it is in."""
    inner = unwrapped(env)
    return identity.state is None and (
        isinstance(getattr(inner, "dynamics", None), TabularMDP) or has_table(inner)
    )


def indexed(env: Any, max_states: int) -> Indexed:
    """The table that an environment brings along, verified.

    Raises:
        ValueError: it is not the environment's, has too many states, or is none.
    """
    inner = unwrapped(env)
    own = getattr(inner, "dynamics", None)
    if isinstance(own, TabularMDP):
        found = Indexed(env, own, own.ends, "state", np.arange(own.states))
        # It is stepped by this very table: only wrappers could make something else of it.
        return replace(found, verified=verified_index(found)) if step_changers(env) else found
    with left_alone():
        begun = deep_copy_or_own(env)
        shown = reset(begun, 0)
    row = getattr(unwrapped(begun), "s", shown)
    row = int(row) if isinstance(row, int | np.integer) else None
    listed = listed_table(inner, action_count(env), max_states, row)
    name = "s" if hasattr(unwrapped(begun), "s") else ""
    if not name and changes(env, "observation"):
        raise ValueError(
            f"{type(inner).__name__} has a table P, but no attribute s that says in which of its "
            "rows it is; add it, or give state=(save, load)"
        )
    found = Indexed(env, listed.mdp, listed.mdp.terminal, name, listed.twin, listed.rewards)
    return replace(found, verified=verified_index(found))


def check_environment(env: Any, identity: Identity) -> None:
    """Refuses what is no environment, and wrappers that make other actions of those they get.

    With `identity.state` steps are made through the wrappers, whatever they do.

    Raises:
        ValueError: it is either.
    """
    inner = unwrapped(env)
    if not all(hasattr(inner, name) for name in ("action_space", "step", "reset")):
        raise ValueError(
            f"{short(env)} is not a Gymnasium environment; give what gymnasium.make returns"
        )
    if identity.state is not None:
        return
    layer = env
    while isinstance(layer, gymnasium.Wrapper):
        if isinstance(layer, gymnasium.ActionWrapper):
            raise ValueError(
                f"{type(layer).__name__} changes the actions, which the table of the environment "
                "inside does not know; pass the environment that it wraps, or state=(save, load), "
                "with which steps are made through the wrappers"
            )
        layer = layer.env
    if env.action_space != layer.action_space:
        raise ValueError(
            f"the actions are {env.action_space} outside and {layer.action_space} inside; give the "
            "environment inside the wrapper that changes them"
        )


@dataclass(frozen=True)
class Enumeration:
    """Back from the states of an enumerated table to the environment.

    Attributes:
        access: the environment's states.
        table: the table, and how its states are reached.
        verified: how many transitions were seen in replays.
    """

    access: Access
    table: Enumerated
    verified: int

    def restore(self, state: int) -> Any:
        """The environment, with its wrappers, in a state."""
        if not self.access.own:
            return self._walked(state)[0]
        env = self.access.begin()
        self.access.load(self.table.snapshots[state])
        return env

    def observation(self, state: int) -> Any:
        """The environment's observation in a state, through its wrappers."""
        if state == 0 and self.access.shown is None:
            raise ValueError(
                "the observation of the first state is unknown with seed=None; give the seed of "
                "a reset"
            )
        return self._walked(state)[1]

    def _walked(self, state: int) -> tuple[Any, Any]:
        """An environment that was led to a state along a shortest path, and what it shows."""
        actions, here = [], state
        while self.table.parent[here] >= 0:
            actions.append(int(self.table.action[here]))
            here = int(self.table.parent[here])
        env, shown, ended = self.access.begin(), self.access.shown, False
        for action in reversed(actions):
            shown, _, ended, _ = made_step(env, action, f"the path to state {state}")
        if (self.access.look(env).digest, ended) != self.table.marks[state]:
            raise ValueError(
                f"the shortest path to state {state} does not lead there through the wrappers of "
                "the environment, which cut it off; tabulate the environment without them"
            )
        return env, shown
