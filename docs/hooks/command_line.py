"""The reference of the command line, from the parser that reads it."""

from argparse import ArgumentParser, _SubParsersAction
from typing import Any

from mkdocs.structure.pages import Page

from habilis.cli import parser

_HERE = "<!-- every command -->"


def on_page_markdown(markdown: str, page: Page, **_: Any) -> str:
    """Puts every command where a page asks for them."""
    if _HERE not in markdown:
        return markdown
    return markdown.replace(_HERE, "\n\n".join(_section(verb) for verb in verbs()))


def verbs() -> list[ArgumentParser]:
    """A parser for each verb, in their order."""
    whole = parser()
    (choices,) = (a for a in whole._actions if isinstance(a, _SubParsersAction))
    return list(choices.choices.values())


def _section(verb: ArgumentParser) -> str:
    name = verb.prog.removeprefix("habilis ")
    return f"## {name}\n\n```text\n{verb.format_help()}```"
