"""Output of the command line: JSON, errors, files, progress."""

import json
import sys
from argparse import Namespace
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from habilis import compiled
from habilis.files import check_file, check_folder, writing

if TYPE_CHECKING:
    from rich.console import Console


def print_json(value: Any) -> int:
    """Prints JSON; returns the exit status for "done"."""
    print(json.dumps(value))
    return 0


def refuse(message: str, status: int = 2) -> int:
    """Prints a line on standard error; returns the exit status."""
    print(f"habilis: {message}", file=sys.stderr)
    return status


def save(path: Path, write: Callable[[Path], Any]) -> None:
    """Writes a file.

    Raises:
        ValueError: it cannot be written.
    """
    with writing(path):
        write(path)


def print_written(path: Path | str) -> None:
    """Says where a result is."""
    print(f"written to {path}")


def lower_bounds(args: Namespace) -> str:
    """The prefix of sampled values."""
    return "lower bounds on " if args.method == "sampled" else ""


def check_outputs(args: Namespace) -> None:
    """Refuses files and folders that could not be written, before anything is computed.

    Args:
        args: `args.writes` has, by argument, the suffixes that its files may have, or `FOLDER`.

    Raises:
        ValueError: one of them cannot be written; nothing is left behind.
    """
    for name, suffixes in getattr(args, "writes", {}).items():
        value = getattr(args, name)
        for path in value if isinstance(value, list) else [value]:
            if path is not None:
                check_file(path, suffixes) if suffixes else check_folder(path)


def shows_progress(args: Namespace) -> bool:
    """Whether a verb draws progress bars: on a terminal, unless a machine reads what it prints."""
    return sys.stderr.isatty() and not args.json


def compiling_announced(args: Namespace) -> AbstractContextManager[None]:
    """Within it, a line on a terminal says so, once, when the compiler starts."""
    if not shows_progress(args):
        return nullcontext()
    return compiled.compiling_announced(
        cache(lambda: print("compiling (first use only)", file=sys.stderr))
    )


def console() -> "Console":
    """The terminal, or what stands in its place."""
    from rich.console import Console

    return Console(highlight=False)
