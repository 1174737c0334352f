"""Public names of a package, imported on first use (PEP 562).

The list is the stub beside the package, `__init__.pyi`: what type checkers read is what is loaded.
"""

import ast
import sys
from collections.abc import Callable, Collection
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from habilis.extras import extra_named


class Public(NamedTuple):
    """The attributes that make a package lazy."""

    getattr: Callable[[str], Any]
    dir: Callable[[], list[str]]
    all: list[str]
    """The names that need no extra, so that `from package import *` works without one."""


def public(package: str, optional: Collection[str] = ()) -> Public:
    """The exports of a package.

    Args:
        package: its `__name__`. Each `from module import name as name` of its stub is a public
            name; `from . import name as name` is a subpackage.
        optional: the modules in the stub that need an extra which the others do not.

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
        with extra_named():
            if home is None:
                return import_module(f"{package}.{name}")
            return getattr(import_module(home), name)

    names = [name for name, home in homes.items() if home not in optional and home is not None]
    return Public(load, lambda: sorted(homes), names)
