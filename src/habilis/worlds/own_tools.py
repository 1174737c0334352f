"""Tools by their names: the built-in ones, and those that users write in files of their own.

One's own is named by where it is written, `mytools.py:Rake` (a file, from the working directory)
or `package.module:Rake`.
"""

from functools import lru_cache
from pathlib import Path
from typing import Any

from habilis.files import shown
from habilis.own_code import BETWEEN, FILE, failure, imported, instance, is_own, member, read, run
from habilis.worlds.map_text import check_free
from habilis.worlds.tools import TOOLS, Tool

_METHODS = ("attached", "carry", "swing")


class OwnToolError(ValueError):
    """A tool of one's own is not where it should be, or is none."""


def tool_named(name: str) -> Tool:
    """The tool of that name.

    A file is run when a tool is first asked of it, and again when its content has changed.

    Args:
        name: a built-in one's kind, `FILE.py:CLASS` or `package.module:CLASS`. In place of a class,
            which must need no arguments, the name of an instance will do.

    Raises:
        ValueError: there is none, or (`OwnToolError`) what is there is no tool; the message says
            how to fix it.
    """
    if name in TOOLS:
        return TOOLS[name]
    if not is_own(name):
        raise ValueError(
            f"tool {shown(repr(name))} is unknown; use one of {', '.join(TOOLS)}, none, or one of "
            "your own as FILE.py:CLASS"
        )
    place, _, wanted = name.rpartition(BETWEEN)
    try:
        if not place.endswith(FILE):
            example = f"{place.rpartition('.')[2] or 'mytools'}.py:CLASS"
            return _made(member(imported(place, example), wanted))
        path, source = read(place, "mytools.py:Rake")
        return _found_in_file(place, path, source, wanted)
    except ValueError as error:
        raise OwnToolError(f"tool {shown(repr(name))}: {error}") from None


def as_tool(given: Any) -> Tool:
    """A tool from its name, its class or itself.

    Raises:
        ValueError: it is none; the message says how to fix it.
    """
    if isinstance(given, str):
        return tool_named(given)
    try:
        return _made(given)
    except ValueError as error:
        kind = given if isinstance(given, type) else type(given)
        raise ValueError(f"tool {kind.__qualname__!r}: {error}") from None


def is_in_file(name: str) -> bool:
    """Whether it names a file, rather than a module that Python finds by itself."""
    return name.rpartition(BETWEEN)[0].endswith(FILE)


def located(name: str) -> str:
    """A name that holds in any working directory."""
    place, _, wanted = name.rpartition(BETWEEN)
    return f"{Path(place).absolute()}{BETWEEN}{wanted}" if is_in_file(name) else name


def beside(folder: Path, name: str) -> str:
    """A name that a map in some folder has: of a file beside the map, if there is one."""
    place = folder / name.rpartition(BETWEEN)[0]
    return str(folder / name) if is_in_file(name) and place.is_file() else name


@lru_cache(256)
def _found_in_file(place: str, path: Path, source: bytes, wanted: str) -> Tool:
    return _made(member(run(place, path, source), wanted))


def _made(found: Any) -> Tool:
    """A tool from its class, looked over as far as can be seen without asking it."""
    kind = found if isinstance(found, type) else type(found)
    for method in _METHODS:
        if not callable(_said(found, method)):
            raise ValueError(
                f"{kind.__name__} has no method {method!r}; a tool has {', '.join(_METHODS)}"
            )
    tool = instance(found)
    _said(tool, "drawing")
    character = _said(tool, "character")
    if character is None:
        raise ValueError(f"{kind.__name__} has no character; give it one, such as 'R'")
    check_free(character)
    return tool


def _said(found: Any, name: str) -> Any:
    """An attribute, `None` if there is none; a property may do anything."""
    try:
        return getattr(found, name, None)
    except (Exception, SystemExit) as error:
        raise ValueError(f"its {name} fails with {failure(error)}; fix it") from error
