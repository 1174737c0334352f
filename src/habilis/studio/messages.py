"""The validation of requests: of their form by `protocol`, of their scene by the library."""

import contextlib
import json
import re
from collections.abc import Collection
from reprlib import Repr
from typing import Any

import msgspec
from msgspec import UNSET, inspect

from habilis.studio.board_scenes import BoardScene
from habilis.studio.boards import Board
from habilis.studio.limits import MESSAGE
from habilis.studio.protocol.requests import AnyRequest, Futures, Request
from habilis.studio.protocol.scenes import GIVE, LARGEST, Index
from habilis.studio.protocol.scenes import Scene as ScenePart
from habilis.studio.scenes import AnyScene, Scene

_LONGEST_ERROR = 400
_DECODER = msgspec.json.Decoder(AnyRequest)
_KINDS: dict[str, inspect.StructType] = {
    kind.tag: kind
    for kind in inspect.type_info(AnyRequest).types  # type: ignore[attr-defined]
}
_STEP = re.compile(r"\.(\w+)|\[(\d+)\]")  # of a path in an error
_HALF = re.compile(r"[\ud800-\udfff]|\\u[dD][89a-fA-F]")
_UNKNOWN = "Object contains unknown field `"
_MISSING = "Object missing required field `"
_SHORT = Repr()
_SHORT.maxlevel, _SHORT.maxstring, _SHORT.maxother = 2, 60, 60


class MessageError(ValueError):
    """The error of an invalid message; `id` is its number, if it has one."""

    def __init__(self, message: str, number: int | None):
        super().__init__(message)
        self.id = number


class _Numbered(msgspec.Struct):
    """The number of a message, whatever else it has."""

    id: Index


def read(
    message: Any, tools: Collection[str], board: Board | None = None
) -> tuple[Request, AnyScene | None]:
    """A request from a message, and its scene if it has one.

    Args:
        message: as received.
        tools: the names of all tools.
        board: the one that the studio shows, if any.

    Raises:
        MessageError: the message is invalid; one line says why.
    """
    try:
        request = _request(message)
        asked = getattr(request, "scene", None)
        scene = None if asked is None else _scene(asked, tools, board)
        if isinstance(request, Futures):
            _check_inside(request.agent, scene)
    except (ValueError, RecursionError) as error:
        raise MessageError(one_line(error), _number_of(message)) from None
    return request, scene


def _scene(asked: ScenePart, tools: Collection[str], board: Board | None) -> AnyScene:
    """The scene of a message.

    Raises:
        ValueError: there is no such world, board or thing; the message says why.
    """
    if asked.board is UNSET:
        return Scene.of(asked, tools)
    return BoardScene.of(asked, board)


def kind_of(request: Request) -> str:
    """The name of a request."""
    return str(request.__struct_config__.tag)


def one_line(error: object) -> str:
    """The text of an error, in one line of limited length."""
    line = " ".join(str(error).split()) or type(error).__name__
    return line if len(line) <= _LONGEST_ERROR else f"{line[:_LONGEST_ERROR]}..."


def shown(value: Any) -> str:
    """A value as sent, truncated."""
    return _SHORT.repr(value)


def _request(message: Any) -> Request:
    if not isinstance(message, str):
        raise ValueError("a message is binary; send a JSON object as text")
    if len(message) > MESSAGE:
        raise ValueError(f"a message has {len(message):,} characters; send at most {MESSAGE:,}")
    try:
        return _DECODER.decode(message)
    except msgspec.ValidationError as error:
        raise ValueError(_explained(str(error), message)) from None
    except msgspec.DecodeError as error:
        half = _loaded(message) is not None and _HALF.search(message)
        why = "it has half of a surrogate pair" if half else error
        raise ValueError(f"a message is not JSON ({why}); send an object") from None
    except RecursionError:
        raise ValueError("a message is nested too deeply; send an object as documented") from None
    except ValueError as error:
        raise ValueError(f"a message is not JSON ({error}); send an object") from None


def _number_of(message: Any) -> int | None:
    """The id of an invalid message, also of one that is too long, so that it can be answered."""
    try:
        return msgspec.json.decode(message, type=_Numbered).id
    except (ValueError, TypeError, RecursionError):
        loaded = _loaded(message)
    found = loaded.get("id") if isinstance(loaded, dict) else None
    return found if type(found) is int and 0 <= found <= LARGEST else None


