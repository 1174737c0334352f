"""Every public name is in the reference, and its docstring says what it takes, gives and refuses.

The build fails where one does not.
"""

import ast
import inspect
import re
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError

from habilis.learning.algorithms import ALGORITHMS
from habilis.learning.algorithms.protocol import Algorithm

PACKAGES = (
    "habilis",
    "habilis.analysis",
    "habilis.bridges",
    "habilis.channels",
    "habilis.envs",
    "habilis.estimators",
    "habilis.estimators.simulators",
    "habilis.learning",
    "habilis.sweeps",
    "habilis.tasks",
    "habilis.worlds",
    "habilis.worlds.pictures",
)
"""Packages whose names are public."""

_SHOWN = re.compile(r"^::: (\S+)$", re.MULTILINE)
_SECTION = re.compile(r"^(Args|Attributes|Returns|Raises|Yields|Warns|Example):\s*$")
_SHARED = re.compile(r"^ {4}- `(\w+)`:", re.MULTILINE)  # what all methods of a class take
_ENTRY = re.compile(r"^ {4}(?P<names>\*{0,2}[\w.]+(?:, \*{0,2}[\w.]+)*):")


def on_pre_build(config: MkDocsConfig, **_: Any) -> None:
    """Refuses to build a reference that lacks something."""
    pages = (Path(config.docs_dir) / "reference").glob("*.md")
    found = list(faults(public_names(), (page.read_text("utf-8") for page in pages)))
    if found:
        raise PluginError("the reference lacks something:\n  " + "\n  ".join(found))


def public_names() -> dict[str, Any]:
    """The public names: everything that the public packages list."""
    return {
        f"{package}.{name}": getattr(sys.modules[package], name)
        for package in map(_imported, PACKAGES)
        for name in _listed(sys.modules[package])
    }


def _imported(package: str) -> str:
    import_module(package)
    return package


def _listed(package: ModuleType) -> list[str]:
    """The names that a package exports, lazily or not; its subpackages have lists of their own."""
    lazy = dir(package) if "__getattr__" in vars(package) else []
    return [
        name
        for name in sorted({*package.__all__, *lazy})
        if not name.startswith("_") and not isinstance(getattr(package, name), ModuleType | Mapping)
    ]


def faults(names: Mapping[str, Any], pages: Iterable[str]) -> Iterator[str]:
    """The faults, one line each.

    Args:
        names: the public names, and what they name.
        pages: the text of the reference.
    """
    shown = {path: _found(path) for page in pages for path in _SHOWN.findall(page)}
    for name, thing in names.items():
        if name not in shown and not any(other is thing for other in shown.values()):
            yield f"{name} is on no page of the reference"
    for name, thing in {**shown, **names}.items():
        if thing is None:
            yield f"{name} is in the reference, and does not exist"
        yield from (f"{name}{fault}" for fault in _faults(thing))


def _found(path: str) -> Any:
    module, _, name = path.rpartition(".")
    try:
        return getattr(import_module(module), name, None)
    except ImportError:
        return None


def _faults(thing: Any) -> Iterator[str]:
    if inspect.isclass(thing):
        yield from _faults_of_class(thing)
    elif callable(thing):
        yield from _faults_of_function(thing)


def _faults_of_class(kind: type) -> Iterator[str]:
    text = kind.__dict__.get("__doc__") or ""
    if not text or text.startswith(f"{kind.__name__}("):  # what dataclasses make of themselves
        yield " has no docstring"
        return
    if is_dataclass(kind):
        told = _entries(inspect.cleandoc(text), "Attributes")
        for one in fields(kind):
            if one.name not in told and "help" not in one.metadata and one.init:
                yield f": its attribute {one.name} is not described"
    for name, member in vars(kind).items():
        function = _function(member)
        if function is None or (name.startswith("_") and name != "__init__"):
            continue
        if name == "__init__" and is_dataclass(kind):
            continue
        if not function.__doc__ and any(hasattr(base, name) for base in kind.__mro__[1:]):
            continue  # what it overrides is described where it comes from
        if kind in ALGORITHMS.values() and hasattr(Algorithm, name):
            continue  # as is what it implements
        known = _SHARED.findall(inspect.cleandoc(text))
        yield from (f".{name}{fault}" for fault in _faults_of_function(function, known))


def _function(member: Any) -> Callable[..., Any] | None:
    if isinstance(member, property):
        return member.fget
    if isinstance(member, classmethod | staticmethod):
        return member.__func__
    return member if inspect.isfunction(member) else None


def _faults_of_function(function: Callable[..., Any], known: Collection[str] = ()) -> Iterator[str]:
    text = inspect.cleandoc(function.__doc__ or "")
    if not text:
        yield " has no docstring"
        return
    signature = inspect.signature(function)
    taken = [name for name in signature.parameters if name not in ("self", "cls", *known)]
    told = {name.lstrip("*") for name in _entries(text, "Args")}
    for name in taken:
        if name not in told:
            yield f": its argument {name} is not described"
    for name in sorted(told - set(taken)):
        yield f" describes an argument {name} that it does not have"
    gives = signature.return_annotation not in (None, "None", inspect.Signature.empty)
    if gives and taken and not re.search(r"^(Returns|Yields):$", text, re.MULTILINE):
        yield " does not say what it returns"
    for error in sorted(_raised(function)):
        if error not in _entries(text, "Raises"):
            yield f" does not say when it raises {error}"


def _entries(text: str, section: str) -> set[str]:
    """The names in a section of a docstring; several may share a description."""
    names: set[str] = set()
    inside = False
    for line in text.splitlines():
        if heading := _SECTION.match(line):
            inside = heading[1] == section
        elif inside and (entry := _ENTRY.match(line)):
            names.update(entry["names"].split(", "))
    return names


def _raised(function: Callable[..., Any]) -> set[str]:
    """The errors that a function raises itself, by name."""
    source = inspect.getsource(function)
    tree = ast.parse(
        f"if True:\n{source}" if source[0].isspace() else source
    )  # a method is indented
    raised = (node.exc for node in ast.walk(tree) if isinstance(node, ast.Raise))
    made = (e.func for e in raised if isinstance(e, ast.Call))
    return {kind.id for kind in made if isinstance(kind, ast.Name) and kind.id[0].isupper()}
