"""Tools by their names: the built-in ones, and those that users write in files of their own.

One's own is named by where it is written, `mytools.py:Rake` (a file, from the working directory)
or `package.module:Rake`.
"""

import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import lru_cache
from importlib import import_module
from operator import attrgetter
from pathlib import Path
from types import ModuleType
from typing import Any

from habilis.files import shown
from habilis.worlds.map_text import check_free
from habilis.worlds.tools import TOOLS, Tool

_BETWEEN = ":"  # the file or module, and the class in it
_FILE = ".py"
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
    place, _, wanted = name.rpartition(_BETWEEN)
    try:
        if not place.endswith(_FILE):
            return _found(_imported(place), wanted)
        path, source = _read(place)
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


def is_own(name: str) -> bool:
    """Whether a name says where a tool of one's own is written."""
    return _BETWEEN in name


def is_in_file(name: str) -> bool:
    """Whether it names a file, rather than a module that Python finds by itself."""
    return name.rpartition(_BETWEEN)[0].endswith(_FILE)


def located(name: str) -> str:
    """A name that holds in any working directory."""
    place, _, wanted = name.rpartition(_BETWEEN)
    return f"{Path(place).absolute()}{_BETWEEN}{wanted}" if is_in_file(name) else name


def beside(folder: Path, name: str) -> str:
    """A name that a map in some folder has: of a file beside the map, if there is one."""
    place = folder / name.rpartition(_BETWEEN)[0]
    return str(folder / name) if is_in_file(name) and place.is_file() else name


def failure(error: BaseException) -> str:
    """An error in somebody's code, in one line, and its place in it."""
    frames = traceback.extract_tb(error.__traceback__)[1:]
    places = [(f.filename, f.lineno) for f in frames if "importlib" not in f.filename]
    if isinstance(error, SyntaxError):
        places = [(error.filename or "?", error.lineno)]
    what = type(error).__name__
    lines = str(error.msg if isinstance(error, SyntaxError) else error).splitlines()
    what += f": {lines[0]}" if lines else ""
    if not places:
        return what
    file = places[0][0]
    line = [line for name, line in places if name == file][-1]
    return f"{what} ({Path(file).name}, line {line})"


def _read(place: str) -> tuple[Path, bytes]:
    path = Path(place).resolve()
    try:
        return path, path.read_bytes()
    except OSError as error:
        raise ValueError(
            f"{path} cannot be read ({error.strerror}); give the path of a Python file and a class "
            f"in it, as mytools.py:Rake"
        ) from None


@lru_cache(256)
def _found_in_file(place: str, path: Path, source: bytes, wanted: str) -> Tool:
    return _found(_run(place, path, source), wanted)


@lru_cache(64)
def _run(place: str, path: Path, source: bytes) -> ModuleType:
    """A file as a module, whose name is the file's as it was given: no other module's."""
    module = ModuleType(place)
    module.__file__ = str(path)
    before = sys.modules.get(place)
    sys.modules[place] = module  # where dataclasses, for one, look for a class's module
    try:
        with importing_from(path.parent):
            exec(compile(source, str(path), "exec"), vars(module))
    except (Exception, SystemExit) as error:
        sys.modules.pop(place)
        if before is not None:
            sys.modules[place] = before
        raise ValueError(f"{path.name} fails with {failure(error)}; fix the file") from error
    return module


def _imported(place: str) -> ModuleType:
    try:
        with importing_from(Path.cwd()):
            return import_module(place)
    except (Exception, SystemExit) as error:
        raise ValueError(
            f"importing {place!r} fails with {failure(error)}; name a module that Python finds, "
            f"or a file as {place.rpartition('.')[2] or 'mytools'}.py:CLASS"
        ) from error


@contextmanager
def importing_from(folder: Path) -> Iterator[None]:
    """Lets a file import those beside it, or a module be found there, within it."""
    sys.path.insert(0, str(folder))
    try:
        yield
    finally:
        with suppress(ValueError):  # the file may have put things in order itself
            sys.path.remove(str(folder))


def _found(module: ModuleType, wanted: str) -> Tool:
    try:
        found = attrgetter(wanted)(module)
    except AttributeError:
        there = [
            name
            for name, value in vars(module).items()
            if isinstance(value, type) and value.__module__ == module.__name__
        ]
        known = f"it has {', '.join(there)}" if there else "it has no classes"
        raise ValueError(f"there is no class {wanted!r} in it; {known}") from None
    return _made(found)


def _made(found: Any) -> Tool:
    """A tool from its class, looked over as far as can be seen without asking it."""
    kind = found if isinstance(found, type) else type(found)
    for method in _METHODS:
        if not callable(_said(found, method)):
            raise ValueError(
                f"{kind.__name__} has no method {method!r}; a tool has {', '.join(_METHODS)}"
            )
    if not isinstance(found, type):
        tool = found
    else:
        try:
            tool = found()
        except (Exception, SystemExit) as error:
            raise ValueError(
                f"{kind.__name__}() fails with {failure(error)}; give its arguments defaults, or "
                "name an instance"
            ) from error
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
