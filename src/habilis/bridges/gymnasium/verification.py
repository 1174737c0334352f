"""Enumerated tables are checked against the environments that they are of."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import gymnasium
import numpy as np

from habilis.bridges.gymnasium.enumeration import Enumerated, made_step, observed
from habilis.bridges.gymnasium.identity import view
from habilis.bridges.gymnasium.minigrid import is_minigrid, reward_now
from habilis.bridges.gymnasium.randomness import reseed
from habilis.bridges.gymnasium.replays import LEAST_SECONDS, Came, Mismatch, replayed
from habilis.bridges.gymnasium.snapshots import Access, Identity, Snapshot, layers, short, unwrapped

_CHANGES = {
    "observation": ("transform_observation", "stateful_observation", "array_conversion"),
    "reward": ("transform_reward", "stateful_reward"),
}
"""By what they change, the modules of `gymnasium.wrappers`."""


def verified(
    access: Access, found: Enumerated, env: Any, identity: Identity, show_progress: bool = False
) -> int:
    """The number of transitions of a table seen in replays, which take no longer than it did.

    Args:
        access: the environment's states.
        found: its table.
        env: the environment as the user passed it.
        identity: what makes two states the same.
        show_progress: whether to draw progress bars.

    Raises:
        ValueError: a step was another than the table's; the message names the step and the fix.
    """
    seconds = max(found.seconds, LEAST_SECONDS)
    seen, mismatch = _replayed(access, found, env, seconds, show_progress)
    if mismatch is not None:
        advice = _advice(access, found, env, identity, mismatch)
        raise ValueError(mismatch.message(type(unwrapped(env)).__name__, advice))
    return len(seen)


def follows(access: Access, found: Enumerated, env: Any, seconds: float) -> bool:
    """Whether replays of so many seconds show no difference from a table."""
    return _replayed(access, found, env, seconds, False)[1] is None


def _replayed(
    access: Access, found: Enumerated, env: Any, seconds: float, show_progress: bool
) -> tuple[set[tuple[int, int]], Mismatch | None]:
    held = _Held(access, found, changes(env, "observation"), changes(env, "reward"))
    late = bool(access.counts or step_changers(env))  # what counts may act late in an episode
    return replayed(held, seconds, late, show_progress)


def changes(env: Any, what: str) -> bool:
    """Whether a wrapper declares that it changes the "observation" or the "reward".

    By its class, by the attribute `changes_observation` or `changes_reward`, or by an
    observation space of its own.
    """
    return any(declares(layer, what) for layer in layers(env)[:-1])


def declares(layer: Any, what: str) -> bool:
    """As `changes`, of one wrapper."""
    kind = gymnasium.ObservationWrapper if what == "observation" else gymnasium.RewardWrapper
    package, _, module = type(layer).__module__.rpartition(".")
    return (
        isinstance(layer, kind)
        or (package == "gymnasium.wrappers" and module in _CHANGES[what])
        or getattr(layer, f"changes_{what}", False)
        or (what == "observation" and vars(layer).get("_observation_space") is not None)
    )


def step_changers(env: Any) -> list[str]:
    """The wrappers that may change what a step does, by their classes."""
    return [type(layer).__name__ for layer in layers(env)[:-1] if _steps_by_itself(layer)]


@dataclass(frozen=True)
class _Held:
    """An enumerated table, and its environment with all wrappers."""

    access: Access
    found: Enumerated
    shown_otherwise: bool
    rewarded_otherwise: bool

    def successors(self) -> list[list[list[int]]]:
        table, terminal = self.found.mdp.next_state.tolist(), self.found.mdp.terminal
        return [[[] if terminal[s] else [t] for t in row] for s, row in enumerate(table)]

    @cached_property
    def place(self) -> dict[Any, int]:
        return {mark: state for state, mark in enumerate(self.found.marks)}

    def begin(self, seed: int) -> tuple[Any, int]:
        env = self.access.begin()
        reseed(self.access.generators(env), seed)
        return env, 0

    def step(self, env: Any, state: int, action: int) -> Came:
        observation, reward, terminated, truncated = made_step(env, action, f"state {state}")
        mdp, mark = self.found.mdp, (self.access.look(env).digest, terminated)
        expected = int(mdp.next_state[state, action])
        differs = None
        if mark != self.found.marks[expected]:
            if terminated != mdp.terminal[expected]:
                differs = (f"terminated={not terminated}", f"terminated={terminated}")
            else:
                differs = self._difference(expected, mark, env)
        elif not self.rewarded_otherwise:
            due = float(mdp.reward[state, action])
            inner = unwrapped(env)
            due = reward_now(inner, due) if is_minigrid(inner) else due
            if np.float32(due) != reward:
                differs = (f"reward {due:g}", f"reward {float(reward):g}")
        shown = self.found.observed[state, action]
        if differs is None and not self.shown_otherwise and observed(observation) != shown:
            differs = ("the observation of the first time", "another")
        return Came(expected, terminated or truncated, differs)

    def _difference(self, expected: int, mark: Any, env: Any) -> tuple[str, str]:
        """Some attributes in which the state that was expected differs from that which came."""
        states = self.found.snapshots
        wanted = self.access.parts(states[expected]) if states else {}
        now = Snapshot(self.access.save(unwrapped(env)), self.access.look(env))
        here = self.access.parts(now)
        names = [
            name
            for name in sorted(wanted.keys() & here.keys())
            if view(wanted[name], strict=False).digest != view(here[name], strict=False).digest
        ]
        pairs = [(n, short(wanted[n]), short(here[n])) for n in names]
        pairs = [pair for pair in pairs if pair[1] != pair[2]][:2]
        if not pairs:
            came = self.place.get(mark)
            return f"state {expected}", "a new state" if came is None else f"state {came}"
        return (
            ", ".join(f"{name}={value}" for name, value, _ in pairs),
            ", ".join(f"{name}={value}" for name, _, value in pairs),
        )


def _advice(
    access: Access, found: Enumerated, env: Any, identity: Identity, mismatch: Mismatch
) -> str:
    stochastic = "give the probabilities to TabularMDP.stochastic"
    if mismatch.again:
        return f"with other random numbers the same actions lead elsewhere: {stochastic}"
    wrappers = step_changers(env)
    if wrappers and identity.state is None and _inner_follows(access, found, mismatch.actions):
        return (
            f"{', '.join(wrappers)} changes what a step does: pass the environment that it wraps, "
            "or state=(save, load), with which steps are made through the wrappers"
        )
    if "observation" in mismatch.expected and identity.ignore:
        return (
            f"what it shows depends on {', '.join(identity.ignore)}: let that be part of the "
            "state, or leave it out of the observation by an ObservationWrapper"
        )
    left_out = [*identity.ignore, *(["what key= leaves out"] if identity.key else [])]
    if left_out:
        return f"its transitions depend on {', '.join(left_out)}: let that be part of the state"
    if identity.state is not None:
        return "save(env) does not return all that its next steps depend on, or it is random"
    return (
        "its next step depends on something that is not in its attributes, or it is random: give "
        f"state=(save, load), or {stochastic}"
    )


def _steps_by_itself(layer: Any) -> bool:
    """Whether a wrapper has a `step` that is not one of Gymnasium's harmless ones."""
    step = getattr(type(layer), "step", None)
    return getattr(step, "__module__", "") not in ("gymnasium.core", "gymnasium.wrappers.common")


def _inner_follows(access: Access, found: Enumerated, actions: Sequence[int]) -> bool:
    """Whether the unwrapped environment by itself follows the table."""
    env, state = access.load(access.first), 0
    for action in actions:
        _, _, terminated, _ = made_step(env, action, f"state {state}")
        state = int(found.mdp.next_state[state, action])
        if (access.look(env).digest, terminated) != found.marks[state]:
            return False
    return True
