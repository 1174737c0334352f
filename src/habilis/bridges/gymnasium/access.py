"""Access to the states of an environment: by copies, or by functions that save and load them."""

import copy
import hashlib
import pickle
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from typing import Any

import numpy as np

from habilis.bridges.gymnasium.encodings import attributes, bookkeeping, of_class
from habilis.bridges.gymnasium.identity import View, deep_recursion, owners, view
from habilis.bridges.gymnasium.randomness import left_alone, states_of
from habilis.bridges.gymnasium.snapshots import (
    STATE_ADVICE,
    Access,
    Identity,
    Seen,
    Snapshot,
    check_same,
    keeps_states,
    layers,
    reason,
    reset,
    unwrapped,
)


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
        with left_alone(_Shared(env).generators()):
            yield Copies(env, seed, identity)


@contextmanager
def _left_as_it_was(
    env: Any, save: Callable[[Any], Any], load: Callable[[Any, Any], Any]
) -> Iterator[None]:
    """Restores the state of an environment, and what Gymnasium's wrappers count, in the end."""
    inner = unwrapped(env)
    names = ("_np_random", "_np_random_seed", "step_count")  # a reset makes another generator
    counted = [(inner, {n: vars(inner)[n] for n in names if n in getattr(inner, "__dict__", {})})]
    counted += [(layer, _counters(layer)) for layer in layers(env)[:-1]]
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


_COUNTING = "gymnasium.wrappers."  # whose attributes are no part of a state


def _counters(layer: Any) -> dict[str, Any]:
    """Copies of a wrapper's attributes, but for what is inside."""
    content = {name: value for name, value in vars(layer).items() if name != "env"}
    try:
        return copy.deepcopy(content)
    except Exception:  # whatever they are: left as they are
        return content


class _Shared:
    """The attributes of the classes of an environment and its parts, which copies share.

    Their spaces and generators draw for all instances; all else should not change.
    """

    def __init__(self, env: Any):
        classes = {cls for layer in layers(env) for cls in view(layer, strict=False).classes}
        self._holders = [one for cls in classes for one in of_class(cls)]
        self._classes = [cls for cls in type(unwrapped(env)).__mro__[:-1] if _is_users(cls)]
        self._content = self._digest()

    def generators(self) -> Sequence[Any]:
        return [one for holder in self._holders for one in view(holder, strict=False).generators]

    def check(self) -> None:
        """Raises ValueError: something of the environment's class has changed."""
        if self._classes and self._digest() != self._content:
            names = " or ".join(cls.__name__ for cls in self._classes)
            raise ValueError(
                f"a step changes an attribute of the class {names}, which copies share; let reset "
                "set it on the environment, or give state=(save, load)"
            )

    def _digest(self) -> bytes:
        content = [
            [value for value in vars(cls).values() if isinstance(value, _MUTABLE)]
            for cls in self._classes
        ]
        return view(content, strict=False).digest if any(content) else b""


_MUTABLE = (int, float, str, list, dict, set, np.ndarray)  # also names are given other values


def _is_users(cls: type) -> bool:
    return cls.__module__.partition(".")[0] not in ("gymnasium", "minigrid", "typing", "builtins")


class _Saved:
    """Access by saving and loading the states of the user's own environment."""

    own = True
    counts = True  # whatever is not saved

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
        self.shown = None if seed is None else reset(env, seed)
        self._generators = self._all_generators()
        counting = [one for one in layers(env)[:-1] if type(one).__module__.startswith(_COUNTING)]
        self._counters = [(layer, _counters(layer)) for layer in counting]
        self.first = Snapshot(self.save(env), self.look(env))

    def _all_generators(self) -> Sequence[Any]:
        return [*view(self._env, strict=False).generators, *_Shared(self._env).generators()]

    def look(self, env: Any) -> Seen:
        return Seen(self._identity.of(self._env).digest, states_of(self._generators))

    def shared(self) -> list[Any]:
        return []  # they are among those of the environment

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
        self.rewind(self._env)
        digest = self._identity.of(self._env).digest
        check_same(
            snapshot, digest, f"{type(unwrapped(self._env)).__name__} after load(env, value)"
        )
        return self._stepped

    def rewind(self, env: Any) -> None:
        inner = unwrapped(env)
        if "step_count" in bookkeeping(type(inner)):
            inner.step_count = 0  # Minigrid's: every step is a first one
        for layer, content in self._counters:
            vars(layer).update(copy.copy(content))

    def begin(self) -> Any:
        if self._seed is not None:
            reset(self._env, self._seed)
            self._generators = self._all_generators()
        self.load(self.first)
        return self._env

    def parts(self, snapshot: Snapshot) -> dict[str, Any]:
        content = snapshot.content
        if isinstance(content, Mapping):
            return {str(name): part for name, part in content.items()}
        return attributes(content) or {"state": content}


