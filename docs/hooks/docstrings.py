"""Our docstrings as the reference shows them."""

from collections.abc import Iterator
from copy import copy
from dataclasses import fields, is_dataclass
from importlib import import_module
from typing import Any

from griffe import Attribute, Class, ExprCall, Extension, Function, Module, Object


class Docstrings(Extension):
    """Examples become a section, and settings, which have their help with them, are listed.

    Methods that a class takes from another module are shown as its own.
    """

    def on_object(self, *, obj: Object, **_: Any) -> None:
        if obj.docstring is not None:
            obj.docstring.value = obj.docstring.value.replace("Example:\n", "Examples:\n")

    def on_class_members(self, *, cls: Class, **_: Any) -> None:
        if "dataclass" not in cls.labels or cls.docstring is None:
            return
        kind = getattr(import_module(cls.module.path), cls.name)
        told = [one for one in fields(kind) if "help" in one.metadata] if is_dataclass(kind) else []
        if told:
            lines = [f"    {one.name}: {one.metadata['help']}." for one in told]
            cls.docstring.value += "\n\nAttributes:\n" + "\n".join(lines)

    def on_package(self, *, pkg: Module, **_: Any) -> None:
        for cls in _classes(pkg):
            for name, member in list(cls.members.items()):
                if isinstance(member, Attribute) and (function := _taken(pkg, member)) is not None:
                    method = copy(function)
                    method.parent, method.lineno = cls, member.lineno
                    if isinstance(member.value, ExprCall):
                        method.labels = {*function.labels, "classmethod"}
                    cls.set_member(name, method)


def _classes(module: Module) -> Iterator[Class]:
    for member in module.members.values():
        if isinstance(member, Class):
            yield member
        elif isinstance(member, Module):
            yield from _classes(member)


def _taken(package: Module, member: Attribute) -> Function | None:
    """The function of another module that a class takes as a method, if it is one.

    As in `find = mdp_states.find` and `load = classmethod(mdp_sources.load)`.
    """
    value: Any = member.value
    if isinstance(value, ExprCall) and str(value.function) == "classmethod":
        value = value.arguments[0]
    path = getattr(value, "canonical_path", "").removeprefix(f"{package.path}.")
    try:
        found = package[path] if path else None
    except KeyError:
        return None
    return found if isinstance(found, Function) else None
