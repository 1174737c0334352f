"""Code of one's own, named by where it is written: `FILE.py:NAME` or `package.module:NAME`."""

import sys
import traceback
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from functools import lru_cache
from importlib import import_module
from operator import attrgetter
from pathlib import Path
from types import ModuleType
from typing import Any

BETWEEN = ":"
"""Stands between the file or module and the name in it."""
FILE = ".py"


def is_own(name: str) -> bool:
    """Whether a name says where something is written."""
    return BETWEEN in name


def read(place: str, example: str) -> tuple[Path, bytes]:
    """The path and the content of a file.

    Raises:
        ValueError: it cannot be read; `example` shows what to give.
    """
    path = Path(place).resolve()
    try:
        return path, path.read_bytes()
    except OSError as error:
        raise ValueError(
            f"{path} cannot be read ({error.strerror}); give the path of a Python file and a class "
            f"in it, as {example}"
        ) from None


@lru_cache(64)
def run(place: str, path: Path, source: bytes) -> ModuleType:
    """A file as a module, whose name is the file's as it was given: no other module's.

    Raises:
        ValueError: the code fails.
    """
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


def imported(place: str, example: str) -> ModuleType:
    """A module that Python finds, also in the working directory.

    Raises:
        ValueError: importing it fails; `example` shows how a file is named.
    """
    try:
        with importing_from(Path.cwd()):
            return import_module(place)
    except (Exception, SystemExit) as error:
        raise ValueError(
            f"importing {place!r} fails with {failure(error)}; name a module that Python finds, "
            f"or a file as {example}"
        ) from error


def member(module: ModuleType, wanted: str) -> Any:
    """What a module has under a name, dots included.

    Raises:
        ValueError: nothing; the message lists the module's classes.
    """
    try:
        return attrgetter(wanted)(module)
    except AttributeError:
        there = [
            name
            for name, value in vars(module).items()
            if isinstance(value, type) and value.__module__ == module.__name__
        ]
        known = f"it has {', '.join(there)}" if there else "it has no classes"
        raise ValueError(f"there is no class {wanted!r} in it; {known}") from None


def instance(found: Any) -> Any:
    """An instance of a class that needs no arguments; anything else as it is.

    Raises:
        ValueError: the class fails without arguments.
    """
    if not isinstance(found, type):
        return found
    try:
        return found()
    except (Exception, SystemExit) as error:
        raise ValueError(
            f"{found.__name__}() fails with {failure(error)}; give its arguments defaults, or "
            "name an instance"
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


def failure(error: BaseException, files: Collection[str | None] = ()) -> str:
    """An error in somebody's code, in one line, and its place in it.

    Args:
        error: as it was caught.
        files: those in which the place is sought; by default the first file that the catcher
            called.
    """
    frames = traceback.extract_tb(error.__traceback__)[1:]
    places = [(f.filename, f.lineno) for f in frames if "importlib" not in f.filename]
    if files:
        places = [place for place in places if place[0] in files]
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
