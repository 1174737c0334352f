"""How the verbs of the command line say what they have to say."""

import json
import sys
from argparse import Namespace
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

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
    try:
        write(path)
    except OSError as error:
        raise ValueError(f"{path}: cannot be written ({error.strerror or error})") from error


def shows_progress(args: Namespace) -> bool:
    """Whether a verb draws progress bars: on a terminal, unless a machine reads what it prints."""
    return sys.stderr.isatty() and not args.json


def console() -> "Console":
    """The terminal, or what stands in its place."""
    from rich.console import Console

    return Console(highlight=False)
