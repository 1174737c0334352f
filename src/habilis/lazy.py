"""Public names of a package, imported on first use (PEP 562).

The list is the stub beside the package, `__init__.pyi`: what type checkers read is what is loaded.
"""

import ast
import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from habilis.extras import import_from

_NONE: Mapping[str, str] = MappingProxyType({})


class Public(NamedTuple):
    """The attributes that make a package lazy."""

    getattr: Callable[[str], Any]
    dir: Callable[[], list[str]]
    all: list[str]
    """The names that need no extra, so that `from package import *` works without one."""


def public(package: str, extras: Mapping[str, str] = _NONE) -> Public:
    """The exports of a package.

    Args:
        package: its `__name__`. Each `from module import name as name` of its stub is a public
            name; `from . import name as name` is a subpackage.
        extras: the extra that each of the modules in the stub needs, if any.

    Raises:
        MissingExtraError: on first use of a name whose extra is not installed.
    """
    file = sys.modules[package].__file__
    assert file is not None, "packages of Habilis are files"
    stub = ast.parse(Path(file).with_suffix(".pyi").read_text("utf-8"))
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    homes = {alias.name: node.module for node in imports for alias in node.names}

    def load(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        home = homes[name]
        path = f"{package}.{name}" if home is None else home
        module = import_from(path, extras[path]) if path in extras else import_module(path)
        return module if home is None else getattr(module, name)

    names = [name for name, home in homes.items() if home not in extras and home is not None]
    return Public(load, lambda: sorted(homes), names)
