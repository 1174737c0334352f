"""How the states of an environment are kept, restored and compared.

As deep copies of the unwrapped environment; by its own `get_state` and `set_state`; or by two
functions of the wrapped environment that the user gives.
"""

import copy
import hashlib
import pickle
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from typing import Any, Protocol

from habilis.gymnasium_tables.identity import View, attributes, bookkeeping, owners, view
from habilis.gymnasium_tables.randomness import left_alone, states_of

StateFunctions = tuple[Callable[[Any], Any], Callable[[Any, Any], Any]]
"""`save(env)` returns a value, which says which state it is; `load(env, value)` restores it."""

_ADVICE = "give state=(save, load), two functions that return and restore its state"


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
            raise ValueError("key says by itself what a state is; leave out ignore and state")
        pair = self.state
        if pair is not None and not (
            isinstance(pair, tuple | list) and len(pair) == 2 and all(map(callable, pair))
        ):
            raise ValueError(f"state is {pair!r}; give two functions, (save, load)")

    def of(self, env: Any) -> View:
        """The view of an environment in some state, wrapped or not."""
        if self.state is not None:
            return view(self.state[0](env), "save(env)")
        inner = unwrapped(env)
        if self.key is not None:
            seen = view(inner, strict=False)
            return replace(seen, digest=view(self.key(inner), "key(env)").digest)
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
    return all(callable(getattr(inner, name, None)) for name in ("get_state", "set_state"))


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
        content: what is kept of it: a copy, or what it was saved as.
        seen: its identity.
    """

    content: Any
    seen: Seen


class Access(Protocol):
    """An environment's states.

    Attributes:
        first: the first state.
        shown: what the environment shows in it; `None` if it was not reset.
        own: whether states are loaded into the user's own environment, not into copies.
    """

    first: Snapshot
    shown: Any
    own: bool

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

    def drawn_before(self, snapshot: Snapshot) -> list[Any]:
        """The states of the generators of an environment that was just loaded."""
        ...

    def generators(self, env: Any) -> Sequence[Any]:
        """Its random generators."""
        ...

    def loader(self, snapshot: Snapshot) -> Callable[[], tuple[Any, Sequence[Any]]]:
        """What loads a state again and again, and returns its random generators, too."""
        ...

    def parts(self, snapshot: Snapshot) -> dict[str, Any]:
        """By name, what a state is made of, to say in what two of them differ."""
        ...


@contextmanager
def access(env: Any, seed: int | None, identity: Identity) -> Iterator[Access]:
    """The states of an environment, which is left as it was.

    Args:
        env: an environment, wrapped or not.
        seed: of the reset that makes the first state; `None`: the state that it is in.
        identity: what makes two states the same.

    Raises:
        ValueError: it cannot be copied, compared or reset.
    """
    inner = unwrapped(env)
    if identity.state is not None:
        save, load = identity.state
        with _left_as_it_was(env, save, load):
            yield _Saved(env, env, seed, identity, save, load)
    elif keeps_states(inner):
        functions = lambda _: inner.get_state(), lambda _, state: inner.set_state(state)
        with _left_as_it_was(env, *functions):
            yield _Saved(env, inner, seed, identity, *functions)
    else:
        with left_alone():
            yield _Copies(env, seed, identity)


@contextmanager
def _left_as_it_was(
    env: Any, save: Callable[[Any], Any], load: Callable[[Any, Any], Any]
) -> Iterator[None]:
    """Restores the state of an environment, and what Gymnasium's wrappers count, in the end."""
    counted = [(layer, dict(vars(layer))) for layer in layers(env)[:-1]]
    with left_alone(view(env, strict=False).generators):
        try:
            before, was_reset = copy.deepcopy(save(env)), True
        except Exception:  # it was never reset, and has no state yet
            before, was_reset = None, False
        try:
            yield
        finally:
            if was_reset:
                load(env, before)
            for layer, content in counted:
                vars(layer).update(content)


class _Saved:
    """Access by saving and loading the states of the user's own environment."""

    own = True

    def __init__(
        self,
        env: Any,
        stepped: Any,
        seed: int | None,
        identity: Identity,
        save: Callable[[Any], Any],
        load: Callable[[Any, Any], Any],
    ):
        self._env, self._stepped, self._seed, self._identity = env, stepped, seed, identity
        self._save, self._load = save, load
        self._generators = view(env, strict=False).generators
        self.shown = None if seed is None else reset(env, seed)
        self.first = Snapshot(self.save(env), self.look(env))

    def look(self, env: Any) -> Seen:
        return Seen(self._identity.of(self._env).digest, states_of(self._generators))

    def drawn_before(self, snapshot: Snapshot) -> list[Any]:
        return states_of(self._generators)

    def generators(self, env: Any) -> Sequence[Any]:
        return self._generators

    def loader(self, snapshot: Snapshot) -> Callable[[], tuple[Any, Sequence[Any]]]:
        return lambda: (self.load(snapshot), self._generators)

    def save(self, env: Any) -> Any:
        return copy.deepcopy(self._save(self._env))

    def load(self, snapshot: Snapshot) -> Any:
        self._load(self._env, copy.deepcopy(snapshot.content))
        digest = self._identity.of(self._env).digest
        _check_same(snapshot, digest, f"{_name(self._env)} after load(env, value)")
        return self._stepped

    def rewind(self, env: Any) -> None:
        pass

    def begin(self) -> Any:
        if self._seed is not None:
            reset(self._env, self._seed)
        self.load(self.first)
        return self._env

    def parts(self, snapshot: Snapshot) -> dict[str, Any]:
        content = snapshot.content
        if isinstance(content, Mapping):
            return {str(name): part for name, part in content.items()}
        return attributes(content) or {"state": content}


