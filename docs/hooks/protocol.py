"""The studio's messages, from the module that reads them."""

from typing import Any

from mkdocs.structure.pages import Page

from habilis.studio import messages

_HERE = "<!-- the studio's messages -->"


def on_page_markdown(markdown: str, page: Page, **_: Any) -> str:
    """Puts what a message may be where a page asks for it."""
    return markdown.replace(_HERE, f"```text\n{(messages.__doc__ or '').strip()}\n```")
