"""The code blocks of a page: what they are, and running them as a reader would.

Blocks of Python and commands of `habilis` run in the page's order, in one process, in a folder of
their own, with warnings as errors. A block with a title is a file of that name. Text right after
a block that runs is what the block prints (`...` stands for anything). A comment before a block,

    <!-- not run: it trains for minutes -->

keeps it from being run; the commands in it are still read by the real parser.
"""

import contextlib
import doctest
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

HOOKS = Path(__file__).parent
ROOT = HOOKS.parents[1]

_FENCE = re.compile(r"(?P<indent> *)```(?P<language>\w+)(?: title=\"(?P<title>[\w./-]+)\")?\s*")
_NOT_RUN = re.compile(r" *<!-- not run: (?P<reason>.+) -->\s*")
_RUN = ("python", "sh")


@dataclass(frozen=True)
class Block:
    """A block of code.

    Attributes:
        language: python, sh, text, toml...
        text: what is in it.
        line: of the page, that of its first line.
        title: the file that it is, if it is one.
        not_run: the reason why it is not run, if there is one.
        follows: whether nothing but empty lines stands between the block before and this one.
    """

    language: str
    text: str
    line: int
    title: str | None = None
    not_run: str | None = None
    follows: bool = False

    @property
    def runs(self) -> bool:
        return self.language in _RUN and self.title is None and self.not_run is None


def blocks(page: str) -> list[Block]:
    """All blocks of a page, in order.

    Raises:
        ValueError: a fence that is not understood.
    """
    found: list[Block] = []
    lines = page.splitlines()
    number, reason, follows = 0, None, False
    while number < len(lines):
        line = lines[number]
        number += 1
        if not line.lstrip().startswith("```"):
            if line.strip():
                told = _NOT_RUN.fullmatch(line)
                reason, follows = told["reason"] if told else None, False
            continue
        fence = _FENCE.fullmatch(line)
        if fence is None:
            raise ValueError(f"line {number}: {line!r}; begin a block with ```python, ```sh, ...")
        first = number
        while number < len(lines) and lines[number].strip() != "```":
            number += 1
        text = "".join(f"{x.removeprefix(fence['indent'])}\n" for x in lines[first:number])
        found.append(Block(fence["language"], text, first + 1, fence["title"], reason, follows))
        number, reason, follows = number + 1, None, True
    return found


def commands(block: Block) -> Iterator[tuple[int, list[str]]]:
    """The commands of a sh block, each with its line, as lists of words."""
    for number, line in enumerate(block.text.splitlines(), start=block.line):
        words = shlex.split(line, comments=True)
        if words:
            yield number, words


def run(page: Path, folder: Path) -> None:
    """Runs the blocks of a page in a folder.

    Raises:
        ValueError: one of them failed, or printed something else than the page says.
    """
    shutil.copytree(
        ROOT / "examples", folder / "examples", dirs_exist_ok=True
    )  # as a reader of a clone has them
    environment = os.environ | {"MPLBACKEND": "agg", "COLUMNS": "80"}
    done = subprocess.run(
        [sys.executable, "-W", "error", __file__, str(page)],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
    )
    if done.returncode:
        raise ValueError(f"{page.name}: {done.stderr.strip() or done.stdout.strip()}")


def _run_here(page: Path) -> None:
    """Runs the blocks of a page in this process and folder."""
    names: dict[str, object] = {"__name__": "__main__"}
    printed: str | None = None
    for block in blocks(page.read_text("utf-8")):
        where = f"{page.name}, line {block.line}"
        if block.title is not None:
            Path(block.title).parent.mkdir(parents=True, exist_ok=True)
            Path(block.title).write_text(block.text, "utf-8")
        elif block.runs:
            output = io.StringIO()
            with contextlib.redirect_stdout(output):
                if block.language == "python":
                    # Empty lines before it, so that a traceback names the line of the page.
                    code = "\n" * (block.line - 1) + block.text
                    exec(compile(code, page.name, "exec"), names)
                else:
                    _run_commands(block, page)
            printed = output.getvalue()
            continue
        elif block.language == "text" and block.not_run is None:
            _check_printed(block, printed, where)
        printed = None


def _run_commands(block: Block, page: Path) -> None:
    from habilis.cli import main

    for number, words in commands(block):
        if words[0] != "habilis":
            raise SystemExit(
                f"line {number}: {words[0]} is no command of ours; say why it not runs"
            )
        status = main(words[1:])
        if status:
            raise SystemExit(f"{page.name}, line {number}: exit status {status}")


def _check_printed(block: Block, printed: str | None, where: str) -> None:
    if printed is None or not block.follows:
        raise SystemExit(f"{where}: text that no block before it prints; give it a title")
    how = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    if not doctest.OutputChecker().check_output(block.text, printed, how):
        raise SystemExit(f"{where}: what is printed is\n{printed}")


if __name__ == "__main__":
    sys.path[0] = os.getcwd()
    _run_here(Path(sys.argv[1]))
