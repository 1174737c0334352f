"""Our docstrings as the reference shows them."""

from dataclasses import fields, is_dataclass
from importlib import import_module
from typing import Any

from griffe import Class, Extension, Object


class Docstrings(Extension):
    """Examples become a section, and settings, which have their help with them, are listed."""

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
