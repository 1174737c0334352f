"""Encodings of values as bytes that are equal for equal values.

Some values are encoded alone, as atoms, others from the encodings of their parts. The first
byte of an encoding is its kind; it contains where it ends.
"""

import copyreg
import enum
import hashlib
import logging
import random
import struct
import types
import weakref
from collections.abc import Callable, Mapping
from collections.abc import Set as AbstractSet
from functools import cache, lru_cache, partial
from numbers import Number
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from habilis.bridges.gymnasium.identity import Walk

_RENDERERS = frozenset(("pyglet", "matplotlib", "OpenGL", "glfw", "tkinter", "_tkinter"))
"""Packages whose objects are windows and figures."""

_DRAWN_WITH = frozenset(
    (
        *("pygame.surface.Surface", "pygame.time.Clock", "pygame.font.Font"),
        *("pygame.freetype.Font", "pygame.mixer.Sound"),
    )
)
"""Classes of other packages with which pictures are drawn."""

_BOOKKEEPING: Mapping[str, frozenset[str]] = {
    "gymnasium.core.Env": frozenset(("_np_random_seed", "render_mode", "spec", "metadata")),
    "minigrid.minigrid_env.MiniGridEnv": frozenset(("step_count", "render_size")),
    "minigrid.core.world_object.WorldObj": frozenset(("cur_pos",)),
}
"""Attributes of known classes on which, by their documentation, no transition depends. Where one
does all the same, the replays of `verification` find out: counters run on in them."""

DROPPED = b"-"  # the encoding of what is no part of a state

Token = bytes | int
"""The encoding of a value, or the number of a node whose value depends on a circle."""


class IncomparableError(Exception):
    """Something of a kind that has no value; `path` are the attributes that lead to it."""

    def __init__(self, kind: str):
        super().__init__(kind)
        self.kind, self.path = kind, list[str]()


def attributes(thing: Any) -> dict[str, Any]:
    """All attributes of an instance, those in slots among them."""
    named = getattr(thing, "__dict__", {})
    slots = slots_of(type(thing))
    return named | {s: getattr(thing, s) for s in slots if hasattr(thing, s)} if slots else named


@cache
def bookkeeping(cls: type) -> frozenset[str]:
    """The attributes that are no part of a state in instances of a class."""
    named = (_BOOKKEEPING.get(full_name(base), frozenset()) for base in cls.__mro__)
    return frozenset().union(*named)


_Atom = Callable[[Any], bytes]
_Composite = Callable[["Walk", Any, int], Token]


@cache
def encoder(cls: type) -> tuple[_Atom | None, _Composite]:
    for kinds, atom in _ATOMS:
        if issubclass(cls, kinds):
            attributed = cls.__dictoffset__ and not issubclass(cls, enum.Enum | type)
            return (None, partial(_attributed, atom)) if attributed else (atom, _instance)
    for kinds, composite in _COMPOSITES:
        if issubclass(cls, kinds):
            return None, composite
    if cls.__module__.partition(".")[0] in _RENDERERS or full_name(cls) in _DRAWN_WITH:
        return None, _no_state
    if any(full_name(base) == "PIL.Image.Image" for base in cls.__mro__):
        return None, _image
    if hasattr(cls, "__array__"):
        return None, _like_an_array
    return None, _instance


def _attributed(atom: _Atom, walk: "Walk", value: Any, number: int) -> Token:
    """A number or text of a class of its own, which may have attributes."""
    return _instance(walk, value, number, atom(value)) if attributes(value) else atom(value)


def _number(value: Any) -> bytes:
    if isinstance(value, np.datetime64 | np.timedelta64):
        return _text(repr(value))
    if isinstance(value, np.generic):
        value = value.item()  # compared with floats, NumPy's integers lose digits
    if isinstance(value, complex | np.complexfloating):
        if value.imag != 0:
            return b"c" + _number(value.real) + _number(value.imag)
        value = value.real
    if value != value:
        return _NAN
    try:
        near = float(value)
    except OverflowError:
        near = None
    if near is not None and near == value:
        return b"f" + _DOUBLE.pack(near + 0.0)  # -0.0 + 0.0 is 0.0
    exact = "{}/{}".format(*value.as_integer_ratio()).encode()
    return b"i" + _size(len(exact)) + exact


@lru_cache(10_000)
def _text(value: str) -> bytes:
    encoded = value.encode("utf-8", "surrogatepass")
    return b"s" + _size(len(encoded)) + encoded


def _bytes(value: Any) -> bytes:
    return b"b" + _size(len(value)) + bytes(value)


def _member(value: enum.Enum) -> bytes:
    return b"E" + _name(type(value)) + _text(value.name or repr(value.value))  # flags may be 0