class _Copies:
    """Access by copies of the unwrapped environment.

    They are pickled where that leaves nothing out: it takes a fifth of the time of `deepcopy`, and
    the same bytes are the same state, which then need not be looked into.
    """

    own = False

    def __init__(self, env: Any, seed: int | None, identity: Identity):
        self._identity, self._originals = identity, {id(layer) for layer in layers(env)}
        self._outer = deep_copy(env)
        self.shown = None if seed is None else reset(self._outer, seed)
        inner = unwrapped(self._outer)
        if vars(inner).get("render_mode") == "human":
            inner.render_mode = None  # no window for each of the steps
        counted = ("step_count",) if "step_count" in bookkeeping(type(inner)) else ()
        counted = tuple(name for name in counted if hasattr(inner, name))
        self._names = (*identity.ignore, *counted)
        kept = [getattr(owner, name) for owner, name in owners(inner, identity.ignore)]
        self._begun = [*copy.deepcopy(kept), *(0 for _ in counted)]  # Minigrid's: a first step
        self._known: dict[bytes, Seen] = {}
        self._checked: set[bytes] = set()
        self._pickles = True
        self.first = Snapshot(self.save(inner), self.look(inner))
        self.load(self.first)

    def look(self, env: Any) -> Seen:
        inner = unwrapped(env)
        pickled = self._fingerprint(inner)
        seen = None if pickled is None else self._known.get(pickled)
        if seen is None:
            whole = self._identity.of(inner)
            self._pickles &= whole.pickled_whole
            seen = Seen(whole.digest, states_of(whole.generators))
            if pickled is not None and self._pickles:
                self._known[pickled] = seen
        return seen

    def _fingerprint(self, inner: Any) -> bytes | None:
        """Of the bytes that an environment is pickled as, its counters at their beginning."""
        if not self._pickles:
            return None
        found = owners(inner, self._names)
        running = [getattr(owner, name) for owner, name in found]
        self.rewind(inner)
        try:
            return hashlib.blake2b(pickle.dumps(inner, 5), digest_size=32).digest()
        except Exception:  # whatever its parts raise: it is copied otherwise
            self._pickles = False
            return None
        finally:
            for (owner, name), value in zip(found, running, strict=True):
                setattr(owner, name, value)

    def save(self, env: Any) -> Any:
        if self._pickles:
            with suppress(Exception):
                return pickle.dumps(env, 5)
        return deep_copy(env)

    def load(self, snapshot: Snapshot) -> Any:
        pickled = isinstance(snapshot.content, bytes)
        env = pickle.loads(snapshot.content) if pickled else deep_copy(snapshot.content)
        if snapshot.seen.digest not in self._checked:
            seen = self._identity.of(env)
            _check_same(snapshot, seen.digest, f"a copy of {type(env).__name__}")
            _check_apart(seen, self._originals, f"a copy of {type(env).__name__}")
            self._checked.add(snapshot.seen.digest)
        self.rewind(env)
        return env

    def rewind(self, env: Any) -> None:
        for (owner, name), value in zip(owners(env, self._names), self._begun, strict=True):
            setattr(owner, name, copy.deepcopy(value))

    def begin(self) -> Any:
        return deep_copy(self._outer)

    def drawn_before(self, snapshot: Snapshot) -> list[Any]:
        return snapshot.seen.drawn

    def generators(self, env: Any) -> Sequence[Any]:
        return view(env, strict=False).generators

    def loader(self, snapshot: Snapshot) -> Callable[[], tuple[Any, Sequence[Any]]]:
        env = self.load(snapshot)
        generators = self.generators(env)
        if self._pickles:
            with suppress(Exception):
                pickled = pickle.dumps((env, generators), 5)
                return lambda: pickle.loads(pickled)

        def load() -> tuple[Any, Sequence[Any]]:
            env = self.load(snapshot)
            return env, self.generators(env)

        return load

    def parts(self, snapshot: Snapshot) -> dict[str, Any]:
        return attributes(self.load(snapshot))


def _check_same(snapshot: Snapshot, digest: bytes, name: str) -> None:
    if digest != snapshot.seen.digest:
        raise ValueError(f"{name} is not in the state that was copied or saved; {_ADVICE}")


def _check_apart(seen: View, originals: set[int], name: str) -> None:
    if not seen.objects.isdisjoint(originals):
        raise ValueError(
            f"{name} still refers to the environment that it was copied from, in a function's "
            f"closure or a weak reference; {_ADVICE}"
        )


def deep_copy(env: Any) -> Any:
    """A deep copy of an environment, but for modules and pictures, which are shared.

    Instances of `EzPickle` are copied by their attributes: by themselves they begin anew.

    Raises:
        ValueError: something in it cannot be copied.
    """
    seen = view(env, strict=False)
    memo = {id(thing): thing for thing in seen.outside}
    shells = [(thing, object.__new__(type(thing))) for thing in seen.rebuilt]
    memo.update((id(thing), shell) for thing, shell in shells)
    try:
        for thing, shell in shells:
            for name, value in attributes(thing).items():
                object.__setattr__(shell, name, copy.deepcopy(value, memo))
        return copy.deepcopy(env, memo)
    except Exception as error:  # whatever the environment's own parts raise
        raise ValueError(
            f"{_name(env)} cannot be copied ({reason(error)}); make it without a renderer, or "
            "give state=(save, load), two functions that return and restore its state"
        ) from None


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
    return next(iter(str(error).splitlines()), "") or type(error).__name__


def _name(env: Any) -> str:
    return type(unwrapped(env)).__name__
