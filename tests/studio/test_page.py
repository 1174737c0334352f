"""The page that is shipped is the one that its sources give."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES, PAGE = ROOT / "studio", ROOT / "src" / "habilis" / "studio" / "page"
LARGEST = 150_000  # bytes of all files


def files_of(folder: Path) -> dict[str, bytes]:
    found = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in found}


@pytest.mark.skipif(shutil.which("npm") is None, reason="needs Node")
@pytest.mark.skipif(not (SOURCES / "node_modules").exists(), reason="needs npm ci in studio/")
def test_the_committed_page_is_what_the_sources_give(tmp_path: Path):
    copy = tmp_path / "studio"
    shutil.copytree(SOURCES, copy, ignore=shutil.ignore_patterns("node_modules"))
    (copy / "node_modules").symlink_to(SOURCES / "node_modules")
    built = tmp_path / "page"
    subprocess.run(
        ["npm", "run", "build", "--", "--outDir", str(built)],
        cwd=copy,
        check=True,
        capture_output=True,
        env=os.environ | {"NO_COLOR": "1"},
    )
    assert files_of(built) == files_of(PAGE), "call make page, and commit what it builds"


def test_the_page_is_small_whole_and_asks_no_other_host():
    files = files_of(PAGE)
    assert set(files) == {"index.html", "assets/studio.css", "assets/studio.js"}
    assert sum(map(len, files.values())) < LARGEST
    for name, content in files.items():
        text = content.decode()
        for place in text.split("http")[1:]:
            assert place.startswith(("://www.w3.org/", "s:")), f"{name} names another host"
