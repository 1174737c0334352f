"""Snapshots of the states of an environment: made, restored and compared.

As deep copies of the unwrapped environment; by its own `get_state` and `set_state`; or by two
functions of the wrapped environment that the user gives.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from inspect import signature
from typing import Any, Protocol, runtime_checkable

from habilis.bridges.gymnasium.identity import View, view

StateFunctions = tuple[Callable[[Any], Any], Callable[[Any, Any], Any]]
"""`save(env)` returns the value of the state; `load(env, value)` restores it."""

STATE_ADVICE = "give state=(save, load), two functions that return and restore its state"


@dataclass(frozen=True)
class Identity:
    """Which attributes make the state of an environment.

    Attributes:
        key: of the unwrapped environment, what makes two states the same, in place of all it holds.
        ignore: attributes of the unwrapped environment that are no part of the state.
        state: how states are saved and loaded, in place of copies; of the wrapped environment.
    """

    key: Callable[[Any], Any] | None = None
    ignore: Sequence[str] = ()
    state: StateFunctions | None = None

    def __post_init__(self) -> None:
        if isinstance(self.ignore, str) or not all(isinstance(one, str) for one in self.ignore):
            raise ValueError(f"ignore is {self.ignore!r}; give a list of names, as ['steps']")
        if self.key is not None and (self.ignore or self.state):
            raise ValueError("key alone defines the state; leave out ignore and state")
        pair = self.state
        if pair is not None and not (
            isinstance(pair, tuple | list) and len(pair) == 2 and all(map(callable, pair))
        ):
            raise ValueError(f"state is {pair!r}; give two functions, (save, load)")

    def of(self, env: Any) -> View:
        """The view of an environment in some state, wrapped or not."""
        if self.state is not None:
            return view(called(self.state[0], env, name="save(env)"), "save(env)")
        inner = unwrapped(env)
        if self.key is not None:
            seen = view(inner, strict=False)
            key = called(self.key, inner, name="key(env)")
            return replace(seen, digest=view(key, "key(env)").digest)
        if keeps_states(inner):
            return view(inner.get_state(), "get_state()")
        return view(inner, ignore=self.ignore)


def unwrapped(env: Any) -> Any:
    """The innermost environment; one that is no `gymnasium.Env` may be so itself."""
    return getattr(env, "unwrapped", env)


def layers(env: Any) -> list[Any]:
    """An environment and all inside of it, from the outermost."""
    found = [env]
    while (inner := getattr(found[-1], "env", None)) is not None and found[-1] is not unwrapped(
        env
    ):
        found.append(inner)
    return found


def keeps_states(inner: Any) -> bool:
    """Whether an environment has `get_state()` and `set_state(state)`."""
    for name, given in (("get_state", ()), ("set_state", (None,))):
        try:
            signature(getattr(inner, name)).bind(*given)
        except (AttributeError, TypeError, ValueError):
            return False
    return True


def called(function: Callable[..., Any], *given: Any, name: str) -> Any:
    """The result of a function of the user's.

    Raises:
        ValueError: it raises something; the message says what.
    """
    try:
        return function(*given)
    except Exception as error:
        raise ValueError(
            f"{name} raises {type(error).__name__}: {reason(error)}; correct it"
        ) from None


@dataclass(frozen=True)
class Seen:
    """Which state an environment is in.

    Attributes:
        digest: of its identity.
        drawn: the states of its random generators, which are no part of that.
    """

    digest: bytes
    drawn: list[Any]


@dataclass(frozen=True)
class Snapshot:
    """A state of an environment.

    Attributes:
        content: a copy, or what it was saved as.
        seen: its identity.
    """

    content: Any
    seen: Seen


@runtime_checkable
class Access(Protocol):
    """An environment's states.

    Attributes:
        first: the first state.
        shown: its observation; `None` if the environment was not reset.
        own: whether states are loaded into the user's own environment, not into copies.
        counts: whether there are attributes that run on in episodes and are no part of a state.
    """

    first: Snapshot
    shown: Any
    own: bool
    counts: bool

    def look(self, env: Any) -> Seen:
        """Which state an environment is in, wrapped or not."""
        ...

    def save(self, env: Any) -> Any:
        """The content of a snapshot."""
        ...

    def load(self, snapshot: Snapshot) -> Any:
        """An environment in a state, to make steps with."""
        ...

    def rewind(self, env: Any) -> None:
        """Sets ignored attributes to what they are in the first state."""
        ...

    def begin(self) -> Any:
        """The environment as the user passed it, with its wrappers, in the first state."""
        ...

    def shared(self) -> list[Any]:
        """The states of the generators that belong to classes: all environments draw from these."""
        ...

    def drawn_before(self, snapshot: Snapshot) -> list[Any]:
        """The states of the generators of an environment that was just loaded."""
        ...

    def generators(self, env: Any) -> Sequence[Any]:
        """Its random generators."""
        ...

    def loader(self, snapshot: Snapshot) -> Callable[[], tuple[Any, Sequence[Any]]]:
        """A function that loads a state again and again, and returns its random generators, too."""
        ...

    def parts(self, snapshot: Snapshot) -> dict[str, Any]:
        """The parts of a state by name, to name those in which two states differ."""
        ...


def check_same(snapshot: Snapshot, digest: bytes, name: str) -> None:
    if digest != snapshot.seen.digest:
        raise ValueError(f"{name} is not in the state that was copied or saved; {STATE_ADVICE}")


def reset(env: Any, seed: int | None) -> Any:
    """The observation with which an environment's reset begins an episode.

    Raises:
        ValueError: it raises something; the message says what.
    """
    try:
        return env.reset(seed=seed)[0]
    except Exception as error:
        raise ValueError(
            f"{_name(env)} cannot be reset with seed {seed} ({reason(error)}); reset it yourself "
            "and give seed=None"
        ) from None


def reason(error: Exception) -> str:
    """The first line of an exception, or what it is."""
    return next(iter(str(error).splitlines()), "")[:200] or type(error).__name__


def short(value: Any) -> str:
    """A value in one line of at most 60 characters."""
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else text[:57] + "..."


def _name(env: Any) -> str:
    return type(unwrapped(env)).__name__