class Copies:
    """Access by copies of the unwrapped environment.

    They are pickled where that leaves nothing out: it takes a fifth of the time of `deepcopy`, and
    the same bytes are the same state, which then need not be looked into.
    """

    own = False

    def __init__(self, env: Any, seed: int | None, identity: Identity):
        self._identity, self._originals = identity, {id(layer) for layer in layers(env)}
        self._outer = without_recorders(deep_copy(env))
        inner, name = unwrapped(self._outer), type(unwrapped(env)).__name__
        if inner is not unwrapped(env):
            before, after = (view(one, strict=False) for one in (unwrapped(env), inner))
            if before.digest != after.digest:
                raise ValueError(f"a copy of {name} is not in the state of {name}; {STATE_ADVICE}")
            _check_apart(after, self._originals, f"a copy of {name}")
        self.shown = None if seed is None else reset(self._outer, seed)
        if getattr(inner, "render_mode", None) == "human":
            inner.render_mode = None  # no window for each of the steps
        counted = ("step_count",) if "step_count" in bookkeeping(type(inner)) else ()
        counted = tuple(name for name in counted if hasattr(inner, name))
        self._names, self.counts = (*identity.ignore, *counted), bool(identity.ignore)
        self.counts |= identity.key is not None
        kept = [getattr(owner, name) for owner, name in owners(inner, identity.ignore)]
        self._begun = [*copy.deepcopy(kept), *(0 for _ in counted)]  # Minigrid's: a first step
        self._of_classes = _Shared(self._outer)
        self._known: dict[bytes, Seen] = {}
        self._checked: set[bytes] = set()
        self._pickles = True
        self.rewind(inner)  # refuses an attribute that cannot be set
        seen = self.look(inner)
        self.first = Snapshot(self.save(inner), seen)
        self.load(self.first)

    def shared(self) -> list[Any]:
        return states_of(self._of_classes.generators())

    def look(self, env: Any) -> Seen:
        self._of_classes.check()
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
        """The hash of the bytes that an environment is pickled as, its counters reset."""
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
                _set(owner, name, value)

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
            check_same(snapshot, seen.digest, f"a copy of {type(env).__name__}")
            _check_apart(seen, self._originals, f"a copy of {type(env).__name__}")
            self._checked.add(snapshot.seen.digest)
        self.rewind(env)
        return env

    def rewind(self, env: Any) -> None:
        for (owner, name), value in zip(owners(env, self._names), self._begun, strict=True):
            _set(owner, name, copy.deepcopy(value))

    def begin(self) -> Any:
        return deep_copy(self._outer)

    def drawn_before(self, snapshot: Snapshot) -> list[Any]:
        return snapshot.seen.drawn

    def generators(self, env: Any) -> Sequence[Any]:
        return [*view(env, strict=False).generators, *self._of_classes.generators()]

    def loader(self, snapshot: Snapshot) -> Callable[[], tuple[Any, Sequence[Any]]]:
        env = self.load(snapshot)
        generators = view(env, strict=False).generators
        if self._pickles:
            with suppress(Exception):
                pickled = pickle.dumps((env, generators), 5)

                def unpickled() -> tuple[Any, Sequence[Any]]:
                    env, generators = pickle.loads(pickled)
                    return env, [*generators, *self._of_classes.generators()]

                return unpickled

        def load() -> tuple[Any, Sequence[Any]]:
            env = self.load(snapshot)
            return env, self.generators(env)

        return load

    def parts(self, snapshot: Snapshot) -> dict[str, Any]:
        return attributes(self.load(snapshot))


def _set(owner: Any, name: str, value: Any) -> None:
    try:
        object.__setattr__(owner, name, value)  # of frozen dataclasses, too
    except (AttributeError, TypeError):
        raise ValueError(
            f"ignore has {name!r}, an attribute of {type(owner).__name__} that cannot be set; "
            "define the state with key="
        ) from None


def without_recorders(env: Any) -> Any:
    """Removes wrappers that record or show: copies must not overwrite the user's videos."""
    while type(env).__module__ == "gymnasium.wrappers.rendering":
        env = env.env
    layer = env
    while layer is not unwrapped(env):
        while type(layer.env).__module__ == "gymnasium.wrappers.rendering":
            layer.env = layer.env.env
        layer = layer.env
    return env


def _check_apart(seen: View, originals: set[int], name: str) -> None:
    if not seen.objects.isdisjoint(originals):
        raise ValueError(
            f"{name} still refers to the environment that it was copied from, in a function's "
            f"closure or a weak reference; {STATE_ADVICE}"
        )


def deep_copy(env: Any) -> Any:
    """A deep copy of an environment, but for modules and pictures, which are shared.

    Instances of `EzPickle` are copied by their attributes: by themselves they start afresh.

    Raises:
        ValueError: something in it cannot be copied.
    """
    seen = view(env, strict=False)
    memo = {id(thing): thing for thing in seen.outside}
    shells = [(thing, object.__new__(type(thing))) for thing in seen.rebuilt]
    memo.update((id(thing), shell) for thing, shell in shells)
    try:
        if seen.weak:
            raise ValueError("it has a weak reference, which would refer to the original")
        with deep_recursion():
            for thing, shell in shells:
                for name, value in attributes(thing).items():
                    object.__setattr__(shell, name, copy.deepcopy(value, memo))
            return copy.deepcopy(env, memo)
    except Exception as error:  # whatever the environment's own parts raise
        name = type(unwrapped(env)).__name__
        raise ValueError(
            f"{name} cannot be copied ({reason(error)}); make it without a renderer, or "
            f"{STATE_ADVICE}"
        ) from None
