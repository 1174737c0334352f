"""The reference of the studio's messages, from the types by which the server reads them."""

import inspect as text
from collections.abc import Iterator
from typing import Any

import msgspec
from mkdocs.structure.pages import Page
from msgspec import inspect

from habilis.studio import protocol
from habilis.studio.protocol.answers import ANSWER_OF, Answer
from habilis.studio.protocol.hello import Hello, Show

_HERE = "<!-- the studio's messages -->"
_PLAIN: dict[type, str] = {
    inspect.StrType: "text",
    inspect.BoolType: "true or false",
    inspect.NoneType: "null",
    inspect.AnyType: "anything",
}


def on_page_markdown(markdown: str, page: Page, **_: Any) -> str:
    """Puts the messages where a page asks for them."""
    return markdown.replace(_HERE, reference()) if _HERE in markdown else markdown


def reference() -> str:
    """Every request with its answer, the greeting, and the types in them."""
    types: dict[str, str] = {}
    parts = [text.cleandoc(protocol.__doc__ or "").partition("\n\n")[2].rpartition("\n\n")[0]]
    parts += ["## Any answer", *_table(Answer, types), "## Requests and answers"]
    for request, answer in ANSWER_OF.items():
        parts.append(f"### {request.__struct_config__.tag}")
        parts += [_said(request), *_table(request, types, ("id",))]
        if answer is not Answer:
            said = _said(answer)
            parts += [f"Answer: {said[0].lower()}{said[1:]}"]
            parts += _table(answer, types, Answer.__struct_fields__)
    greeting = ["## Hello", _said(Hello), *_table(Hello, types)]
    greeting += ["## Show", _said(Show), *_table(Show, types)]
    named = (line for name in sorted(types) for line in (f"### {name}", types[name]))
    return "\n\n".join([*parts, *greeting, "## Types", *named])


def _table(struct: Any, types: dict[str, str], besides: tuple[str, ...] = ()) -> Iterator[str]:
    """The fields of a message."""
    rows = []
    infos = {one.encode_name: one for one in msgspec.structs.fields(struct)}
    for field in inspect.type_info(struct).fields:  # type: ignore[attr-defined]
        info = infos[field.encode_name]
        if field.encode_name in besides:
            continue
        default = ""
        if info.default is msgspec.UNSET:
            default = "" if issubclass(struct, Answer) else "optional"
        elif info.default is not msgspec.NODEFAULT:
            default = f"default {msgspec.json.encode(info.default).decode()}"
        words = "" if _described(field.type, "title") else _described(field.type, "description")
        notes = "; ".join(filter(None, (words, default)))
        rows.append(f"| `{field.encode_name}` | {_type(field.type, types)} | {notes} |")
    if rows:
        yield "\n".join(["| field | type | |", "|---|---|---|", *rows])


def _type(kind: Any, types: dict[str, str]) -> str:
    """A type in words; those that have a name are added to `types`, and linked."""

    def inner(one: Any) -> str:
        return _type(one, types)

    match kind:
        case inspect.Metadata():
            title = _described(kind, "title")
            if not title:
                return inner(kind.type)
            words = _described(kind, "description")
            types.setdefault(title, f"{inner(kind.type)}. {words}".strip())
            return f"[{title}](#{title.lower()})"
        case inspect.StructType():
            name = kind.cls.__name__
            if name not in types:
                types[name] = ""  # a type may contain itself
                types[name] = "\n\n".join([_said(kind.cls), *_table(kind.cls, types)])
            return f"[{name}](#{name.lower()})"
        case inspect.UnionType():
            return " or ".join(map(inner, kind.types))
        case inspect.LiteralType():
            return " or ".join(f"`{value}`" for value in kind.values)
        case inspect.ListType():
            return f"list of {inner(kind.item_type)}"
        case inspect.TupleType():
            return f"[{', '.join(map(inner, kind.item_types))}]"
        case inspect.DictType():
            return f"{inner(kind.value_type)} by name"
        case inspect.IntType() | inspect.FloatType():
            whole = "whole number" if isinstance(kind, inspect.IntType) else "number"
            least, most = kind.ge, kind.le if kind.lt is None else kind.lt - 1
            return (
                whole
                if least is None or most is None or most > 2**30
                else f"{whole}, {least} to {most:,}"
            )
        case _:
            return _PLAIN[type(kind)]


def _described(kind: Any, what: str) -> str:
    return (getattr(kind, "extra_json_schema", None) or {}).get(what, "")


def _said(struct: Any) -> str:
    return text.cleandoc(struct.__doc__ or "")
