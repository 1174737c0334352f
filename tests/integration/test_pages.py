"""The code of the pages on other people's agents, with what the other tests of pages leave out."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

PAGES = Path(__file__).parents[2] / "docs" / "how-to"
BLOCK = re.compile(r"```(\w+)\n(.*?)```(?:\s*```text\n(.*?)```)?", re.DOTALL)


@pytest.mark.parametrize("page", ["sb3.md", "jax.md"])
def test_the_code_of_a_page_runs_and_prints_what_it_says(page, tmp_path):
    said, program = [], ""
    for language, code, output in BLOCK.findall((PAGES / page).read_text("utf-8")):
        if language == "python":
            said.append(output)
            program += code + f"\nprint('<block {len(said)}>')\n"
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", program], capture_output=True, text=True, cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    printed = re.split(r"<block \d+>\n", done.stdout)[:-1]
    assert len(printed) == len(said) >= 3
    for ours, theirs in zip(printed, said, strict=True):
        assert ours == theirs or not theirs
