"""Environments that say themselves in which row of their table they are: toy-text's, and ours."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np
from jaxtyping import Bool, Int64

from habilis.bridges.gymnasium.access import deep_copy, without_recorders
from habilis.bridges.gymnasium.enumeration import made_step
from habilis.bridges.gymnasium.identity import view
from habilis.bridges.gymnasium.randomness import left_alone, reseed
from habilis.bridges.gymnasium.replays import LEAST_SECONDS, Came, replayed
from habilis.bridges.gymnasium.snapshots import layers, reset, unwrapped
from habilis.bridges.gymnasium.verification import changes, declares, step_changers
from habilis.mdp import TabularMDP


@dataclass(frozen=True)
class Indexed:
    """An environment and its table.

    Attributes:
        env: as the user passed it.
        mdp: the table.
        ends: bool[S], the states in which a step terminates an episode.
        name: of the attribute that has the row; "" where the observation is it.
        twin: for each row that `name` can have, that of an episode that has ended there.
        rewards: by state, action and next state, the rewards that are possible; `None`: any.
        verified: how many transitions were seen in replays.
    """

    env: Any
    mdp: TabularMDP
    ends: Bool[np.ndarray, "S"]
    name: str
    twin: Int64[np.ndarray, "P"]
    rewards: Mapping[tuple[int, int, int], set[float]] | None = None
    verified: int = 0

    def after(self, state: int, action: int) -> list[int]:
        """The states that an action may lead to; none where it is not available."""
        if not self.mdp.is_stochastic:
            reached = int(self.mdp.next_state[state, action])
            return [reached] if reached >= 0 else []
        rows: Any = self.mdp.transitions
        row = state * self.mdp.action_count + action
        return rows.indices[rows.indptr[row] : rows.indptr[row + 1]].tolist()

    def place(self, env: Any, observation: Any, ended: bool) -> int:
        """The row of the table that an environment is in.

        Raises:
            ValueError: it is in none.
        """
        row = getattr(unwrapped(env), self.name, None) if self.name else observation
        try:
            index = int(row)  # type: ignore[arg-type]
            if index != row or not 0 <= index < len(self.twin):
                raise ValueError
        except (TypeError, ValueError):
            where = f"its attribute {self.name!r}" if self.name else "its observation"
            raise ValueError(
                f"{type(unwrapped(env)).__name__}: {where} is {str(row)[:60]}, not a row of its "
                f"table of {len(self.twin)}; add an attribute s with the row, or give "
                "state=(save, load)"
            ) from None
        return int(self.twin[index]) if ended else index

    def restore(self, state: int) -> Any:
        """An environment in a state."""
        if not self.name:
            raise ValueError("the environment has no attribute s with which to restore a state")
        env = deep_copy_or_own(self.env)
        reset(env, 0)
        setattr(unwrapped(env), self.name, self._row(state))
        return env

    def observation(self, state: int) -> Any:
        """The environment's observation in a state, through all wrappers."""
        inner = unwrapped(self.env)
        shown = inner.observe(self._row(state)) if hasattr(inner, "observe") else self._row(state)
        for layer in reversed(layers(self.env)[:-1]):
            if isinstance(layer, gymnasium.ObservationWrapper):
                shown = layer.observation(shown)
            elif declares(layer, "observation"):
                raise ValueError(
                    f"{type(layer).__name__} has observations that depend on more than the current "
                    "state; tabulate the environment without it"
                )
        return shown

    def _row(self, state: int) -> int:
        if state < len(self.twin):
            return state
        return int(np.flatnonzero(self.twin == state)[0])


def deep_copy_or_own(env: Any) -> Any:
    """A copy of an environment, or the user's own where it cannot be copied."""
    try:
        made = without_recorders(deep_copy(env))
    except ValueError:
        return env
    if not view(made, strict=False).objects.isdisjoint(map(id, layers(env))):
        return env
    if getattr(unwrapped(made), "render_mode", None) == "human":
        unwrapped(made).render_mode = None  # no window for each of the steps
    return made


def verified(indexed: Indexed) -> int:
    """The number of transitions of a table that were seen in replays of its environment.

    Raises:
        ValueError: one came that the table does not list.
    """
    env = deep_copy_or_own(indexed.env)
    generators = view(env, strict=False).generators
    with left_alone(generators):
        try:
            held = _Held(indexed, env, generators, changes(env, "reward"))
            seen, mismatch = replayed(held, LEAST_SECONDS, late=bool(step_changers(env)))
        finally:
            if env is indexed.env:
                reset(env, None)
    if mismatch is None:
        return len(seen)
    changers = step_changers(indexed.env)
    advice = (
        f"{', '.join(changers)} changes what a step does: pass the environment that it wraps"
        if changers
        else "its step does not follow its own table P"
    )
    raise ValueError(
        mismatch.message(type(unwrapped(indexed.env)).__name__, f"{advice}, or state=(save, load)")
    )


@dataclass(frozen=True)
class _Held:
    """A table, and its environment with all wrappers."""

    indexed: Indexed
    env: Any
    generators: Sequence[Any]
    rewarded_otherwise: bool

    def successors(self) -> list[list[list[int]]]:
        indexed, actions = self.indexed, range(self.indexed.mdp.action_count)
        return [
            [[] if indexed.ends[state] else indexed.after(state, action) for action in actions]
            for state in range(indexed.mdp.states)
        ]

    def begin(self, seed: int) -> tuple[Any, int]:
        shown = reset(self.env, seed)
        reseed(self.generators, seed)
        return self.env, self.indexed.place(self.env, shown, False)

    def step(self, env: Any, state: int, action: int) -> Came:
        shown, reward, terminated, truncated = made_step(env, action, f"state {state}")
        after = self.indexed.place(env, shown, terminated)
        possible = self.indexed.after(state, action)
        differs = None
        if after not in possible:
            several = "one of states" if len(possible) > 1 else "state"
            listed = ", ".join(map(str, possible[:10])) + (", ..." if len(possible) > 10 else "")
            differs = (f"{several} {listed}", f"state {after}")
        elif terminated != self.indexed.ends[after]:
            differs = (f"terminated={not terminated}", f"terminated={terminated}")
        elif self.indexed.rewards is not None and not self.rewarded_otherwise:
            due = self.indexed.rewards[state, action, after]
            if not any(np.float32(one) == reward for one in due):
                listed = " or ".join(f"{one:g}" for one in sorted(due))
                differs = (f"reward {listed}", f"reward {float(reward):g}")
        return Came(after, terminated or truncated, differs)