def _array(walk: "Walk", value: np.ndarray, number: int) -> Token:
    if type(value) is not np.ndarray and attributes(value):
        walk.pickled_whole = False
        return _instance(walk, value, number, np.asarray(value))
    kind, wide = value.dtype.kind, value.dtype.itemsize > 4
    exact = kind in "bf" or (kind in "iu" and not (wide and (abs(value) >= _EXACT).any()))
    if kind == "f" and value.dtype.itemsize > 8:
        exact = False
    if not exact or not value.size or not value.ndim:
        return walk.encode(value.tolist())
    numbers = value.astype(np.float64) + 0.0  # -0.0 + 0.0 is 0.0
    if kind == "f":
        numbers[np.isnan(numbers)] = np.nan
    return _numbers(value.shape, numbers.tobytes())


def _like_an_array(walk: "Walk", value: Any, number: int) -> Token:
    try:
        array = np.asarray(value)
    except Exception:  # whatever its own code raises
        raise IncomparableError(type(value).__name__) from None
    return _instance(walk, value, number, array) if attributes(value) else walk.encode(array)


def _image(walk: "Walk", value: Any, number: int) -> Token:
    return walk.encode(["PIL.Image", value.mode, value.size, value.tobytes()])


def _numbers(shape: tuple[int, ...], content: bytes) -> bytes:
    """The encoding of an array of numbers, and of nested sequences of them."""
    return b"A" + _size(len(shape)) + b"".join(map(_size, shape)) + content


def _sequence(walk: "Walk", value: Any, number: int) -> Token:
    if type(value) not in _PLAIN and attributes(value):
        return _instance(walk, value, number, list(value))
    parts = [walk.encode(part) for part in value]
    kinds = {part[:1] if isinstance(part, bytes) else b"" for part in parts}
    if kinds <= {b"f"}:
        return _numbers((len(parts),), b"".join(part[1:] for part in parts))  # type: ignore
    if kinds == {b"A"} and len(heads := {_head(part) for part in parts}) == 1:  # type: ignore
        (head,) = heads
        shape = struct.unpack(f"<{len(head) // 8 - 1}Q", head[8:])
        return _numbers((len(parts), *shape), b"".join(part[1 + len(head) :] for part in parts))  # type: ignore
    return walk.node(number, b"l", parts)


def _head(array: bytes) -> bytes:
    """The number of axes and their lengths."""
    return array[1 : 9 + 8 * _SIZE.unpack_from(array, 1)[0]]


def _set(walk: "Walk", value: Any, number: int) -> Token:
    if type(value) not in _PLAIN and attributes(value):
        return _instance(walk, value, number, frozenset(value))
    return walk.node(number, b"S", [walk.encode(part) for part in value], ordered=False)


def _mapping(walk: "Walk", value: Any, number: int) -> Token:
    if type(value) not in _PLAIN and attributes(value):
        return _instance(walk, value, number, dict(value.items()))
    pairs = [walk.pair(walk.encode(key), walk.encode(part)) for key, part in value.items()]
    return walk.node(number, b"M", pairs, ordered=False)


def _generator(walk: "Walk", value: Any, number: int) -> Token:
    walk.generators.append(value)
    return DROPPED


def _no_state(walk: "Walk", value: Any, number: int) -> Token:
    walk.outside.append(value)
    return DROPPED


def _reference(walk: "Walk", value: Any, number: int) -> Token:
    """Weak references are copied as they are, and so refer to what they were copied from."""
    walk.weak = True
    raise IncomparableError(type(value).__name__)


def _module(walk: "Walk", value: Any, number: int) -> Token:
    walk.outside.append(value)
    return _text(value.__name__)


def _function(walk: "Walk", value: Any, number: int) -> Token:
    cells = [_content(cell) for cell in value.__closure__ or ()]
    inside = (value.__code__, cells, value.__defaults__, value.__kwdefaults__, vars(value))
    label = b"F" + _text(full_name(value))
    return walk.node(number, label, [walk.encode(part) for part in inside])


def _code(walk: "Walk", value: Any, number: int) -> Token:
    inside = (value.co_code, value.co_consts, value.co_names)
    return walk.node(number, b"D", [walk.encode(part) for part in inside])


def _content(cell: Any) -> Any:
    try:
        return cell.cell_contents
    except ValueError:  # nothing is in it yet
        return None


def _method(walk: "Walk", value: Any, number: int) -> Token:
    inside = (value.__func__, value.__self__)
    return walk.node(number, b"B", [walk.encode(part) for part in inside])


def _builtin(walk: "Walk", value: Any, number: int) -> Token:
    owner = None if isinstance(value.__self__, types.ModuleType) else value.__self__
    return walk.node(number, b"C" + _text(value.__qualname__), [walk.encode(owner)])


def _instance(walk: "Walk", value: Any, number: int, content: Any = None) -> Token:
    """By class and attributes; those that are None, or no part of a state, are as if absent.

    Args:
        walk, value, number: as of every composite.
        content: what it holds besides its attributes.
    """
    cls = type(value)
    walk.objects.append(id(value))
    walk.classes.add(cls)
    if _is_rebuilt(cls):
        walk.rebuilt.append(value)
    walk.pickled_whole &= _is_pickled_whole(cls)
    if content is None and _has_content(cls):
        content = _native_content(value)
    pairs = [] if content is None else [walk.pair(b"", walk.encode(content))]
    left_out = bookkeeping(cls)
    if walk.ignore:
        left_out = left_out | {name for owner, name in walk.ignore if owner == id(value)}
    for name, part in _parts(cls, value).items():
        if part is None or name in left_out:
            continue
        try:
            token = walk.encode(part)
        except IncomparableError as error:
            if not walk.strict:
                continue
            error.path.insert(0, name)
            raise
        if token != DROPPED:
            pairs.append(walk.pair(_text(name), token))
    return walk.node(number, b"O" + _name(cls), pairs, ordered=False)


