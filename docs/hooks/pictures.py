"""Pictures that a page's own code writes are made by that code when the page is built."""

import re
import tempfile
from pathlib import Path, PurePosixPath
from typing import Any

from blocks import blocks, run
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files

_PICTURE = re.compile(r"!\[[^\]]*\]\((?P<path>[\w./-]+)\)")


def on_files(files: Files, config: MkDocsConfig, **_: Any) -> Files:
    """Runs the pages that write pictures which they show, and adds these."""
    for page in list(files.documentation_pages()):
        folder = PurePosixPath(page.src_uri).parent
        shown = {found["path"] for found in _PICTURE.finditer(page.content_string)}
        code = "".join(block.text for block in blocks(page.content_string) if block.runs)
        written = sorted(path for path in shown if path in code)
        if not written:
            continue
        if kept := [path for path in written if (Path(config.docs_dir) / folder / path).exists()]:
            raise PluginError(f"{page.src_uri}: {kept[0]} is kept, and made by the page too")
        if twice := [path for path in written if files.get_file_from_path(str(folder / path))]:
            raise PluginError(f"{page.src_uri}: {twice[0]} is made by another page too")
        assert page.abs_src_path is not None, "pages are files"
        with tempfile.TemporaryDirectory() as made:
            try:
                run(Path(page.abs_src_path), Path(made))
            except ValueError as error:
                raise PluginError(str(error)) from None
            for path in written:
                picture = Path(made) / path
                if not picture.exists():
                    raise PluginError(f"{page.src_uri}: none of its blocks makes {path}")
                content = picture.read_bytes()
                files.append(File.generated(config, str(folder / path), content=content))
    return files
