"""The description of the packages: the README, its links as an index needs them.

A package index shows the README without the repository around it. So that pictures and links lead
somewhere, they become absolute, in the version that is built, where the repository's address is
known: from the environment variable HABILIS_REPOSITORY, or from the remote of the clone. Otherwise
pictures are replaced by what they show, and links by their text.
"""

import os
import re
import subprocess
from contextlib import suppress
from email import message_from_string
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

_LINK = re.compile(
    r"(?s)(?P<code>```.*?```)|(?P<picture>!?)\[(?P<text>(?:[^\[\]]|\n)+)\]\((?P<path>(?![a-z]+:|#)[^)\s]+)\)"
)
_REMOTE = re.compile(
    r"(?:https://(?P<host>[\w.-]+(?::\d+)?)/|git@(?P<by_git>[\w.-]+):"
    r"|ssh://git@(?P<by_ssh>[\w.-]+)(?::\d+)?/)(?P<path>[\w./-]+?)(?:\.git)?/?"
)


class Description(MetadataHookInterface):
    """The dynamic field `readme` of the project's metadata."""

    def update(self, metadata: dict[str, Any]) -> None:
        root = Path(self.root)
        metadata["readme"] = {"content-type": "text/markdown", "text": description(root)}


def description(root: Path) -> str:
    """The README for an index; in an unpacked sdist, that with which it was built."""
    built = root / "PKG-INFO"
    if built.exists():
        return str(message_from_string(built.read_text("utf-8")).get_payload())
    version = re.search(r'__version__ = "(.+)"', (root / "src/habilis/__init__.py").read_text())
    assert version is not None, "hatchling has read it there"
    readme = (root / "README.md").read_text("utf-8")
    return with_links(readme, repository(root), f"v{version[1]}")


def repository(root: Path) -> str | None:
    """The address of the repository, without a slash at its end, if it is known."""
    remote = os.environ.get("HABILIS_REPOSITORY")
    if remote is None and (root / ".git").exists():
        command = ["git", "-C", str(root), "remote", "get-url", "origin"]
        with suppress(OSError):  # a machine that builds may have no git
            remote = subprocess.run(command, capture_output=True, text=True).stdout.strip()
    found = _REMOTE.fullmatch(remote or "")
    if found is None:
        return None
    host = found["host"] or found["by_git"] or found["by_ssh"]
    return f"https://{host}/{found['path']}"


def with_links(readme: str, address: str | None, version: str) -> str:
    """The README with absolute links, or without any that are relative."""

    def replaced(link: re.Match[str]) -> str:
        if link["code"]:
            return link[0]
        if address is None:
            return f"*{link['text']}*" if link["picture"] else link["text"]
        kind = "raw" if link["picture"] else "blob"
        target = f"{address}/{kind}/{version}/{link['path']}"
        return f"{link['picture']}[{link['text']}]({target})"

    return _LINK.sub(replaced, readme)