def _parts(cls: type, value: Any) -> dict[str, Any]:
    if cls.__module__.startswith("gymnasium.wrappers."):  # all else in them counts and records
        return {"env": value.env, "arguments": getattr(value, "_saved_kwargs", None)}
    return attributes(value)


@cache
def of_class(cls: type) -> tuple[Any, ...]:
    """The spaces and random generators that instances share through their class."""
    found = [value for base in cls.__mro__[:-1] for value in vars(base).values()]
    kinds = (np.random.Generator, np.random.RandomState, random.Random)
    return tuple(one for one in found if isinstance(one, kinds) or _is_space(type(one)))


@cache
def _is_space(cls: type) -> bool:
    return any(full_name(base) == "gymnasium.spaces.space.Space" for base in cls.__mro__)


@cache
def _is_rebuilt(cls: type) -> bool:
    return any(full_name(base) == "gymnasium.utils.ezpickle.EzPickle" for base in cls.__mro__)


def _first_defined(cls: type, *names: str) -> Any:
    """The first attribute of one of these names in the bases of a class, `object` excepted."""
    found = (vars(base).get(name) for base in cls.__mro__[:-1] for name in names)
    return next((one for one in found if one is not None), None)


@cache
def _has_content(cls: type) -> bool:
    """Whether instances hold something besides attributes, as those of extension modules do."""
    reduce = _first_defined(cls, "__reduce_ex__", "__reduce__")
    if reduce is not None:
        return not isinstance(reduce, types.FunctionType)
    return cls is object or not (slots_of(cls) or cls.__dictoffset__)


@cache
def _is_pickled_whole(cls: type) -> bool:
    """Whether no Python code selects what of an instance is pickled."""
    own = _first_defined(cls, "__reduce_ex__", "__reduce__", "__getstate__")
    return not isinstance(own, types.FunctionType) and cls not in copyreg.dispatch_table


def _native_content(value: Any) -> Any:
    """Its pickled form without its class."""
    try:
        reduced = value.__reduce_ex__(4)
    except TypeError:
        raise IncomparableError(type(value).__name__) from None
    if isinstance(reduced, str):
        return reduced
    return [list(part) if hasattr(part, "__next__") else part for part in reduced[1:]]


@cache
def slots_of(cls: type) -> tuple[str, ...]:
    names = []
    for base in cls.__mro__:
        slots = base.__dict__.get("__slots__", ())
        for slot in (slots,) if isinstance(slots, str) else slots:
            private = slot.startswith("__") and not slot.endswith("__")
            names.append(f"_{base.__name__.lstrip('_')}{slot}" if private else slot)
    return tuple(name for name in names if name not in ("__dict__", "__weakref__"))


_ATOMS: tuple[tuple[Any, _Atom], ...] = (
    (type(None), lambda value: b"0"),
    ((Number, np.number, np.bool_), _number),  # members of an IntEnum are numbers
    (str, _text),
    ((bytes, bytearray, memoryview), _bytes),
    (enum.Enum, _member),
    (type, lambda value: b"T" + _name(value)),
)
_COMPOSITES: tuple[tuple[Any, _Composite], ...] = (
    (np.ndarray, _array),
    ((list, tuple), _sequence),
    (AbstractSet, _set),
    (Mapping, _mapping),
    ((np.random.Generator, np.random.RandomState, np.random.BitGenerator), _generator),
    (random.Random, _generator),
    (logging.Logger, _no_state),
    ((weakref.ReferenceType, weakref.ProxyType, weakref.CallableProxyType), _reference),
    (types.ModuleType, _module),
    (types.FunctionType, _function),
    (types.CodeType, _code),
    (types.MethodType, _method),
    (types.BuiltinFunctionType, _builtin),
)

_PLAIN = frozenset((list, tuple, set, frozenset, dict))  # these have no attributes
_EXACT = 2**53  # integers below are float64 numbers
_DOUBLE = struct.Struct("<d")
_NAN = b"f" + _DOUBLE.pack(float("nan"))
_SIZE = struct.Struct("<Q")


def _size(count: int) -> bytes:
    return _SIZE.pack(count)


def hash_of(content: bytes) -> bytes:
    return hashlib.blake2b(content, digest_size=32).digest()


def full_name(thing: Any) -> str:
    return f"{thing.__module__}.{thing.__qualname__}"


@cache
def _name(thing: Any) -> bytes:
    return _text(full_name(thing))


def combined(label: bytes, ordered: bool, parts: list[bytes]) -> bytes:
    return b"d" + hash_of(label + _size(len(parts)) + b"".join(parts if ordered else sorted(parts)))
