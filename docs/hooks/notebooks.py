"""The notebooks as pages: executed when the documentation is built, with what their cells show.

They are pages like the others, in Markdown: with our formulae, search and colours, and without the
scripts and style sheets of Jupyter.
"""

import re
from html import escape
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import Any

import nbformat
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError
from nbformat import NotebookNode

SOURCES = Path(__file__).parents[2] / "examples" / "notebooks"
FOLDER = PurePosixPath("notebooks")
SECONDS = 300  # of a cell, at most

_SUFFIXES = {"image/svg+xml": ".svg", "image/png": ".png"}  # by what is shown first
_NAVIGATION = re.compile(rf"{FOLDER}/[\w-]+\.md")
_LINKS = (  # in the folder of the notebooks, and where the pages are
    (re.compile(r"\]\(\.\./\.\./docs/"), "](../"),
    (re.compile(r"\]\(([\w-]+)\.ipynb"), r"](\1.md"),
)
_FIGURE = "<Figure "


def on_files(files: Files, config: MkDocsConfig, **_: Any) -> Files:
    """Adds the pages that the navigation names, each with its notebook to download."""
    for named in dict.fromkeys(_NAVIGATION.findall(str(config.nav or ""))):
        source = SOURCES / f"{PurePosixPath(named).stem}.ipynb"
        text = source.read_text("utf-8")
        for name, content in page_of(executed(nbformat.reads(text, 4), source.name), source.stem):
            files.append(File.generated(config, str(FOLDER / name), content=content))
        notebook = str(FOLDER / source.name)
        files.append(File.generated(config, notebook, content=text))
    return files


def executed(notebook: NotebookNode, name: str) -> NotebookNode:
    """A notebook with its outputs.

    Raises:
        PluginError: a cell fails.
    """
    with TemporaryDirectory() as folder:
        where = {"metadata": {"path": folder}}
        try:
            NotebookClient(
                notebook,
                timeout=SECONDS,
                kernel_name="python3",
                resources=where,
                extra_arguments=["--log-level=ERROR"],
            ).execute()
        except CellExecutionError as error:
            raise PluginError(f"{name}: {error}") from None
    return notebook


def page_of(notebook: NotebookNode, stem: str) -> list[tuple[str, str | bytes]]:
    """A page in Markdown, after the files of its pictures, each with its name."""
    parts: list[str] = []
    files: list[tuple[str, str | bytes]] = []
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            parts.append(_on_page(cell.source))
            continue
        parts.append(f"```python\n{cell.source}\n```")
        for output in cell.outputs:
            part, picture = _shown(output, cell.metadata.get("alt"), f"{stem}-{len(files) + 1}")
            parts.append(part)
            files += [picture] if picture is not None else []
    title, _, rest = "\n\n".join(parts).partition("\n")
    download = f"[Download this notebook]({stem}.ipynb){{ .md-button download }}"
    return [*files, (f"{stem}.md", f"{title}\n{rest}\n\n{download}\n")]


def _on_page(markdown: str) -> str:
    """With links as they are on the page."""
    for there, here in _LINKS:
        markdown = there.sub(here, markdown)
    return markdown


def _shown(
    output: NotebookNode, alt: str | None, stem: str
) -> tuple[str, tuple[str, str | bytes] | None]:
    """An output in Markdown, and the file of its picture, if it is one.

    Raises:
        PluginError: it is an error or a warning, or a picture that nothing describes.
    """
    if output.output_type == "stream":
        if output.name != "stdout":
            raise PluginError(f"{stem}: a cell writes to {output.name}: {output.text}")
        return _verbatim(output.text), None
    text = output.data.get("text/plain", "")
    if "text/html" in output.data:
        html = re.sub(r"\n\s*\n", "\n", output.data["text/html"])
        return f'<div class="shown" markdown="0">{html}</div>', None
    for kind, suffix in _SUFFIXES.items():
        if kind in output.data:
            words = alt or text
            if words.startswith(_FIGURE):
                raise PluginError(f'{stem}: its figure needs a description, metadata "alt"')
            content = output.data[kind]
            name = f"{stem}{suffix}"
            bytes_of = content if suffix == ".svg" else _decoded(content)
            return f'<p class="shown"><img alt="{escape(words)}" src="{name}"></p>', (
                name,
                bytes_of,
            )
    return _verbatim(text), None


def _verbatim(text: str) -> str:
    return "```text\n" + text.rstrip("\n") + "\n```"


def _decoded(text: str) -> bytes:
    from base64 import b64decode

    return b64decode(text)
