"""When two environments are in the same state: when all that they hold has the same value.

Numbers are equal by value, whatever their types, NaN equal to itself; lists, tuples and arrays are
alike; sets and mappings have no order; other objects are equal by class and attributes. Objects may
refer to each other in circles: they are equal where no path through their attributes tells them
apart (bisimilar). Whether two references are to one object or to two equal ones does not matter.

Random generators and what pictures are drawn with, both known by their types, are no part of a
value; nor are the attributes of `encodings._BOOKKEEPING` and the counters of Gymnasium's own
wrappers. Nothing else is left out because of its name.
"""

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from habilis.bridges.gymnasium.encodings import (
    DROPPED,
    IncomparableError,
    Token,
    attributes,
    combined,
    encoder,
    hash_of,
)


@dataclass(frozen=True)
class View:
    """A value, and what it contains.

    Attributes:
        digest: 32 bytes; the same for equal values, in every process.
        generators: the random generators, which are no part of the value.
        outside: modules and what pictures are drawn with; copies share them.
        rebuilt: instances of `gymnasium.utils.EzPickle`, which forget their state when copied.
        objects: the ids of all instances.
        pickled_whole: whether pickling it leaves nothing out, as classes can.
        weak: whether there are weak references in it.
        classes: of all instances.
    """

    digest: bytes
    generators: tuple[Any, ...]
    outside: tuple[Any, ...]
    rebuilt: tuple[Any, ...]
    objects: frozenset[int]
    pickled_whole: bool
    weak: bool
    classes: frozenset[type]


def view(value: Any, name: str = "", ignore: Iterable[str] = (), strict: bool = True) -> View:
    """The identity of a value.

    Args:
        value: such as an (unwrapped) environment.
        name: what error messages call it; "" where they name its attributes alone.
        ignore: attributes to leave out, those of attributes as "simulator.time".
        strict: whether to refuse what has no value to compare, or to leave it out.

    Raises:
        ValueError: a part of it is of a kind that has no value to compare, or there is no such
            attribute to leave out; it is named.
    """
    walk = Walk({(id(owner), last) for owner, last in owners(value, ignore)}, strict)
    try:
        with deep_recursion():
            token = walk.encode(value)
    except IncomparableError as error:
        path = ".".join([name, *error.path] if name else error.path)
        which = f"the attribute {path!r} ({error.kind})" if path else error.kind
        raise ValueError(f"{which} cannot be compared; {_ADVICE}") from None
    except RecursionError:
        raise ValueError(
            f"{name or type(value).__name__} is nested too deeply to be compared; {_ADVICE}"
        ) from None
    whole = walk.fold(token) if isinstance(token, int) else token
    return View(
        hash_of(whole),
        *(tuple(walk.generators), tuple(walk.outside), tuple(walk.rebuilt)),
        *(frozenset(walk.objects), walk.pickled_whole, walk.weak, frozenset(walk.classes)),
    )


@contextmanager
def deep_recursion() -> Iterator[None]:
    """For objects that refer to each other in long chains: of Python's frames, not C's."""
    before = sys.getrecursionlimit()
    sys.setrecursionlimit(max(before, _DEEP))
    try:
        yield
    finally:
        sys.setrecursionlimit(before)


def digest(value: Any, name: str = "") -> bytes:
    """The 32 bytes of a value's `view`."""
    return view(value, name).digest


def owners(env: Any, names: Iterable[str]) -> list[tuple[Any, str]]:
    """The objects that have the named attributes, as (simulator, "time") for "simulator.time".

    Raises:
        ValueError: there is no such attribute.
    """
    found = []
    for name in names:
        path, _, last = name.rpartition(".")
        owner = env
        for part in path.split(".") if path else ():
            owner = getattr(owner, part, None)
        if not hasattr(owner, last):
            known = ", ".join(sorted(attributes(env))) or "none"
            raise ValueError(
                f"ignore has {name!r}, but {type(env).__name__} has no such attribute; it has "
                f"{known}"
            )
        found.append((owner, last))
    return found


_DEEP = 50_000  # frames: some ten thousand objects in a chain

_ADVICE = "give state=(save, load), functions that return and restore a value for its state"


class Walk:
    """Encodes a value, passing once through all that it refers to."""

    def __init__(self, ignore: set[tuple[int, str]], strict: bool):
        self.ignore, self.strict = ignore, strict
        self._known: dict[int, Token] = {}
        self._alive: list[Any] = []  # so that no id becomes that of another object
        self._nodes: dict[int, tuple[bytes, bool, list[Token]]] = {}
        self._numbers = 0
        self.generators: list[Any] = []
        self.outside: list[Any] = []
        self.rebuilt: list[Any] = []
        self.objects: list[int] = []
        self.pickled_whole, self.weak = True, False
        self.classes: set[type] = set()

    def encode(self, value: Any) -> Token:
        atom, composite = encoder(type(value))
        if atom is not None:
            return atom(value)
        known = self._known.get(id(value))
        if known is not None:
            return known
        self._numbers = number = self._numbers + 1
        self._known[id(value)] = number
        self._alive.append(value)
        try:
            token = composite(self, value, number)
        except IncomparableError:
            self._known[id(value)] = DROPPED  # found again where it is left out
            raise
        self._known[id(value)] = token
        return token

    def node(self, number: int, label: bytes, parts: list[Token], ordered: bool = True) -> Token:
        if all(type(part) is bytes for part in parts):
            return combined(label, ordered, parts)  # type: ignore[arg-type]
        self._nodes[number] = (label, ordered, parts)
        return number

    def pair(self, key: Token, value: Token) -> Token:
        if isinstance(key, bytes) and isinstance(value, bytes):
            return b"p" + key + value
        self._numbers += 1
        return self.node(self._numbers, b"p", [key, value])

    def fold(self, root: int) -> bytes:
        """The encoding of a node that depends on a circle, by refining a partition of the nodes.

        After k rounds two nodes have the same color where no path of k steps tells them apart;
        once a round splits no class, none ever will. Then the classes and what they lead to say
        all about the root.
        """
        reached = self._reached(root)
        colors = {i: combined(self._nodes[i][0], True, []) for i in reached}
        while True:
            finer = {}
            for i in reached:
                label, ordered, parts = self._nodes[i]
                known = [part if isinstance(part, bytes) else colors[part] for part in parts]
                finer[i] = combined(label, ordered, known)
            if len(set(finer.values())) == len(set(colors.values())):
                classes = {colors[i] + finer[i] for i in reached}
                return finer[root] + b"".join(sorted(classes))
            colors = finer

    def _reached(self, root: int) -> list[int]:
        found, todo = {root}, [root]
        while todo:
            for part in self._nodes[todo.pop()][2]:
                if isinstance(part, int) and part not in found:
                    found.add(part)
                    todo.append(part)
        return sorted(found)
