"""Pictures that a page shows and no folder has are made by the page's own code when it is built."""

import re
import tempfile
from pathlib import Path, PurePosixPath
from typing import Any

from blocks import run
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files

_PICTURE = re.compile(r"!\[[^\]]*\]\((?P<path>[\w./-]+)\)")


def on_files(files: Files, config: MkDocsConfig, **_: Any) -> Files:
    """Runs the pages whose pictures are missing, and adds what they made."""
    for page in list(files.documentation_pages()):
        folder = PurePosixPath(page.src_uri).parent
        shown = {found["path"] for found in _PICTURE.finditer(page.content_string)}
        missing = [path for path in shown if not (Path(config.docs_dir) / folder / path).exists()]
        if not missing:
            continue
        assert page.abs_src_path is not None, "pages are files"
        with tempfile.TemporaryDirectory() as made:
            try:
                run(Path(page.abs_src_path), Path(made))
            except ValueError as error:
                raise PluginError(str(error)) from None
            for path in missing:
                picture = Path(made) / path
                if not picture.exists():
                    raise PluginError(f"{page.src_uri}: none of its blocks makes {path}")
                content = picture.read_bytes()
                files.append(File.generated(config, str(folder / path), content=content))
    return files