def _loaded(message: Any) -> Any:
    """A short message as the standard library reads it, which accepts halves of surrogate pairs."""
    with contextlib.suppress(ValueError, TypeError, RecursionError):
        return json.loads(message) if len(message) <= MESSAGE else None
    return None


def _check_inside(agent: tuple[int, int], scene: AnyScene | None) -> None:
    assert scene is not None
    row, column = agent
    if not (0 <= row < scene.height and 0 <= column < scene.width):
        raise ValueError(f"the agent's cell {agent} is outside the map; give a free cell")


def _explained(error: str, message: str) -> str:
    """The decoder's error in our words: which field is wrong, and what to give instead."""
    try:
        value = json.loads(message, object_pairs_hook=_once)
    except _TwiceError as twice:
        return str(twice)
    except (ValueError, RecursionError):  # a number of thousands of digits, or a deep nest
        return f"a message is not as documented ({error}); send an object that is"
    if not isinstance(value, dict):
        return "a message is not a JSON object; send one"
    try:
        return _located(error, value)
    except (LookupError, TypeError, StopIteration):  # an unknown name that looks like a path
        return f"a message is not as documented ({error}); send an object that is"


class _TwiceError(Exception):
    """A field that is given twice: decoders differ in which one counts."""


def _once(fields: list[tuple[str, Any]]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, value in fields:
        if name in found:
            raise _TwiceError(f"a message has {shown(name)} twice in an object; give it once")
        found[name] = value
    return found


def _located(error: str, value: dict[str, Any]) -> str:
    """The error where its path leads.

    Raises:
        LookupError, TypeError, StopIteration: its path leads nowhere.
    """
    what, _, path = error.partition(" - at `$")
    do = value.get("do")
    if not isinstance(do, str) or do not in _KINDS:
        return f"do is {shown(do)}; use one of {', '.join(_KINDS)}"
    name: str = ""
    at: Any = value
    kind: Any = _KINDS[do]
    for step in _STEP.finditer(path):
        field, place = step.groups()
        if field is not None:
            kind = next(one.type for one in kind.fields if one.encode_name == field)
            name, at = f"{name}.{field}" if name else field, at[field]
        else:
            kind = kind.item_type if hasattr(kind, "item_type") else kind.item_types[int(place)]
            name, at = f"{name}[{place}]", at[int(place)]
        kind, give = _bare(kind)
        if give is not None:
            return f"{name} has {shown(at)}; give {give}"
    name = name or f"the message {do!r}"
    if what.startswith(_MISSING):
        return f"{name} has no {what[len(_MISSING) : -1]!r}; give it"
    if what.startswith(_UNKNOWN):
        known = ", ".join(one.encode_name for one in kind.fields)
        return (
            f"{name} has {shown(what[len(_UNKNOWN) : -1])}, which is unknown; it may have {known}"
        )
    return f"{name} is {shown(at)}; give {_wanted(kind)}"


def _bare(kind: inspect.Type) -> tuple[Any, str | None]:
    """A type without its description and without null; and its own words, if it has some."""
    give = None
    while isinstance(kind, inspect.Metadata | inspect.UnionType):
        if isinstance(kind, inspect.Metadata):
            give = (kind.extra or {}).get(GIVE, give)
            kind = kind.type
        else:
            kind = next(one for one in kind.types if not isinstance(one, inspect.NoneType))
    return kind, give


def _wanted(kind: Any) -> str:
    """The values of a type, in words."""
    match kind:
        case inspect.IntType():
            return f"a whole number{_range(kind)}"
        case inspect.FloatType():
            return f"a finite number{_range(kind)}"
        case inspect.LiteralType():
            return f"one of {', '.join(map(str, kind.values))}"
        case inspect.BoolType():
            return "true or false"
        case inspect.StrType():
            return "text"
        case inspect.ListType():
            return f"a list of {_count(kind)}"
        case _:
            return "an object"


def _range(kind: Any) -> str:
    least, most = kind.ge, kind.le if kind.lt is None else kind.lt - 1
    return "" if least is None else f" from {least:,} to {most:,}"


def _count(kind: inspect.ListType) -> str:
    if kind.max_length is None:
        return "them"
    return f"{kind.min_length or 0} to {kind.max_length}"
