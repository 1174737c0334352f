"""Estimators of one's own, named by where they are written: `mine.py:Mine`."""

import sys
from importlib import import_module
from operator import attrgetter
from pathlib import Path
from types import ModuleType
from typing import Any

from habilis.estimators.protocol import Estimator, is_estimator
from habilis.files import shown
from habilis.worlds.own_tools import failure, importing_from

_FILE = ".py"


def is_own(name: str) -> bool:
    """Whether a name says where an estimator is written."""
    return ":" in name


def own_estimator(name: str) -> Estimator:
    """The estimator that a file or a module has.

    Args:
        name: `FILE.py:CLASS` or `package.module:CLASS`. The class needs no arguments; in its place
            the name of an instance will do.

    Returns:
        An instance.

    Raises:
        ValueError: there is none, or the code fails; the message says how to fix it.
    """
    place, _, wanted = name.rpartition(":")
    try:
        found = _found(_run(Path(place)) if place.endswith(_FILE) else _imported(place), wanted)
        made = _made(found) if isinstance(found, type) else found
    except ValueError as error:
        raise ValueError(f"estimator {shown(repr(name))}: {error}") from None
    if not is_estimator(made):
        raise ValueError(
            f"estimator {shown(repr(name))}: it has no method fit; give it "
            "fit(simulator, horizon, sensor, *, seed)"
        )
    return made


def _run(path: Path) -> ModuleType:
    """A file as a module, which dataclasses, for one, look for by its name."""
    try:
        source = path.read_bytes()
    except OSError as error:
        raise ValueError(
            f"{path} cannot be read ({error.strerror}); give the path of a Python file and a class "
            "in it, as mine.py:Mine"
        ) from None
    module = ModuleType(str(path))
    module.__file__ = str(path.resolve())
    before = sys.modules.get(module.__name__)
    sys.modules[module.__name__] = module
    try:
        with importing_from(path.resolve().parent):
            exec(compile(source, module.__file__, "exec"), vars(module))
    except (Exception, SystemExit) as error:
        sys.modules.pop(module.__name__)
        if before is not None:
            sys.modules[module.__name__] = before
        raise ValueError(f"{path.name} fails with {failure(error)}; fix the file") from error
    return module


def _imported(place: str) -> ModuleType:
    try:
        with importing_from(Path.cwd()):
            return import_module(place)
    except (Exception, SystemExit) as error:
        raise ValueError(
            f"importing {place!r} fails with {failure(error)}; name a module that Python finds, "
            "or a file as mine.py:Mine"
        ) from error


def _found(module: ModuleType, wanted: str) -> Any:
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


def _made(kind: type) -> Any:
    try:
        return kind()
    except (Exception, SystemExit) as error:
        raise ValueError(
            f"{kind.__name__}() fails with {failure(error)}; give its arguments defaults, or name "
            "an instance"
        ) from error
