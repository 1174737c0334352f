"""The environments that were checked, from the file that `tests/support/survey.py` writes."""

import csv
from pathlib import Path
from typing import Any

from mkdocs.structure.pages import Page

_HERE = "<!-- every environment that was checked -->"
_CHECKED = Path(__file__).parents[1] / "explanation" / "environments.csv"
_NUMBERS = ("states", "transitions", "verified")


def on_page_markdown(markdown: str, page: Page, **_: Any) -> str:
    """Puts the table of environments where a page asks for it."""
    return markdown.replace(_HERE, table()) if _HERE in markdown else markdown


def table() -> str:
    """The file as a table in Markdown."""
    with _CHECKED.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    lines = ["| environment | states | transitions | seen in replays | outcome |"]
    lines.append("|---|--:|--:|--:|---|")
    for row in rows:
        counts = [f"{int(row[name]):,}" if row[name] else "" for name in _NUMBERS]
        cells = [f"`{row['environment']}`", *counts, _outcome(row["outcome"])]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def _outcome(text: str) -> str:
    """An outcome as the table has it: of a refusal why, not the whole line of the error."""
    return "refused: random" if "more than one outcome" in text else text
